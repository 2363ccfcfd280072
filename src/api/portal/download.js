// Downloads of results, and the curl commands for them.

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

/** Fetches a file, with the token if there is one, and saves it. */
export const keep = async (name, path, type) => save(name, await api.getText(path, type), type);

/** The values of nested objects as rows of JSON pointer and value. */
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

/** Text quoted as one word of a POSIX shell. */
export const quoted = (text) => `'${text.replaceAll("'", "'\\''")}'`;

/** The curl command of a request. The token is a shell variable, so the command can be shared. */
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

/** A command with a button that copies it, or selects it if the clipboard is not available. */
export function command(text) {
  const place = h('code', { tabindex: '0' }, text);
  const status = h('span', { role: 'status' });
  const copy = async () => {
    try {
      await navigator.clipboard.writeText(place.textContent);
      status.textContent = 'Copied';
    } catch {
      getSelection().selectAllChildren(place);
      status.textContent = 'Selected: press Ctrl+C';
    }
    setTimeout(() => {
      status.textContent = '';
    }, 3000);
  };
  return h('div', { class: 'command' }, h('pre', {}, place), small('Copy command', copy), status);
}
