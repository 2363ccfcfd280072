// A metric over two varied parameters: a coloured field for each point, the best one marked, and a bar of the colours.

import { scale, ticks, tickText } from './chart.js';
import { h, s } from './dom.js';
import { number } from './format.js';

const ROOM = { left: 70, right: 88, top: 16, bottom: 46 };
const BAR = { gap: 14, width: 16, steps: 24 };
const HEIGHT = 400;
/** Viridis at equal distances: it rises evenly in lightness, also for those who see no colours. */
const COLOURS = ['#440154', '#472d7b', '#3b528b', '#2c728e', '#21918c', '#28ae80', '#5ec962', '#addc30', '#fde725'];

const channels = (colour) => [1, 3, 5].map((at) => parseInt(colour.slice(at, at + 2), 16));

/** The colour of a share from 0 to 1. */
export function shade(share) {
  const at = Math.min(Math.max(share, 0), 1) * (COLOURS.length - 1);
  const place = Math.min(Math.floor(at), COLOURS.length - 2);
  const [a, b] = [channels(COLOURS[place]), channels(COLOURS[place + 1])];
  return `rgb(${a.map((value, i) => Math.round(value + (b[i] - value) * (at - place))).join(' ')})`;
}

/** Whether a point along an axis is a number, so that the axis has round ticks. */
const isNumeric = (values) => values.length > 1 && values.every((value) => typeof value === 'number');

/** Ticks of an axis in fields from its start: round numbers, or each name. Values that are not evenly spaced keep their own. */
function marks(values, most) {
  const own = () => {
    const every = Math.ceil(values.length / most);
    return values.map((value, i) => [i + 0.5, typeof value === 'number' ? number(value, 4) : String(value)]).filter((_, i) => i % every === 0);
  };
  if (!isNumeric(values)) return own();
  const step = (values.at(-1) - values[0]) / (values.length - 1);
  const isEven = step !== 0 && values.every((value, i) => Math.abs(value - values[0] - i * step) < 1e-3 * Math.abs(step));
  if (!isEven) return own();
  const ends = { from: values[0] - step / 2, to: values.at(-1) + step / 2 };
  return ticks(ends, most).map((value) => [(value - ends.from) / step, tickText({}, value)]);
}

export class HeatMap {
  constructor() {
    this.element = h('div', { class: 'chart' });
    new ResizeObserver(() => {
      if (this.drawn && this.element.clientWidth !== this.width) this.#draw();
    }).observe(this.element);
  }

  /** `x`, `y`: `{ values, label }`. `value(column, row)`: the metric, or null. `best`: column and row, or null. `text` describes the map. */
  draw(content) {
    this.drawn = content;
    this.#draw();
  }

  #draw() {
    const { x, y, value, best, unit, text } = this.drawn;
    const width = this.element.clientWidth;
    // Narrower only while the page is laid out.
    if (width < 200) return;
    this.width = width;
    const height = Math.min(HEIGHT, Math.max(280, width * 0.8));
    const [right, bottom] = [width - ROOM.right, height - ROOM.bottom];
    const [columns, rows] = [x.values.length, y.values.length];
    const [w, t] = [(right - ROOM.left) / columns, (bottom - ROOM.top) / rows];
    const known = [];
    for (let i = 0; i < columns; i += 1) for (let k = 0; k < rows; k += 1) if (Number.isFinite(value(i, k))) known.push([i, k, value(i, k)]);
    const [least, most] = [Math.min(...known.map(([, , v]) => v)), Math.max(...known.map(([, , v]) => v))];
    const share = (v) => (most > least ? (v - least) / (most - least) : 0.5);
    const field = ([i, k, v]) =>
      s('rect', { x: ROOM.left + i * w, y: bottom - (k + 1) * t, width: w + 0.4, height: t + 0.4, fill: shade(share(v)) }, s('title', {}, `${number(v, 5)} ${unit}`));
    const bar = { left: right + BAR.gap, step: (bottom - ROOM.top) / BAR.steps };
    const ends = most > least ? { from: least, to: most } : { from: least - 1, to: least + 1 };
    const at = scale(ends, bottom, ROOM.top);
    const middle = best && [ROOM.left + (best[0] + 0.5) * w, bottom - (best[1] + 0.5) * t];
    const svg = s(
      'svg',
      { width, height, viewBox: `0 0 ${width} ${height}`, role: 'img', 'aria-label': text },
      s('rect', { class: 'frame', x: ROOM.left, y: ROOM.top, width: right - ROOM.left, height: bottom - ROOM.top }),
      known.map(field),
      middle && [
        s('circle', { class: 'best-edge', cx: middle[0], cy: middle[1], r: 7 }),
        s('circle', { class: 'best', cx: middle[0], cy: middle[1], r: 7 }),
      ],
      marks(x.values, Math.max(3, Math.floor((right - ROOM.left) / 70))).map(([place, name]) =>
        s('text', { x: ROOM.left + place * w, y: bottom + 16, 'text-anchor': 'middle' }, name),
      ),
      marks(y.values, 7).map(([place, name]) => s('text', { x: ROOM.left - 6, y: bottom - place * t + 4, 'text-anchor': 'end' }, name)),
      s('text', { class: 'soft', x: (ROOM.left + right) / 2, y: height - 8, 'text-anchor': 'middle' }, x.label),
      s('text', { class: 'soft', transform: `translate(13 ${(ROOM.top + bottom) / 2}) rotate(-90)`, 'text-anchor': 'middle' }, y.label),
      known.length > 0 && [
        Array.from({ length: BAR.steps }, (_, k) =>
          s('rect', { x: bar.left, y: bottom - (k + 1) * bar.step, width: BAR.width, height: bar.step + 0.4, fill: shade((k + 0.5) / BAR.steps) }),
        ),
        ticks(ends, 6).map((v) => s('text', { x: bar.left + BAR.width + 5, y: at(v) + 4 }, tickText({}, v))),
      ],
    );
    this.element.replaceChildren(svg);
  }
}
