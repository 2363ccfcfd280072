// The form of a shaft: its lists and single fields. It writes edits into the request; errors appear at the field of their pointer.

import { designationField } from './designation.js';
import { h, labelledRadio, more, select, small, tools } from './dom.js';
import { help } from './fields.js';
import { field, Fields, focusFirstError, idOf, offered, openAround, ownDimensions, readNumber, textInput } from './form.js';
import { atRamp, rampOf, readRampTime, withRamp } from './ramp.js';
import { read, write } from './request.js';
import { ANALYSIS, LISTS, OPERATION, RUN, SHAFT, SPINDLE, TERMS } from './shaft-lists.js';
import { arrangement, dimensions, EXAMPLE, isRigid, listAt, renamed, without } from './shaft-request.js';

const BEARINGS = '/scene/bearings';
const PRELOADS = '/scene/preloads';
/** The choice of own dimensions. */
const OWN = '';

export class ShaftForm {
  #fields = new Fields();
  #places = new Map();
  /** Elements that belong to a shaft or to a rigid spindle only. */
  #parts = [];

  /** `onChange(request)` gets every changed request. */
  constructor(host, { document: openapi, presets, catalogue, onChange }) {
    Object.assign(this, { host, openapi, presets, catalogue, onChange });
    // The service's document decides: what it does not describe is left out.
    this.known = LISTS.filter(({ of }) => openapi.components.schemas[of]).map((list) => ({
      ...list,
      fields: this.#described(list),
      more: (list.more ?? []).map((group) => ({ ...group, fields: this.#described(group) })),
    }));
    this.lists = new Map(this.known.map((list) => [list.pointer, this.#list(list)]));
    host.replaceChildren(
      this.#kind(),
      this.#group(OPERATION),
      this.#group(SPINDLE),
      ...[...this.lists.values()].map(({ element }) => element),
      this.#group(SHAFT),
      this.#group(TERMS),
      this.#group(ANALYSIS),
      this.#group(RUN),
    );
  }

  /** Whether a field contains text that is not a number. */
  get unreadable() {
    return this.#fields.unreadable;
  }

  /** Shows a request. The field that is being edited keeps its text. */
  show(request) {
    this.request = request;
    const part = isRigid(request) ? 'spindle' : 'shaft';
    if (request.scene.shaft) this.shaft = request.scene.shaft;
    this.kind.querySelector(`[value=${part}]`).checked = true;
    for (const { element, part: own } of this.#parts) element.hidden = own !== part;
    // A list is built anew when its items, or those that it may name, change.
    for (const list of this.known) {
      const shown = this.lists.get(list.pointer);
      const items = listAt(request, list.pointer);
      const shape = JSON.stringify([
        items.length,
        ...namedIn(list).map((pointer) => listAt(request, pointer).map(({ name }) => name)),
      ]);
      if (shape !== shown.shape) this.#build(list, shown, items.length, shape);
      shown.summary.textContent = items.length && !list.open ? `${list.title}: ${items.length}` : list.title;
    }
    for (const [pointer, { input, ofValue, when, ramp }] of this.#fields) {
      // A value that does not belong here stays in sight: its error is at its field.
      if (when) input.closest('.field').hidden = read(request, pointer) === undefined && !this.#holds(when, request);
      if (!this.#fields.isUnreadable(pointer) && document.activeElement !== input) input.value = ofValue(ramp ? rampOf(request)[ramp] : read(request, pointer));
      if (input.tagName === 'INPUT') input.placeholder = this.#fallback(pointer);
    }
    this.#notes();
  }

  /** Shows errors at their fields, else at the item or list that holds them. Returns those of no place. */
  showErrors(errors) {
    const { places, elsewhere } = this.#fields.showErrors(atRamp(errors), (pointer) => this.#places.has(pointer));
    for (const [pointer, error] of this.#places) {
      error.textContent = (places.get(pointer) ?? []).join('\n');
      if (error.textContent) openAround(error);
    }
    return elsewhere;
  }

  /** Focuses the first field of an item. */
  focus(pointer) {
    const [found] = [...this.#fields].filter(([one]) => one.startsWith(`${pointer}/`) && !one.endsWith('/name'));
    const input = found?.[1].input;
    if (!input) return;
    openAround(input);
    input.focus({ preventScroll: true });
    input.closest('.item').scrollIntoView({ block: 'nearest' });
  }

  focusFirstError() {
    focusFirstError(this.host);
  }

  /** Removes an item; the button that adds one to its list gets the focus. */
  remove(pointer, index) {
    const request = without(this.request, pointer, index);
    const list = this.lists.get(pointer);
    list.shape = '';
    this.#change(request);
    list.adder.focus();
  }

  #change(request) {
    this.show(request);
    this.onChange(request);
  }

  /** The fields of a list or group that the service describes. */
  #described({ of, fields }) {
    return fields.filter((spec) => this.#schema(spec.of ?? of, spec.path));
  }

  /** The schema of a field: a property of `of`, named by the last step that is no index. */
  #schema(of, path) {
    const property = path.split('/').findLast((step) => !/^\d+$/.test(step));
    return this.openapi.components.schemas[of]?.properties?.[property];
  }

  #fallback(pointer) {
    const { fallback = '' } = this.#fields.get(pointer);
    const bearing = pointer.match(/^(\/scene\/bearings\/\d+\/bearing)\/(\w+)$/);
    const value = bearing && dimensions(read(this.request, bearing[1]), this.presets)[bearing[2]];
    return typeof value === 'number' ? String(value) : fallback;
  }

  /** The choice between a shaft of sections and a rigid spindle. The shaft is kept for the way back. */
  #kind() {
    const choose = (part) => {
      const { spindle, ...scene } = this.request.scene;
      if (spindle) this.spindle = spindle;
      const other = part === 'shaft' ? { shaft: this.shaft ?? structuredClone(EXAMPLE.scene.shaft) } : { spindle: this.spindle };
      delete scene.shaft;
      this.#fields.giveUp();
      this.#change({ ...this.request, scene: JSON.parse(JSON.stringify({ ...other, ...scene })) });
    };
    const one = ([value, text]) => labelledRadio({ name: 'shaft-part', value, onchange: () => choose(value) }, text);
    const parts = [
      ['shaft', 'Shaft of sections'],
      ['spindle', 'Rigid spindle'],
    ];
    this.kind = h('fieldset', { class: 'segments' }, h('legend', { class: 'unseen' }, 'What the bearings hold'), parts.map(one));
    return this.kind;
  }

  #group({ title, open, of, part, fields }) {
    const element = h(
      'details',
      { class: 'group', open },
      h('summary', {}, title),
      h(
        'div',
        { class: 'fields' },
        fields.map((spec) => this.#field(spec.pointer, { of, ...spec })),
      ),
    );
    if (part) this.#parts.push({ element, part });
    return element;
  }

  #list({ pointer, title, item, open, part, fresh }) {
    const summary = h('summary', {}, title);
    const items = h('div', {});
    const error = h('p', { class: 'error', 'aria-live': 'polite' });
    const note = h('p', { class: 'note' });
    this.#places.set(pointer, error);
    const add = () => {
      const count = listAt(this.request, pointer).length;
      this.#change(write(this.request, pointer, [...listAt(this.request, pointer), fresh(this.request)]));
      this.focus(`${pointer}/${count}`);
    };
    const adder = small(`Add ${item.toLowerCase()}`, add);
    const element = h('details', { class: 'group', open }, summary, error, items, note, tools(adder));
    if (part) this.#parts.push({ element, part });
    return { summary, items, note, adder, element };
  }

  #build(list, shown, count, shape) {
    shown.shape = shape;
    const gone = (known) => known.startsWith(`${list.pointer}/`);
    this.#fields.forget(gone);
    for (const key of [...this.#places.keys()].filter(gone)) this.#places.delete(key);
    const groups = () => [...shown.items.querySelectorAll('details')];
    const open = groups().map((group) => group.open);
    shown.items.replaceChildren(...Array.from({ length: count }, (_, i) => this.#item(list, i)));
    groups().forEach((group, i) => (group.open = open[i] ?? false));
  }

  #item({ pointer, item, of, fields, more: groups = [] }, index) {
    const here = `${pointer}/${index}`;
    const error = h('p', { class: 'error', 'aria-live': 'polite' });
    this.#places.set(here, error);
    const inside = (specs, schema) =>
      specs.map(({ when, ...spec }) =>
        this.#field(`${here}/${spec.path}`, { of: schema, ...spec, when: when && [`${here}/${when[0]}`, when[1]] }),
      );
    return h(
      'fieldset',
      { class: 'item' },
      h('legend', {}, `${item} ${index + 1}`),
      pointer === BEARINGS && [this.#bearing(`${here}/bearing`), this.#designation(`${here}/bearing`)],
      h('div', { class: fields.length === 3 ? 'fields three' : 'fields' }, inside(fields, of)),
      error,
      groups.map((group) => more(group.summary, h('div', { class: 'fields' }, inside(group.fields, group.of)))),
      small('Remove', () => this.remove(pointer, index), { 'aria-label': `Remove ${item.toLowerCase()} ${index + 1}` }),
    );
  }

  /** The choice of a preset or of own dimensions. */
  #bearing(pointer) {
    const choose = (name) => {
      const now = dimensions(read(this.request, pointer), this.presets);
      this.#change(write(this.request, pointer, name || ownDimensions(now)));
    };
    const input = select([...Object.keys(this.presets.bearings).map((name) => [name, name]), [OWN, 'own dimensions']], choose);
    return this.#registered(pointer, input, {
      label: 'Bearing',
      ofValue: (value) => offered(input, typeof value === 'string' ? value : (value?.preset ?? OWN)),
    });
  }

  /** A bearing of the catalogue by its designation. */
  #designation(pointer) {
    const id = `${idOf('s', pointer)}-designation`;
    const choose = (name) => this.#change(write(this.request, pointer, name));
    return designationField({ id, list: `${id}s`, label: 'or by designation', catalogue: this.catalogue, choose });
  }

  #field(pointer, spec) {
    if (spec.choices || spec.names) return this.#choice(pointer, spec);
    const input = spec.text
      ? textInput(() => this.#change(renamed(this.request, pointer, input.value.trim())), 'text')
      : textInput(() => this.#typed(pointer, spec));
    const ofValue = (value) => (typeof value === 'object' ? 'list' : (value ?? ''));
    return this.#registered(pointer, input, { ...spec, ofValue });
  }

  /** Whether a field exists for the chosen value of another one. */
  #holds([pointer, values], request) {
    return values.includes(read(request, pointer) ?? this.#fields.get(pointer)?.input.options[0].value);
  }

  #choice(pointer, { choices, names, others = [], unset, ...spec }) {
    const pairs = names
      ? [...others, ...listAt(this.request, names).map(({ name }) => [name, name])]
      : typeof choices === 'function'
        ? choices(this.presets)
        : choices;
    const input = select(pairs, (value) => this.#chosen(pointer, value));
    const usual = () => unset?.(this.request, pointer, this.presets) ?? pairs[0]?.[0] ?? '';
    const ofValue = (value) => (typeof value === 'object' ? '' : (value ?? usual()));
    return this.#registered(pointer, input, { ...spec, ofValue });
  }

  /** Sets a choice. Fields that exist for other choices only lose their values. */
  #chosen(pointer, value) {
    let request = write(this.request, pointer, value || undefined);
    const isOther = (one) => {
      const { when } = this.#fields.get(one);
      return when?.[0] === pointer && !when[1].includes(value);
    };
    this.#fields.giveUp(isOther);
    for (const [one] of this.#fields) if (isOther(one)) request = write(request, one, undefined);
    this.#change(request);
  }

  #registered(pointer, input, { label, unit, of, fallback, ofValue, when, ramp, help: hint = help(this.#schema(of, pointer) ?? {}) }) {
    const shown = field({ id: idOf('s', pointer), label, unit, input, help: hint });
    return this.#fields.add(pointer, { ...shown, fallback, ofValue, when, ramp });
  }

  #typed(pointer, { size, alike, ramp }) {
    const { value, error } = this.#fields.read(pointer, ramp === 'time' ? readRampTime : readNumber);
    if (error) this.onChange(this.request);
    else if (ramp) this.#change(withRamp(this.request, { ...rampOf(this.request), [ramp]: value }));
    else this.#change(write(this.request, pointer, value, { size, others: alike ? value : 0 }));
  }

  /** The arrangement of each preloaded pair. */
  #notes() {
    const bearings = listAt(this.request, BEARINGS);
    const pairs = listAt(this.request, PRELOADS).map(({ between = [] }) =>
      between.map((name) => bearings.find((one) => one.name === name)),
    );
    const texts = pairs
      .filter((pair) => pair.length === 2 && pair.every(Boolean))
      .map((pair) => `${pair[0].name} and ${pair[1].name}: ${arrangement(pair)}`);
    this.lists.get(PRELOADS).note.textContent = texts.join('; ');
  }
}

/** Lists whose items the fields of a list name. */
const namedIn = ({ fields, more: groups = [] }) => [
  ...new Set([...fields, ...groups.flatMap((group) => group.fields)].map(({ names }) => names).filter(Boolean)),
];
