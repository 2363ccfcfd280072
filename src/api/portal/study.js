// A study of one parameter: a run at each value, and the trend of a metric.

import * as api from './api.js';
import { h, labelled, more, select, small, table, tools } from './dom.js';
import { command, curl, keep } from './download.js';
import { rangeAround, schemaAt, VARIED } from './fields.js';
import { LEVEL_UNIT, number, quantity, title, words } from './format.js';
import { CurvePlot } from './plots.js';
import { read } from './request.js';

/** Plotted metrics: pointer, name, unit, and the function for the error of a point, if stated. */
const METRICS = [
  ...['y', 'z'].map((axis) => [
    `/channels/spindle.${axis}.acceleration/level_db`,
    `Level ${axis}`,
    LEVEL_UNIT,
    (m) => m.channels?.[`spindle.${axis}.acceleration`]?.level_error_db ?? m.accuracy?.level_error_db,
  ]),
  ...['y', 'z'].map((axis) => [`/channels/spindle.${axis}.velocity/rms`, `Velocity ${axis}, rms`, 'mm/s']),
  ...['y', 'z'].flatMap((axis) => [
    [`/channels/spindle.${axis}.acceleration/kurtosis`, `Kurtosis ${axis}`, ''],
    [`/channels/spindle.${axis}.acceleration/crest_factor`, `Crest factor ${axis}`, ''],
    ...[
      ['ball_pass_outer', 'BPFO'],
      ['ball_pass_inner', 'BPFI'],
      ['double_ball_spin', '2·BSF'],
    ].flatMap(([rate, label]) => [
      [`/channels/spindle.${axis}.acceleration/envelope/${rate}/first`, `Envelope ${axis} at ${label}`, 'm/s²'],
      [`/channels/spindle.${axis}.acceleration/envelope/${rate}/first_over_rms`, `Envelope ${axis} at ${label} over rms`, ''],
    ]),
  ]),
  ['/contacts/inner/max_load_n', 'Largest ball load, inner', 'N', (m, value) => m.accuracy?.max_load_error * value],
  ['/contacts/outer/max_load_n', 'Largest ball load, outer', 'N', (m, value) => m.accuracy?.max_load_error * value],
  ['/contacts/inner/max_pressure_mpa', 'Largest pressure, inner', 'MPa', (m, value) => (m.accuracy?.max_load_error * value) / 3],
  ['/contacts/inner/min_film_thickness_um', 'Smallest film thickness, inner', 'µm'],
  ['/contacts/pocket/max_load_n', 'Largest pocket load', 'N', (m, value) => m.accuracy?.max_pocket_load_error * value],
  ['/kinematics/cage_speed_hz', 'Cage speed', 'Hz', (m, value) => m.accuracy?.cage_speed_error * value],
  ['/kinematics/cage_slip', 'Cage slip', '', (m) => m.accuracy?.cage_slip_error],
  ['/cage/orbit_radius_um', 'Cage orbit radius', 'µm', (m, value) => m.accuracy?.orbit_radius_error * value],
];

export class Study {
  constructor(host, { document, request, resolved, say, onStart }) {
    Object.assign(this, { document, request, resolved, say, onStart });
    const short = (name, value) => h('input', { type: 'text', inputmode: 'decimal', class: 'short', value, 'aria-label': name });
    this.field = select(
      VARIED.map((f) => [f.pointer, f.label]),
      () => this.reset(),
    );
    this.field.value = '/scene/bearing/radial_clearance_um';
    this.from = short('From');
    this.to = short('To');
    this.count = h('input', { type: 'number', min: 2, max: 200, value: 9, class: 'short' });
    this.scale = select([
      ['linear', 'linear'],
      ['log', 'log'],
    ]);
    this.start = h('button', { type: 'submit', class: 'primary' }, 'Run study');
    this.error = h('p', { class: 'error', role: 'alert' });
    this.unit = h('span', { class: 'unit' });
    this.plotHost = h('div', {});
    this.plot = new CurvePlot(this.plotHost);
    this.body = h('div', {});
    host.replaceChildren(
      h('h2', {}, 'Study of one parameter'),
      h(
        'form',
        {
          class: 'tools',
          onsubmit: (event) => {
            event.preventDefault();
            this.#submit();
          },
        },
        labelled('Parameter', this.field),
        labelled('From', this.from),
        labelled('To', this.to, ' ', this.unit),
        labelled('Points', this.count),
        labelled('Spacing', this.scale),
        this.start,
      ),
      this.error,
      this.body,
    );
  }

  reset() {
    const resolved = this.resolved();
    if (!resolved) return;
    const spec = this.#spec();
    const value = read(this.request(), spec.pointer) ?? read(resolved, spec.pointer);
    // The entered range is kept as long as the value is unchanged.
    const base = `${spec.pointer} ${value}`;
    if (base === this.base) return;
    this.base = base;
    const [from, to] = rangeAround(spec, value, schemaAt(this.document, spec.pointer));
    Object.assign(this.from, { value: from });
    Object.assign(this.to, { value: to });
    if (spec.whole) this.count.value = to - from + 1;
    this.unit.textContent = spec.unit;
  }

  #spec(path = this.field.value) {
    return VARIED.find((spec) => spec.pointer === path || spec.pointer === `/scene${path}`);
  }

  #job() {
    const { scene, solver, duration_s, settle_s, outputs } = this.request();
    const { envelope, envelope_band_hz } = outputs ?? {};
    return {
      kind: 'study',
      scene,
      ...(solver && { solver }),
      ...(duration_s && { duration_s }),
      ...(settle_s !== undefined && { settle_s }),
      ...((envelope || envelope_band_hz) && { outputs: { envelope, envelope_band_hz } }),
      axes: [
        {
          path: this.field.value.replace('/scene', ''),
          from: Number(this.from.value),
          to: Number(this.to.value),
          count: Number(this.count.value),
          ...(this.scale.value === 'log' && { scale: 'log' }),
        },
      ],
    };
  }

  async #submit() {
    this.error.textContent = '';
    this.start.disabled = true;
    try {
      const job = await api.submit(this.#job());
      this.onStart(job);
      await this.show(job);
    } catch (error) {
      this.error.textContent = error.errors?.length
        ? error.errors.map(({ pointer, detail }) => `${pointer.replace('/axes/0/', '')}: ${detail}`).join('; ')
        : error.message;
    } finally {
      this.start.disabled = false;
    }
  }

  async show(job) {
    this.controller?.abort();
    const controller = new AbortController();
    this.controller = controller;
    const bar = h('progress', { max: 1, value: job.progress, 'aria-label': 'Progress of the study' });
    const note = h('span', { class: 'note', role: 'status' });
    const stop = small('Cancel', () => api.cancel(job).catch((error) => this.say(error.message)));
    const head = h(
      'div',
      { class: 'run-head' },
      h('h3', {}, title(job.request)),
      h('div', { class: 'run-state' }, bar, note, stop),
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
      note.textContent = ended.status;
      if (ended.status === 'queued') return;
      await this.#table(ended, controller.signal);
      this.say(`The study has ${ended.status}.`);
    } catch (error) {
      if (!controller.signal.aborted) this.error.textContent = error.message;
    }
  }

  async #table(job, signal) {
    const answer = await api.get(job.links.table, { signal });
    const metrics = METRICS.filter(([pointer]) => answer.rows.some((row) => typeof valueAt(row.metrics, pointer) === 'number'));
    const chooser = select(
      metrics.map(([pointer, name]) => [pointer, name]),
      () => draw(),
    );
    const caption = h('figcaption', {});
    const rows = h('div', {});
    const [axis] = answer.axes;
    const spec = this.#spec(axis.axis) ?? { label: words(axis.axis), unit: '' };
    const xLabel = [spec.label, spec.unit].filter(Boolean).join(', ');
    const plot = this.plot;
    const draw = () => {
      const [pointer, name, unit, errorOf] = metrics.find((metric) => metric[0] === chooser.value);
      const x = answer.rows.map((row) => row.point[axis.axis]);
      const y = answer.rows.map((row) => valueAt(row.metrics, pointer) ?? null);
      const errors = answer.rows.map((row, i) => (y[i] === null ? null : (errorOf?.(row.metrics, Math.abs(y[i])) ?? null)));
      const yLabel = [name, unit].filter(Boolean).join(', ');
      plot.draw({ x, y, errors, xLabel, yLabel, logX: job.request.axes[0].scale === 'log' });
      const best = answer.best[pointer];
      const trend = answer.trends[pointer];
      const failed = answer.points - answer.succeeded;
      const text = [
        `${yLabel} over ${xLabel}, ${answer.succeeded} of ${answer.points} points.`,
        best &&
          `Best (${best.goal.replace('_', ' ')}): ${quantity(best.value, unit)} at ${quantity(best.point[axis.axis], spec.unit)}${best.as_good > 1 ? `, with ${best.as_good - 1} as good within their errors` : ''}.`,
        trend?.resolved === false && 'The trend is not resolved: the errors exceed a tenth of its span.',
        failed > 0 && `${failed} without a result: ${answer.rows.find((row) => row.error)?.error.detail ?? 'not run'}.`,
      ]
        .filter(Boolean)
        .join(' ');
      plot.describe(text);
      caption.textContent = `${text}${errors.some(Boolean) ? ' Bars: estimated error.' : ''}`;
      rows.replaceChildren(
        more(
          'Points as a table',
          table(
            `${name} of each point`,
            [xLabel, yLabel, 'Estimated error', 'Model'],
            answer.rows.map((row, i) => [
              number(x[i], 5),
              y[i] === null ? (row.error?.cause ?? row.status) : number(y[i]),
              number(errors[i], 2),
              words(row.metrics?.solver?.rung ?? ''),
            ]),
            { hidden: true },
          ),
        ),
      );
    };
    const path = job.links.table;
    const trends = () => keep(`trend-${job.id}.svg`, `${job.links.self}/plots/trend.svg`, 'image/svg+xml');
    const file = (text, name, type) => small(text, () => keep(name, path, type).catch((error) => this.say(error.message)));
    this.body.append(
      h('figure', {}, tools(labelled('Metric', chooser)), this.plotHost, caption),
      rows,
      tools(
        h('span', { class: 'note' }, 'Download'),
        file('Table CSV', `study-${job.id}.csv`, 'text/csv'),
        file('Table JSON', `study-${job.id}.json`, 'application/json'),
        small('Trends SVG', () => trends().catch((error) => this.say(error.message))),
      ),
      more(
        'curl commands',
        command(curl({ method: 'POST', path: '/v1/jobs', body: job.request, token: api.hasToken() })),
        command(curl({ path, accept: 'text/csv', token: api.hasToken() })),
      ),
    );
    if (metrics.length) draw();
    else caption.textContent = answer.rows.find((row) => row.error)?.error.detail ?? 'No point has a result.';
  }
}

const valueAt = (metrics, pointer) =>
  pointer
    .split('/')
    .slice(1)
    .reduce((value, step) => value?.[step], metrics);
