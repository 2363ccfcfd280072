// The HTTP API: tokens, problems, waiting and trying again, and the progress of a job.

const TOKEN = 'raceway-token';

/** A problem that the service stated (RFC 9457). */
class Problem extends Error {
  constructor(status, body) {
    super(body.detail || body.title || `The service answered ${status}.`);
    this.status = status;
    this.type = body.type ?? '';
    this.errors = body.errors ?? [];
  }
}

/** What the page does when the API needs it: ask for a token, tell that it waits. */
export const hooks = { askToken: async () => null, waiting: () => {} };

/** What this version of the service can do, read from its own document instead of trying it. */
export const features = { events: false, plots: '' };

export const hasToken = () => sessionStorage.getItem(TOKEN) !== null;
export const setToken = (token) => (token ? sessionStorage.setItem(TOKEN, token) : sessionStorage.removeItem(TOKEN));

/** Times a request is tried again, and the longest wait that is still worth it [s]. */
const TRIES = 5;
const LONGEST_WAIT = 30;

/** Only what changes nothing when it is repeated may be sent again after the connection broke. */
async function send(method, path, { body, headers = {}, signal, again = method === 'GET', retry = true } = {}) {
  let waited = false;
  for (let attempt = 0; ; attempt += 1) {
    const token = sessionStorage.getItem(TOKEN);
    const response = await fetch(path, {
      method,
      signal,
      headers: {
        Accept: 'application/json',
        ...(body === undefined ? {} : { 'Content-Type': 'application/json' }),
        ...(token ? { Authorization: `Bearer ${token}` } : {}),
        ...headers,
      },
      body: body === undefined ? undefined : JSON.stringify(body),
    }).catch((error) => {
      if (error.name === 'AbortError') throw error;
      return null;
    });
    if (response?.status === 401) {
      if (await newToken(token)) continue;
      throw await problemOf(response);
    }
    const wait = retry && attempt < TRIES ? waitBefore(response, attempt, again) : null;
    if (wait === null) {
      if (waited) hooks.waiting(null);
      if (!response) throw new Error('The service cannot be reached.');
      if (!response.ok) throw await problemOf(response);
      return response;
    }
    waited = true;
    hooks.waiting(
      response ? (response.status === 429 ? 'The queue is full' : 'The service is not ready') : 'No connection',
      wait,
    );
    await sleep(wait * 1000, signal);
  }
}

/** Seconds until the next try; null where there is none. A 429 took nothing, so anything may be sent again. */
function waitBefore(response, attempt, again) {
  const backoff = Math.min(0.5 * 2 ** attempt, 8);
  if (!response) return again ? backoff : null;
  if (response.status !== 429 && !(response.status === 503 && again)) return null;
  const stated = Number(response.headers.get('Retry-After') || backoff);
  return stated <= LONGEST_WAIT ? Math.max(stated, 0.2) : null;
}

async function problemOf(response) {
  const body = await response.json().catch(() => ({}));
  return new Problem(response.status, body);
}

let asking = null;

/** True once there is a token other than the one that was refused. Requests that fail together ask once. */
async function newToken(refused) {
  if (sessionStorage.getItem(TOKEN) !== refused) return true;
  asking ??= hooks.askToken(refused !== null).finally(() => {
    asking = null;
  });
  const token = await asking;
  setToken(token);
  return Boolean(token);
}

function sleep(milliseconds, signal) {
  return new Promise((resolve, reject) => {
    const stop = () => {
      clearTimeout(timer);
      reject(new DOMException('stopped', 'AbortError'));
    };
    const timer = setTimeout(() => {
      signal?.removeEventListener('abort', stop);
      resolve();
    }, milliseconds);
    if (signal?.aborted) stop();
    signal?.addEventListener('abort', stop, { once: true });
  });
}

export const get = async (path, settings) => (await send('GET', path, settings)).json();
export const getText = async (path, accept, settings) =>
  (await send('GET', path, { ...settings, headers: { Accept: accept } })).text();
export const remove = (path) => send('DELETE', path, { again: true });
export const cancel = async (job) => (await send('POST', `${job.links.self}/cancel`, { again: true })).json();

/** Quantities that follow from a scene. A form that changes needs no second try: the next keystroke asks again. */
export const resolve = async (job, signal) =>
  (await send('POST', '/v1/scenes/resolve', { body: job, signal, retry: false })).json();

/** Submits a job. The key makes sending it again safe. */
export const submit = async (job) =>
  (await send('POST', '/v1/jobs', { body: job, again: true, headers: { 'Idempotency-Key': key() } })).json();

/** Submits a job and waits for its end; not tried again, because the next position of the slider is better. */
export const submitAndWait = async (job, seconds, signal) =>
  (await send('POST', '/v1/jobs', { body: job, signal, retry: false, headers: { Prefer: `wait=${seconds}` } })).json();

/** `crypto.randomUUID` exists in secure contexts only, and a service on a local network is none. */
function key() {
  return [...crypto.getRandomValues(new Uint8Array(16))].map((byte) => byte.toString(16).padStart(2, '0')).join('');
}

/** Jobs of the slider carry this label, so that lists can leave them out. */
export const SLIDER = 'portal-slider';

/** Recent jobs without those of the slider, which may fill whole pages: `{ jobs, next }`. */
export async function recentJobs(path = '/v1/jobs?limit=100', wanted = 25) {
  const found = [];
  let next = path;
  for (let pages = 0; next && found.length < wanted && pages < 5; pages += 1) {
    const page = await get(next);
    found.push(...page.jobs.filter((job) => !job.labels.includes(SLIDER)));
    next = page.next;
  }
  return { jobs: found, next };
}

export const spectrum = (id, channel, maxFrequency, signal) => get(spectrumPath(id, channel, maxFrequency), { signal });

export function spectrumPath(id, channel, maxFrequency, kind = 'amplitude') {
  const limit = maxFrequency ? `&max_frequency_hz=${maxFrequency}` : '';
  const other = kind === 'amplitude' ? '' : `&kind=${kind}`;
  return `/v1/jobs/${id}/spectrum?channel=${encodeURIComponent(channel)}${other}${limit}`;
}

export const hasEnded = (job) => !['queued', 'running'].includes(job.status);

/** Follows a job to its end and gives it back; events where the service has them, else questions. */
export async function follow(job, { signal, onProgress }) {
  if (features.events && !hasEnded(job)) {
    try {
      await listen(job, signal, onProgress);
    } catch (error) {
      if (signal?.aborted) throw error;
      // A proxy that breaks the stream off loses nothing: the job can still be asked.
    }
  }
  for (let wait = 100; ; wait = Math.min(wait * 1.4, 1500)) {
    const now = await get(job.links.self, { signal });
    onProgress(now);
    if (hasEnded(now)) return now;
    await sleep(wait, signal);
  }
}

/** Reads server-sent events by fetch, which, unlike EventSource, can send a token. Returns after the last event. */
async function listen(job, signal, onProgress) {
  const response = await send('GET', `${job.links.self}/events`, { signal, headers: { Accept: 'text/event-stream' } });
  const reader = response.body.pipeThrough(new TextDecoderStream()).getReader();
  let rest = '';
  for (;;) {
    const { value, done } = await reader.read();
    if (done) return;
    const blocks = (rest + value).replaceAll('\r\n', '\n').split('\n\n');
    rest = blocks.pop();
    for (const block of blocks) {
      const of = (field) =>
        block
          .split('\n')
          .filter((line) => line.startsWith(`${field}:`))
          .map((line) => line.slice(field.length + 1).replace(/^ /, ''))
          .join('\n');
      const event = of('event');
      if (event === 'progress') onProgress(JSON.parse(of('data')));
      if (['succeeded', 'failed', 'cancelled'].includes(event)) {
        await reader.cancel();
        return;
      }
    }
  }
}
