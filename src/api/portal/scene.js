// The form: a view of the request. It writes edits into the request and shows the defaults of the service as placeholders. Errors
// appear at the field of their pointer.

import { h, options } from './dom.js';
import { GROUPS, FIELDS, help, schemaAt } from './fields.js';
import { number, PAIR, pairOf, plainNumber, words } from './format.js';
import { read, write } from './request.js';
import { SurfacesForm } from './surfaces.js';

/** Required fields of a bearing without preset; they start with the values of the current bearing. */
const REQUIRED = [
  'type',
  'outer_diameter_mm',
  'inner_diameter_mm',
  'width_mm',
  'ball_count',
  'ball_diameter_mm',
  'pitch_diameter_mm',
];

export class SceneForm {
  #inputs = new Map();
  #errors = new Map();
  #unreadable = new Map();

  /** `onChange(job)` gets every changed request; `compare()` runs the scene with and without its surfaces. */
  constructor(host, { document, presets, onChange, compare }) {
    this.document = document;
    this.presets = presets;
    this.onChange = onChange;
    // A request from outside and one from the surfaces show alike.
    this.surfaces = new SurfacesForm({ document, presets, onChange: (job) => this.#update(job), compare });
    const groups = GROUPS.map((group) => this.#group(group));
    host.replaceChildren(this.#bearing(), ...groups.slice(0, -1), this.surfaces.element, ...groups.slice(-1));
    host.addEventListener('focusin', (event) => this.#explain(event.target));
  }

  /** Shows a request. The field that is being edited keeps its text. */
  show(job) {
    this.job = job;
    const { bearing } = job.scene ?? {};
    this.preset.value = typeof bearing === 'string' ? bearing : (bearing?.preset ?? '');
    const changed = typeof bearing === 'object' && bearing?.preset;
    this.presetNote.textContent = !this.preset.value
      ? 'All dimensions are entered below.'
      : `${this.presets.bearings[this.preset.value]?.description ?? ''}${changed ? '; with changes below' : ''}`;
    for (const spec of FIELDS) {
      const input = this.#inputs.get(spec.pointer);
      const value = this.#requested(spec);
      if (!this.#unreadable.has(spec.pointer) && !(document.activeElement === input && same(spec, input.value, value))) {
        input.value = shown(spec, value);
      }
      input.closest('.field').classList.toggle('edited', value !== undefined);
    }
    this.surfaces.show(job);
  }

  /** Shows the defaults of empty fields. */
  showDefaults(resolved) {
    for (const spec of FIELDS) {
      const input = this.#inputs.get(spec.pointer);
      const value = spec.lubricants
        ? resolved.scene.lubricant?.kind
        : (read(resolved, spec.pointer) ?? (spec.derived && read(resolved, spec.derived)));
      if (input.tagName === 'SELECT') input.options[0].textContent = value ? `${words(value)} (default)` : 'automatic';
      else if (spec.automatic && value === undefined) input.placeholder = 'automatic';
      else input.placeholder = [value].flat().every((one) => typeof one === 'number') ? [value].flat().map(plain).join(PAIR) : '';
    }
    this.surfaces.showDefaults(resolved);
  }

  /** Shows errors at their fields and returns those without a field. */
  showErrors(errors) {
    for (const pointer of this.#errors.keys()) this.#error(pointer, '');
    const elsewhere = [];
    for (const { pointer, detail } of this.surfaces.showErrors(errors)) {
      const known = [...this.#errors.keys()];
      const near =
        pointer === '/scene/bearing'
          ? 'preset'
          : (known.find((one) => one === pointer) ?? known.find((one) => pointer.startsWith(`${one}/`)));
      if (near) this.#error(near, detail);
      else elsewhere.push({ pointer, detail });
    }
    for (const [pointer, detail] of this.#unreadable) this.#error(pointer, detail);
    return elsewhere;
  }

  /** Whether a field contains text that is not a number. */
  get unreadable() {
    return this.#unreadable.size > 0 || this.surfaces.unreadable;
  }

  /** Focuses the field of the first error. */
  focusFirstError() {
    const field = document.querySelector('.field.wrong');
    field?.querySelector('input, select')?.focus();
  }

  #bearing() {
    const names = Object.keys(this.presets.bearings);
    this.preset = h(
      'select',
      {
        id: 'preset',
        'aria-describedby': 'preset-note preset-error',
        onchange: () => this.#choosePreset(),
      },
      options([...names.map((name) => [name, name]), ['', 'own dimensions']]),
    );
    this.presetNote = h('p', { id: 'preset-note', class: 'note' });
    this.#inputs.set('preset', this.preset);
    const error = h('p', { id: 'preset-error', class: 'error', 'aria-live': 'polite' });
    this.#errors.set('preset', error);
    return h(
      'div',
      { class: 'field wide preset' },
      h('label', { for: 'preset' }, 'Bearing'),
      this.preset,
      error,
      this.presetNote,
    );
  }

  #choosePreset() {
    this.#unreadable.clear();
    const name = this.preset.value;
    const current = this.resolved?.scene.bearing ?? Object.values(this.presets.bearings)[0].bearing;
    const own = Object.fromEntries(REQUIRED.map((field) => [field, current[field]]));
    this.#update(write(this.job, '/scene/bearing', name || own));
  }

  #group(group) {
    const fields = group.fields.map((spec) => this.#field(spec));
    return h(
      'details',
      { class: 'group', open: group.open },
      h('summary', {}, group.name),
      h('div', { class: 'fields' }, fields),
    );
  }

  #field(spec) {
    const id = `f${spec.pointer.replaceAll('/', '-')}`;
    const schema = schemaAt(this.document, spec.pointer);
    const described = { id, 'aria-describedby': `${spec.unit ? `${id}-unit ` : ''}${id}-hint ${id}-error` };
    const input =
      spec.choices || spec.lubricants
        ? h('select', { ...described, onchange: () => this.#edited(spec, input) }, options(this.#choices(spec, schema)))
        : h('input', {
            ...described,
            type: 'text',
            inputmode: 'decimal',
            autocomplete: 'off',
            spellcheck: 'false',
            oninput: () => this.#edited(spec, input),
          });
    this.#inputs.set(spec.pointer, input);
    const error = h('p', { id: `${id}-error`, class: 'error', 'aria-live': 'polite' });
    this.#errors.set(spec.pointer, error);
    return h(
      'div',
      { class: `field${spec.wide ? ' wide' : ''}` },
      h('label', { for: id }, spec.label, symbol(spec.symbol)),
      h('div', { class: 'entry' }, input, spec.unit && h('span', { id: `${id}-unit`, class: 'unit' }, spec.unit)),
      error,
      h('p', { id: `${id}-hint`, class: 'hint' }, help(schema)),
    );
  }

  #choices(spec, schema) {
    const names = spec.lubricants ? Object.keys(this.presets.lubricants) : (schema.enum ?? []);
    return [['', 'default'], ...names.map((name) => [name, words(name)])];
  }

  /** The value of a field in the request; undefined if it is absent. */
  #requested(spec) {
    const value = read(this.job, spec.pointer);
    return spec.lubricants && typeof value === 'object' ? value.kind : value;
  }

  #edited(spec, input) {
    const isNumber = input.tagName === 'INPUT';
    const text = isNumber ? plainNumber(input.value) : input.value.trim();
    this.#unreadable.delete(spec.pointer);
    if (spec.pair && text !== '' && !pairOf(input.value)) {
      this.#unreadable.set(spec.pointer, 'These are not two numbers. Write, for example, 890 to 3500.');
      this.onChange(this.job);
      return;
    }
    if (isNumber && !spec.pair && text !== '' && !Number.isFinite(Number(text))) {
      const digits = /^\d{1,3}(,\d{3})+$/.test(text) ? `: a comma may separate thousands. Write ${text.replaceAll(',', '')} or ${text.replace(',', '.')}` : '';
      this.#unreadable.set(spec.pointer, `This is not a number${digits}.`);
      this.onChange(this.job);
      return;
    }
    const entered = () => (spec.pair ? pairOf(input.value) : isNumber ? Number(text) : text);
    const value = text === '' ? undefined : entered();
    const keep = spec.lubricants && typeof read(this.job, spec.pointer) === 'object' ? `${spec.pointer}/kind` : spec.pointer;
    this.#update(write(this.job, keep, value));
  }

  #update(job) {
    this.show(job);
    this.onChange(job);
  }

  #error(pointer, detail) {
    const error = this.#errors.get(pointer);
    error.textContent = detail;
    error.closest('.field').classList.toggle('wrong', Boolean(detail));
    const input = this.#inputs.get(pointer);
    if (detail) {
      input.setAttribute('aria-invalid', 'true');
      input.closest('details')?.setAttribute('open', '');
    } else {
      input.removeAttribute('aria-invalid');
    }
  }

  /** Shows the help of a field next to the button. A fixed place keeps the form from moving. */
  #explain(element) {
    const field = element.closest('.field');
    const hint = field?.querySelector('.hint, .note');
    if (hint) document.getElementById('help').textContent = hint.textContent;
  }
}

/** A symbol with its subscript. */
export function symbol(text) {
  return text
    ? h('span', { class: 'symbol', 'aria-hidden': 'true' }, h('i', {}, text[0]), text.length > 1 && h('sub', {}, text.slice(1)))
    : null;
}

/** The text of a value in its field. */
function shown(spec, value) {
  if (value === undefined) return '';
  if (spec.pair && Array.isArray(value)) return value.join(PAIR);
  return typeof value === 'object' ? 'profile' : String(value);
}

const plain = (value) => number(value, 5).replaceAll('\u202f', '');

/** Whether the text of a field already has the value: `500.` and `500` are equal. */
function same(spec, text, value) {
  if (text.trim() === '') return value === undefined;
  return spec.pair ? String(pairOf(text)) === String(value) : Number(plainNumber(text)) === value;
}
