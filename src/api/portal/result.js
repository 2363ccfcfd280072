// One run: its progress, then its results.

import * as api from './api.js';
import { h, more, small, tools } from './dom.js';
import { command, curl, keep } from './download.js';
import { moment, title, words } from './format.js';
import { MachineView } from './machine.js';
import { answerOf } from './kinds.js';
import { MeasuredPanel } from './measured.js';
import { notes, summary, tables } from './metrics.js';
import { answerView, pictures } from './pictures.js';
import { Views } from './views.js';

export class Result {
  /** `say(text)` shows a status message; `onEnd(job)`, `rerun(request)`, `edit(request)` and `report(job)` are actions of the page. */
  constructor(host, { say, onEnd, rerun, edit, report }) {
    Object.assign(this, { host, say, onEnd, edit, report });
    this.rerun = rerun;
  }

  /** Follows a job to its end and shows its results. Another call replaces it. */
  async show(job) {
    this.controller?.abort();
    const controller = new AbortController();
    this.controller = controller;
    const { signal } = controller;
    this.job = job;
    try {
      this.#progress(job);
      const ended = api.hasEnded(job)
        ? job
        : await api.follow(job, {
            signal,
            onProgress: (now) => {
              if (!signal.aborted) this.#progress({ ...job, ...now });
            },
          });
      if (signal.aborted) return;
      this.job = ended;
      this.#progress(ended);
      if (!api.hasEnded(job)) this.onEnd(ended);
      if (ended.status !== 'succeeded') return;
      if (ended.kind === 'simulation') await this.#results(ended, signal);
      else if (ended.kind === 'machine') await this.#machine(ended, signal);
      else await this.#report(ended, signal);
    } catch (error) {
      if (!signal.aborted) this.#failed(error);
    }
  }

  /** Shows the recorded example: the same view, without actions that need the service. */
  async example({ version, request, metrics, spectra }) {
    this.controller?.abort();
    this.head = null;
    this.views ??= new Views({ say: this.say, rerun: this.rerun });
    const text = `Example: the answer of version ${version} to the scene of the form as it opens. Press Run for your own.`;
    this.host.replaceChildren(
      h(
        'div',
        { class: 'run-head' },
        h('h2', {}, title(request)),
        h('div', { class: 'run-state' }, h('span', { class: 'chip' }, 'example'), h('span', { class: 'note' }, text)),
      ),
      ...this.#shown(metrics),
    );
    await this.views.show({ request, links: {}, spectra }, metrics);
  }

  /** Shows only a remark. */
  clear(remark) {
    this.controller?.abort();
    this.head = null;
    this.host.replaceChildren(h('p', { class: 'empty' }, remark, ' Press Run, or open a job.'));
  }

  #progress(job) {
    if (this.head?.id !== job.id) this.#frame(job);
    const { chip, bar, note, stop } = this.head;
    chip.textContent = job.status === 'running' && job.phase ? words(job.phase) : job.status;
    chip.dataset.status = job.status;
    bar.value = job.progress;
    bar.hidden = api.hasEnded(job);
    bar.textContent = `${Math.round(job.progress * 100)} %`;
    stop.hidden = api.hasEnded(job);
    stop.disabled = Boolean(job.cancel_requested_at);
    note.textContent = remark(job);
    note.className = job.error ? 'error' : 'note';
  }

  #frame(job) {
    const chip = h('span', { class: 'chip' });
    const bar = h('progress', { max: 1, 'aria-label': 'Progress of the run' });
    const note = h('span', { class: 'note' });
    const stop = small('Cancel', () => this.#cancel());
    this.head = { id: job.id, chip, bar, note, stop };
    this.body = h('div', {});
    this.host.replaceChildren(
      h(
        'div',
        { class: 'run-head' },
        h('h2', {}, title(job.request)),
        h(
          'div',
          { class: 'run-state' },
          chip,
          bar,
          note,
          stop,
          small('Edit this scene', () => this.edit(job.request)),
          this.report && small('Report', () => this.report(job)),
        ),
      ),
      this.body,
    );
  }

  async #cancel() {
    this.head.stop.disabled = true;
    try {
      await api.cancel(this.job);
      this.say('Cancelling.');
    } catch (error) {
      this.say(error.message);
    }
  }

  #failed(error) {
    this.body?.replaceChildren(h('p', { class: 'error' }, error.message));
    this.say(error.message);
  }

  /** The answer of an optimum, accuracy or uncertainty job, or of a kind that this page does not know. */
  async #report(job, signal) {
    const path = answerOf(job);
    const [plots, answer] = await Promise.all([pictures(job, { signal }), path ? api.get(path, { signal }) : {}]);
    if (signal.aborted) return;
    const { first, rest } = answerView(job.kind, answer);
    const { table } = job.links;
    const name = `${job.kind}-${job.id}`;
    const file = (text, at, type, file) => at && small(text, () => keep(file, at, type).catch((error) => this.say(error.message)));
    const files = [
      file('Download JSON', path, 'application/json', `${name}.json`),
      file('Table CSV', table, 'text/csv', `${name}-table.csv`),
      file('Table JSON', table, 'application/json', `${name}-table.json`),
    ];
    const command_ = path && more('curl command', command(curl({ path, token: api.hasToken() })));
    this.body.replaceChildren(...first, ...plots, ...rest, tools(files), command_ || '');
  }

  async #machine(job, signal) {
    this.machine ??= new MachineView({ say: this.say });
    await this.machine.show(this.body, job, signal);
    if (signal.aborted) return;
    const { answer, channels } = this.machine;
    const [bearing] = Object.values(answer.bearings);
    this.#measured(job, answer.lines, bearing?.shaft_hz, channels);
  }

  async #results(job, signal) {
    this.views ??= new Views({ say: this.say, rerun: this.rerun });
    const metrics = job.metrics ?? (await api.get(job.links.metrics, { signal }));
    if (signal.aborted) return;
    this.body.replaceChildren(...this.#shown(metrics));
    await this.views.show(job, metrics);
    if (signal.aborted) return;
    this.#measured(job, metrics.lines, metrics.frequencies_hz.shaft, this.views.channels);
  }

  /** The panel for a measured file, below the results. */
  #measured(job, lines = [], speed_hz = 0, channels = []) {
    this.measured ??= new MeasuredPanel();
    this.body.append(this.measured.element);
    this.measured.show({ job, lines, speed_hz, channels });
  }

  /** Levels first, then the plots, and below them all that explains them. */
  #shown(metrics) {
    return [summary(metrics), this.views.element, notes(metrics), tables(metrics)].flat().filter(Boolean);
  }
}

/** Status of a job as text. */
function remark({ status, error, progress, reused, finished_at: ended }) {
  if (error) return `${error.title}: ${error.detail}`;
  if (status === 'queued') return 'waiting for a worker';
  if (status === 'running') return `${Math.round(progress * 100)} %`;
  return reused ? 'answered by the result of an identical run' : `ended ${moment(ended)}`;
}
