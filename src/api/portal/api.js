// Client of the HTTP API: tokens, problems, retries, and the progress of a job.

const TOKEN = 'raceway-token';

/** A problem in an answer of the service (RFC 9457). */
class Problem extends Error {
  constructor(status, body) {
    super(body.detail || body.title || `The service answered ${status}.`);
    this.status = status;
    this.type = body.type ?? '';
    this.errors = body.errors ?? [];
  }
}

/** Functions of the page that the client calls: asking for a token, reporting a wait. */
export const hooks = { askToken: async () => null, waiting: () => {} };

/** Features of the service, read from its OpenAPI document. */
export const features = { events: false, plots: '' };

export const hasToken = () => sessionStorage.getItem(TOKEN) !== null;
export const setToken = (token) => (token ? sessionStorage.setItem(TOKEN, token) : sessionStorage.removeItem(TOKEN));

/** Largest number of retries. */
const MAX_RETRIES = 5;
/** Longest wait before a retry [s]. */
const MAX_WAIT = 30;

/** `again`: whether the request may be repeated after a broken connection, because a repetition changes nothing. `asks`: whether a refused
 *  request asks for a token. */
async function send(method, path, { body, headers = {}, signal, again = method === 'GET', retry = true, asks = true } = {}) {
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
      if (asks && (await newToken(token))) continue;
      throw await problemOf(response);
    }
    const wait = retry && attempt < MAX_RETRIES ? waitBefore(response, attempt, again) : null;
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

/** Wait before the next retry [s]; null: no retry. A request answered by 429 had no effect, so it may always be repeated. */
function waitBefore(response, attempt, again) {
  const backoff = Math.min(0.5 * 2 ** attempt, 8);
  if (!response) return again ? backoff : null;
  if (response.status !== 429 && !(response.status === 503 && again)) return null;
  const stated = Number(response.headers.get('Retry-After') || backoff);
  return stated <= MAX_WAIT ? Math.max(stated, 0.2) : null;
}

async function problemOf(response) {
  const body = await response.json().catch(() => ({}));
  return new Problem(response.status, body);
}

let asking = null;

/** Whether there is a token other than the refused one. Requests that fail together ask once. */
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

/** Derived quantities of a scene. Without retries, because the next keystroke sends a new request. */
export const resolve = async (job, signal) =>
  (await send('POST', '/v1/scenes/resolve', { body: job, signal, retry: false })).json();

/** The analysis of a rotor. Without retries, because the next edit sends a new request. */
export const analyse = async (job, signal) => (await send('POST', '/v1/rotor', { body: job, signal, retry: false })).json();

/** Submits a job. The idempotency key makes retries safe. */
export const submit = async (job) =>
  (await send('POST', '/v1/jobs', { body: job, again: true, headers: { 'Idempotency-Key': key() } })).json();

/** Runs a simulation without a job: its metrics and spectra. Aborting ends the run. Without retries, because the next position of the slider
 *  replaces it. */
export const preview = async (job, signal) => (await send('POST', '/v1/preview', { body: job, signal, retry: false })).json();

/** A random key. `crypto.randomUUID` exists only in secure contexts, and a service on a local network is not one. */
function key() {
  return [...crypto.getRandomValues(new Uint8Array(16))].map((byte) => byte.toString(16).padStart(2, '0')).join('');
}

/** Recent jobs `{ jobs, next }`. */
export const recentJobs = (path = '/v1/jobs?limit=25') => get(path);

export const spectrum = (id, channel, maxFrequency, signal, kind) => get(spectrumPath(id, channel, maxFrequency, kind), { signal });

export function spectrumPath(id, channel, maxFrequency, kind = 'amplitude') {
  const limit = maxFrequency ? `&max_frequency_hz=${maxFrequency}` : '';
  const other = kind === 'amplitude' ? '' : `&kind=${kind}`;
  return `/v1/jobs/${id}/spectrum?channel=${encodeURIComponent(channel)}${other}${limit}`;
}

export const hasEnded = (job) => !['queued', 'running'].includes(job.status);

/** Follows a job and returns it when it has ended, by events if the service has them, else by polling. */
export async function follow(job, { signal, onProgress }) {
  if (features.events && !hasEnded(job)) {
    try {
      await listen(job, signal, onProgress);
    } catch (error) {
      if (signal?.aborted) throw error;
      // The stream may be interrupted by a proxy; polling continues.
    }
  }
  for (let wait = 100; ; wait = Math.min(wait * 1.4, 1500)) {
    const now = await get(job.links.self, { signal });
    onProgress(now);
    if (hasEnded(now)) return now;
    await sleep(wait, signal);
  }
}

/** Reads server-sent events with fetch, which can send a token, unlike EventSource. Returns after the last event. */
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
