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

/** Members that a name may replace, with the member of the object that holds the name. */
const NAMED = { bearing: 'preset', lubricant: 'kind' };
/** Objects and lists that stay though they are empty, because a request needs them. */
const REQUIRED = ['scene', 'operation', 'shaft', 'sections', 'bearing', 'bearings'];

const isIndex = (step) => /^\d+$/.test(step);
/** Nothing, an object of nothing, or a list of zeros. */
const isEmpty = (value) =>
  value === undefined ||
  (Array.isArray(value) && value.every((one) => one === 0)) ||
  (typeof value === 'object' && value !== null && Object.values(value).every(isEmpty));

/** Whether two values of JSON are equal. Members have no order: the service writes its own. */
export function isEqual(one, other) {
  const [members, others] = [one, other].map((value) => (typeof value === 'object' && value !== null ? Object.keys(value) : null));
  if (!members || !others) return one === other;
  return members.length === others.length && members.every((name) => isEqual(one[name], other[name]));
}

/** The steps of a JSON pointer. */
const steps = (pointer) =>
  pointer
    .split('/')
    .slice(1)
    .map((step) => step.replaceAll('~1', '/').replaceAll('~0', '~'));

export function read(object, pointer) {
  return steps(pointer).reduce((at, step) => (typeof at === 'object' && at !== null ? at[step] : undefined), object);
}

/** A copy with one value set, or removed if it is `undefined`. A name becomes an object for changes of what it names, and a name again
 *  without them. `size`: length of a list of numbers that begins with this value, `others`: its other numbers. */
export function write(request, pointer, value, { size = 0, others = 0 } = {}) {
  const copy = structuredClone(request);
  const path = steps(pointer);
  const parents = [];
  let at = copy;
  path.slice(0, -1).forEach((step, i) => {
    if (typeof at[step] === 'string' && NAMED[step]) at[step] = { [NAMED[step]]: at[step] };
    if (typeof at[step] !== 'object' || at[step] === null) at[step] = isIndex(path[i + 1]) ? Array(size).fill(others) : {};
    parents.push([at, step]);
    at = at[step];
  });
  const last = path.at(-1);
  // A list of numbers has no gaps.
  if (value !== undefined) at[last] = value;
  else if (Array.isArray(at)) at[last] = 0;
  else delete at[last];
  for (const [parent, step] of value === undefined ? parents.toReversed() : []) {
    const inner = parent[step];
    if (NAMED[step] && Object.keys(inner).join() === NAMED[step]) parent[step] = inner[NAMED[step]];
    else if (isEmpty(inner) && !REQUIRED.includes(step) && !isIndex(step)) delete parent[step];
  }
  return copy;
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
  const [run, tab] = ['run', 'tab'].map((name) => parameters.get(name));
  // A job of a shaft under the other name is one for the form of the shaft.
  if (['rotor', 'machine'].includes(job?.kind) && isOfShaft(job)) return { job: null, shaft: job, run, tab: tab ?? 'shaft' };
  return { job: whole(job), shaft: isOfShaft(whole(shaft)) ? shaft : null, run, tab };
}

/** Whether a word has the form of a job id. */
export const isId = (word) => /^[0-9a-f]{8}(-[0-9a-f]{4}){3}-[0-9a-f]{12}$/.test(word);

/** A shaft that was edited stays in the address, so that a reload on another tab keeps it. */
export function toAddress({ job, shaft, run, tab }) {
  const parameters = new URLSearchParams({ job: JSON.stringify(job) });
  if (shaft) parameters.set('shaft', JSON.stringify(shaft));
  if (run) parameters.set('run', run);
  if (tab && tab !== 'result') parameters.set('tab', tab);
  history.replaceState(null, '', `#${parameters}`);
}
