// A chart of lines as SVG: it is drawn in the pixels of its place, its marks can be chosen by pointer and by keys, and its lines
// differ by dashes, not only by colour.

import { h, s } from './dom.js';
import { number, power } from './format.js';

/** Least width of a chart [px]. */
const LEAST_WIDTH = 160;
const ROOM = { left: 66, right: 26, top: 14, bottom: 44 };

export class Chart {
  /** `height` [px]. */
  constructor(height = 340) {
    this.height = height;
    this.place = h('div', { class: 'chart' });
    this.legend = h('p', { class: 'legend' });
    this.element = h('div', {}, this.legend, this.place);
    new ResizeObserver(() => {
      if (this.drawn && this.place.clientWidth !== this.width) this.#draw();
    }).observe(this.place);
  }

  /** `x`, `y`: `{ from, to, label, log }`. `lines`: `{ points, style }`, a point without number ends a piece. `legend`: pairs of style and
   *  name. `verticals`: `{ at, name }`. `marks`: `{ x, y, shape, name, chosen, choose }`. `text` describes the chart. */
  draw(content) {
    this.drawn = content;
    const sample = ([style, name]) =>
      h(
        'span',
        {},
        s('svg', { width: 30, height: 10, 'aria-hidden': 'true' }, s('path', { class: `line ${style}`, d: 'M1 5H29' })),
        name,
      );
    this.legend.replaceChildren(...(content.legend ?? []).map(sample));
    this.#draw();
  }

  #draw() {
    const { x, y, lines, verticals = [], marks = [], text } = this.drawn;
    const width = this.place.clientWidth;
    // Narrower only while the page is laid out.
    if (width < LEAST_WIDTH) return;
    this.width = width;
    const height = Math.min(this.height, Math.max(240, width * 0.75));
    const [right, bottom] = [width - ROOM.right, height - ROOM.bottom];
    const px = scale(x, ROOM.left, right);
    const py = scale(y, bottom, ROOM.top);
    const most = Math.max(3, Math.floor((right - ROOM.left) / 80));
    const grid = [
      ...ticks(x, most).map((value) => [
        s('path', { class: 'grid', d: `M${px(value)} ${ROOM.top}V${bottom}` }),
        s('text', { x: px(value), y: bottom + 16, 'text-anchor': 'middle' }, tickText(x, value)),
      ]),
      ...ticks(y, 7).map((value) => [
        s('path', { class: 'grid', d: `M${ROOM.left} ${py(value)}H${right}` }),
        s('text', { x: ROOM.left - 6, y: py(value) + 4, 'text-anchor': 'end' }, tickText(y, value)),
      ]),
    ];
    const path = (points) => {
      let pen = 'M';
      return points
        .map(([a, b]) => {
          const here = Number.isFinite(a) && Number.isFinite(b) && !(y.log && b <= 0);
          const piece = here ? `${pen}${(px(a) - ROOM.left).toFixed(1)} ${(py(b) - ROOM.top).toFixed(1)}` : '';
          pen = here ? 'L' : 'M';
          return piece;
        })
        .join('');
    };
    const focused = this.place.contains(document.activeElement) ? document.activeElement.getAttribute('aria-label') : null;
    const svg = s(
      'svg',
      { width, height, viewBox: `0 0 ${width} ${height}`, role: 'group', 'aria-label': text },
      s('g', { 'aria-hidden': 'true' }, grid),
      // A nested drawing clips its lines.
      s(
        'svg',
        { x: ROOM.left, y: ROOM.top, width: right - ROOM.left, height: bottom - ROOM.top, 'aria-hidden': 'true' },
        lines.map(({ points, style }) => s('path', { class: `line ${style}`, d: path(points) })),
        verticals.map(({ at }) => s('path', { class: 'vertical', d: `M${px(at) - ROOM.left} 0V${bottom - ROOM.top}` })),
      ),
      s('rect', {
        class: 'frame',
        x: ROOM.left,
        y: ROOM.top,
        width: right - ROOM.left,
        height: bottom - ROOM.top,
        'aria-hidden': 'true',
      }),
      verticals.map(({ at, name }) =>
        s(
          'text',
          {
            class: 'soft',
            x: px(at) + (px(at) > right - 90 ? -4 : 4),
            y: ROOM.top + 13,
            'text-anchor': px(at) > right - 90 ? 'end' : 'start',
            'aria-hidden': 'true',
          },
          name,
        ),
      ),
      s(
        'text',
        { class: 'soft', x: (ROOM.left + right) / 2, y: height - 8, 'text-anchor': 'middle', 'aria-hidden': 'true' },
        x.label,
      ),
      s(
        'text',
        {
          class: 'soft',
          transform: `translate(13 ${(ROOM.top + bottom) / 2}) rotate(-90)`,
          'text-anchor': 'middle',
          'aria-hidden': 'true',
        },
        y.label,
      ),
      marks.map((mark) => drawMark(mark, px(mark.x), py(mark.y))),
    );
    this.place.replaceChildren(svg);
    if (focused)
      [...svg.querySelectorAll('[role=button]')].find((mark) => mark.getAttribute('aria-label') === focused)?.focus();
  }
}

/** `up` a filled triangle, `down` a hollow one, `dot` a square. */
const SHAPES = { up: 'M-6 5L0 -6L6 5Z', down: 'M-6 -5L0 6L6 -5Z', dot: 'M-4 -4H4V4H-4Z' };

function drawMark({ shape, name, chosen, choose }, x, y) {
  const act = (event) => {
    if (event.type === 'keydown' && event.key !== 'Enter' && event.key !== ' ') return;
    event.preventDefault();
    choose();
  };
  return s(
    'g',
    {
      class: `mark ${shape}`,
      transform: `translate(${x.toFixed(1)} ${y.toFixed(1)})`,
      role: 'button',
      tabindex: 0,
      'aria-label': name,
      'aria-pressed': String(Boolean(chosen)),
      onclick: act,
      onkeydown: act,
    },
    s('title', {}, name),
    s('circle', { class: 'halo', r: 11 }),
    s('path', { d: SHAPES[shape] }),
  );
}

/** Positions of the values of an axis between two positions. */
export function scale({ from, to, log }, start, end) {
  const of = log ? Math.log10 : (value) => value;
  const [a, b] = [of(from), of(to)];
  return (value) => start + ((of(value) - a) / (b - a || 1)) * (end - start);
}

/** Multiples of 1, 2 or 5 times a power of ten within a range; whole decades of a logarithmic one. */
export function ticks({ from, to, log }, most) {
  if (log) {
    const [first, last] = [Math.ceil(Math.log10(from) - 1e-9), Math.floor(Math.log10(to) + 1e-9)];
    return Array.from({ length: Math.max(last - first + 1, 0) }, (_, k) => 10 ** (first + k));
  }
  const [low, high] = [Math.min(from, to), Math.max(from, to)];
  const rough = (high - low) / most;
  const decade = 10 ** Math.floor(Math.log10(rough));
  const step = [1, 2, 5, 10].map((m) => m * decade).find((one) => one >= 0.999 * rough);
  const first = Math.ceil(low / step - 1e-9);
  return Array.from({ length: Math.floor(high / step + 1e-9) - first + 1 }, (_, k) =>
    Number(((first + k) * step).toPrecision(12)),
  );
}

export const tickText = ({ log }, value) => (log ? power(value) : number(value, 5));
