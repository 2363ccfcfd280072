// One run: its progress, then its results.

import * as api from './api.js';
import { h, small } from './dom.js';
import { keep } from './download.js';
import { moment, title, words } from './format.js';
import { MachineView } from './machine.js';
import { MeasuredPanel } from './measured.js';
import { summary, tables } from './metrics.js';
import { picture } from './plots.js';
import { Views } from './views.js';

export class Result {
  /** `say(text)` shows a status message; `onEnd(job)`, `rerun(request)` and `edit(request)` are actions of the page. */
  constructor(host, { say, onEnd, rerun, edit }) {
    Object.assign(this, { host, say, onEnd, edit });
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

  /** The plot of an optimum job or an accuracy job. */
  async #report(job, signal) {
    const [image, answer] =
      job.kind === 'optimum'
        ? [job.links.optimum_svg, job.links.optimum]
        : [job.links.work_precision_svg, job.links.accuracy];
    const svg = await api.getText(image, 'image/svg+xml', { signal });
    if (signal.aborted) return;
    this.body.replaceChildren(
      h('figure', {}, picture(svg, title(job.request))),
      small('Download JSON', () => keep(`${job.kind}-${job.id}.json`, answer, 'application/json')),
    );
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
    this.body.replaceChildren(...[summary(metrics), this.views.element, tables(metrics)].flat().filter(Boolean));
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
}

/** Status of a job as text. */
function remark({ status, error, progress, reused, finished_at: ended }) {
  if (error) return `${error.title}: ${error.detail}`;
  if (status === 'queued') return 'waiting for a worker';
  if (status === 'running') return `${Math.round(progress * 100)} %`;
  return reused ? 'answered by the result of an identical run' : `ended ${moment(ended)}`;
}
