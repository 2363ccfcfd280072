// The fields of an uncertainty job: uncertain inputs with their distributions, the samples, and the metrics. Limits and defaults come
// from the OpenAPI document.

import { h, labelled, select, small, tools } from './dom.js';
import { VARIED } from './fields.js';
import { readNumber } from './form.js';
import { words } from './format.js';
import { read } from './request.js';
import { SEARCHED } from './study-metrics.js';
import { VariedField } from './varied-axis.js';

/** The field that a clearance group describes. */
const CLEARANCE = '/scene/bearing/radial_clearance_um';
/** Deviation of an input as it opens, as a share of the range of a slider: small enough for samples with which most scenes can be built. */
const DEVIATION = 0.05;
/** Digits of a value as it opens. */
const DIGITS = 4;

/** Fields of a distribution: label, and of a number its value as it opens, from the value of the scene and a deviation from it. */
const FIELDS = {
  mean: ['Mean', (value) => value],
  standard_deviation: ['Standard deviation', (value, deviation) => deviation],
  from: ['From', (value, deviation) => value - deviation],
  mode: ['Most probable', (value) => value],
  to: ['To', (value, deviation) => value + deviation],
  nominal: ['Nominal', (value) => value],
  plus: ['Plus', (value, deviation) => deviation],
  minus: ['Minus', (value, deviation) => deviation],
  group: ['Group'],
  values: ['Values', (value, deviation) => [value - deviation, value, value + deviation]],
  weights: ['Weights'],
};
/** Fields that are lists of numbers. */
const LISTS = ['values', 'weights'];
const SEPARATOR = ';';
/** Fields that each distribution takes. */
const DISTRIBUTIONS = {
  normal: ['mean', 'standard_deviation', 'from', 'to'],
  uniform: ['from', 'to'],
  triangular: ['from', 'mode', 'to'],
  lognormal: ['mean', 'standard_deviation'],
  tolerance: ['nominal', 'plus', 'minus'],
  discrete: ['values', 'weights'],
  clearance_group: ['group'],
};
/** Placeholder of a field that may stay empty: a normal distribution need not be cut, and weights are equal. */
const placeholder = (type, name) => {
  if (type === 'normal' && ['from', 'to'].includes(name)) return 'not cut';
  return name === 'weights' ? 'equal' : '';
};

class UncertainInput extends VariedField {
  constructor({ remove, ...settings }) {
    super({
      ...settings,
      label: 'Parameter',
      onChange: () => {
        this.#offer();
        this.reset();
      },
    });
    this.distribution = select([], () => this.reset());
    this.controls = {};
    this.fields = h('span', { class: 'tools' });
    this.legend = h('legend', {});
    this.removal = small('Remove', () => remove(this));
    const kind = labelled('Distribution', this.distribution);
    this.element = h('fieldset', { class: 'item' }, this.legend, tools(this.choice, kind, this.fields, this.removal));
    this.#offer();
    this.reset();
  }

  /** Names the input by its place in the list. */
  name(place) {
    this.place = `Input ${place}`;
    this.legend.textContent = this.place;
    this.removal.setAttribute('aria-label', `Remove input ${place}`);
  }

  /** Offers the distributions of the field, and keeps the chosen one if it is among them. */
  #offer() {
    // Whole numbers have values of a list only, and a clearance group describes one field.
    const isFor = (type) => (type === 'clearance_group' ? this.field.value === CLEARANCE : type === 'discrete' || !this.spec.whole);
    const offered = Object.keys(DISTRIBUTIONS).filter(isFor);
    const chosen = offered.find((type) => type === this.distribution.value) ?? offered[0];
    this.distribution.replaceChildren(...offered.map((type) => h('option', { value: type }, words(type))));
    this.distribution.value = chosen;
  }

  /** Sets the numbers of the distribution around the value of the form. Entered ones are kept as long as that is unchanged. */
  reset() {
    if (!this.resolved()) return;
    const type = this.distribution.value;
    const { value, range, schema } = this.around();
    const base = [this.field.value, type, value].join(' ');
    if (base === this.base) return;
    this.base = base;
    const [from, to] = range;
    const middle = typeof value === 'number' ? value : (from + to) / 2;
    const control = (name) => {
      if (name === 'group') return this.#group();
      const empty = placeholder(type, name);
      const deviation = this.spec.whole ? 1 : DEVIATION * (to - from);
      const number = (start) => Number(Math.max(start, schema.minimum ?? -Infinity).toPrecision(DIGITS));
      const text = empty ? { placeholder: empty } : { value: [FIELDS[name][1](middle, deviation)].flat().map(number).join(`${SEPARATOR} `) };
      const shape = LISTS.includes(name) ? {} : { class: 'short', inputmode: 'decimal' };
      return h('input', { type: 'text', autocomplete: 'off', ...shape, ...text });
    };
    this.controls = Object.fromEntries(DISTRIBUTIONS[type].map((name) => [name, control(name)]));
    const shown = Object.entries(this.controls).map(([name, one]) => labelled(FIELDS[name][0], one));
    this.fields.replaceChildren(...shown, type === 'clearance_group' ? '' : this.spec.unit);
  }

  /** The choice of a clearance group; at first that of the scene, else the ordinary one. */
  #group() {
    const group = select(this.document.components.schemas.ClearanceGroupName.enum.map((name) => [name, name]));
    group.value = read(this.resolved(), '/derived/clearance/group') ?? 'CN';
    return group;
  }

  /** The input of a request. */
  get value() {
    const entry = ([name, { value: text }]) => {
      if (name === 'group') return [name, text];
      const number = (one) => {
        const { value, error } = readNumber(one);
        if (error) throw new Error(`${this.place}, ${FIELDS[name][0].toLowerCase()}: ${error}`);
        return value;
      };
      if (!LISTS.includes(name)) return [name, number(text)];
      return [name, text.trim() ? text.split(SEPARATOR).map(number) : undefined];
    };
    const fields = Object.fromEntries(Object.entries(this.controls).map(entry));
    return { path: this.path, distribution: { type: this.distribution.value, ...fields } };
  }
}

export class UncertaintyForm {
  constructor(settings) {
    this.settings = settings;
    const { schemas } = settings.document.components;
    const { inputs, samples, design, seed } = schemas.UncertaintyJob.properties;
    const whole = ({ minimum, maximum, default: value }) =>
      h('input', { type: 'number', min: minimum, max: maximum, value, class: 'short', oninput: () => this.#count() });
    this.most = inputs.maxItems;
    this.inputs = [];
    this.list = h('div', {});
    this.add = small('Add input', () => this.#add().field.focus());
    this.samples = whole(samples);
    this.design = select(schemas.DesignName.enum.map((name) => [name, words(name)]), () => this.#count());
    this.design.value = design.default;
    this.seed = whole(seed);
    this.runs = h('span', { class: 'note', role: 'status' });
    this.metrics = SEARCHED.map(([pointer], i) => h('input', { type: 'checkbox', value: pointer, checked: i === 0 }));
    const boxes = this.metrics.map((box, i) => h('label', {}, box, SEARCHED[i][1]));
    this.elements = [
      this.list,
      tools(this.add),
      tools(labelled('Samples', this.samples), labelled('Design', this.design), labelled('Seed', this.seed), this.runs),
      h('fieldset', { class: 'item' }, h('legend', {}, 'Metrics'), tools(boxes)),
    ];
    this.#add();
  }

  /** Adds an input of a field that is not uncertain yet, the clearance first; returns it. */
  #add() {
    const isFree = (pointer) => !this.inputs.some(({ field }) => field.value === pointer);
    const pointer = [CLEARANCE, ...VARIED.map((one) => one.pointer)].find(isFree);
    const input = new UncertainInput({ ...this.settings, pointer, remove: (one) => this.#remove(one) });
    this.inputs.push(input);
    this.#show();
    return input;
  }

  #remove(input) {
    this.inputs = this.inputs.filter((one) => one !== input);
    this.#show();
    this.add.focus();
  }

  #show() {
    this.list.replaceChildren(...this.inputs.map(({ element }) => element));
    this.inputs.forEach((input, i) => {
      input.name(i + 1);
      input.removal.hidden = this.inputs.length === 1;
    });
    this.add.disabled = this.inputs.length === this.most;
    this.#count();
  }

  /** Shows how many runs the samples are: pairs repeat them for each input and twice more, and the nominal run is one more. */
  #count() {
    const times = this.design.value === 'pairs' ? this.inputs.length + 2 : 1;
    this.runs.textContent = `${this.samples.value * times + 1} runs`;
  }

  reset() {
    this.inputs.forEach((input) => input.reset());
  }

  /** The fields of a request. */
  get value() {
    return {
      inputs: this.inputs.map(({ value }) => value),
      samples: Number(this.samples.value),
      design: this.design.value,
      seed: Number(this.seed.value),
      metrics: this.metrics.filter(({ checked }) => checked).map(({ value }) => value),
    };
  }
}
