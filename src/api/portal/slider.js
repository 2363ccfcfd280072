// One parameter by slider: each position is a run without a job, and the newest one is shown.

import * as api from './api.js';
import { button, h, labelled, more, select, tools } from './dom.js';
import { command, curl } from './download.js';
import { rangeAround, schemaAt, VARIED } from './fields.js';
import { level, number, numerical, quantity, seconds, words } from './format.js';
import { usualLimit } from './metrics.js';
import { SpectrumPlot } from './plots.js';
import { read, write } from './request.js';

/** Time that a run has before a newer position cancels it [ms]. If none had any, a moving slider would show nothing. */
const HEAD_START = 250;

/** Time after which shown values are dimmed, because the run of the newest position still goes on [ms]. */
const DIM_AFTER = 150;

/**
 * Runs only the newest value: older ones that wait are dropped, one that runs is cancelled after its head start. The one after a cancelled run ends,
 * so that a slow machine shows something, too.
 */
class Latest {
  #running = null;

  /** `work(value, signal)` runs; `changed(isRunning)` is told when the first run begins and the last one has ended. */
  constructor(work, changed) {
    Object.assign(this, { work, changed });
  }

  push(value) {
    this.waiting = { value };
    if (!this.#running) this.#next();
    else this.#hurry();
  }

  stop() {
    this.waiting = null;
    this.#running?.controller.abort();
  }

  #hurry() {
    const running = this.#running;
    clearTimeout(this.timer);
    if (running.follows) return;
    const cancel = () => {
      if (!this.waiting) return;
      this.cancelled = true;
      running.controller.abort();
    };
    this.timer = setTimeout(cancel, Math.max(HEAD_START - (performance.now() - running.begin), 0));
  }

  #next() {
    clearTimeout(this.timer);
    if (!this.waiting) {
      this.#running = null;
      this.changed(false);
      return;
    }
    const { value } = this.waiting;
    this.waiting = null;
    if (!this.#running) this.changed(true);
    // `follows`: a cancelled run.
    this.#running = { controller: new AbortController(), begin: performance.now(), follows: this.cancelled };
    this.cancelled = false;
    this.work(value, this.#running.controller.signal).finally(() => this.#next());
  }
}

/** Fields that set the play of a bearing: one of the first two, or those by which a clearance group sets it. */
const SAME_PLAY = ['/scene/bearing/radial_clearance_um', '/scene/bearing/contact_angle_deg'];
const PLAY_BY_GROUP = ['radial_clearance_group', 'fits', 'temperatures'].map((name) => `/scene/bearing/${name}`);

export class Slider {
  /** `request()` returns the request of the form, `resolved()` its resolved form; `apply(job)` puts a position into the form. */
  constructor(host, { document, request, resolved, apply, say }) {
    Object.assign(this, { document, request, resolved, apply, say });
    this.latest = new Latest(
      (value, signal) => this.#run(value, signal),
      (isRunning) => this.#busy(isRunning),
    );
    this.frames = [];
    this.field = select(
      VARIED.map((f) => [f.pointer, f.label]),
      () => this.reset(),
      { id: 'slider-field' },
    );
    this.field.value = '/scene/bearing/radial_clearance_um';
    const end = (name) =>
      h('input', { type: 'text', inputmode: 'decimal', class: 'short', 'aria-label': name, onchange: () => this.#ends() });
    this.from = end('Lowest value');
    this.to = end('Highest value');
    this.range = h('input', { type: 'range', id: 'slider', 'aria-describedby': 'slider-value', oninput: () => this.#moved() });
    this.value = h('output', { id: 'slider-value', for: 'slider', 'aria-live': 'off' });
    this.channel = select(
      ['y', 'z'].map((axis) => [`spindle.${axis}.acceleration`, `spindle ${axis} acceleration`]),
      () => this.#moved(),
    );
    this.tolerance = select(
      [
        ['1', '1 dB (fast)'],
        ['0.2', '0.2 dB'],
        ['', 'as in the form'],
      ],
      () => this.#moved(),
    );
    this.sweep = h('button', { type: 'button', 'aria-pressed': 'false', onclick: () => this.#toggle() }, 'Sweep');
    const gauge = (name) => {
      const dd = h('dd', {}, '–');
      return [h('div', {}, h('dt', {}, name), dd), dd];
    };
    const gauges = ['Level', 'Frames per second', 'Model', 'Response time'].map(gauge);
    [this.level, this.rate, this.rung, this.delay] = gauges.map(([, dd]) => dd);
    this.error = h('p', { class: 'error', role: 'status' });
    // Its place is kept, so that nothing moves when it appears.
    this.progress = h('progress', { class: 'busy', 'aria-label': 'The run of this position' });
    this.place = h('div', {});
    this.plot = new SpectrumPlot(this.place, 400);
    this.plot.describe('Spectrum at the position of the slider. The level is shown above.');
    host.replaceChildren(
      h('h2', {}, 'Slider'),
      tools(
        labelled('Parameter', this.field),
        labelled('Channel', this.channel),
        labelled('Model accuracy', this.tolerance),
      ),
      h(
        'div',
        { class: 'slide' },
        this.from,
        h('label', { class: 'unseen', for: 'slider' }, 'Value of the parameter'),
        this.range,
        this.to,
      ),
      tools(
        this.value,
        this.progress,
        this.sweep,
        button('Copy to the form', () => this.apply(this.#job(Number(this.range.value), true))),
      ),
      (this.shown = h(
        'div',
        { class: 'shown' },
        h(
          'dl',
          { class: 'figures' },
          gauges.map(([div]) => div),
        ),
        this.error,
        h('figure', {}, this.place, h('figcaption', {}, 'Thin grey: the starting position of the slider.')),
      )),
      this.#asCommand(),
    );
  }

  /** Restarts with the scene of the form, and keeps the settings if the scene is unchanged. */
  reset() {
    const resolved = this.resolved();
    if (!resolved) return;
    const spec = this.#spec();
    const scene = JSON.stringify([this.request(), spec.pointer]);
    if (scene === this.scene) {
      this.#moved();
      return;
    }
    this.scene = scene;
    const value = read(this.request(), spec.pointer) ?? read(resolved, spec.pointer) ?? spec.range?.[0] ?? 0;
    const [from, to] = rangeAround(spec, value, schemaAt(this.document, spec.pointer));
    this.from.value = from;
    this.to.value = to;
    this.ghost = null;
    this.#ends(value);
  }

  /** The job of the current position as a curl command, written only when it is opened: at each redraw it would cost time. */
  #asCommand() {
    const place = h('div', {});
    const details = more('This position with curl', place);
    details.addEventListener('toggle', () => {
      const body = this.#job(Number(this.range.value));
      if (details.open) place.replaceChildren(command(curl({ method: 'POST', path: '/v1/preview', body, token: api.hasToken() })));
    });
    return details;
  }

  stop() {
    this.#toggle(false);
    this.latest.stop();
  }

  /** Shows that a run goes on, and dims the values of an older position. */
  #busy(isRunning) {
    clearTimeout(this.dimming);
    if (isRunning) this.dimming = setTimeout(() => this.#dim(true), DIM_AFTER);
    else this.#dim(false);
  }

  #dim(isOld) {
    this.shown.classList.toggle('old', isOld);
    this.progress.classList.toggle('seen', isOld);
  }

  #spec() {
    return VARIED.find((spec) => spec.pointer === this.field.value);
  }

  #ends(value = Number(this.range.value)) {
    const [from, to] = [Number(this.from.value), Number(this.to.value)];
    if (!(from < to)) {
      this.error.textContent = 'The lowest value must be a number below the highest value.';
      return;
    }
    Object.assign(this.range, { min: from, max: to, step: this.#spec().whole ? 1 : (to - from) / 200 });
    this.range.value = value;
    this.#moved();
  }

  #moved() {
    const value = Number(this.range.value);
    const spec = this.#spec();
    this.value.textContent = `${spec.label} ${quantity(value, spec.unit)}`;
    this.range.setAttribute('aria-valuetext', quantity(value, spec.unit));
    this.latest.push(value);
  }

  #job(value, bare = false) {
    const spec = this.#spec();
    let job = write(this.request(), spec.pointer, Number(value.toPrecision(5)));
    if (SAME_PLAY.includes(spec.pointer))
      for (const other of [...SAME_PLAY, ...PLAY_BY_GROUP].filter((one) => one !== spec.pointer)) job = write(job, other, undefined);
    if (bare) return job;
    const tolerance = this.tolerance.value;
    return {
      ...job,
      ...(tolerance ? { solver: { model_tolerance_db: Number(tolerance) } } : {}),
      outputs: { metrics: ['vibration'], spectra: [this.channel.value] },
    };
  }

  async #run(value, signal) {
    const begin = performance.now();
    try {
      const { metrics, spectra } = await api.preview(this.#job(value), signal);
      if (signal.aborted) return;
      this.limit = this.ghost ? this.limit : usualLimit(metrics);
      const [spectrum] = spectra;
      const count = spectrum.frequency_hz.findLastIndex((frequency) => frequency <= this.limit) + 1;
      const cut = { frequency_hz: spectrum.frequency_hz.slice(0, count), amplitude: spectrum.amplitude.slice(0, count) };
      this.#draw(metrics, { ...spectrum, ...cut }, begin);
    } catch (error) {
      if (!signal.aborted) this.error.textContent = error.errors?.[0]?.detail ?? error.message;
    }
  }

  #draw(metrics, spectrum, begin) {
    if (this.ghost?.channel !== spectrum.channel) this.ghost = spectrum;
    this.error.textContent = '';
    this.plot.draw({
      spectra: [
        { name: 'start', ...this.ghost },
        { name: 'now', ...spectrum },
      ],
      lines: metrics.lines.slice(0, 10),
      unit: spectrum.unit,
      limit: this.limit,
      keepZoom: true,
      ghost: true,
    });
    const now = performance.now();
    this.frames = [...this.frames.filter((at) => now - at < 2000), now];
    const rate = this.frames.length > 2 ? (this.frames.length - 1) / ((now - this.frames[0]) / 1000) : 0;
    const channel = metrics.channels[spectrum.channel];
    const error = channel?.level_error_db ?? metrics.accuracy.level_error_db;
    this.level.textContent = `${level(channel?.level_db)} dB${error === undefined ? '' : ` ${numerical(error)}`}`;
    this.rate.textContent = rate ? rate.toFixed(0) : '–';
    this.rung.textContent = words(metrics.solver.rung);
    this.delay.textContent = seconds((now - begin) / 1000);
    // While the slider moves, each position is new for a moment.
    this.#dim(false);
    if (this.latest.waiting) this.#busy(true);
    // Read by the automated check.
    this.place.dataset.redraws = String(Number(this.place.dataset.redraws ?? 0) + 1);
  }

  /** Moves the slider back and forth. It never starts by itself, because motion can disturb. */
  #toggle(on = this.sweep.getAttribute('aria-pressed') !== 'true') {
    this.sweep.setAttribute('aria-pressed', String(on));
    this.sweep.textContent = on ? 'Stop' : 'Sweep';
    clearInterval(this.timer);
    if (!on) return;
    const { min, max } = this.range;
    const span = max - min;
    const start = Math.acos(1 - (2 * (this.range.value - min)) / span);
    const begin = performance.now();
    this.timer = setInterval(() => {
      const phase = start + ((performance.now() - begin) / 6000) * 2 * Math.PI;
      this.range.value = Number(min) + (span * (1 - Math.cos(phase))) / 2;
      this.#moved();
    }, 40);
  }
}
