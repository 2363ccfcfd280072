// The request as JSON: reading and changing it by JSON pointers, and keeping it in the address of the page.
// It contains only what the user entered; the service adds the defaults.

export const START = {
  kind: 'simulation',
  scene: {
    bearing: '6205',
    operation: { speed_rpm: 3000, radial_load_y_n: 500 },
    spindle: { balance_grade: 6.3 },
  },
};

/** Pointers at which a name may replace an object, with the member of the object that holds the name. */
const NAMED = { '/scene/bearing': 'preset', '/scene/lubricant': 'kind' };

/** The steps of a JSON pointer. */
export const steps = (pointer) =>
  pointer
    .split('/')
    .slice(1)
    .map((step) => step.replaceAll('~1', '/').replaceAll('~0', '~'));

export function read(object, pointer) {
  return steps(pointer).reduce((at, step) => (typeof at === 'object' && at !== null ? at[step] : undefined), object);
}

/** A copy with one value set, or removed if it is `undefined`. */
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

/** Removes empty objects, and replaces an object with only a name by the name. */
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

/** Whether a request has a shaft, or bearings on a rigid spindle. */
export const isOfShaft = (request) => Boolean(request?.scene?.shaft ?? request?.scene?.bearings);

/** Requests, run and tab from the part of the address after `#`. */
export function fromAddress() {
  const parameters = new URLSearchParams(location.hash.slice(1));
  const [job, shaft] = ['job', 'shaft'].map((name) => {
    try {
      return JSON.parse(parameters.get(name));
    } catch {
      // An incomplete link is ignored.
      return null;
    }
  });
  const whole = (value) => (value && typeof value === 'object' ? value : null);
  return { job: whole(job), shaft: isOfShaft(whole(shaft)) ? shaft : null, run: parameters.get('run'), tab: parameters.get('tab') };
}

/** Whether a word has the form of a job id. */
export const isId = (word) => /^[0-9a-f]{8}(-[0-9a-f]{4}){3}-[0-9a-f]{12}$/.test(word);

/** Only the tab of the shaft needs the request of the shaft. */
export function toAddress({ job, shaft, run, tab }) {
  const parameters = new URLSearchParams({ job: JSON.stringify(job) });
  if (shaft && tab === 'shaft') parameters.set('shaft', JSON.stringify(shaft));
  if (run) parameters.set('run', run);
  if (tab && tab !== 'result') parameters.set('tab', tab);
  history.replaceState(null, '', `#${parameters}`);
}
