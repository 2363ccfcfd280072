// Answers that the service draws itself: plots as pictures, and the numbers of an optimum, accuracy or uncertainty job.

import * as api from './api.js';
import { h, more, table } from './dom.js';
import { axisName } from './fields.js';
import { measured, number, numerical, quantity, seconds, statisticName, words } from './format.js';
import { plotsOf } from './kinds.js';
import { figure } from './metrics.js';
import { picture } from './plots.js';
import { metricName } from './study-metrics.js';
import { uncertainty } from './uncertainty.js';

/** Plots of a job as figures. `only`: names in `links`. */
export async function pictures(job, { signal, only, theme } = {}) {
  const shown = plotsOf(job).filter(([name]) => !only || only.includes(name));
  const drawn = shown.map(async ([name, path]) => {
    try {
      const svg = await api.getText(theme ? `${path}?theme=${theme}` : path, 'image/svg+xml', { signal });
      return h('figure', {}, picture(svg, `${words(name.replace(/_svg$/, ''))} plot`));
    } catch (error) {
      if (error.name === 'AbortError') throw error;
      // Some models lack the data of some plots.
      return null;
    }
  });
  return (await Promise.all(drawn)).filter(Boolean);
}

/** What is shown of an answer above its plots (`first`) and below them (`rest`). */
export function answerView(kind, answer) {
  if (kind === 'optimum') return optimum(answer);
  if (kind === 'accuracy') return accuracy(answer);
  if (kind === 'uncertainty') return uncertainty(answer);
  return { first: [], rest: [] };
}

function optimum({ metric, goal, axes, point, value, error, statistic, nominal, within, at_end_of_range: ends, runs, failed, rivals, evaluations }) {
  const places = axes.map(({ axis }) => {
    const [name, unit] = axisName(axis);
    const range = within?.[axis];
    return figure(name, number(point[axis], 5), unit, range && `${number(range[0], 5)} to ${number(range[1], 5)} within the errors`);
  });
  const [name, unit] = metricName(metric);
  // The error of a statistic is that of the samples.
  const remark = error === undefined ? '' : statistic ? `± ${number(error, 2)}` : numerical(error, 2);
  const heads = [...axes.map(({ axis }) => axisName(axis).filter(Boolean).join(', ')), 'Value', 'Estimated error', 'Purpose'];
  const row = (run) => [
    ...axes.map(({ axis }) => number(run.point[axis], 6)),
    run.value === undefined ? (run.failure?.cause ?? '–') : number(run.value, 5),
    measured(run.error),
    run.purpose,
  ];
  return {
    first: [
      h(
        'dl',
        { class: 'figures' },
        figure(`${goal === 'minimum' ? 'Least' : 'Largest'} ${statistic ? `${statisticName(statistic)} of` : 'value:'} ${name}`, number(value, 5), unit, remark),
        statistic && nominal !== undefined && figure('With nominal inputs', number(nominal, 5), unit),
        places,
        figure('Runs', number(runs), '', failed ? `${failed} failed` : ''),
      ),
      ends.length > 0 &&
        h('p', { class: 'warning', role: 'note' }, `The range ends at the best point of ${ends.map((axis) => axisName(axis)[0]).join(' and ')}: there may be better points beyond.`),
      rivals.length > 0 && h('p', { class: 'note' }, `${rivals.length} ${statistic ? 'repeated points' : 'runs'} elsewhere may be as good.`),
    ].filter(Boolean),
    rest: [more(`Runs as a table (${evaluations.length})`, table('Runs of the search', heads, evaluations.map(row), { hidden: true }))],
  };
}

function accuracy({ points, recommended = [], machine }) {
  if (!points?.every(({ method }) => method)) return { first: [], rest: [] };
  const recommendation = ({ method, relative_tolerance: tolerance, within_db: within, wall_time_s: time }) =>
    figure(`Within ${quantity(within, 'dB')}`, words(method), '', `tolerance ${number(tolerance)}, ${seconds(time)}`);
  return {
    first: [h('dl', { class: 'figures' }, recommended.map(recommendation))],
    rest: [
      more(
        `Points as a table (${points.length})`,
        table(
          'Error and run time of each method',
          ['Method', 'Tolerance', 'Level error, dB', 'Trajectory error', 'Steps', 'Run time'],
          points.map((one) => [
            words(one.method),
            number(one.relative_tolerance),
            measured(one.level_error_db),
            measured(one.trajectory_error),
            number(one.steps, 9),
            seconds(one.wall_time_s),
          ]),
          { hidden: true },
        ),
      ),
      machine ? h('p', { class: 'note' }, `${machine.processor}, ${machine.cores} cores, version ${machine.version}.`) : '',
    ],
  };
}
