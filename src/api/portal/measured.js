// A measured file beside a finished run. The browser reads the file and computes its spectrum; nothing is sent.

import * as api from './api.js';
import { h, labelled, lineName, select, table, tools } from './dom.js';
import { channelName, number, plainNumber, quantity } from './format.js';
import { readMeasured } from './measured-files.js';
import { byAngle, comparedLevels, comparedLines, linesOf, peaksOf, pulsesOf, requireVibration, spectrumOf } from './measured-spectrum.js';
import { usualLimit } from './metrics.js';
import { SpectrumPlot } from './plots.js';

/** Motion and size of each unit in the unit of channels: m/s², mm/s or µm. */
const UNITS = {
  'm/s2': ['acceleration', 1, 'm/s²'],
  g: ['acceleration', 9.80665, 'g'],
  'm/s': ['velocity', 1000, 'm/s'],
  'mm/s': ['velocity', 1, 'mm/s'],
  'um/s': ['velocity', 0.001, 'µm/s'],
  mm: ['displacement', 1000, 'mm'],
  um: ['displacement', 1, 'µm'],
};
/** Bands of ISO 15242-1 [Hz]. */
const BANDS = [
  [50, 300],
  [300, 1800],
  [1800, 10000],
];
/** Highest frequency of levels and lines [Hz]. */
const BAND = 20000;
const TRANSFER =
  'The ratio is an apparent transfer: the path from the bearing to the sensor is unknown, so it is no error of the prediction. Equal orders prove the geometry only. Ratios between lines of one narrow band test the physics.';

const motionOf = (channel) => channel.split('.').at(-1);
const decibels = (value) => (typeof value === 'number' ? `${value < 0 ? '−' : '+'}${Math.abs(value).toFixed(1)}` : '–');

export class MeasuredPanel {
  constructor() {
    this.file = h('input', { type: 'file', accept: '.csv,.txt,.tsv,.npy,.wav,.uff,.unv', onchange: () => this.#open(this.file.files[0]) });
    this.remark = h('p', { class: 'note', role: 'status' });
    this.settings = h('div', {});
    this.tables = h('div', {});
    this.plotHost = h('div', {});
    this.caption = h('figcaption', {});
    this.figure = h('figure', { hidden: true }, this.plotHost, this.caption);
    this.element = h(
      'details',
      {
        class: 'measured',
        ondragover: (event) => event.preventDefault(),
        ondrop: (event) => {
          event.preventDefault();
          this.element.open = true;
          this.#open(event.dataTransfer.files[0]);
        },
      },
      h('summary', {}, 'Compare with a measurement'),
      h('p', { class: 'note' }, 'Drop a file here: CSV, NPY, WAV or UFF 58, at most 64 MB. It is read in this browser and never sent.'),
      tools(labelled('Measured file', this.file)),
      this.settings,
      this.remark,
      this.figure,
      this.tables,
    );
  }

  /** A finished run: its lines, and the speed of its shaft [Hz]. The file stays, so that it can stand beside several runs. */
  show({ job, lines, speed_hz: speed, channels }) {
    const profile = job.request.scene?.operation?.speed_rpm;
    const varies = Array.isArray(profile) && profile.some(({ rpm }) => rpm !== profile[0].rpm);
    this.element.hidden = varies || !(speed > 0) || channels.length === 0;
    Object.assign(this, { job, lines, speed, channels });
    if (this.read && !this.element.hidden) this.#ask();
  }

  async #open(file) {
    if (!file) return;
    // The fields of another file would compare that one.
    this.read = undefined;
    this.settings.replaceChildren();
    try {
      this.remark.className = 'note';
      this.remark.textContent = `Reading ${file.name} …`;
      this.read = { name: file.name, ...readMeasured(await file.arrayBuffer()) };
      this.#ask();
    } catch (error) {
      this.#refuse(error);
    }
  }

  #refuse(error) {
    this.remark.className = 'error';
    this.remark.textContent = error.message;
    this.figure.hidden = true;
    this.tables.replaceChildren();
  }

  /** Fields for what the file does not say. */
  #ask() {
    const { columns, rate_hz: rate, unit, hasFullScale } = this.read;
    const change = () => this.#compare();
    const field = (value) => h('input', { type: 'text', inputmode: 'decimal', class: 'short', value, onchange: change });
    const names = columns.map(({ name }, k) => [k, name]);
    const kept = this.fields ?? {};
    this.fields = {
      column: select(names, change),
      unit: select(Object.entries(UNITS).map(([name, [, , shown]]) => [name, shown]), change),
      channel: select(this.channels.map((name) => [name, channelName(name)]), change),
      rate: field(rate ? String(Number(rate.toPrecision(9))) : (kept.rate?.value ?? '')),
      speed: field(kept.speed?.value ?? String(Number((60 * this.speed).toPrecision(6)))),
      fullScale: field(kept.fullScale?.value ?? '1'),
      gain: field(kept.gain?.value ?? '1'),
      tachometer: select([['', 'none'], ...names], () => {
        this.#pulses();
        this.#compare();
      }),
      perTurn: field(kept.perTurn?.value ?? '1'),
    };
    const { fields } = this;
    fields.unit.value = unit ?? kept.unit?.value ?? 'm/s2';
    if (this.channels.includes(kept.channel?.value)) fields.channel.value = kept.channel.value;
    this.ofPulses = labelled('Pulses in a turn', fields.perTurn);
    this.settings.replaceChildren(
      tools(
        columns.length > 1 && labelled('Signal', fields.column),
        labelled('Unit', fields.unit),
        hasFullScale && labelled('Full scale', fields.fullScale),
        labelled('Rate', fields.rate, ' Hz'),
        labelled('Shaft speed', fields.speed, ' r/min'),
        columns.length > 1 && labelled('Tachometer', fields.tachometer),
        this.ofPulses,
        labelled('Gain', fields.gain),
        labelled('Predicted channel', fields.channel),
      ),
    );
    this.#pulses();
    this.#compare();
  }

  #pulses() {
    const has = this.fields.tachometer.value !== '';
    this.ofPulses.hidden = !has;
    this.fields.speed.disabled = has;
  }

  #positive(name, what) {
    const value = Number(plainNumber(this.fields[name].value));
    if (!(value > 0) || !Number.isFinite(value)) throw new Error(`${what} must be above 0.`);
    return value;
  }

  async #compare() {
    this.comparing?.abort();
    this.comparing = new AbortController();
    const { signal } = this.comparing;
    try {
      const rate = this.#positive('rate', 'Rate');
      const gain = this.#positive('gain', 'Gain');
      const [motion, size] = UNITS[this.fields.unit.value];
      const channel = this.fields.channel.value;
      if (motion !== motionOf(channel)) throw new Error(`The unit is that of a ${motion}. Choose a predicted ${motion}, or another unit.`);
      const factor = gain * size * (this.read.hasFullScale ? this.#positive('fullScale', 'Full scale') : 1);
      const column = this.read.columns[Number(this.fields.column.value)];
      requireVibration(column);
      let { values } = column;
      let speed = 0;
      if (this.fields.tachometer.value === '') speed = this.#positive('speed', 'Shaft speed') / 60;
      else {
        const pulses = pulsesOf(this.read.columns[Number(this.fields.tachometer.value)].values, rate);
        ({ values, speed_hz: speed } = byAngle(values, rate, pulses, this.#positive('perTurn', 'Pulses in a turn')));
      }
      const predicted = await api.get(api.spectrumPath(this.job.id, channel), { signal });
      if (signal.aborted) return;
      const measured = spectrumOf(values, rate, predicted.resolution_hz, predicted.averages);
      measured.amplitude = measured.amplitude.map((amplitude) => factor * amplitude);
      this.#draw({ channel, predicted, measured, speed, gain });
    } catch (error) {
      if (!signal.aborted) this.#refuse(error);
    }
  }

  #draw({ channel, predicted, measured, speed, gain }) {
    const to = Math.min(measured.highest_hz, BAND, predicted.frequency_hz.at(-1));
    const from = 2 * predicted.resolution_hz;
    const own = this.lines.filter((line) => line.channel === channel && line.frequency_hz >= from && line.frequency_hz <= to);
    const { lines, others } = comparedLines(own, linesOf(measured, to), [this.speed, speed], predicted.resolution_hz, peaksOf(predicted, to));
    const isAcceleration = motionOf(channel) === 'acceleration';
    const levels = comparedLevels(measured, predicted, BANDS, { isAcceleration, unit: predicted.unit, from, to });
    this.figure.hidden = false;
    this.plot ??= new SpectrumPlot(this.plotHost);
    const limit = Math.min(usualLimit({ lines: this.lines, frequencies_hz: { ball_pass_outer: this.#passage() } }, 'amplitude'), to);
    const within = measured.frequency_hz.filter((f) => f <= limit).length;
    const cut = { ...measured, frequency_hz: measured.frequency_hz.slice(0, within), amplitude: measured.amplitude.slice(0, within) };
    this.plot.draw({ spectra: [{ name: 'predicted', ...predicted }, { name: 'measured', ...cut }], lines: own, unit: predicted.unit, limit });
    const text = `Predicted and measured spectrum of ${channelName(channel)}, both with a Hann window and a resolution of ${quantity(predicted.resolution_hz, 'Hz', 3)}; ${measured.averages} of ${predicted.averages} windows measured. Compared from ${quantity(from, 'Hz', 3)} to ${quantity(to / 1000, 'kHz', 3)}. The first colour is the prediction, whose lines are named.`;
    this.plot.describe(text);
    this.caption.textContent = text;
    this.remark.className = 'note';
    this.remark.textContent = [
      `${this.read.name} (${this.read.format}), shaft at ${quantity(60 * speed, 'r/min', 6)}.`,
      gain !== 1 && `Gain ${decibels(20 * Math.log10(gain))} dB.`,
      TRANSFER,
      'Envelopes are compared by the API.',
    ]
      .filter(Boolean)
      .join(' ');
    const hertz = (value) => number(value, 5);
    this.tables.replaceChildren(
      table(
        'Measured and predicted levels, rms',
        ['Band, Hz', 'Unit', 'Measured', 'Predicted', 'Ratio, dB'],
        levels.map((row) => [
          `${hertz(row.from_hz)} to ${hertz(row.to_hz)}`,
          row.unit,
          number(row.measured, 4),
          number(row.predicted, 4),
          decibels(row.level_ratio_db),
        ]),
      ),
      table(
        'Measured and predicted lines by order',
        ['Line', 'Predicted order', 'Measured order', 'Difference, %', `Predicted, ${predicted.unit}`, `Measured, ${predicted.unit}`, 'Ratio, dB', 'Over floor'],
        lines.map((line) => [
          line.label ? lineName(line.label) : '–',
          number(line.predicted_order, 5),
          line.measured_order === undefined ? 'not found' : number(line.measured_order, 5),
          number(line.order_difference_percent, 2),
          number(line.predicted_amplitude, 3),
          number(line.measured_amplitude, 3),
          decibels(line.level_ratio_db),
          number(line.over_floor_db, 3),
        ]),
      ),
      ...(others.length > 0
        ? [
            h(
              'p',
              { class: 'note' },
              `Strongest measured lines that were not predicted, by order: ${others
                .slice(0, 10)
                .map((line) => `${number(line.order, 5)} (${quantity(line.frequency_hz, 'Hz', 5)}, ${quantity(line.amplitude, predicted.unit, 3)})`)
                .join(', ')}.`,
            ),
          ]
        : []),
    );
  }

  /** Highest ball passage of the run, for the shown range. */
  #passage() {
    return Math.max(0, ...this.lines.filter(({ label }) => /^BPF[OI](@|$)/.test(label)).map((line) => line.frequency_hz));
  }
}
