/** Client of the raceway API. Types come from its OpenAPI document. */

import type { components, operations } from "./schema.js";

export type Schemas = components["schemas"];
export type Scene = Schemas["SceneInput"];
export type JobRequest = Schemas["JobInput"];
export type Job = Schemas["JobAnswer"];
export type Line = Schemas["LineAnswer"];
export type SpectrumQuery = NonNullable<operations["getSpectrum"]["parameters"]["query"]>;
export type SeriesQuery = NonNullable<operations["getSeries"]["parameters"]["query"]>;
export type JobsQuery = NonNullable<operations["listJobs"]["parameters"]["query"]>;
export type CatalogueQuery = NonNullable<operations["searchCatalogue"]["parameters"]["query"]>;

/** A spectrum with the labelled lines of its channel, strongest first. */
export type LabelledSpectrum = Schemas["SpectrumAnswer"] & { lines: Line[] };

export interface WaitOptions {
  /** Ends the wait; `run` then cancels its job. */
  signal?: AbortSignal;
  /** Receives the job whenever it was looked at. */
  onProgress?: (job: Job) => void;
}

export interface ClientOptions {
  token?: string;
  /** Replaces the global `fetch`. */
  fetch?: typeof fetch;
  /** Longest time for which a request is repeated because the service asks for it or cannot be reached [s]. Default 120. */
  patience_s?: number;
}

/** Error response of the service (RFC 9457). */
export class Refused extends Error {
  override readonly name: string = "Refused";

  constructor(readonly problem: Schemas["Problem"]) {
    super(`${problem.title}: ${problem.detail}`);
  }

  /** Reason for the field with a JSON pointer, such as `/scene/operation/speed_rpm`. */
  at(pointer: string): string | undefined {
    return this.problem.errors?.find((error) => error.pointer === pointer)?.detail;
  }
}

/** A job that has no result: it failed or was cancelled. */
export class JobFailed extends Error {
  override readonly name: string = "JobFailed";

  constructor(readonly job: Job) {
    super(job.error?.detail ?? `the job is ${job.status}`);
  }
}

/** Pause between two looks at a job [s]: it grows from the first to the second. */
const FIRST_PAUSE_S = 0.05;
const LONGEST_PAUSE_S = 0.5;
/** Pause before a service that cannot be reached is tried again [s]. */
const PAUSE_AWAY_S = 1;

/** A service at a URL. */
export class Client {
  readonly #url: string;
  readonly #options: ClientOptions;
  /** Whether the service has answered before: what never answered is not away, but has another address. */
  #hasAnswered = false;

  constructor(url = "http://127.0.0.1:8080", options: ClientOptions = {}) {
    this.#url = url.replace(/\/+$/, "");
    this.#options = options;
  }

  /** The succeeded job of a request. Throws `Refused` or `JobFailed`. */
  async run(request: JobRequest, options: WaitOptions = {}): Promise<Job> {
    const submitted = await this.submit(request, options.signal === undefined ? {} : { signal: options.signal });
    const job = await this.wait(submitted, options).catch(async (error: unknown) => {
      if (options.signal?.aborted) await this.cancel(submitted);
      throw error;
    });
    if (job.status !== "succeeded") throw new JobFailed(job);
    return job;
  }

  /** The accepted job, which runs without this program. A repetition after a broken connection makes no second one. */
  submit(request: JobRequest, options: { signal?: AbortSignal } = {}): Promise<Job> {
    return this.request("POST", "/v1/jobs", { body: request, key: newKey(), ...options });
  }

  /** The job once it has ended, in whatever way. */
  async wait(job: Job, { signal, onProgress }: WaitOptions = {}): Promise<Job> {
    for (let pause = FIRST_PAUSE_S; isUnfinished(job); pause = Math.min(1.5 * pause, LONGEST_PAUSE_S)) {
      onProgress?.(job);
      await sleep(pause, signal);
      job = await this.request("GET", job.links.self, signal === undefined ? {} : { signal });
    }
    onProgress?.(job);
    return job;
  }

  job(id: string): Promise<Job> {
    return this.request("GET", `/v1/jobs/${encodeURIComponent(id)}`);
  }

  /** Jobs, newest first, read page by page. */
  async *jobs(query: JobsQuery = {}): AsyncGenerator<Job, void, undefined> {
    let page: Schemas["JobList"] = await this.request("GET", "/v1/jobs", { query });
    for (;;) {
      yield* page.jobs;
      if (page.next === null) return;
      page = await this.request("GET", page.next);
    }
  }

  /** Asks the service to cancel a job, which ends soon after. */
  cancel(job: Job): Promise<Job> {
    return this.request("POST", `${job.links.self}/cancel`);
  }

  metrics(job: Job): Promise<Schemas["Metrics"]> {
    return this.request("GET", link(job, "metrics"));
  }

  /** Spectrum of a channel, by default of the first one, with its labelled lines. */
  async spectrum(job: Job, query: SpectrumQuery = {}): Promise<LabelledSpectrum> {
    const main = link(job, job.kind === "simulation" ? "metrics" : "machine");
    const [spectrum, answer] = await Promise.all([
      this.request<Schemas["SpectrumAnswer"]>("GET", link(job, "spectrum"), { query }),
      this.request<{ lines?: Line[]; envelope_lines?: Line[] }>("GET", main),
    ]);
    const lines = (spectrum.kind === "envelope" ? answer.envelope_lines : answer.lines) ?? [];
    return { ...spectrum, lines: lines.filter((line) => line.channel === spectrum.channel) };
  }

  /** Time series of a channel that the job recorded (`outputs.series`). */
  series(job: Job, query: SeriesQuery = {}): Promise<Schemas["SeriesAnswer"]> {
    return this.request("GET", link(job, "series"), { query });
  }

  /** Table of a study. */
  table(job: Job): Promise<Schemas["TableAnswer"]> {
    return this.request("GET", link(job, "table"));
  }

  /** The scene with every default, derived values, omitted terms and cost. Nothing runs. */
  resolve(scene: Scene, options: { signal?: AbortSignal } = {}): Promise<Schemas["ResolveAnswer"]> {
    return this.request("POST", "/v1/scenes/resolve", { body: { scene }, ...options });
  }

  presets(): Promise<Schemas["PresetsAnswer"]> {
    return this.request("GET", "/v1/presets");
  }

  catalogue(query: CatalogueQuery = {}): Promise<Schemas["CatalogueAnswer"]> {
    return this.request("GET", "/v1/catalogue", { query });
  }

  /**
   * JSON of any path of the API. Repeats where the service says later (429, 503). Where it has answered before and cannot be reached, as while it
   * restarts, reading requests are repeated, and others with a `key`, by which the service knows a repetition.
   */
  async request<T>(
    method: string,
    path: string,
    { body, query, signal, key }: { body?: unknown; query?: object; signal?: AbortSignal; key?: string } = {},
  ): Promise<T> {
    const { token, patience_s = 120 } = this.#options;
    const call = this.#options.fetch ?? fetch;
    const headers: Record<string, string> = { Accept: "application/json" };
    // A redirection would carry the token to another host.
    const request: RequestInit = { method, headers, redirect: "error" };
    if (token !== undefined) headers["Authorization"] = `Bearer ${token}`;
    if (body !== undefined) {
      headers["Content-Type"] = "application/json";
      request.body = JSON.stringify(body);
    }
    if (key !== undefined) headers["Idempotency-Key"] = key;
    if (signal !== undefined) request.signal = signal;
    signal?.throwIfAborted();
    const isRepeatable = method === "GET" || key !== undefined;
    const deadline = Date.now() + 1000 * patience_s;
    for (;;) {
      const answer = await call(this.#url + path + search(query), request).catch((error: unknown) => {
        if (signal?.aborted || !this.#hasAnswered || !isRepeatable || !(Date.now() + 1000 * PAUSE_AWAY_S < deadline)) throw error;
        return null;
      });
      if (answer === null) {
        await sleep(PAUSE_AWAY_S, signal);
        continue;
      }
      this.#hasAnswered = true;
      if (answer.ok) return (await answer.json()) as T;
      const pause = Number(answer.headers.get("Retry-After") ?? 1);
      const isLater = answer.status === 429 || answer.status === 503;
      if (!isLater || !(Date.now() + 1000 * pause < deadline)) throw new Refused(await problem(answer));
      await sleep(pause, signal);
    }
  }
}

/** A key that no other request has. `crypto` is absent from Node.js 18 and from pages without TLS. */
function newKey(): string {
  return Array.from({ length: 4 }, () => Math.random().toString(36).slice(2)).join("");
}

function isUnfinished(job: Job): boolean {
  return job.status === "queued" || job.status === "running";
}

function link(job: Job, name: keyof Schemas["Links"]): string {
  const path = job.links[name];
  if (path === undefined) throw new Error(`the job is ${job.status} and has no ${name}`);
  return path;
}

function search(query: object | undefined): string {
  const fields = new URLSearchParams();
  for (const [name, value] of Object.entries(query ?? {})) {
    for (const one of Array.isArray(value) ? value : [value]) if (one !== undefined) fields.append(name, String(one));
  }
  const text = fields.toString();
  return text === "" ? "" : `?${text}`;
}

/** The problem of an error response; one without problem document has the status line. */
async function problem(answer: Response): Promise<Schemas["Problem"]> {
  const kind = answer.headers.get("Content-Type") ?? "";
  if (kind.startsWith("application/problem+json")) return (await answer.json()) as Schemas["Problem"];
  return { type: "about:blank", title: `${answer.status} ${answer.statusText}`, status: answer.status, detail: await answer.text() };
}

function sleep(seconds: number, signal?: AbortSignal): Promise<void> {
  return new Promise((resolve, reject) => {
    signal?.throwIfAborted();
    const stop = (): void => {
      clearTimeout(timer);
      reject(signal?.reason as Error);
    };
    const timer = setTimeout(() => {
      signal?.removeEventListener("abort", stop);
      resolve();
    }, 1000 * seconds);
    signal?.addEventListener("abort", stop, { once: true });
  });
}
