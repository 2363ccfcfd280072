// One varied parameter of a study or an optimum: its field, range and points.

import { h, labelled, select } from './dom.js';
import { rangeAround, schemaAt, VARIED } from './fields.js';
import { read } from './request.js';

/** Points of an axis as it opens: of one axis, and of each of two. */
const POINTS = [9, 7];

export class VariedAxis {
  /** `first`: whether it is the first of the axes; a further one may be absent. */
  constructor({ document, request, resolved, first, pointer, onChange = () => {} }) {
    Object.assign(this, { document, request, resolved, first });
    const short = (name) => h('input', { type: 'text', inputmode: 'decimal', class: 'short', 'aria-label': name });
    this.field = select([...(first ? [] : [['', 'none']]), ...VARIED.map((f) => [f.pointer, f.label])], () => {
      this.reset();
      onChange();
    });
    this.field.value = pointer;
    const prefix = first ? '' : 'Second: ';
    this.from = short(`${prefix}From`);
    this.to = short(`${prefix}To`);
    this.count = h('input', { type: 'number', min: 2, max: 200, value: POINTS[first ? 0 : 1], class: 'short' });
    this.scale = select([
      ['linear', 'linear'],
      ['log', 'log'],
    ]);
    this.unit = h('span', { class: 'unit' });
    this.range = h('span', { class: 'tools' }, labelled('From', this.from), labelled('To', this.to, ' ', this.unit));
    this.grid = h('span', { class: 'tools' }, labelled('Points', this.count), labelled('Spacing', this.scale));
    this.element = h('div', { class: 'tools' }, labelled(first ? 'Parameter' : 'Second parameter', this.field), first && [this.range, this.grid]);
  }

  get isThere() {
    return this.field.value !== '';
  }

  get spec() {
    return VARIED.find(({ pointer }) => pointer === this.field.value);
  }

  /** Sets the range around the value of the form. The entered range is kept as long as the value is unchanged. */
  reset() {
    const resolved = this.resolved();
    if (!this.first) {
      if (this.isThere) this.element.append(this.range, this.grid);
      else [this.range, this.grid].forEach((part) => part.remove());
    }
    if (!resolved || !this.isThere) return;
    const { spec } = this;
    const value = read(this.request(), spec.pointer) ?? read(resolved, spec.pointer);
    const base = `${spec.pointer} ${value}`;
    if (base === this.base) return;
    this.base = base;
    const [from, to] = rangeAround(spec, value, schemaAt(this.document, spec.pointer));
    Object.assign(this.from, { value: from });
    Object.assign(this.to, { value: to });
    if (spec.whole) this.count.value = to - from + 1;
    this.unit.textContent = spec.unit;
  }

  /** The axis of a request; `search`: only its range. */
  value(search) {
    const range = { path: this.field.value.replace('/scene', ''), from: Number(this.from.value), to: Number(this.to.value) };
    if (search) return range;
    return { ...range, count: Number(this.count.value), ...(this.scale.value === 'log' && { scale: 'log' }) };
  }
}
