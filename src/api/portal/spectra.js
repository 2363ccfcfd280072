// The spectrum of a channel and that of its envelope, with labelled lines, tables and downloads.

import * as api from './api.js';
import { h, labelled, lineName, more, select, table, tools } from './dom.js';
import { keep } from './download.js';
import { recordedSpectrum } from './example.js';
import { channelName, number, quantity } from './format.js';
import { linesOf, usualLimit } from './metrics.js';
import { SpectrumPlot } from './plots.js';

export class Spectra {
  /** `redraw()` draws again after a choice. */
  constructor(redraw) {
    this.redraw = redraw;
    this.channel = 'spindle.y.acceleration';
    // One plot for all runs, because a plot has listeners on the page.
    this.plots = ['amplitude', 'envelope'].map((kind) => {
      const [host, caption] = [h('div', {}), h('figcaption', {})];
      return { kind, host, caption, plot: new SpectrumPlot(host), figure: h('figure', {}, host, caption) };
    });
  }

  /** A new run. Faults are found by the envelope: it stands beside the spectrum. */
  begin(channels, hasFaults) {
    if (!channels.includes(this.channel)) [this.channel] = channels;
    this.kind = this.chosenKind ?? (hasFaults ? 'both' : 'amplitude');
  }

  /** Draws into `stage`; returns the files to download, the request of the first of them, and the tables of lines. */
  async draw(stage, { job: { id, spectra }, metrics, channels }, signal) {
    this.metrics = metrics;
    const shown = this.plots.filter(({ kind }) => this.kind === 'both' || this.kind === kind);
    const limitOf = (kind) => this.chosenLimit ?? usualLimit(metrics, kind);
    const channel = select(
      channels.map((name) => [name, channelName(name)]),
      (value) => {
        this.channel = value;
        this.redraw();
      },
    );
    channel.value = this.channel;
    const limit = h('input', {
      type: 'number',
      min: 0.1,
      max: 20,
      step: 'any',
      class: 'short',
      value: limitOf(shown[0].kind) / 1000,
      onchange: () => {
        this.chosenLimit = Math.min(Math.max(limit.valueAsNumber || 5, 0.1), 50) * 1000;
        this.redraw();
      },
    });
    const kind = select(
      [
        ['amplitude', 'signal'],
        ['envelope', 'envelope'],
        ['both', 'signal and envelope'],
      ],
      (value) => {
        this.chosenKind = value;
        this.kind = value;
        this.redraw();
      },
    );
    kind.value = this.kind;
    const path = (kind, limit) => api.spectrumPath(id, this.channel, limit, kind);
    // A recorded run brings its spectra along.
    const found = await Promise.all(
      shown.map(({ kind }) =>
        spectra
          ? recordedSpectrum(spectra, this.channel, kind, limitOf(kind))
          : api.get(path(kind, limitOf(kind)), { signal }),
      ),
    );
    stage.replaceChildren(
      tools(labelled('Channel', channel), labelled('Spectrum of the', kind), labelled('Up to', limit, ' kHz')),
      h(
        'div',
        { class: shown.length > 1 ? 'pair' : undefined },
        shown.map(({ figure }) => figure),
      ),
    );
    const files = shown.flatMap(({ kind }) => {
      const [name, file] = kind === 'envelope' ? ['Envelope', 'envelope'] : ['Spectrum', 'spectrum'];
      return [
        [`${name} CSV`, () => keep(`${file}-${id}.csv`, path(kind), 'text/csv')],
        [`${name} JSON`, () => keep(`${file}-${id}.json`, path(kind), 'application/json')],
        [`${name} SVG`, () => keep(`${file}-${id}.svg`, `/v1/jobs/${id}/plots/${file}.svg`, 'image/svg+xml')],
      ];
    });
    return {
      files,
      request: { path: path(shown[0].kind, limitOf(shown[0].kind)), accept: 'text/csv' },
      tables: shown.map((one, i) => this.#spectrum(one, found[i], limitOf(one.kind))),
    };
  }

  /** Draws one spectrum and returns the table of its lines. */
  #spectrum({ kind, plot, caption }, spectrum, limit) {
    const lines = linesOf(this.metrics, kind).filter((line) => line.channel === this.channel);
    plot.draw({ spectra: [{ name: this.channel, ...spectrum }], lines, unit: spectrum.unit, limit });
    const strongest = lines[0];
    const name = kind === 'envelope' ? 'Envelope' : 'Amplitude';
    const text =
      `${name} spectrum of ${channelName(this.channel)} up to ${quantity(limit / 1000, 'kHz')}, resolution ${quantity(spectrum.resolution_hz, 'Hz', 3)}.` +
      (strongest
        ? ` Strongest line: ${strongest.label || 'unnamed'} at ${quantity(strongest.frequency_hz, 'Hz')}, ${quantity(strongest.amplitude, spectrum.unit, 3)}.`
        : '');
    plot.describe(text);
    caption.textContent = `${text} Drag to zoom.`;
    const rows = lines.map((line) => [
      line.label ? lineName(line.label) : '–',
      number(line.frequency_hz, 5),
      number(line.amplitude, 3),
      number(line.deviation_hz, 2),
    ]);
    return more(
      kind === 'envelope' ? `Lines of the envelope as a table (${lines.length})` : `Lines as a table (${lines.length})`,
      table(
        `Lines of the ${kind} spectrum of ${channelName(this.channel)}`,
        ['Line', 'Frequency, Hz', `Amplitude, ${spectrum.unit}`, 'Deviation, Hz'],
        rows,
        { hidden: true },
      ),
    );
  }
}
