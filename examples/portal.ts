// For a front end: resolve a scene as its fields are typed, submit it, wait, and take the spectrum for a chart; types come from openapi/openapi.json.
// Run: openapi-typescript openapi/openapi.json -o examples/raceway.d.ts && tsc -p examples && RACEWAY_URL=http://127.0.0.1:8080 node examples/portal.js

import type { components, operations } from "./raceway.js";

type Schemas = components["schemas"];
type Scene = Schemas["SceneInput"];
type JobRequest = Schemas["JobInput"];
type Job = Schemas["JobAnswer"];
type Channel = NonNullable<NonNullable<operations["getSpectrum"]["parameters"]["query"]>["channel"]>;

/** An answer that is an error: what went wrong, and which fields of the body are wrong. */
export class Refused extends Error {
  constructor(readonly problem: Schemas["Problem"]) {
    super(problem.detail);
  }

  /** What to write beside the field of a JSON pointer, such as `/scene/operation/speed_rpm`. */
  at(pointer: string): string | undefined {
    return this.problem.errors?.find((error) => error.pointer === pointer)?.detail;
  }
}

/** The service at a URL. */
export class Raceway {
  constructor(
    private readonly url: string,
    private readonly token?: string,
  ) {}

  /** What a scene means, without running it: defaults, stiffness, frequencies, cost. */
  resolve(scene: Scene, signal?: AbortSignal): Promise<Schemas["ResolveAnswer"]> {
    return this.ask("POST", "/v1/scenes/resolve", { scene }, signal);
  }

  submit(job: JobRequest): Promise<Job> {
    return this.ask("POST", "/v1/jobs", job);
  }

  /** The job once it has ended; `seen` is told how far it is. */
  async ended(job: Job, seen?: (progress: number) => void): Promise<Job> {
    while (job.status === "queued" || job.status === "running") {
      seen?.(job.progress);
      await pause(0.2);
      job = await this.ask("GET", job.links.self);
    }
    return job;
  }

  metrics(job: Job): Promise<Schemas["Metrics"]> {
    return this.ask("GET", job.links.metrics ?? `${job.links.self}/metrics`);
  }

  spectrum(job: Job, channel: Channel, upToHz: number): Promise<Schemas["SpectrumAnswer"]> {
    const query = new URLSearchParams({ channel, max_frequency_hz: String(upToHz) });
    return this.ask("GET", `${job.links.spectrum ?? `${job.links.self}/spectrum`}?${query}`);
  }

  private async ask<T>(method: string, path: string, body?: object, signal?: AbortSignal): Promise<T> {
    const headers: Record<string, string> = { Accept: "application/json" };
    if (this.token !== undefined) headers["Authorization"] = `Bearer ${this.token}`;
    if (body !== undefined) headers["Content-Type"] = "application/json";
    const request: RequestInit = { method, headers };
    if (body !== undefined) request.body = JSON.stringify(body);
    if (signal !== undefined) request.signal = signal;
    for (let triesLeft = 5; ; triesLeft -= 1) {
      const answer = await fetch(new URL(path, this.url), request);
      if (answer.ok) return (await answer.json()) as T;
      // The queue is full, or the service is about to stop: it says when to come again.
      const later = answer.status === 429 || answer.status === 503;
      if (!later || triesLeft === 0) throw new Refused((await answer.json()) as Schemas["Problem"]);
      await pause(Number(answer.headers.get("Retry-After") ?? 1));
    }
  }
}

/** Resolves what is typed: the last scene only, once the typing rests; what is under way for an older one is given up. */
export function resolver(api: Raceway, show: (answer: Schemas["ResolveAnswer"] | Refused) => void, restMs = 150) {
  let timer: ReturnType<typeof setTimeout> | undefined;
  let under = new AbortController();
  return (scene: Scene): void => {
    clearTimeout(timer);
    under.abort();
    const mine = (under = new AbortController());
    timer = setTimeout(() => {
      api.resolve(scene, mine.signal).then(show, (error: unknown) => {
        if (error instanceof Refused) show(error);
        else if (!mine.signal.aborted) throw error;
      });
    }, restMs);
  };
}

/** Points of a chart: frequency [Hz] and amplitude in the spectrum's unit. */
export function points(spectrum: Schemas["SpectrumAnswer"]): { x: number; y: number }[] {
  return spectrum.frequency_hz.map((x, index) => ({ x, y: spectrum.amplitude[index] ?? NaN }));
}

function pause(seconds: number): Promise<void> {
  return new Promise((resume) => setTimeout(resume, 1000 * seconds));
}

// From here on: what a portal's user does, without a portal.

declare const process: { env: Record<string, string | undefined> };

async function main(): Promise<void> {
  const api = new Raceway(process.env["RACEWAY_URL"] ?? "http://127.0.0.1:8080", process.env["RACEWAY_TOKEN"]);
  const scene = (speed_rpm: number): Scene => ({ bearing: "6205", operation: { speed_rpm, radial_load_y_n: 500 } });

  // A wrong speed, then the user types 6, 60, 600, 6000: only the last one is asked for.
  const wrong = await api.resolve(scene(6e6)).catch((error: unknown) => error);
  if (!(wrong instanceof Refused)) throw new Error("the wrong speed was not refused");
  console.log("beside the field:", wrong.at("/scene/operation/speed_rpm"));
  const shown: (Schemas["ResolveAnswer"] | Refused)[] = [];
  await new Promise<void>((resume) => {
    const typed = resolver(api, (answer) => {
      shown.push(answer);
      resume();
    });
    for (const speed of [6, 60, 600, 6000]) typed(scene(speed));
  });
  const [resolved] = shown;
  if (shown.length !== 1 || resolved === undefined || resolved instanceof Refused) throw new Error("one answer was due");
  console.log("BPFO:", resolved.derived.frequencies_hz.ball_pass_outer, "Hz, about", resolved.cost.estimated_wall_time_s, "s");

  const job = await api.ended(await api.submit({ kind: "simulation", scene: scene(6000) }));
  if (job.status !== "succeeded") throw new Error(job.error?.detail ?? job.status);
  const metrics = await api.metrics(job);
  console.log("level:", metrics.channels?.["spindle.y.acceleration"]?.level_db, "dB");
  const spectrum = await api.spectrum(job, "spindle.y.acceleration", 5000);
  console.log(points(spectrum).length, "points in", spectrum.unit);
}

await main();
