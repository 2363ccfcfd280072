// The plots of a finished run, one at a time, each with its table, downloads and curl command.

import * as api from './api.js';
import { button, h, labelled, labelledRadio, more, select, small, table, tools } from './dom.js';
import { command, csv, curl, flat, keep, save } from './download.js';
import { channelName, number, quantity } from './format.js';
import { ballBars, CurvePlot, orbit } from './plots.js';
import { drawn, isRunUp, RUN_UP_VIEWS, runUp } from './run-up.js';
import { Spectra } from './spectra.js';

/** Series for orbit and time plots, which the service keeps only on request. */
const SERIES = [
  'spindle.y.displacement',
  'spindle.z.displacement',
  'spindle.y.velocity',
  'spindle.z.velocity',
  'spindle.y.acceleration',
  'spindle.z.acceleration',
];

const VIEWS = [
  ['spectrum', 'Spectrum'],
  ['orbit', 'Orbit'],
  ['velocity', 'Velocity'],
  ['acceleration', 'Acceleration'],
  ['loads', 'Ball loads'],
  ['impact', 'Impact'],
  ...RUN_UP_VIEWS,
];
const POINTS = 4000;

export class Views {
  /** `say(text)` shows a status message; `rerun(request)` is an action of the page. */
  constructor({ say, rerun }) {
    Object.assign(this, { say, rerun });
    this.view = 'spectrum';
    this.stage = h('div', { class: 'stage' });
    this.extras = h('div', { class: 'extras' });
    this.spectra = new Spectra(() => this.#draw());
    this.curveHost = h('div', {});
    this.curvePlot = new CurvePlot(this.curveHost);
    this.element = h('div', {}, this.#choice(), this.stage, this.extras);
  }

  /** Shows a finished simulation. */
  async show(job, metrics) {
    Object.assign(this, { job, metrics });
    this.channels = job.request.outputs?.spectra ?? ['spindle.y.acceleration', 'spindle.z.acceleration'];
    this.spectra.begin(this.channels, Boolean(job.request.scene?.surfaces));
    const varies = isRunUp(job);
    const exists = {
      impact: Boolean(job.links.impact_svg),
      waterfall: varies || Boolean(job.links.waterfall_svg),
      orders: varies || Boolean(job.links.orders_svg),
    };
    // Of a recorded run only the spectra are there.
    this.choice.hidden = Boolean(job.spectra);
    if (job.spectra) this.view = 'spectrum';
    const radio = (view) => this.element.querySelector(`input[name=view][value=${view}]`);
    Object.entries(exists).forEach(([view, is]) => (radio(view).closest('label').hidden = !is));
    if (exists[this.view] === false) this.view = 'spectrum';
    if (varies && this.view === 'spectrum' && this.opened !== job.id) this.view = 'waterfall';
    this.opened = job.id;
    radio(this.view).checked = true;
    this.stage.replaceChildren();
    await this.#draw();
  }

  #choice() {
    const choose = (value) => {
      this.view = value;
      this.#draw();
    };
    const one = ([value, text]) =>
      labelledRadio({ name: 'view', value, checked: value === this.view, onchange: () => choose(value) }, text);
    this.choice = h('fieldset', { class: 'segments' }, h('legend', { class: 'unseen' }, 'Plot'), VIEWS.map(one));
    return this.choice;
  }

  /** Draws the selected view; a newer selection replaces it. */
  async #draw() {
    this.drawing?.abort();
    this.drawing = new AbortController();
    const { signal } = this.drawing;
    const { view } = this;
    try {
      this.extras.replaceChildren();
      if (view === 'spectrum') await this.#spectrum(signal);
      else if (view === 'loads') await this.#loads(signal);
      else if (view === 'impact') await this.#picture('impact', 'The acceleration of the spindle around its largest peak.', signal);
      else if (view === 'waterfall' || view === 'orders') await this.#orders(view, signal);
      else await this.#motion(view, signal);
    } catch (error) {
      if (!signal.aborted) this.stage.replaceChildren(h('p', { class: 'error' }, error.message));
    }
  }

  async #spectrum(signal) {
    const { files, request, tables } = await this.spectra.draw(this.stage, { job: this.job, metrics: this.metrics, channels: this.channels }, signal);
    this.extras.replaceChildren(...tables, this.job.spectra ? '' : this.#downloads(files, request));
  }

  /** Orbit, velocity or acceleration: from kept series, or the plot of the service. */
  async #motion(view, signal) {
    const { request } = this.job;
    const kept = request.outputs?.series ?? [];
    const drawnByService =
      api.features.plots.includes(`${view}.svg`) &&
      (api.features.plots.includes('orbit.svg') || SERIES.some((channel) => kept.includes(channel) && channel.endsWith(view)));
    if (view !== 'orbit' && kept.some((channel) => channel.startsWith('spindle.') && channel.endsWith(view))) {
      await this.#time(
        view,
        kept.filter((channel) => channel.startsWith('spindle.') && channel.endsWith(view)),
        signal,
      );
    } else if (drawnByService) {
      await this.#picture(view, `The ${view} of the spindle.`, signal);
    } else if (view === 'orbit' && ['y', 'z'].every((axis) => kept.includes(`spindle.${axis}.displacement`))) {
      await this.#orbit(signal);
    } else {
      const again = () => this.rerun({ ...request, outputs: { ...request.outputs, series: SERIES } });
      this.stage.replaceChildren(
        h(
          'div',
          { class: 'empty' },
          h('p', {}, 'This run kept no time series.'),
          button('Run again with time series', again),
        ),
      );
    }
  }

  /** Waterfall or orders, which need kept series. */
  async #orders(view, signal) {
    if (!this.job.links[`${view}_svg`]) {
      const { request } = this.job;
      const again = () => this.rerun({ ...request, outputs: { ...request.outputs, orders: {} } });
      this.stage.replaceChildren(
        h('div', { class: 'empty' }, h('p', {}, 'This run kept no orders.'), button('Run again with orders', again)),
      );
      return;
    }
    this.#place(view, await runUp(this.job, view, signal));
  }

  async #picture(view, text, signal) {
    this.#place(view, await drawn(this.job, view, text, signal));
  }

  #place(view, { element, svg, path }) {
    this.stage.replaceChildren(h('figure', {}, element));
    const file = ['Plot SVG', async () => save(`${view}-${this.job.id}.svg`, svg, 'image/svg+xml')];
    this.extras.replaceChildren(this.#downloads([file], { path, accept: 'image/svg+xml' }));
  }

  async #orbit(signal) {
    const [y, z] = await Promise.all(['y', 'z'].map((axis) => this.#series(`spindle.${axis}.displacement`, signal)));
    const wide = (values) => quantity(Math.max(...values) - Math.min(...values), y.unit, 3);
    const text = `Orbit of the spindle's centre: ${wide(z.value)} wide in z, ${wide(y.value)} in y.`;
    this.stage.replaceChildren(h('figure', {}, orbit({ y: y.value, z: z.value, unit: y.unit, text }), h('figcaption', {}, text)));
    this.extras.replaceChildren(
      this.#downloads(
        ['y', 'z'].map((axis) => this.#seriesFile(`spindle.${axis}.displacement`)),
        { path: this.#seriesPath('spindle.y.displacement'), accept: 'text/csv' },
      ),
    );
  }

  async #time(view, channels, signal) {
    const chosen = channels.includes(this.seriesChannel) ? this.seriesChannel : channels[0];
    const chooser = select(
      channels.map((name) => [name, channelName(name)]),
      (value) => {
        this.seriesChannel = value;
        this.#draw();
      },
    );
    chooser.value = chosen;
    const series = await this.#series(chosen, signal);
    const [least, most] = [Math.min(...series.value), Math.max(...series.value)];
    const text = `${channelName(chosen)} over time, from ${quantity(least, series.unit, 3)} to ${quantity(most, series.unit, 3)}.`;
    this.stage.replaceChildren(
      h(
        'figure',
        {},
        tools(labelled('Channel', chooser)),
        this.curveHost,
        h('figcaption', {}, `${text} Drag to zoom, double-click for the whole range.`),
      ),
    );
    const plot = this.curvePlot;
    plot.draw({
      x: series.time_s,
      y: series.value,
      xLabel: 'Time, s',
      yLabel: `${view[0].toUpperCase()}${view.slice(1)}, ${series.unit}`,
      dots: false,
    });
    plot.describe(text);
    this.extras.replaceChildren(
      this.#downloads([this.#seriesFile(chosen)], { path: this.#seriesPath(chosen), accept: 'text/csv' }),
    );
  }

  #series(channel, signal) {
    return api.get(this.#seriesPath(channel), { signal });
  }

  #seriesPath(channel) {
    return `/v1/jobs/${this.job.id}/series?channel=${encodeURIComponent(channel)}&max_points=${POINTS}`;
  }

  #seriesFile(channel) {
    return [`${channelName(channel)} CSV`, () => keep(`${channel}-${this.job.id}.csv`, this.#seriesPath(channel), 'text/csv')];
  }

  async #loads(signal) {
    if (api.features.plots.includes('loads.svg')) {
      await this.#picture('loads', 'Loads of a ball over its orbit.', signal);
      return;
    }
    const { inner, outer } = this.metrics.contacts ?? {};
    if (!inner) {
      this.stage.replaceChildren(h('p', { class: 'empty' }, 'This run computed no contact loads.'));
      return;
    }
    const [a, b] = [inner.max_load_per_ball_n, outer.max_load_per_ball_n];
    const text = `Largest load of each ball: up to ${quantity(Math.max(...a), 'N')} on the inner raceway, ${quantity(Math.max(...b), 'N')} on the outer.`;
    this.stage.replaceChildren(
      h(
        'figure',
        {},
        ballBars({ inner: a, outer: b, text }),
        h(
          'figcaption',
          {},
          h('span', { class: 'key inner' }, 'inner raceway'),
          h('span', { class: 'key outer' }, 'outer raceway'),
          text,
        ),
      ),
    );
    this.extras.replaceChildren(
      more(
        'Loads as a table',
        table(
          'Largest load of each ball',
          ['Ball', 'Inner, N', 'Outer, N'],
          a.map((load, i) => [i + 1, number(load), number(b[i])]),
          { hidden: true },
        ),
      ),
    );
  }

  #downloads(files, request) {
    const { id } = this.job;
    const all = [
      ...files,
      ['Metrics JSON', async () => save(`metrics-${id}.json`, JSON.stringify(this.metrics, null, 2), 'application/json')],
      ['Metrics CSV', async () => save(`metrics-${id}.csv`, csv([['field', 'value'], ...flat(this.metrics)]), 'text/csv')],
    ];
    const file = ([text, act]) => small(text, () => act().catch((error) => this.say(error.message)));
    return h(
      'div',
      { class: 'downloads' },
      tools(h('span', { class: 'note' }, 'Download'), all.map(file)),
      more('curl command', command(curl({ ...request, token: api.hasToken() }))),
    );
  }
}
