// The result of a run of a shaft in time: levels of each channel, spectra with labelled lines, bearings, natural frequencies.

import * as api from './api.js';
import { leftOut } from './derived.js';
import { h, labelledRadio, more, small, table, tools } from './dom.js';
import { command, curl, keep, save } from './download.js';
import { channelName, LEVEL_UNIT, level, measured, number, numerical, quantity, words } from './format.js';
import { isWarning, messageList } from './messages.js';
import { figure, headlineFigures } from './metrics.js';
import { RUN_UP_VIEWS, runUp } from './run-up.js';
import { Spectra } from './spectra.js';

const isAcceleration = (name) => name.endsWith('.acceleration');
const isSensor = (name) => name.startsWith('sensor.');

/** Errors of levels by the steps and, on a reduced level, by the model. */
const levelErrors = ({ level_errors_db: steps, model_errors_db: model = {} }) =>
  Object.fromEntries(Object.entries(steps).map(([name, error]) => [name, error + (model[name] ?? 0)]));

export class MachineView {
  /** `say(text)` shows a status message. */
  constructor({ say }) {
    this.say = say;
    this.spectra = new Spectra(() => this.#draw());
    this.stage = h('div', { class: 'stage' });
    this.extras = h('div', { class: 'extras' });
  }

  /** Shows a finished run in `host`. */
  async show(host, job, signal) {
    const answer = await api.get(job.links.machine, { signal });
    if (signal.aborted) return;
    this.#take(job, answer);
    const hasFaults = (job.request.scene.bearings ?? []).some(({ surfaces }) => surfaces);
    this.spectra.begin(this.channels, hasFaults);
    const views = RUN_UP_VIEWS.filter(([view]) => job.links[`${view}_svg`]);
    // A run-up opens as a waterfall.
    this.view = views[0]?.[0] ?? 'spectrum';
    host.replaceChildren(
      this.#summary(),
      ...messageList(answer.messages.filter(isWarning)),
      views.length > 0 ? this.#choice(views) : '',
      this.stage,
      this.extras,
      ...messageList(answer.messages.filter((message) => !isWarning(message))),
      this.#levels(),
      this.#bearings(),
      this.#rest(),
    );
    await this.#draw();
  }

  /** Key values and tables of an answer, for a report. */
  summary(job, answer) {
    this.#take(job, answer);
    return [this.#summary(), this.#levels(), this.#bearings()];
  }

  #take(job, answer) {
    const passages = Object.values(answer.bearings).map(({ ball_pass_outer_hz: outer }) => outer);
    // The fields by which spectra choose their lines and their limit.
    const { lines, envelope_lines } = answer;
    this.metrics = { lines, envelope_lines, frequencies_hz: { ball_pass_outer: Math.max(...passages, 0) } };
    this.channels = Object.keys(answer.channels)
      .filter(isAcceleration)
      .sort((one, other) => isSensor(other) - isSensor(one));
    Object.assign(this, { job, answer });
  }

  #choice(views) {
    const choose = (view) => {
      this.view = view;
      this.#draw();
    };
    const one = ([value, text]) =>
      labelledRadio({ name: 'machine-view', value, checked: value === this.view, onchange: () => choose(value) }, text);
    const all = [...views, ['spectrum', 'Spectrum']];
    return h('fieldset', { class: 'segments' }, h('legend', { class: 'unseen' }, 'Plot'), all.map(one));
  }

  async #draw() {
    this.drawing?.abort();
    this.drawing = new AbortController();
    const { signal } = this.drawing;
    try {
      const { files, request, tables } =
        this.view === 'spectrum' ? await this.spectra.draw(this.stage, this, signal) : await this.#runUp(signal);
      const { id, links } = this.job;
      const all = [...files, ['Result JSON', () => keep(`machine-${id}.json`, links.machine, 'application/json')]];
      const file = ([text, act]) => small(text, () => act().catch((error) => this.say(error.message)));
      this.extras.replaceChildren(
        ...tables,
        tools(h('span', { class: 'note' }, 'Download'), all.map(file)),
        more('curl command', command(curl({ ...request, token: api.hasToken() }))),
      );
    } catch (error) {
      if (!signal.aborted) this.stage.replaceChildren(h('p', { class: 'error' }, error.message));
    }
  }

  async #runUp(signal) {
    const { view, job } = this;
    const { element, svg, path } = await runUp(job, view, signal);
    this.stage.replaceChildren(h('figure', {}, element));
    const file = ['Plot SVG', async () => save(`${view}-${job.id}.svg`, svg, 'image/svg+xml')];
    return { files: [file], request: { path, accept: 'image/svg+xml' }, tables: [] };
  }

  #summary() {
    const { channels, bearings, model, accuracy, is_stable: isStable } = this.answer;
    const sensors = this.channels.filter(isSensor);
    const shown = sensors.length ? sensors : this.channels.filter((name) => name.endsWith('.y.acceleration'));
    const errors = levelErrors(accuracy);
    const of = (name) => {
      const error = errors[name] === undefined ? '' : numerical(errors[name]);
      return figure(
        `Level ${channelName(name.replace(/^sensor\.|\.acceleration$/g, ''))}`,
        level(channels[name].level_db),
        LEVEL_UNIT,
        error,
      );
    };
    const load = Math.max(...Object.values(bearings).flatMap((one) => [one.max_inner_load_n, one.max_outer_load_n]));
    return h(
      'dl',
      { class: 'figures' },
      shown.slice(0, 4).map(of),
      headlineFigures(this.answer),
      figure('Largest ball load', number(load), 'N'),
      isStable !== undefined && figure('Linear analysis', isStable ? 'stable' : 'unstable'),
      figure('Step', number(model.step_us, 3), 'µs', `${words(model.rung)}, ${model.coordinates} coordinates of the shaft`),
    );
  }

  #levels() {
    const { channels, accuracy } = this.answer;
    const errors = levelErrors(accuracy);
    const rows = this.channels.map((name) => {
      const { unit, rms, peak, crest_factor: crest, kurtosis, level_db: loud } = channels[name];
      const error = errors[name];
      return [
        channelName(name),
        unit,
        measured(rms),
        measured(peak),
        measured(crest),
        measured(kurtosis),
        level(loud),
        error === undefined ? '–' : number(error, 1),
      ];
    });
    return table(
      'Levels, 0 to 20 kHz',
      ['Channel', 'Unit', 'rms', 'Peak', 'Crest', 'Kurtosis', `Level, ${LEVEL_UNIT}`, 'Numerical ±, dB'],
      rows,
    );
  }

  #bearings() {
    const rows = Object.entries(this.answer.bearings).map(([name, one]) => [
      name,
      number(one.cage_hz, 5),
      number(one.ball_pass_outer_hz, 5),
      number(one.ball_pass_inner_hz, 5),
      number(one.ball_spin_hz, 5),
      one.cage_slip === undefined ? '–' : number(one.cage_slip * 100, 2),
      number(Math.max(one.max_inner_load_n, one.max_outer_load_n), 4),
      number(one.max_slip_m_s, 2),
    ]);
    return table(
      'Bearings',
      ['Bearing', 'FTF, Hz', 'BPFO, Hz', 'BPFI, Hz', 'BSF, Hz', 'Cage slip, %', 'Largest ball load, N', 'Largest slip, m/s'],
      rows,
    );
  }

  /** Natural frequencies, and all other channels. */
  #rest() {
    const { natural_frequencies: natural, channels, model } = this.answer;
    const omitted = model.left_out ?? [];
    const others = Object.entries(channels).filter(([name]) => !isAcceleration(name));
    return h(
      'div',
      { class: 'tables' },
      more(
        `Natural frequencies: ${natural.length}`,
        table(
          'Natural frequencies about the operating point',
          ['Frequency', 'Damping ratio'],
          natural.map((one) => [quantity(one.frequency_hz, 'Hz', 5), `${number(one.damping_ratio * 100, 3)} %`]),
          { hidden: true },
        ),
      ),
      more(
        `Other channels: ${others.length}`,
        table(
          'Other channels',
          ['Channel', 'Unit', 'Mean', 'rms', 'Peak'],
          others.map(([name, { unit, mean, rms, peak }]) => [
            channelName(name),
            unit,
            measured(mean, 4),
            measured(rms),
            measured(peak),
          ]),
          { hidden: true },
        ),
      ),
      omitted.length > 0 && more(`Omitted terms: ${omitted.length}`, leftOut(omitted)),
    );
  }
}
