// A varied field of the scene, and the axis of a study or an optimum: its field, range and points.

import { h, labelled, select } from './dom.js';
import { rangeAround, schemaAt, VARIED } from './fields.js';
import { read } from './request.js';

/** Points of an axis as it opens: of one axis, and of each of two. */
const POINTS = [9, 7];

/** A field of the scene that varies, chosen by the user. */
export class VariedField {
  /** `label`: that of the choice. `pointer`: the field at first. `fields`: those offered. `others`: choices before them. */
  constructor({ document, request, resolved, label, pointer, onChange, fields = VARIED, others = [] }) {
    Object.assign(this, { document, request, resolved });
    this.field = select([...others, ...fields.map((f) => [f.pointer, f.label])], onChange);
    this.field.value = pointer;
    this.choice = labelled(label, this.field);
  }

  get spec() {
    return VARIED.find(({ pointer }) => pointer === this.field.value);
  }

  /** Path of the field in the scene. */
  get path() {
    return this.field.value.replace('/scene', '');
  }

  /** The value of the field in the form, a range around it, and its schema. */
  around() {
    const { spec } = this;
    const resolved = this.resolved();
    const value = read(this.request(), spec.pointer) ?? read(resolved, spec.pointer) ?? (spec.derived && read(resolved, spec.derived));
    const schema = schemaAt(this.document, spec.pointer);
    return { value, range: rangeAround(spec, value, schema), schema };
  }
}

export class VariedAxis extends VariedField {
  /** `first`: whether it is the first of the axes; a further one may be absent. */
  constructor({ first, ...settings }) {
    super({
      ...settings,
      label: first ? 'Parameter' : 'Second parameter',
      others: first ? [] : [['', 'none']],
      onChange: () => this.reset(),
    });
    this.first = first;
    const short = (name) => h('input', { type: 'text', inputmode: 'decimal', class: 'short', 'aria-label': name });
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
    this.element = h('div', { class: 'tools' }, this.choice, first && [this.range, this.grid]);
  }

  get isThere() {
    return this.field.value !== '';
  }

  /** Sets the range around the value of the form. The entered range is kept as long as the value is unchanged. */
  reset() {
    if (!this.first) {
      if (this.isThere) this.element.append(this.range, this.grid);
      else [this.range, this.grid].forEach((part) => part.remove());
    }
    if (!this.resolved() || !this.isThere) return;
    const { spec } = this;
    const {
      value,
      range: [from, to],
    } = this.around();
    const base = `${spec.pointer} ${value}`;
    if (base === this.base) return;
    this.base = base;
    Object.assign(this.from, { value: from });
    Object.assign(this.to, { value: to });
    if (spec.whole) this.count.value = to - from + 1;
    this.unit.textContent = spec.unit;
  }

  /** The axis of a request; `search`: only its range. */
  value(search) {
    const range = { path: this.path, from: Number(this.from.value), to: Number(this.to.value) };
    if (search) return range;
    return { ...range, count: Number(this.count.value), ...(this.scale.value === 'log' && { scale: 'log' }) };
  }
}
