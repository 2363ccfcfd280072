// The form: a view of the request. It writes edits into the request and shows the defaults of the service as placeholders. Errors
// appear at the field of their pointer.

import { designationField } from './designation.js';
import { h, select } from './dom.js';
import { GROUPS, FIELDS, help, schemaAt } from './fields.js';
import { field, Fields, focusFirstError, idOf, offered, ownDimensions, readNumber, textInput } from './form.js';
import { PAIR, pairOf, plain, plainNumber, words } from './format.js';
import { atRamp, rampOf, readRampTime, withRamp } from './ramp.js';
import { read, write } from './request.js';
import { SurfacesForm } from './surfaces.js';

const BEARING = '/scene/bearing';

export class SceneForm {
  #fields = new Fields();

  /** `onChange(job)` gets every changed request; `compare()` runs the scene with and without its surfaces; `catalogue()` gives the bearings
   *  of the catalogue. */
  constructor(host, { document, presets, onChange, compare, catalogue }) {
    Object.assign(this, { host, document, presets, onChange, catalogue });
    // A request from outside and one from the surfaces show alike.
    this.surfaces = new SurfacesForm({ document, presets, onChange: (job) => this.#update(job), compare });
    const groups = GROUPS.map((group) => this.#group(group));
    host.replaceChildren(this.#bearing(), this.#designation(), ...groups.slice(0, -1), this.surfaces.element, ...groups.slice(-1));
    host.addEventListener('focusin', (event) => this.#explain(event.target));
  }

  /** Shows a request. The field that is being edited keeps its text. */
  show(job) {
    this.job = job;
    const { bearing } = job.scene ?? {};
    this.preset.value = offered(this.preset, typeof bearing === 'string' ? bearing : (bearing?.preset ?? ''));
    const changed = typeof bearing === 'object' && bearing?.preset;
    this.presetNote.textContent = !this.preset.value
      ? 'All dimensions are entered below.'
      : `${this.presets.bearings[this.preset.value]?.description ?? 'bearing of the catalogue'}${changed ? '; with changes below' : ''}`;
    for (const spec of FIELDS) {
      const { input } = this.#fields.get(spec.pointer);
      const value = this.#requested(spec);
      if (!this.#fields.isUnreadable(spec.pointer) && !(document.activeElement === input && same(spec, input.value, value))) {
        input.value = shown(spec, value);
      }
      input.closest('.field').classList.toggle('edited', value !== undefined);
    }
    this.surfaces.show(job);
  }

  /** Shows the defaults of empty fields. */
  showDefaults(resolved) {
    for (const spec of FIELDS) {
      const { input } = this.#fields.get(spec.pointer);
      const value = spec.lubricants
        ? resolved.scene.lubricant?.kind
        : (read(resolved, spec.pointer) ?? (spec.derived && read(resolved, spec.derived)));
      const name = spec.materials ? this.#materialName(value) : value;
      // A chosen value is no default.
      if (input.tagName === 'SELECT') input.options[0].textContent = typeof name === 'string' && !input.value ? `${words(name)} (default)` : (spec.absent ?? 'automatic');
      else if (spec.automatic && value === undefined) input.placeholder = 'automatic';
      else input.placeholder = [value].flat().every((one) => typeof one === 'number') ? [value].flat().map(plain).join(PAIR) : '';
    }
    this.surfaces.showDefaults(resolved);
  }

  /** Shows errors at their fields and returns those without a field. */
  showErrors(errors) {
    return this.#fields.showErrors(this.surfaces.showErrors(atRamp(errors))).elsewhere;
  }

  /** Whether a field contains text that is not a number. */
  get unreadable() {
    return this.#fields.unreadable || this.surfaces.unreadable;
  }

  /** Focuses the field of the first error. */
  focusFirstError() {
    focusFirstError(this.host);
  }

  #bearing() {
    const names = Object.keys(this.presets.bearings);
    this.preset = select([...names.map((name) => [name, name]), ['', 'own dimensions']], () => this.#choosePreset());
    this.presetNote = h('p', { id: 'preset-note', class: 'note' });
    const preset = field({ id: 'preset', label: 'Bearing', input: this.preset, isWide: true });
    this.preset.setAttribute('aria-describedby', 'preset-note preset-error');
    preset.element.classList.add('preset');
    preset.element.append(this.presetNote);
    return this.#fields.add(BEARING, preset);
  }

  #designation() {
    const help = 'A bearing of the catalogue, with suffixes if you like: 6206-2RS/C3, 7008C. C2 to C5 set the clearance group.';
    const choose = (name) => {
      this.#fields.giveUp();
      this.#update(write(this.job, BEARING, name));
    };
    return designationField({ id: 'designation', list: 'designations', help, catalogue: this.catalogue, choose });
  }

  #choosePreset() {
    this.#fields.giveUp();
    const name = this.preset.value;
    const current = this.resolved?.scene.bearing ?? Object.values(this.presets.bearings)[0].bearing;
    this.#update(write(this.job, BEARING, name || ownDimensions(current)));
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
    const schema = schemaAt(this.document, spec.pointer);
    const edited = () => this.#edited(spec, input);
    const input = spec.choices || spec.lubricants || spec.materials ? select(this.#choices(spec, schema), edited) : textInput(edited);
    const label = [spec.label, symbol(spec.symbol)].filter(Boolean);
    const id = idOf('f', spec.pointer);
    return this.#fields.add(spec.pointer, field({ id, label, unit: spec.unit, input, help: spec.help ?? help(schema), isWide: spec.wide }));
  }

  #choices(spec, schema) {
    const presets = spec.lubricants ? this.presets.lubricants : spec.materials && this.presets.materials;
    const names = presets ? Object.keys(presets) : (schema.enum ?? []);
    return [['', 'default'], ...names.map((name) => [name, words(name)])];
  }

  /** The preset with the constants of a material; nothing for one of its own. */
  #materialName(material) {
    const names = ['elastic_modulus_gpa', 'poisson_ratio', 'density_kg_m3'];
    const isSame = ([, preset]) => names.every((name) => preset[name] === material?.[name]);
    return Object.entries(this.presets.materials).find(isSame)?.[0];
  }

  /** The value of a field in the request; undefined if it is absent. */
  #requested(spec) {
    if (spec.ramp) return rampOf(this.job)[spec.ramp];
    const value = read(this.job, spec.pointer);
    return spec.lubricants && typeof value === 'object' ? value.kind : value;
  }

  #edited(spec, input) {
    const isNumber = input.tagName === 'INPUT';
    const text = { value: input.value.trim() || undefined };
    const { value, error } = isNumber ? this.#fields.read(spec.pointer, readerOf(spec)) : text;
    if (error) {
      this.onChange(this.job);
      return;
    }
    if (spec.ramp) {
      this.#update(withRamp(this.job, { ...rampOf(this.job), [spec.ramp]: value }));
      return;
    }
    const keep = spec.lubricants && typeof read(this.job, spec.pointer) === 'object' ? `${spec.pointer}/kind` : spec.pointer;
    this.#update(write(this.job, keep, value));
  }

  #update(job) {
    this.show(job);
    this.onChange(job);
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

/** The reader of a typed text. */
function readerOf({ pair, ramp }) {
  if (pair) return readPair;
  return ramp === 'time' ? readRampTime : readNumber;
}

/** The `value` of two typed numbers, undefined if the text is empty, or an `error`. */
function readPair(text) {
  const value = pairOf(text) ?? undefined;
  return value || text.trim() === '' ? { value } : { error: 'These are not two numbers. Write, for example, 890 to 3500.' };
}

/** The text of a value in its field. */
function shown(spec, value) {
  if (value === undefined) return '';
  if (spec.pair && Array.isArray(value)) return value.join(PAIR);
  return typeof value === 'object' ? 'profile' : String(value);
}

/** Whether the text of a field already has the value: `500.` and `500` are equal. */
function same(spec, text, value) {
  if (text.trim() === '') return value === undefined;
  return spec.pair ? String(pairOf(text)) === String(value) : Number(plainNumber(text)) === value;
}
