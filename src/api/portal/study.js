// Many runs of one scene: the trend of a metric over one parameter, its map over two, its optimum, its spread by uncertain inputs, or the
// error of methods over run time.

import * as api from './api.js';
import { h, labelled, select, small } from './dom.js';
import { title } from './format.js';
import { StudyTable } from './study-table.js';
import { SEARCHED } from './study-metrics.js';
import { UncertaintyForm } from './uncertainty-form.js';
import { VariedAxis } from './varied-axis.js';

const TASKS = [
  ['study', 'trend or map'],
  ['optimum', 'optimum'],
  ['uncertainty', 'uncertainty'],
  ['accuracy', 'accuracy of methods'],
];
const BUTTONS = { study: 'Run study', optimum: 'Find optimum', uncertainty: 'Run samples', accuracy: 'Compare methods' };

/** The field of an error. */
const inWords = (pointer) =>
  pointer
    .replace('/axes/0/', '')
    .replace('/axes/1/', 'second parameter, ')
    .replace(/^\/inputs\/(\d+)\/(distribution\/)?/, (_, i) => `input ${Number(i) + 1}, `)
    .replace(/^\//, '');

export class Study {
  /** `open(job)` shows a submitted job of any kind, `report(job)` its report. */
  constructor(host, { document, request, resolved, say, open, report }) {
    Object.assign(this, { request, say, open, report });
    const axis = (settings) => new VariedAxis({ document, request, resolved, ...settings });
    this.axes = [axis({ first: true, pointer: '/scene/bearing/radial_clearance_um' }), axis({ first: false, pointer: '' })];
    this.uncertainty = new UncertaintyForm({ document, request, resolved });
    this.task = select(TASKS, () => this.#settle());
    this.metric = select(SEARCHED.map(([pointer, name]) => [pointer, name]));
    this.goal = select([
      ['minimum', 'least'],
      ['maximum', 'largest'],
    ]);
    this.search = h('div', { class: 'tools' }, labelled('Metric', this.metric), labelled('Searched value', this.goal));
    this.start = h('button', { type: 'submit', class: 'primary' }, BUTTONS.study);
    this.error = h('p', { class: 'error', role: 'alert' });
    this.table = new StudyTable({ say });
    this.body = h('div', {});
    this.form = h(
      'form',
      {
        class: 'study',
        onsubmit: (event) => {
          event.preventDefault();
          this.#submit();
        },
      },
      h('div', { class: 'tools' }, labelled('Task', this.task)),
      h('div', { class: 'tools' }, this.start),
    );
    host.replaceChildren(h('h2', {}, 'Study of the scene'), this.form, this.error, this.body);
    this.#settle();
  }

  /** Shows the fields of the task. */
  #settle() {
    const task = this.task.value;
    const parts = {
      study: this.axes.map((axis) => axis.element),
      optimum: [...this.axes.map((axis) => axis.element), this.search],
      uncertainty: this.uncertainty.elements,
      accuracy: [h('p', { class: 'note' }, 'Runs the scene of the form with each method at several tolerances, and states error and run time.')],
    }[task];
    for (const axis of this.axes) axis.grid.hidden = task === 'optimum';
    const [first, last] = [this.form.firstChild, this.form.lastChild];
    this.form.replaceChildren(first, ...parts, last);
    this.start.textContent = BUTTONS[task];
  }

  reset() {
    this.axes.forEach((axis) => axis.reset());
    this.uncertainty.reset();
  }

  #job() {
    const kind = this.task.value;
    const { scene, solver, duration_s, settle_s, outputs } = this.request();
    const { envelope, envelope_band_hz } = outputs ?? {};
    const axes = () => this.axes.filter((axis) => axis.isThere).map((axis) => axis.value(kind === 'optimum'));
    const ofKind = {
      study: () => ({ ...((envelope || envelope_band_hz) && { outputs: { envelope, envelope_band_hz } }), axes: axes() }),
      optimum: () => ({ axes: axes(), metric: this.metric.value, goal: this.goal.value }),
      uncertainty: () => this.uncertainty.value,
      accuracy: () => ({}),
    };
    return {
      kind,
      scene,
      ...(solver && { solver }),
      ...(duration_s && { duration_s }),
      ...(settle_s !== undefined && { settle_s }),
      ...ofKind[kind](),
    };
  }

  async #submit() {
    this.error.textContent = '';
    this.start.disabled = true;
    try {
      await this.open(await api.submit(this.#job()));
    } catch (error) {
      this.error.textContent = error.errors?.length
        ? error.errors.map(({ pointer, detail }) => `${inWords(pointer)}: ${detail}`).join('; ')
        : error.message;
    } finally {
      this.start.disabled = false;
    }
  }

  /** Follows a study to its end and shows its answer. */
  async show(job) {
    this.controller?.abort();
    const controller = new AbortController();
    this.controller = controller;
    const bar = h('progress', { max: 1, value: job.progress, 'aria-label': 'Progress of the study' });
    const note = h('span', { class: 'note', role: 'status' });
    const stop = small('Cancel', () => api.cancel(job).catch((error) => this.say(error.message)));
    const report = small('Report', () => this.report(job), { hidden: true });
    const head = h(
      'div',
      { class: 'run-head' },
      h('h3', {}, title(job.request)),
      h('div', { class: 'run-state' }, bar, note, stop, report),
    );
    this.body.replaceChildren(head);
    try {
      const ended = await api.follow(job, {
        signal: controller.signal,
        onProgress: (now) => {
          bar.value = now.progress;
          note.textContent = `${now.status}, ${Math.round(now.progress * 100)} %`;
        },
      });
      bar.hidden = true;
      stop.hidden = true;
      report.hidden = ended.status !== 'succeeded';
      note.textContent = ended.status;
      if (ended.status === 'queued') return;
      const answer = await api.get(ended.links.table, { signal: controller.signal });
      this.body.append(...this.table.elements(ended, answer));
      this.table.draw();
      this.say(`The study has ${ended.status}.`);
    } catch (error) {
      if (!controller.signal.aborted) this.error.textContent = error.message;
    }
  }
}
