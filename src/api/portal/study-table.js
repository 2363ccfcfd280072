// The answer of a study: the trend over one parameter, or the map over two, and the table of its points.

import * as api from './api.js';
import { h, labelled, more, select, small, table, tools } from './dom.js';
import { command, curl, keep } from './download.js';
import { axisName } from './fields.js';
import { number, quantity, statisticName, words } from './format.js';
import { HeatMap } from './map.js';
import { CurvePlot } from './plots.js';
import { METRICS, valueAt } from './study-metrics.js';

/** A value on an axis, with its unit if it is a number. */
const placed = (value, unit) => (typeof value === 'number' ? quantity(value, unit) : words(value));

export class StudyTable {
  constructor({ say }) {
    this.say = say;
    this.plotHost = h('div', {});
    this.plot = new CurvePlot(this.plotHost);
    this.map = new HeatMap();
  }

  /** The elements that show a study's answer. They are in the page when `draw` is called. */
  elements(job, answer) {
    Object.assign(this, { job, answer });
    const isThere = ([pointer]) => answer.rows.some((row) => typeof valueAt(row.metrics, pointer) === 'number');
    this.metrics = METRICS.filter(isThere);
    this.chooser = select(this.metrics.map(([pointer, name]) => [pointer, name]), () => this.draw());
    this.caption = h('figcaption', {});
    this.rows = h('div', {});
    const graph = { 1: this.plotHost, 2: this.map.element }[answer.axes.length] ?? h('p', { class: 'note' }, 'More than two parameters: the best point, and the table.');
    const path = job.links.table;
    const file = (text, name, type, at = path) => small(text, () => keep(name, at, type).catch((error) => this.say(error.message)));
    const { trend_svg: trend, map_svg: map } = job.links;
    return [
      h('figure', {}, tools(labelled('Metric', this.chooser)), graph, this.caption),
      this.rows,
      tools(
        h('span', { class: 'note' }, 'Download'),
        file('Table CSV', `study-${job.id}.csv`, 'text/csv'),
        file('Table JSON', `study-${job.id}.json`, 'application/json'),
        trend && file('Trends SVG', `trend-${job.id}.svg`, 'image/svg+xml', trend),
        map && file('Map SVG', `map-${job.id}.svg`, 'image/svg+xml', map),
      ),
      more(
        'curl commands',
        command(curl({ method: 'POST', path: '/v1/jobs', body: job.request, token: api.hasToken() })),
        command(curl({ path, accept: 'text/csv', token: api.hasToken() })),
      ),
    ];
  }

  /** Draws the chosen metric. */
  draw() {
    const { answer, metrics } = this;
    if (metrics.length === 0) {
      this.caption.textContent = answer.rows.find((row) => row.error)?.error.detail ?? 'No point has a result.';
      return;
    }
    const [pointer, name, unit, errorOf] = metrics.find((metric) => metric[0] === this.chooser.value);
    const axes = answer.axes.map(({ axis, values }) => {
      const [label, axisUnit] = axisName(axis);
      return { axis, values, unit: axisUnit, label: [label, axisUnit].filter(Boolean).join(', ') };
    });
    const values = answer.rows.map((row) => valueAt(row.metrics, pointer) ?? null);
    const errors = answer.rows.map((row, i) => (values[i] === null ? null : (errorOfRow(row, pointer, errorOf, values[i]) ?? null)));
    const yLabel = [name, unit].filter(Boolean).join(', ');
    const best = answer.best[pointer];
    const text = this.#text({ axes, yLabel, unit, best, trend: answer.trends[pointer] });
    if (axes.length === 1) {
      const [{ axis, label }] = axes;
      const isLog = this.job.request.axes[0].scale === 'log';
      this.plot.draw({ x: answer.rows.map((row) => row.point[axis]), y: values, errors, xLabel: label, yLabel, logX: isLog });
      this.plot.describe(text);
    } else if (axes.length === 2) {
      const [x, y] = axes;
      const at = best && [x, y].map(({ axis, values: along }) => along.indexOf(best.point[axis]));
      this.map.draw({ x, y, unit, text, best: at, value: (column, row) => values[column * y.values.length + row] });
    }
    const hasBars = axes.length === 1 && errors.some(Boolean);
    this.caption.textContent = `${text}${hasBars ? (answer.statistic ? ' Bars: interval of 95 %, by the longer side.' : ' Bars: estimated error.') : ''}${axes.length === 2 && best ? ' Ring: the best point.' : ''}`;
    const row = (one, i) => [
      ...axes.map(({ axis }) => (typeof one.point[axis] === 'number' ? number(one.point[axis], 5) : words(one.point[axis]))),
      values[i] === null ? (one.error?.cause ?? one.status) : number(values[i]),
      number(errors[i], 2),
      words(one.metrics?.solver?.rung ?? ''),
    ];
    const heads = [...axes.map(({ label }) => label), yLabel, answer.statistic ? 'Half interval' : 'Estimated error', 'Model'];
    this.rows.replaceChildren(more('Points as a table', table(`${name} of each point`, heads, answer.rows.map(row), { hidden: true })));
  }

  #text({ axes, yLabel, unit, best, trend }) {
    const { answer } = this;
    const failed = answer.points - answer.succeeded;
    const error = () => (best.error === undefined ? '' : ` ± ${number(best.error, 2)}`);
    const isAtEnd = ({ axis, values }) => values.length > 2 && [values[0], values.at(-1)].includes(best.point[axis]);
    const ends = best ? axes.filter((axis) => typeof axis.values[0] === 'number' && isAtEnd(axis)).map(({ label }) => label) : [];
    const place = () => axes.map(({ axis, unit: axisUnit }) => placed(best.point[axis], axisUnit)).join(' and ');
    return [
      `${yLabel} over ${axes.map(({ label }) => label).join(' and ')}, ${answer.succeeded} of ${answer.points} points.`,
      answer.statistic && `Each is the ${statisticName(answer.statistic)} over the samples of the uncertain inputs.`,
      best &&
        `Best (${best.goal.replace('_', ' ')}): ${quantity(best.value, unit)}${error()} at ${place()}${best.as_good > 1 ? `, with ${best.as_good - 1} as good within their errors` : ''}.`,
      ends.length > 0 && `It lies at an end of the values of ${ends.join(' and ')}: a better point may lie beyond.`,
      trend?.resolved === false && 'The trend is not resolved: the errors exceed a tenth of its span.',
      failed > 0 && `${failed} without a result: ${answer.rows.find((row) => row.error)?.error.detail ?? 'not run'}.`,
    ]
      .filter(Boolean)
      .join(' ');
  }
}

/** Estimated error of a metric: of the integration, or over samples half of the statistic's interval. */
function errorOfRow({ metrics, samples }, pointer, errorOf, value) {
  return samples ? valueAt(samples.half_intervals, pointer) : errorOf?.(metrics, Math.abs(value));
}
