// Elements. Nothing is ever parsed as HTML, so no text of a service or of a link can become markup.

/** An element: attributes, listeners (`onclick`), properties (`.value`), children. */
export function h(tag, attributes = {}, ...children) {
  return build(document.createElement(tag), attributes, children);
}

/** The same in SVG. */
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

/** A table: heads, then rows of cells. Cells that are numbers or marked `num` stand to the right. */
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

/** The name of a line, `6·BPFO + f_r`, with its index as one. */
export function lineName(label) {
  return label.split(/_(\w+)/).map((part, i) => (i % 2 ? h('sub', {}, part) : part));
}

/** Options of a select from pairs of value and text. */
export const options = (pairs) => pairs.map(([value, text]) => h('option', { value }, text));

/** A button; `small` where it stands among others. */
export const button = (text, onclick, attributes = {}) => h('button', { type: 'button', onclick, ...attributes }, text);
export const small = (text, onclick, attributes = {}) => button(text, onclick, { class: 'small', ...attributes });

/** A choice between pairs of value and text; `onchange` hears the new value. */
export function select(pairs, onchange = () => {}, attributes = {}) {
  return h('select', { onchange: (event) => onchange(event.target.value), ...attributes }, options(pairs));
}

/** A control with its words before it, and perhaps its unit behind it. */
export const labelled = (text, ...controls) => h('label', {}, `${text} `, controls);

/** One of several that exclude each other. */
export const labelledRadio = (attributes, text) =>
  h('label', {}, h('input', { type: 'radio', ...attributes }), h('span', {}, text));

/** Controls side by side. */
export const tools = (...controls) => h('div', { class: 'tools' }, controls);

/** What is shown once it is asked for. */
export const more = (summary, ...content) => h('details', {}, h('summary', {}, summary), content);
