// What the forms of the page share: fields, the reading of numbers, and errors at the field of their pointer.

import { h } from './dom.js';
import { plainNumber } from './format.js';

/** Required dimensions of a bearing without preset. */
const REQUIRED = [
  'type',
  'outer_diameter_mm',
  'inner_diameter_mm',
  'width_mm',
  'ball_count',
  'ball_diameter_mm',
  'pitch_diameter_mm',
];

/** The required dimensions of a bearing, as the start of one without preset. */
export const ownDimensions = (bearing) => Object.fromEntries(REQUIRED.map((name) => [name, bearing[name]]));

/** Adds a designation of the catalogue to a choice of bearings, before the last one; returns it. */
export function offered(select, name) {
  const isKnown = [...select.options].some((option) => option.value === name);
  if (!isKnown) select.add(h('option', { value: name }, name), select.options.length - 1);
  return name;
}

/** Id of the field of a pointer; `form`: a letter of the form. */
export const idOf = (form, pointer) => `${form}${pointer.replaceAll('/', '-')}`;

/** A control for a typed text. */
export const textInput = (oninput, inputmode = 'decimal') =>
  h('input', { type: 'text', inputmode, autocomplete: 'off', spellcheck: 'false', oninput });

/** A control with label, unit, place for errors, and help. */
export function field({ id, label, unit, input, help, isWide }) {
  const error = h('p', { id: `${id}-error`, class: 'error', 'aria-live': 'polite' });
  input.id = id;
  input.setAttribute('aria-describedby', [unit && `${id}-unit`, help && `${id}-hint`, `${id}-error`].filter(Boolean).join(' '));
  const element = h(
    'div',
    { class: isWide ? 'field wide' : 'field' },
    h('label', { for: id }, label),
    h('div', { class: 'entry' }, input, unit && h('span', { id: `${id}-unit`, class: 'unit' }, unit)),
    error,
    help && h('p', { id: `${id}-hint`, class: 'hint' }, help),
  );
  return { input, error, element };
}

/** The `value` of a typed number, undefined if the text is empty, or an `error`. */
export function readNumber(typed) {
  const text = plainNumber(typed);
  if (text === '') return {};
  if (Number.isFinite(Number(text))) return { value: Number(text) };
  const isGrouped = /^\d{1,3}(,\d{3})+$/.test(text);
  const remedy = isGrouped
    ? `: a comma may separate thousands. Write ${text.replaceAll(',', '')} or ${text.replace(',', '.')}`
    : '';
  return { error: `This is not a number${remedy}.` };
}

/** Fields by the pointer of their value. */
export class Fields {
  #all = new Map();
  #unreadable = new Map();

  /** Adds a field of `field`, with what else its form keeps of it. */
  add(pointer, one) {
    this.#all.set(pointer, one);
    return one.element;
  }

  get = (pointer) => this.#all.get(pointer);
  has = (pointer) => this.#all.has(pointer);

  [Symbol.iterator]() {
    return this.#all.entries();
  }

  /** Removes fields that are built anew. */
  forget(isGone = () => true) {
    for (const pointer of [...this.#all.keys()].filter(isGone)) {
      this.#all.delete(pointer);
      this.#unreadable.delete(pointer);
    }
  }

  /** Whether a field contains a text that cannot be read. */
  get unreadable() {
    return this.#unreadable.size > 0;
  }

  isUnreadable = (pointer) => this.#unreadable.has(pointer);

  /** What the text of a field says; an error is kept until the text is read again. */
  read(pointer, read = readNumber) {
    const { value, error } = read(this.#all.get(pointer).input.value);
    if (error) this.#unreadable.set(pointer, error);
    else this.#unreadable.delete(pointer);
    return { value, error };
  }

  /** Texts that cannot be read are given up, because another value takes their place. */
  giveUp(isGone = () => true) {
    for (const pointer of [...this.#unreadable.keys()].filter(isGone)) this.#unreadable.delete(pointer);
  }

  /** Shows errors at their fields and opens the groups around them. An error without a field goes to the nearest field or place above it.
   *  Returns the texts of places, and the errors without either. */
  showErrors(errors, isPlace = () => false) {
    const at = new Map();
    const elsewhere = [];
    for (const { pointer, detail } of errors) {
      // An error of a whole list of numbers stands at the first of them.
      const exact = [pointer, `${pointer}/0`].find((one) => this.has(one) || isPlace(one));
      let near = exact ?? pointer;
      while (near && !this.has(near) && !isPlace(near)) near = near.slice(0, near.lastIndexOf('/'));
      const text = exact ? detail : `${pointer.slice(near.length + 1)}: ${detail}`;
      if (near) at.set(near, [...(at.get(near) ?? []), text]);
      else elsewhere.push({ pointer, detail });
    }
    for (const [pointer, detail] of this.#unreadable) at.set(pointer, [detail]);
    for (const [pointer, one] of this.#all) {
      const details = at.get(pointer) ?? [];
      showError(one, details);
      if (details.length) openAround(one.input);
      at.delete(pointer);
    }
    return { places: at, elsewhere };
  }
}

/** Shows the errors of a field, or none. */
function showError({ input, error }, details) {
  error.textContent = details.join('\n');
  input.closest('.field').classList.toggle('wrong', details.length > 0);
  if (details.length) input.setAttribute('aria-invalid', 'true');
  else input.removeAttribute('aria-invalid');
}

/** Opens the groups around an element. */
export function openAround(element) {
  for (let group = element?.closest('details'); group; group = group.parentElement.closest('details')) group.open = true;
}

/** Focuses the first field with an error. */
export const focusFirstError = (form) => form.querySelector('.field.wrong :is(input, select)')?.focus();
