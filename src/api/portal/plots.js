// Plots: a spectrum with named lines, curves over a quantity, and images drawn by the service.

import { h, labelled, lineName, s, select, small } from './dom.js';
import { number, power, quantity } from './format.js';
import uPlot from './vendor/uPlot.esm.js';

/** The colours of the style sheet, so that plots follow the theme. */
function colours() {
  const style = getComputedStyle(document.documentElement);
  const of = (name) => style.getPropertyValue(`--${name}`).trim();
  return {
    ink: of('ink'),
    soft: of('soft'),
    rule: of('rule'),
    series: [of('accent'), of('second'), of('soft')],
    sheet: of('sheet'),
  };
}

const FONT = '12px system-ui, sans-serif';
const dark = matchMedia('(prefers-color-scheme: dark)');

function axis(label, values, theme, size = 36) {
  return {
    label,
    values,
    size,
    stroke: theme.soft,
    font: FONT,
    labelFont: FONT,
    labelSize: 22,
    labelGap: 2,
    gap: 4,
    grid: { stroke: theme.rule, width: 1 },
    ticks: { stroke: theme.rule, width: 1, size: 4 },
  };
}

/** The decades of a logarithmic axis: nine grid lines each would be too many over seven decades. */
const decades = (u, at) => at.map((v) => (Number.isInteger(Number(Math.log10(v).toFixed(9))) ? v : null));

/** Base of all plots: the size follows the page, the theme follows the system, and a text describes the plot. */
class Plot {
  constructor(host, height) {
    this.host = host;
    this.height = height;
    this.place = h('div', { class: 'canvas', role: 'img' });
    this.readout = h('span', { class: 'readout', 'aria-hidden': 'true' });
    host.replaceChildren(this.place);
    new ResizeObserver(() => this.#fit()).observe(this.place);
    dark.addEventListener('change', () => {
      this.shape = '';
      this.redraw();
    });
  }

  describe(text) {
    this.place.setAttribute('aria-label', text);
  }

  /** Draws the plot. With the same `shape` only the data are replaced, which takes less than a millisecond. */
  put(shape, options, data) {
    if (shape === this.shape && this.plot) {
      this.plot.setData(data, false);
    } else {
      this.plot?.destroy();
      this.shape = shape;
      this.plot = new uPlot({ ...options(colours()), ...this.#size() }, data, this.place);
    }
  }

  #size() {
    const width = Math.max(this.place.clientWidth, 200);
    return { width, height: Math.min(this.height, Math.max(300, width * 0.62)) };
  }

  #fit() {
    if (this.plot && this.place.clientWidth && this.plot.width !== this.place.clientWidth) this.plot.setSize(this.#size());
  }
}

/** Longest leader from a label to its line [px]; a label farther away goes unread. */
const LONGEST_LEADER = 140;

const overlap = (a, b) => a.left < b.right && a.right > b.left && a.top < b.bottom && a.bottom > b.top;

/** Amplitude over frequency of one or two runs, with labelled lines. */
export class SpectrumPlot extends Plot {
  constructor(host, height = 420) {
    super(host, height);
    this.log = true;
    const sign = (text, title, act) => small(text, act, { title, 'aria-label': title });
    const scale = select(
      [
        ['log', 'log'],
        ['linear', 'linear'],
      ],
      (value) => {
        this.log = value === 'log';
        this.redraw();
      },
    );
    this.tools = h(
      'div',
      { class: 'tools' },
      labelled('Amplitude', scale),
      sign('−', 'Zoom out', () => this.#zoom(2)),
      sign('+', 'Zoom in', () => this.#zoom(0.5)),
      sign('←', 'Move left', () => this.#move(-0.25)),
      sign('→', 'Move right', () => this.#move(0.25)),
      small('Whole range', () => this.#set(0, this.limit)),
      this.readout,
    );
    host.append(this.tools);
    this.labels = [];
  }

  /** `spectra`: `[{ name, frequency_hz, amplitude }]`; `lines`: lines of the first spectrum; `limit` [Hz].
   *  With `ghost` the first spectrum is the background, and the lines are those of the second. */
  draw({ spectra, lines, unit, limit, keepZoom = false, ghost = false }) {
    this.zoomed = keepZoom && this.limit === limit ? this.zoomed : null;
    this.drawn = { spectra, lines, unit, ghost };
    this.limit = limit;
    this.redraw();
  }

  redraw() {
    if (!this.drawn) return;
    const { spectra, unit, ghost } = this.drawn;
    const largest = Math.max(...spectra.flatMap(({ amplitude }) => amplitude.reduce((a, b) => Math.max(a, b), 0)), 1e-12);
    // The scale grows at once and shrinks only when it is far too large, so that it stays readable during a sweep.
    if (!(this.top >= largest * 1.05 && this.top <= largest * 12)) this.top = largest * 2;
    const floor = this.top * 1e-6;
    const column = ({ amplitude }) => (this.log ? amplitude.map((a) => Math.max(a, floor / 10)) : amplitude);
    const data =
      spectra.length === 1
        ? [spectra[0].frequency_hz, column(spectra[0])]
        : uPlot.join(spectra.map((one) => [one.frequency_hz, column(one)]));
    const inKilohertz = this.limit > 3000;
    const options = (theme) => ({
      legend: { show: false },
      cursor: { drag: { x: true, y: false, setScale: false }, y: false, points: { size: 6 } },
      scales: {
        x: { time: false, range: () => this.zoomed ?? [0, this.limit] },
        y: { distr: this.log ? 3 : 1, range: () => this.#heights() },
      },
      axes: [
        axis(
          `Frequency, ${inKilohertz ? 'kHz' : 'Hz'}`,
          (u, at) => at.map((x) => (inKilohertz ? number(x / 1000) : number(x, 5))),
          theme,
        ),
        axis(`Amplitude, ${unit}`, (u, at) => at.map((y) => (y === null ? '' : this.log ? power(y) : number(y, 3))), theme, 56),
      ].map((one, i) =>
        this.log && i
          ? { ...one, filter: decades, grid: { ...one.grid, filter: decades }, ticks: { ...one.ticks, filter: decades } }
          : one,
      ),
      series: [
        {},
        ...spectra.map((one, i) => ({
          label: one.name,
          spanGaps: true,
          points: { show: false },
          width: 1.25,
          stroke: theme.series[ghost ? 2 - 2 * i : i],
          alpha: ghost && i === 0 ? 0.45 : 1,
        })),
      ],
      hooks: {
        draw: [(u) => this.#placeLabels(u)],
        setCursor: [(u) => this.#showReadout(u)],
        setSelect: [(u) => this.#select(u)],
      },
    });
    this.put([this.log, unit, inKilohertz, ghost, spectra.length].join(), options, data);
    this.#set(...(this.zoomed ?? [0, this.limit]), this.zoomed);
  }

  #set(from, to, zoomed = from > 0 || to < this.limit ? [from, to] : null) {
    this.zoomed = zoomed;
    this.plot?.batch(() => {
      this.plot.setScale('x', { min: from, max: to });
      const [min, max] = this.#heights();
      this.plot.setScale('y', { min, max });
    });
  }

  #heights() {
    // uPlot finds the grid of a logarithmic axis only from a whole decade on.
    return this.log ? [10 ** Math.floor(Math.log10(this.top * 1e-6)), this.top * 2] : [0, this.top];
  }

  #zoom(factor) {
    const { min, max } = this.plot.scales.x;
    const half = Math.min(((max - min) / 2) * factor, this.limit / 2);
    const middle = Math.min(Math.max((min + max) / 2, half), this.limit - half);
    this.#set(middle - half, middle + half);
  }

  #move(share) {
    const { min, max } = this.plot.scales.x;
    const by = Math.min(Math.max(share * (max - min), -min), this.limit - max);
    this.#set(min + by, max + by);
  }

  #select(u) {
    const { left, width } = u.select;
    if (width > 4) this.#set(u.posToVal(left, 'x'), u.posToVal(left + width, 'x'));
    u.setSelect({ left: 0, width: 0, top: 0, height: 0 }, false);
  }

  #showReadout(u) {
    const i = u.cursor.idx;
    this.readout.textContent =
      i === null || i === undefined
        ? ''
        : `${quantity(u.data[0][i], 'Hz', 5)}: ${u.data
            .slice(1)
            .filter((column) => column[i] != null)
            .map((column) => quantity(column[i], this.drawn.unit, 3))
            .join(' and ')}`;
  }

  /** Places the labels of lines, strongest first; a line without name gets its frequency. A label that would cover another one is omitted. */
  #placeLabels(u) {
    const { min, max } = u.scales.x;
    const taken = [];
    let used = 0;
    for (const { label: name, frequency_hz: f, amplitude } of this.drawn.lines) {
      if (f < min || f > max) continue;
      const label = name || quantity(f, 'Hz', 4);
      const width = label.length * 6.6 + 6;
      const peak = u.valToPos(f, 'x');
      const x = Math.min(Math.max(peak, width / 2), u.over.clientWidth - width / 2);
      // Above all that any spectrum has below the label, so that it crosses no curve; a leader leads to its line.
      const from = Math.max(u.valToIdx(u.posToVal(x - width / 2, 'x')) - 1, 0);
      const to = u.valToIdx(u.posToVal(x + width / 2, 'x')) + 2;
      const least = this.top * 1e-6;
      const above = u.data.slice(1).reduce((most, column) => column.slice(from, to).reduce((a, v) => (v > a ? v : a), most), least);
      const end = u.valToPos(Math.max(amplitude, least), 'y') - 2;
      let y = u.valToPos(Math.max(above, amplitude), 'y') - 18;
      const boxes = () => [
        { left: x - width / 2, right: x + width / 2, top: y, bottom: y + 16 },
        { left: peak - 1, right: peak + 1, top: y + 16, bottom: end },
      ];
      const isTaken = () => boxes().some((box) => taken.some((other) => overlap(box, other)));
      // Over another label there may be room.
      for (let tries = 0; tries < 3 && y >= 0 && isTaken(); tries += 1) y -= 17;
      if (y < 0 || y > u.over.clientHeight - 20 || end - y > LONGEST_LEADER || isTaken()) continue;
      taken.push(...boxes());
      const element = this.#label(used, u);
      used += 1;
      if (element.dataset.line !== label) {
        element.dataset.line = label;
        element.replaceChildren(...lineName(label));
      }
      element.style.transform = `translate(${Math.round(x)}px, ${Math.round(y)}px) translateX(-50%)`;
      element.style.setProperty('--lead', `${Math.max(end - y - 16, 0).toFixed(0)}px`);
      element.style.setProperty('--aside', `${(peak - x).toFixed(1)}px`);
    }
    for (const left of this.labels.splice(used)) left.remove();
  }

  #label(i, u) {
    if (this.labels[i]?.parentNode !== u.over) {
      this.labels[i]?.remove();
      this.labels[i] = h('span', { class: 'line-label' });
      u.over.append(this.labels[i]);
    }
    return this.labels[i];
  }
}

/** A curve with dots over a quantity, with error bars. */
export class CurvePlot extends Plot {
  constructor(host, height = 340) {
    super(host, height);
  }

  /** `errors`: half length of the error bar of each point, or null. `dots`: whether points are marked. */
  draw({ x, y, errors = [], xLabel, yLabel, logX = false, dots = true }) {
    this.drawn = { x, y, errors, xLabel, yLabel, logX, dots };
    this.shape = '';
    this.redraw();
  }

  redraw() {
    if (!this.drawn) return;
    const { x, y, errors, xLabel, yLabel, logX, dots } = this.drawn;
    const known = y.map((value, i) => [value, errors[i] ?? 0]).filter(([value]) => typeof value === 'number');
    const least = Math.min(...known.map(([value, error]) => value - error));
    const most = Math.max(...known.map(([value, error]) => value + error));
    const room = (most - least || Math.abs(most) || 1) * 0.08;
    const options = (theme) => ({
      legend: { show: false },
      cursor: { drag: { x: !dots, y: false }, y: false },
      scales: {
        x: {
          time: false,
          distr: logX ? 3 : 1,
          ...(dots && !logX ? { range: (u, a, b) => [a - (b - a) * 0.04, b + (b - a) * 0.04] } : {}),
        },
        y: { range: known.length ? [least - room, most + room] : [0, 1] },
      },
      axes: [
        axis(xLabel, (u, at) => at.map((v) => (v === null ? '' : number(v, 5))), theme),
        axis(yLabel, (u, at) => at.map((v) => number(v, 5)), theme, 62),
      ],
      series: [{}, { stroke: theme.series[0], width: dots ? 1.75 : 1, points: { show: dots, size: 7, fill: theme.sheet } }],
      hooks: { draw: [(u) => bars(u, x, y, errors, theme.series[0])] },
    });
    this.put('', options, [x, y]);
  }
}

function bars(u, x, y, errors, colour) {
  const { ctx } = u;
  const half = 4 * devicePixelRatio;
  ctx.save();
  ctx.strokeStyle = colour;
  ctx.lineWidth = 1.25 * devicePixelRatio;
  ctx.beginPath();
  x.forEach((at, i) => {
    if (!errors[i] || typeof y[i] !== 'number') return;
    const [px, above, below] = [
      u.valToPos(at, 'x', true),
      u.valToPos(y[i] + errors[i], 'y', true),
      u.valToPos(y[i] - errors[i], 'y', true),
    ];
    ctx.moveTo(px, above);
    ctx.lineTo(px, below);
    for (const end of [above, below]) {
      ctx.moveTo(px - half, end);
      ctx.lineTo(px + half, end);
    }
  });
  ctx.stroke();
  ctx.restore();
}

/** An SVG drawn by the service, as an image, so that its styles do not affect the page. */
export function picture(svg, text) {
  const address = URL.createObjectURL(new Blob([svg], { type: 'image/svg+xml' }));
  const image = h('img', { class: 'picture', src: address, alt: text });
  image.addEventListener('load', () => URL.revokeObjectURL(address), { once: true });
  return image;
}

/** The path of a point in a plane, with the same scale in both directions. */
export function orbit({ y, z, unit, text }) {
  const range = (values) => values.reduce(([a, b], v) => [Math.min(a, v), Math.max(b, v)], [Infinity, -Infinity]);
  const [[y0, y1], [z0, z1]] = [range(y), range(z)];
  const half = (Math.max(y1 - y0, z1 - z0) / 2 || 1) * 1.12;
  const [my, mz] = [(y0 + y1) / 2, (z0 + z1) / 2];
  const at = (v, middle) => (((v - middle) / half) * 100).toFixed(2);
  const points = y.map((value, i) => `${at(z[i], mz)},${at(value, my)}`).join(' ');
  const step = 10 ** Math.floor(Math.log10(half));
  return s(
    'svg',
    { viewBox: '-104 -104 208 224', class: 'orbit', role: 'img', 'aria-label': text },
    s('rect', { x: -100, y: -100, width: 200, height: 200, class: 'frame' }),
    s('line', { x1: -100, x2: 100, y1: 0, y2: 0, class: 'cross' }),
    s('line', { x1: 0, x2: 0, y1: -100, y2: 100, class: 'cross' }),
    s('polyline', { points, class: 'path' }),
    s('line', { x1: -94, x2: -94 + (step / half) * 100, y1: 93, y2: 93, class: 'measure' }),
    s('text', { x: -94, y: 88, class: 'small-text' }, quantity(step, unit)),
    s('text', { x: 0, y: 114, 'text-anchor': 'middle', class: 'small-text' }, 'z to the right, y (gravity) down'),
  );
}

/** Bars of one value for each ball, for the inner and the outer raceway. */
export function ballBars({ inner = [], outer = [], text }) {
  const largest = Math.max(...inner, ...outer, 1e-12);
  const count = Math.max(inner.length, outer.length);
  const [width, height] = [Math.max(360, count * 44), 200];
  const pitch = width / count;
  const bar = (value, x, name) =>
    s('rect', {
      x,
      y: height - (value / largest) * height,
      width: pitch * 0.32,
      height: (value / largest) * height,
      class: name,
    });
  return s(
    'svg',
    { viewBox: `-8 -18 ${width + 16} ${height + 44}`, class: 'bars', role: 'img', 'aria-label': text },
    Array.from({ length: count }, (_, i) => [
      bar(inner[i] ?? 0, i * pitch + pitch * 0.16, 'inner'),
      bar(outer[i] ?? 0, i * pitch + pitch * 0.52, 'outer'),
      s('text', { x: (i + 0.5) * pitch, y: height + 18, 'text-anchor': 'middle', class: 'small-text' }, i + 1),
    ]),
    s('line', { x1: 0, x2: width, y1: height, y2: height, class: 'measure' }),
    s('text', { x: 0, y: -6, class: 'small-text' }, `largest ${quantity(largest, 'N')}`),
  );
}
