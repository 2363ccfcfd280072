// The request as plain contract JSON: reading and changing it by JSON pointers, and keeping it in the address.
// It holds what the user said and nothing else; defaults are the service's.

export const START = {
  kind: 'simulation',
  scene: {
    bearing: '6205',
    operation: { speed_rpm: 3000, radial_load_y_n: 500 },
    spindle: { balance_grade: 6.3 },
  },
};

/** Where a name may stand for an object: the member of the object that then says the name. */
const NAMED = { '/scene/bearing': 'preset', '/scene/lubricant': 'kind' };

const steps = (pointer) =>
  pointer
    .split('/')
    .slice(1)
    .map((step) => step.replaceAll('~1', '/').replaceAll('~0', '~'));

export function read(object, pointer) {
  return steps(pointer).reduce((at, step) => (typeof at === 'object' && at !== null ? at[step] : undefined), object);
}

/** A copy with one value said, or, by `undefined`, no longer said. */
export function write(job, pointer, value) {
  const copy = structuredClone(job);
  const path = steps(pointer);
  const last = path.pop();
  let at = copy;
  let here = '';
  for (const step of path) {
    here += `/${step}`;
    if (typeof at[step] === 'string' && NAMED[here]) at[step] = { [NAMED[here]]: at[step] };
    if (typeof at[step] !== 'object' || at[step] === null) at[step] = {};
    at = at[step];
  }
  if (value === undefined) delete at[last];
  else at[last] = value;
  return tidy(copy);
}

/** Empty objects go, and an object that says only a name becomes the name. */
function tidy(job) {
  const swept = (value, here) => {
    if (typeof value !== 'object' || value === null || Array.isArray(value)) return value;
    const members = Object.entries(value)
      .map(([name, inner]) => [name, swept(inner, `${here}/${name}`)])
      .filter(([, inner]) => inner !== undefined);
    const keepsEmpty = ['', '/scene', '/scene/operation', '/scene/bearing'].includes(here);
    if (members.length === 0 && !keepsEmpty) return undefined;
    if (members.length === 1 && members[0][0] === NAMED[here]) return members[0][1];
    return Object.fromEntries(members);
  };
  return swept(job, '');
}

/** What the address says after `#`: the request and the run that is shown. */
export function fromAddress() {
  const said = new URLSearchParams(location.hash.slice(1));
  let job = null;
  try {
    job = JSON.parse(said.get('job'));
  } catch {
    // A link that was cut off: the page starts as without it.
  }
  return { job: job && typeof job === 'object' ? job : null, run: said.get('run'), tab: said.get('tab') };
}

/** Whether a word can be the id of a job. */
export const isId = (word) => /^[0-9a-f]{8}(-[0-9a-f]{4}){3}-[0-9a-f]{12}$/.test(word);

export function toAddress({ job, run, tab }) {
  const said = new URLSearchParams({ job: JSON.stringify(job) });
  if (run) said.set('run', run);
  if (tab && tab !== 'result') said.set('tab', tab);
  history.replaceState(null, '', `#${said}`);
}
