// Metrics that a study plots, an optimum searches, and whose spread an uncertainty job finds.

import { channelName, LEVEL_UNIT, words } from './format.js';

/** Plotted metrics: pointer, name, unit, and the function for the error of a point, if stated. */
export const METRICS = [
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

/** The metric at a pointer; undefined if a run has none. */
export const valueAt = (metrics, pointer) =>
  pointer
    .split('/')
    .slice(1)
    .reduce((value, step) => value?.[step], metrics);

/** Name and unit of a metric; one that no study plots is named by its pointer. */
export function metricName(pointer) {
  const known = METRICS.find((metric) => metric[0] === pointer);
  return known ? [known[1], known[2]] : [channelName(pointer.split('/').slice(1).map(words).join(' ')), ''];
}

/** Metrics that every scene has, so that the optimum or the spread of any of them can be found. */
export const SEARCHED = METRICS.filter(([pointer]) => !/envelope|pocket/.test(pointer));
