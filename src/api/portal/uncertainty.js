// The answer of an uncertainty job: the spread of each metric beside the errors of other kinds, its percentiles, and the ranking of the
// inputs.

import { h, s, table } from './dom.js';
import { axisName } from './fields.js';
import { measured, number, rounded, words } from './format.js';
import { messageList } from './messages.js';
import { figure } from './metrics.js';
import { metricName } from './study-metrics.js';

const VERDICTS = {
  resolved: 'spread resolved',
  spread_not_resolved: 'spread not resolved',
  numerical_unknown: 'integration error unknown',
};

const INTERVAL = '95 % interval';
const between = (from, to) => `${from} to ${to}`;

/** What is shown of an answer above its plot (`first`) and below it (`rest`). */
export function uncertainty({ metrics, inputs, messages, points, ended, failed, design, samples, seed }) {
  const all = Object.entries(metrics);
  const effects = new Set(all.flatMap(([, { errors }]) => errors.model.without_bound));
  const facts = [`${ended} of ${points} runs have ended`, failed && `${failed} have failed`, `${samples} samples`, words(design), `seed ${seed}`];
  const assumed = inputs.map(({ input, assumption, nominal }) => [
    label(input),
    h('span', { class: 'prose' }, assumption),
    typeof nominal === 'number' ? number(nominal, 5) : words(nominal),
  ]);
  return {
    first: [
      ...all.map(([pointer, of]) => spread(pointer, of, messages.filter(({ metric }) => metric === pointer))),
      all.length === 0 && h('p', {}, 'Fewer than two points have a value.'),
      ...messageList(messages.filter(({ metric }) => !metrics[metric])),
      effects.size > 0 && h('h3', {}, 'Effects that no model contains, without a bound'),
      effects.size > 0 && h('ul', { class: 'note' }, [...effects].map((effect) => h('li', {}, effect))),
    ].filter(Boolean),
    rest: [
      h('h3', {}, 'Uncertain inputs'),
      table('Uncertain inputs', ['Input', 'Distribution', 'Nominal'], assumed, { hidden: true }),
      h('p', { class: 'note' }, `${facts.filter(Boolean).join(', ')}.`),
    ],
  };
}

/** Name and unit of an input. */
const label = (input) => axisName(input).filter(Boolean).join(', ');

/** The numbers of a metric. Its errors are of different kinds, so they stand beside each other. */
function spread(pointer, of, messages) {
  const { errors, standard_deviation: deviation, energy_mean_db: power } = of;
  const [name, unit] = metricName(pointer);
  const ofError = pointer.endsWith('level_db') ? 'dB' : unit;
  const shown = (value) => rounded(value, deviation);
  const within = (error) => `± ${number(error, 2)}`;
  const percentiles = of.percentiles.map(({ percentile, value, from, to }) => [`P${percentile}`, shown(value), between(shown(from), shown(to))]);
  return h(
    'section',
    { class: 'spread' },
    h('h3', {}, name),
    h(
      'dl',
      { class: 'figures' },
      figure('Mean', shown(of.mean), unit, `${within(errors.tolerance_spread)} tolerance spread`),
      figure('Nominal', shown(of.nominal), unit),
      power !== undefined && figure('Level of the mean power', shown(power), unit),
      errors.integration === undefined
        ? figure('Integration error', 'unknown')
        : figure('Integration error', within(errors.integration), ofError, 'numerical'),
      figure('Sampling error', within(errors.sampling), ofError, 'of the mean'),
      figure('Model bound', within(errors.model.model_tolerance_db), 'dB', 'of levels'),
      figure('Verdict', VERDICTS[of.verdict] ?? words(of.verdict)),
      figure('Samples', number(of.values), '', of.without_value > 0 && `${of.without_value} without a value`),
    ),
    ...messageList(messages),
    table(`Percentiles: ${name}`, ['Percentile', unit || 'Value', INTERVAL], percentiles, { hidden: true }),
    ranking(name, of.sensitivity),
  );
}

const interval = ([from, to]) => between(measured(from, 2), measured(to, 2));

/** The inputs by their share of the variance. Shares by pairs are there only for their design. */
function ranking(name, sensitivity) {
  if (!sensitivity) return [h('p', { class: 'note' }, 'No ranking of the inputs: too few values, or all are equal.')];
  const { inputs, q2, resolved, degree } = sensitivity;
  const byShare = [...inputs].sort((a, b) => b.share - a.share);
  const hasPairs = inputs.some(({ pair_share: share }) => share !== undefined);
  const byPairs = (share, within) => (share === undefined ? ['–', '–'] : [measured(share, 2), interval(within)]);
  const rows = byShare.map((one) => [
    label(one.input),
    { 1: '+', '-1': '−' }[one.sign] ?? '–',
    h('span', { class: 'share' }, measured(one.share, 2), bar(one.share, one.share_interval)),
    interval(one.share_interval),
    ...(hasPairs ? [byPairs(one.pair_share, one.pair_share_interval), byPairs(one.total_share, one.total_share_interval)].flat() : []),
  ]);
  const heads = ['Input', 'Sign', 'Share of the variance', INTERVAL, ...(hasPairs ? ['By pairs', INTERVAL, 'Total', INTERVAL] : [])];
  const text = `Q² = ${number(q2, 2)}: share of the variance that these effects predict. ${resolved ? 'Ranking resolved' : 'Ranking not resolved'}, polynomials of degree ${degree}.`;
  return [table(`Ranking of the inputs: ${name}`, heads, rows, { hidden: true }), h('p', { class: 'note' }, text)];
}

/** A share from 0 to 1 as a bar, with a line for its interval. */
function bar(share, [from, to]) {
  const place = (value) => 100 * Math.min(Math.max(value, 0), 1);
  return s(
    'svg',
    { class: 'bar', viewBox: '0 0 100 12', preserveAspectRatio: 'none', 'aria-hidden': 'true' },
    s('rect', { width: place(share), height: 12 }),
    s('path', { d: `M${place(from)} 6H${place(to)}` }),
  );
}
