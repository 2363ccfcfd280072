// Elements. No text is parsed as HTML, so no text of the service or of a link can become markup.

/** An element: attributes, listeners (`onclick`), properties (`.value`), children. */
export function h(tag, attributes = {}, ...children) {
  return build(document.createElement(tag), attributes, children);
}

/** An SVG element. */
export function s(tag, attributes = {}, ...children) {
  return build(document.createElementNS('http://www.w3.org/2000/svg', tag), attributes, children);
}

function build(element, attributes, children) {
  for (const [name, value] of Object.entries(attributes)) {
    if (value === undefined || value === null || value === false) continue;
    if (name.startsWith('on')) element.addEventListener(name.slice(2), value);
    else if (name.startsWith('.')) element[name.slice(1)] = value;
    else element.setAttribute(name, value === true ? '' : value);
  }
  element.append(...children.flat(Infinity).filter((child) => child !== null && child !== undefined && child !== false));
  return element;
}

/** A table with a caption, column heads and rows of cells. All columns except the first are aligned to the right. */
export function table(caption, heads, rows, { hidden = false } = {}) {
  const head = (cell, i) => h('th', { scope: 'col', class: i ? 'num' : undefined }, cell);
  const cell = (content, i) => (i === 0 ? h('th', { scope: 'row' }, content) : h('td', { class: 'num' }, content));
  return h(
    'div',
    { class: 'scroll', tabindex: '0', role: 'region', 'aria-label': caption },
    h(
      'table',
      {},
      h('caption', { class: hidden ? 'unseen' : undefined }, caption),
      h('thead', {}, h('tr', {}, heads.map(head))),
      h(
        'tbody',
        {},
        rows.map((row) => h('tr', {}, row.map(cell))),
      ),
    ),
  );
}

/** The name of a line such as `6·BPFO + f_r`, with its subscript. */
export function lineName(label) {
  return label.split(/_(\w+)/).map((part, i) => (i % 2 ? h('sub', {}, part) : part));
}

/** Options of a select from pairs of value and text. */
export const options = (pairs) => pairs.map(([value, text]) => h('option', { value }, text));

/** A button; `small` in groups of buttons. */
export const button = (text, onclick, attributes = {}) => h('button', { type: 'button', onclick, ...attributes }, text);
export const small = (text, onclick, attributes = {}) => button(text, onclick, { class: 'small', ...attributes });

/** A select from pairs of value and text; `onchange` gets the new value. */
export function select(pairs, onchange = () => {}, attributes = {}) {
  return h('select', { onchange: (event) => onchange(event.target.value), ...attributes }, options(pairs));
}

/** A control after its label, optionally with its unit. */
export const labelled = (text, ...controls) => h('label', {}, `${text} `, controls);

/** A radio button with its label. */
export const labelledRadio = (attributes, text) =>
  h('label', {}, h('input', { type: 'radio', ...attributes }), h('span', {}, text));

/** Controls in a row. */
export const tools = (...controls) => h('div', { class: 'tools' }, controls);

/** Content that opens on request. */
export const more = (summary, ...content) => h('details', {}, h('summary', {}, summary), content);
