// The tab of a shaft: its form and drawing, the analysis that follows each edit, and the run in time.

import * as api from './api.js';
import { h, labelledRadio, small, tools } from './dom.js';
import { command, curl, keep } from './download.js';
import { moment } from './format.js';
import { isEqual, isOfShaft, write } from './request.js';
import { Result } from './result.js';
import { RotorView } from './rotor.js';
import { ShaftDrawing } from './shaft-drawing.js';
import { ShaftForm } from './shaft-form.js';
import { EXAMPLE, listAt, machineJob, ofJob, rotorJob } from './shaft-request.js';

/** Pause in typing after which the shaft is analysed [ms]. */
const TYPING_PAUSE = 250;
/** Pause before a retry when the service cannot be reached [ms]. */
const RETRY_PAUSE = 3000;
/** On a narrow page the drawing stands above the form, not below it. */
const narrow = matchMedia('(max-width: 56rem)');

const at = (id) => document.getElementById(id);

export class Shaft {
  /** `request`: the first request, or null for the example; `onChange(request)` gets every changed one, `onOpen(job)` every job shown. */
  constructor(panel, { document: openapi, presets: known, catalogue, request, say, onChange, onOpen, report }) {
    // Bearings of the catalogue join those of the presets.
    const presets = { ...known, bearings: { ...known.bearings } };
    Object.assign(this, { presets, say, onChange, onOpen, report });
    this.form = new ShaftForm(at('shaft-fields'), {
      document: openapi,
      presets,
      catalogue,
      onChange: (changed) => this.#changed(changed),
    });
    this.drawing = new ShaftDrawing(at('shaft-drawing'), {
      presets,
      move: (pointer, place) => this.edit(write(this.request, `${pointer}/at_mm`, Number(place.toFixed(3)))),
      choose: (pointer) => this.form.focus(pointer),
      remove: (list, index) => this.form.remove(list, index),
    });
    this.note = h('p', { class: 'note', role: 'status' });
    this.files = h('div', {});
    this.rotorHost = h('div', { class: 'analysis' }, h('p', { class: 'empty' }, 'No analysis yet.'));
    this.rotor = new RotorView(this.rotorHost, presets);
    this.runHost = h('div', { hidden: true }, h('p', { class: 'empty' }, 'No run in time yet. Press “Run in time”.'));
    this.analysis = h(
      'div',
      {},
      tools(
        small('Keep as a job', () => this.#keep()),
        small('Start from the example', () => this.edit(structuredClone(EXAMPLE))),
        this.note,
      ),
      this.files,
      this.rotorHost,
    );
    this.result = new Result(this.runHost, {
      say,
      onEnd: (job) => say(`Run in time: ${job.status}.`),
      rerun: () => {},
      report,
      edit: (job) => {
        this.edit(ofJob(job));
        say('The form has the scene of this run now.');
      },
    });
    panel.replaceChildren(h('h2', { class: 'unseen' }, 'Shaft'), this.#choice(), this.analysis, this.runHost);
    this.#listen();
    this.request = request ?? structuredClone(EXAMPLE);
    this.#show();
  }

  /** The tab is opened: an analysis that waits begins. */
  open() {
    this.isOpen = true;
    this.drawing.show(this.request);
    if (this.isStale) this.#analyse();
  }

  close() {
    this.isOpen = false;
  }

  /** Replaces the request. */
  edit(request) {
    this.form.show(request);
    this.#changed(request);
  }

  /** Shows a job of kind `rotor` or `machine`; the form gets its scene. */
  async show(job) {
    const request = ofJob(job.request);
    // A job of this scene has the settings of its kind only; those of the other kind stay.
    const isSame = isEqual(request.scene, this.request.scene);
    this.request = isSame ? { ...this.request, ...request } : request;
    this.#show();
    this.onChange(this.request);
    this.#view(job.kind === 'rotor' ? 'analysis' : 'run');
    this.onOpen(job);
    if (job.kind === 'machine') {
      this.isStale = true;
      if (this.isOpen) this.#analyse();
      await this.result.show(job);
      return;
    }
    await this.#stored(job);
  }

  #choice() {
    const one = ([value, text]) =>
      labelledRadio({ name: 'shaft-view', value, checked: value === 'analysis', onchange: () => this.#view(value) }, text);
    this.choice = h(
      'fieldset',
      { class: 'segments' },
      h('legend', { class: 'unseen' }, 'Result'),
      [
        ['analysis', 'Natural motions'],
        ['run', 'Run in time'],
      ].map(one),
    );
    return this.choice;
  }

  #view(name) {
    this.choice.querySelector(`[value=${name}]`).checked = true;
    this.analysis.hidden = name !== 'analysis';
    this.runHost.hidden = name !== 'run';
  }

  #listen() {
    at('shaft-form').addEventListener('submit', (event) => {
      event.preventDefault();
      this.#run();
    });
    at('shaft-json').addEventListener('input', () => {
      try {
        const job = JSON.parse(at('shaft-json').value);
        if (!isOfShaft(job)) throw new Error('The request has no `scene` with a `shaft` or with `bearings`.');
        at('shaft-json-error').textContent = '';
        const request = ofJob(job);
        this.form.show(request);
        this.#changed(request, true);
      } catch (error) {
        at('shaft-json-error').textContent = `Not sent: ${error.message}`;
      }
    });
    const place = () => {
      const drawing = at('shaft-drawing');
      if (narrow.matches) at('shaft-form').prepend(drawing);
      else at('main').prepend(drawing);
    };
    narrow.addEventListener('change', place);
    place();
  }

  #show(fromText = false) {
    if (!fromText) {
      at('shaft-json').value = JSON.stringify(this.request, null, 2);
      at('shaft-json-error').textContent = '';
    }
    const shared = { method: 'POST', token: api.hasToken() };
    at('shaft-curl').replaceChildren(
      command(curl({ ...shared, path: '/v1/rotor', body: rotorJob(this.request) })),
      command(curl({ ...shared, path: '/v1/jobs', body: machineJob(this.request) })),
    );
    if (!fromText) this.form.show(this.request);
    this.drawing.show(this.request);
    this.isStale = true;
  }

  #changed(request, fromText = false) {
    this.request = request;
    this.#show(fromText);
    this.onChange(request);
    this.controller?.abort();
    clearTimeout(this.timer);
    this.timer = setTimeout(() => this.isOpen && this.#analyse(), TYPING_PAUSE);
  }

  /** Analyses the request; a newer one aborts it. */
  async #analyse() {
    clearTimeout(this.timer);
    this.controller?.abort();
    this.controller = new AbortController();
    const { signal } = this.controller;
    if (this.form.unreadable) {
      this.#showErrors([]);
      return;
    }
    const { request } = this;
    this.isStale = false;
    this.note.textContent = 'Analysing.';
    try {
      const answer = await api.analyse(rotorJob(request), signal);
      if (signal.aborted) return;
      this.#showErrors([]);
      this.files.replaceChildren();
      this.#answered(answer, request, 'Follows each edit.');
    } catch (error) {
      if (signal.aborted) return;
      this.note.textContent = '';
      this.rotorHost.classList.add('stale');
      this.#showErrors(error.errors?.length ? error.errors : [{ pointer: '', detail: error.message }]);
      if (!error.status || error.status >= 500) this.timer = setTimeout(() => this.#analyse(), RETRY_PAUSE);
    }
  }

  #answered(answer, request, note) {
    this.rotorHost.classList.remove('stale');
    this.note.textContent = note;
    this.rotor.show(answer, request);
    this.#measure(request).catch((error) => this.say(error.message));
  }

  /** Fetches the dimensions of bearings that go by a designation, and draws them. */
  async #measure(request) {
    const names = listAt(request, '/scene/bearings').map(({ bearing }) => (typeof bearing === 'string' ? bearing : bearing?.preset));
    const unknown = [...new Set(names)].filter((name) => name && !this.presets.bearings[name]);
    for (const name of unknown) {
      const { scene } = await api.resolve({ scene: { bearing: name, operation: { speed_rpm: 0 } } });
      this.presets.bearings[name] = { bearing: scene.bearing };
    }
    if (unknown.length) this.#show();
  }

  #showErrors(errors) {
    const elsewhere = this.form.showErrors(errors);
    at('shaft-errors').textContent = elsewhere
      .map(({ pointer, detail }) => (pointer ? `${pointer}: ${detail}` : detail))
      .join('\n');
  }

  /** Submits a job and shows it. */
  async #submit(job) {
    if (this.form.unreadable) {
      this.form.focusFirstError();
      return;
    }
    at('shaft-run').disabled = true;
    try {
      const accepted = await api.submit(job);
      this.say('Submitted.');
      await this.show(accepted);
    } catch (error) {
      this.#showErrors(error.errors?.length ? error.errors : [{ pointer: '', detail: error.message }]);
      this.form.focusFirstError();
    } finally {
      at('shaft-run').disabled = false;
    }
  }

  #run() {
    return this.#submit(machineJob(this.request));
  }

  #keep() {
    return this.#submit(rotorJob(this.request));
  }

  /** The kept result of a job of kind `rotor`, with its files. */
  async #stored(job) {
    this.controller?.abort();
    clearTimeout(this.timer);
    this.controller = new AbortController();
    const { signal } = this.controller;
    const { request } = this;
    this.isStale = false;
    this.note.textContent = `Job: ${job.status}.`;
    try {
      const ended = api.hasEnded(job) ? job : await api.follow(job, { signal, onProgress: () => {} });
      if (signal.aborted) return;
      if (ended.status !== 'succeeded') {
        this.note.textContent = ended.error ? `${ended.error.title}: ${ended.error.detail}` : `Job: ${ended.status}.`;
        return;
      }
      const answer = await api.get(ended.links.rotor, { signal });
      if (signal.aborted) return;
      this.#showErrors([]);
      this.#answered(answer, request, `Kept result, ended ${moment(ended.finished_at)}.`);
      this.#download(ended);
    } catch (error) {
      if (!signal.aborted) this.note.textContent = error.message;
    }
  }

  #download(job) {
    const { id, links } = job;
    const files = [
      ['Campbell SVG', `campbell-${id}.svg`, links.campbell_svg, 'image/svg+xml'],
      ['Shapes SVG', `shapes-${id}.svg`, links.shapes_svg, 'image/svg+xml'],
      ['Result JSON', `rotor-${id}.json`, links.rotor, 'application/json'],
      ['ROSS script', `rotor-${id}.py`, links.rotor_script, 'text/x-python'],
    ];
    const file = ([text, name, path, type]) =>
      small(text, () => keep(name, path, type).catch((error) => this.say(error.message)));
    this.files.replaceChildren(tools(h('span', { class: 'note' }, 'Download'), files.filter(([, , path]) => path).map(file), small('Report', () => this.report(job))));
  }
}
