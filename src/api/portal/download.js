// Taking results away: files, and the command that fetches the same from a shell.

import * as api from './api.js';
import { h, small } from './dom.js';

export function save(name, text, type) {
  const address = URL.createObjectURL(new Blob([text], { type }));
  const link = h('a', { href: address, download: name });
  document.body.append(link);
  link.click();
  link.remove();
  setTimeout(() => URL.revokeObjectURL(address), 10000);
}

/** Fetches a file, with the token where there is one, and saves it. */
export const keep = async (name, path, type) => save(name, await api.getText(path, type), type);

/** Numbers of nested objects as CSV: a JSON pointer and its value a row. */
export function flat(object, here = '') {
  return Object.entries(object).flatMap(([name, value]) => {
    const pointer = `${here}/${name.replaceAll('~', '~0').replaceAll('/', '~1')}`;
    return typeof value === 'object' && value !== null ? flat(value, pointer) : [[pointer, value]];
  });
}

export const csv = (rows) =>
  rows
    .map((row) => row.map(csvCell).join(','))
    .join('\n')
    .concat('\n');

const csvCell = (value) => {
  const text = String(value ?? '');
  return /[",\n\r]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text;
};

/** A word of a POSIX shell, whatever it holds. */
export const quoted = (text) => `'${text.replaceAll("'", "'\\''")}'`;

/** The curl command of a request; the token stays a variable of the shell, so that the command can be shown around. */
export function curl({ method = 'GET', path, body, accept, token }) {
  const parts = ['curl -sS'];
  if (method !== 'GET') parts.push(`-X ${method}`);
  if (token) parts.push('-H "Authorization: Bearer $RACEWAY_TOKEN"');
  if (accept) parts.push(`-H ${quoted(`Accept: ${accept}`)}`);
  if (body !== undefined)
    parts.push(`-H ${quoted('Content-Type: application/json')}`, `--data-raw ${quoted(JSON.stringify(body))}`);
  parts.push(quoted(new URL(path, location.origin).href));
  return parts.join(' ');
}

/** A command with a button that copies it; where the page may not use the clipboard, it selects the text instead. */
export function command(text) {
  const place = h('code', { tabindex: '0' }, text);
  const said = h('span', { role: 'status' });
  const copy = async () => {
    try {
      await navigator.clipboard.writeText(place.textContent);
      said.textContent = 'Copied';
    } catch {
      getSelection().selectAllChildren(place);
      said.textContent = 'Selected: press Ctrl+C';
    }
    setTimeout(() => {
      said.textContent = '';
    }, 3000);
  };
  return h('div', { class: 'command' }, h('pre', {}, place), small('Copy command', copy), said);
}
