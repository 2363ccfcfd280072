// Messages of an answer: each has a code, a severity and a text.

import { h } from './dom.js';

export const isWarning = ({ severity }) => severity === 'warning';

/** Messages as paragraphs, warnings first. The text is shown as it is; the page branches only on code and severity. */
export function messageList(messages = []) {
  return [...messages]
    .sort((a, b) => isWarning(b) - isWarning(a))
    .map((message) =>
      h('p', { class: isWarning(message) ? 'warning' : 'note', role: 'note', 'data-code': message.code }, message.text),
    );
}
