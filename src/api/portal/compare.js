// Comparison of two finished runs.

import * as api from './api.js';
import { button, h, labelled, options, select, small, table, tools } from './dom.js';
import { csv, save } from './download.js';
import { channelName, LEVEL_UNIT, level, measured, moment, title, words } from './format.js';
import { linesOf, usualLimit } from './metrics.js';
import { SpectrumPlot } from './plots.js';
import { write } from './request.js';

export class Compare {
  /** `request()` returns the request of the form, `resolved()` its resolved form. */
  constructor(host, { say, request, resolved }) {
    Object.assign(this, { say, request, resolved });
    const run = (text, name) => {
      const element = select([], () => this.#draw());
      return [h('label', { class: `stacked key ${name}` }, text, element), element];
    };
    const [labelA, a] = run('First run', 'inner');
    const [labelB, b] = run('Second run', 'outer');
    this.chosen = [a, b];
    this.channel = select(
      ['spindle.y.acceleration', 'spindle.z.acceleration'].map((name) => [name, channelName(name)]),
      () => this.#draw(),
    );
    this.kind = select(
      [
        ['amplitude', 'signal'],
        ['envelope', 'envelope'],
      ],
      () => this.#draw(),
    );
    this.both = button('Run with and without surfaces', () => this.withAndWithout(), { class: 'small' });
    this.place = h('div', {});
    this.plot = new SpectrumPlot(this.place);
    this.caption = h('figcaption', {});
    this.figure = h('figure', { hidden: true }, this.place, this.caption);
    this.metrics = h('div', {});
    this.note = h('p', { class: 'empty' }, 'Select two finished runs.');
    host.replaceChildren(
      h('h2', {}, 'Compare'),
      h('div', { class: 'pair' }, labelA, labelB),
      tools(labelled('Channel', this.channel), labelled('Spectrum of the', this.kind), this.both),
      this.note,
      this.figure,
      this.metrics,
    );
  }

  /** Adds a run to the comparison. */
  async add(job) {
    this.added = true;
    await this.refresh();
    const [a, b] = this.chosen;
    const place = !a.value || (b.value && b.value !== job.id) ? a : b;
    if (place === a && b.value) a.value = b.value;
    (place === a && !b.value ? a : b).value = job.id;
    await this.#draw();
  }

  /** Runs the scene of the form with and without its surfaces, over the same time, and compares both. */
  async withAndWithout() {
    const [request, resolved] = [this.request(), this.resolved()];
    if (!request.scene?.surfaces || !resolved) {
      this.say('The scene of the form has no surfaces.');
      return;
    }
    this.pair = undefined;
    const same = { ...request, kind: 'simulation', settle_s: resolved.settle_s, duration_s: resolved.duration_s };
    this.added = true;
    this.both.disabled = true;
    this.metrics.replaceChildren();
    this.figure.hidden = true;
    this.note.hidden = false;
    try {
      const jobs = await Promise.all([same, write(same, '/scene/surfaces', undefined)].map(api.submit));
      const shares = [0, 0];
      const ended = await Promise.all(
        jobs.map((job, i) =>
          api.follow(job, {
            onProgress: ({ progress }) => {
              shares[i] = progress;
              this.note.textContent = `Running with surfaces ${Math.round(shares[0] * 100)} %, without ${Math.round(shares[1] * 100)} %.`;
            },
          }),
        ),
      );
      const failed = ended.find(({ status }) => status !== 'succeeded');
      if (failed) throw new Error(failed.error?.detail ?? `A run was ${failed.status}.`);
      await this.refresh();
      ended.forEach(({ id }, i) => {
        this.chosen[i].value = id;
      });
      this.pair = ended.map(({ id }) => id).join();
      this.note.textContent = 'Select two finished runs.';
      await this.#draw();
    } catch (error) {
      this.note.textContent = error.message;
      this.say(error.message);
    } finally {
      this.both.disabled = false;
    }
  }

  /** Selects the last two runs if none is selected. */
  async show() {
    await this.refresh();
    const [a, b] = this.chosen;
    if (this.added || a.value || b.value || a.options.length < 3) return;
    // The first option is "none", the second the newest run.
    [a.value, b.value] = [a.options[2].value, a.options[1].value];
    await this.#draw();
  }

  /** Updates the list of finished runs and keeps the selection. */
  async refresh() {
    try {
      const { jobs } = await api.recentJobs('/v1/jobs?status=succeeded&kind=simulation&limit=50');
      const pairs = jobs.map((job) => [job.id, `${moment(job.created_at)}  ${title(job.request)}`]);
      for (const chooser of this.chosen) {
        const { value } = chooser;
        chooser.replaceChildren(...options([['', 'none'], ...pairs]));
        chooser.value = pairs.some(([id]) => id === value) ? value : '';
      }
    } catch (error) {
      this.say(error.message);
    }
  }

  async #draw() {
    const ids = this.chosen.map((chooser) => chooser.value);
    const ready = ids.every(Boolean);
    this.note.hidden = ready;
    this.figure.hidden = !ready;
    this.metrics.replaceChildren();
    if (!ready) return;
    this.controller?.abort();
    this.controller = new AbortController();
    const { signal } = this.controller;
    const channel = this.channel.value;
    try {
      const metrics = await Promise.all(ids.map((id) => api.get(`/v1/jobs/${id}/metrics`, { signal })));
      const kind = this.kind.value;
      const limit = Math.max(...metrics.map((one) => usualLimit(one, kind)));
      const spectra = await Promise.all(ids.map((id) => api.spectrum(id, channel, limit, signal, kind)));
      const names = this.chosen.map((chooser) => chooser.selectedOptions[0].textContent);
      const lines = linesOf(metrics[0], kind).filter((line) => line.channel === channel);
      this.plot.draw({
        spectra: spectra.map((spectrum, i) => ({ name: names[i], ...spectrum })),
        lines,
        unit: spectra[0].unit,
        limit,
      });
      const levels = metrics.map((m) => m.channels?.[channel]?.level_db);
      const isPair = ids.join() === this.pair;
      const [one, other] = isPair ? ['With surfaces', 'Without'] : ['First', 'Second'];
      const [first, second] = names.map((name, i) => `${name}: ${level(levels[i])} dB`);
      const text = `${kind === 'envelope' ? 'Envelope spectra' : 'Spectra'} of ${channelName(channel)}. ${one} (with line labels): ${first}. ${other}: ${second}.`;
      this.plot.describe(text);
      this.caption.textContent = text;
      this.#differences(metrics, isPair);
    } catch (error) {
      if (!signal.aborted) this.say(error.message);
    }
  }

  /** What the surfaces add, or the change from the first run to the second. */
  #differences([a, b], isPair) {
    const rows = pairs(a, b);
    const names = isPair ? ['With', 'Without', 'With − without'] : ['First', 'Second', 'Second − first'];
    const change = (x, y) => (isPair ? [x, y] : [y, x]);
    const shown = rows.map(([name, unit, x, y]) => {
      const [to, from] = change(x, y);
      return [
        name,
        unit,
        measured(x, 4),
        measured(y, 4),
        signed(to - from),
        name.includes('level') || !from ? '' : `${signed((to / from - 1) * 100, 2)} %`,
      ];
    });
    this.metrics.replaceChildren(
      ...equationsDiffer([a, b]).map((text) => h('p', { class: 'warning' }, text)),
      table('Metrics of both runs and their difference', ['Metric', 'Unit', ...names, 'Relative'], shown),
      tools(
        small('Differences CSV', () => save('comparison.csv', csv([['metric', 'unit', 'first', 'second'], ...rows]), 'text/csv')),
      ),
    );
  }
}

const signed = (value, digits = 3) => (value > 0 ? `+${measured(value, digits)}` : measured(value, digits));

/** Says which terms only one of two runs omits: their difference is in the levels, too. */
function equationsDiffer(runs) {
  const omitted = runs.map(({ left_out: terms = [] }) => terms.map(({ term }) => words(term)));
  const only = omitted.map((own, k) => own.filter((term) => !omitted[1 - k].includes(term)));
  const told = only.map((terms, k) => terms.length > 0 && `Only the ${['first', 'second'][k]} run (${words(runs[k].solver.rung)}) omits: ${terms.join(', ')}.`);
  return told.some(Boolean) ? [`The runs have different equations, which is part of their difference. ${told.filter(Boolean).join(' ')}`] : [];
}

/** Metrics of both runs: name, unit, both values. */
function pairs(a, b) {
  const rows = [];
  for (const [name, channel] of Object.entries(a.channels ?? {})) {
    const other = b.channels?.[name];
    if (!other) continue;
    if (channel.level_db !== undefined) rows.push([`${channelName(name)}, level`, LEVEL_UNIT, channel.level_db, other.level_db]);
    rows.push([`${channelName(name)}, rms`, channel.unit, channel.rms, other.rms]);
    for (const [word, field] of [
      ['crest factor', 'crest_factor'],
      ['kurtosis', 'kurtosis'],
    ])
      if (channel.level_db !== undefined && channel[field] !== undefined && other[field] !== undefined) rows.push([`${channelName(name)}, ${word}`, '', channel[field], other[field]]);
  }
  const at = (metrics, path) => path.split('.').reduce((value, step) => value?.[step], metrics);
  for (const [name, unit, path] of [
    ['Largest ball load, inner', 'N', 'contacts.inner.max_load_n'],
    ['Largest ball load, outer', 'N', 'contacts.outer.max_load_n'],
    ['Largest pressure, inner', 'MPa', 'contacts.inner.max_pressure_mpa'],
    ['Smallest film thickness, inner', 'µm', 'contacts.inner.min_film_thickness_um'],
    ['Largest pocket load', 'N', 'contacts.pocket.max_load_n'],
    ['Cage speed', 'Hz', 'kinematics.cage_speed_hz'],
    ['Cage orbit radius', 'µm', 'cage.orbit_radius_um'],
    ['BPFO', 'Hz', 'frequencies_hz.ball_pass_outer'],
    ['BPFI', 'Hz', 'frequencies_hz.ball_pass_inner'],
  ]) {
    if (at(a, path) !== undefined && at(b, path) !== undefined) rows.push([name, unit, at(a, path), at(b, path)]);
  }
  return rows;
}
