// A field for bearings of the catalogue by designation.

import { h } from './dom.js';
import { field } from './form.js';
import { plain } from './format.js';

/** A field for designations, with those of the catalogue as suggestions. They are fetched when the field is first used. `choose(name)` gets
 *  the designation; the field is empty then. */
export function designationField({ id, list, label = 'Designation', help, catalogue, choose }) {
  const suggestions = h('datalist', { id: list });
  const input = h('input', { type: 'text', list, autocomplete: 'off', spellcheck: 'false', maxlength: '40' });
  const suggest = async () => {
    try {
      const { bearings } = await catalogue();
      const size = (one) => [one.bore_mm, one.outer_diameter_mm, one.width_mm].map(plain).join(' × ');
      const text = (one) => `${size(one)} mm, C ${plain(one.c_iso281_kn)} kN, ${one.confidence} confidence`;
      suggestions.replaceChildren(...bearings.map((one) => h('option', { value: one.designation }, text(one))));
    } catch {
      // A designation can be typed without suggestions.
    }
  };
  input.addEventListener('focus', suggest, { once: true });
  const take = () => {
    const name = input.value.trim();
    if (!name) return;
    input.value = '';
    choose(name);
  };
  input.addEventListener('change', take);
  // Enter ends the name, and does not submit the form.
  input.addEventListener('keydown', (event) => {
    if (event.key !== 'Enter') return;
    event.preventDefault();
    take();
  });
  const { element } = field({ id, label, input, help, isWide: true });
  element.append(suggestions);
  return element;
}
