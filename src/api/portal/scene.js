// The form: a view of the request. It writes what was edited into the request and shows, as placeholders,
// what the service fills in; errors appear at the field that the service's pointer names.

import { h, options } from './dom.js';
import { GROUPS, FIELDS, help, schemaAt } from './fields.js';
import { number, words } from './format.js';
import { read, write } from './request.js';

/** What a bearing without a preset must say; it starts from the bearing that was shown. */
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

  /** `onChange(job)` is told every request that the form makes. */
  constructor(host, { document, presets, onChange }) {
    this.document = document;
    this.presets = presets;
    this.onChange = onChange;
    host.replaceChildren(this.#bearing(), ...GROUPS.map((group) => this.#group(group)));
    host.addEventListener('focusin', (event) => this.#explain(event.target));
  }

  /** Shows a request. Fields that the user is writing in are left alone. */
  show(job) {
    this.job = job;
    const { bearing } = job.scene ?? {};
    this.preset.value = typeof bearing === 'string' ? bearing : (bearing?.preset ?? '');
    const changed = typeof bearing === 'object' && bearing?.preset;
    this.presetNote.textContent = !this.preset.value
      ? 'Every dimension is your own.'
      : `${this.presets.bearings[this.preset.value]?.description ?? ''}${changed ? '; changed below' : ''}`;
    for (const spec of FIELDS) {
      const input = this.#inputs.get(spec.pointer);
      const value = this.#said(spec);
      if (!this.#unreadable.has(spec.pointer) && !(document.activeElement === input && same(input.value, value))) {
        input.value = value === undefined ? '' : typeof value === 'object' ? 'profile' : String(value);
      }
      input.closest('.field').classList.toggle('edited', value !== undefined);
    }
  }

  /** Shows what the service fills in where nothing was said. */
  showDefaults(resolved) {
    for (const spec of FIELDS) {
      const input = this.#inputs.get(spec.pointer);
      const value = spec.lubricants
        ? resolved.scene.lubricant?.kind
        : (read(resolved, spec.pointer) ?? (spec.derived && read(resolved, spec.derived)));
      if (input.tagName === 'SELECT') input.options[0].textContent = value ? `${words(value)} (default)` : 'automatic';
      else input.placeholder = typeof value === 'number' ? number(value, 5).replaceAll('\u202f', '') : '';
    }
  }

  /** Shows errors at their fields and gives back those that have no field here. */
  showErrors(errors) {
    for (const pointer of this.#errors.keys()) this.#error(pointer, '');
    const elsewhere = [];
    for (const { pointer, detail } of errors) {
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

  /** Whether a field holds something that is no number. */
  get unreadable() {
    return this.#unreadable.size > 0;
  }

  /** Puts the cursor where the first error is. */
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
    this.#tell(write(this.job, '/scene/bearing', name || own));
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

  /** What the request says of a field; undefined where it leaves it out. */
  #said(spec) {
    const value = read(this.job, spec.pointer);
    return spec.lubricants && typeof value === 'object' ? value.kind : value;
  }

  #edited(spec, input) {
    const text = input.value.trim().replace(',', '.').replace('−', '-');
    const isNumber = input.tagName === 'INPUT';
    this.#unreadable.delete(spec.pointer);
    if (isNumber && text !== '' && !Number.isFinite(Number(text))) {
      this.#unreadable.set(spec.pointer, 'This is not a number.');
      this.onChange(this.job);
      return;
    }
    const value = text === '' ? undefined : isNumber ? Number(text) : text;
    const keep = spec.lubricants && typeof read(this.job, spec.pointer) === 'object' ? `${spec.pointer}/kind` : spec.pointer;
    this.#tell(write(this.job, keep, value));
  }

  #tell(job) {
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

  /** The line of help beside the button: one place, so that nothing moves while one goes through the fields. */
  #explain(element) {
    const field = element.closest('.field');
    const hint = field?.querySelector('.hint, .note');
    if (hint) document.getElementById('help').textContent = hint.textContent;
  }
}

/** Letters with an index, as formulas have them. */
export function symbol(text) {
  return text
    ? h('span', { class: 'symbol', 'aria-hidden': 'true' }, h('i', {}, text[0]), text.length > 1 && h('sub', {}, text.slice(1)))
    : null;
}

/** Whether a field's text already says the value: `500.` and `500` do. */
const same = (text, value) => (text.trim() === '' ? value === undefined : Number(text.replace(',', '.')) === value);
