// The metrics of a run as key values and tables, and the quantities that plots derive from them.

import { leftOut } from './derived.js';
import { h, more, table } from './dom.js';
import { channelName, LEVEL_UNIT, level, measured, number, numerical, words } from './format.js';
import { isWarning, messageList } from './messages.js';

const MOTIONS = { decaying: 'regular motion', diverging: 'chaotic motion' };

/** Lines of the amplitude or the envelope spectra. */
export const linesOf = (metrics, kind) => (kind === 'envelope' ? metrics.envelope_lines : metrics.lines) ?? [];

/** Upper frequency limit of a spectrum plot: above the strong lines, rounded up [Hz]. */
export function usualLimit(metrics, kind = 'amplitude') {
  const lines = linesOf(metrics, kind);
  // Only amplitudes of the same unit can be compared.
  const motion = (line) => line.channel.split('.').at(-1);
  const strongest = (line) => Math.max(...lines.filter((other) => motion(other) === motion(line)).map((other) => other.amplitude));
  const last = Math.max(
    ...lines.filter((line) => line.amplitude > strongest(line) * 0.01).map((line) => line.frequency_hz),
    10 * metrics.frequencies_hz.ball_pass_outer,
  );
  const step = 10 ** Math.floor(Math.log10(last));
  return Math.min(Math.ceil((last * 1.1) / (step / 2)) * (step / 2), 20000);
}

/** A key value with its unit, and with a small remark. */
export const figure = (name, value, unit, extra) =>
  h('div', {}, h('dt', {}, name), h('dd', {}, h('b', {}, value), unit && ` ${unit}`, extra && h('small', {}, extra)));

/** Key values of the headline of a result, in the units of the trade. */
export function headlineFigures({ headline }) {
  if (!headline) return [];
  const { channel, rms_m_s2: rms, rms_g: g, peak_m_s2: peak, velocity_10_1000_hz_mm_s: velocity, levels } = headline;
  const iso = levels.find(({ quantity, standard }) => quantity === 'acceleration' && standard === 'iso1683');
  const at = channelName(channel);
  return [
    figure(`${at}, rms`, measured(rms), 'm/s²', `${measured(g)} g, peak ${measured(peak)} m/s²${iso ? `, ${level(iso.db)} dB re 1 µm/s²` : ''}`),
    velocity !== undefined && figure('Velocity, 10 to 1000 Hz', measured(velocity), 'mm/s', `rms at ${at}`),
  ].filter(Boolean);
}

/** Levels and other key values of a run, then its warnings. */
export function summary(metrics) {
  const { channels = {}, contacts, kinematics, accuracy, messages = [] } = metrics;
  const of = (axis) => channels[`spindle.${axis}.acceleration`]?.level_db;
  const within = (axis) => {
    const { level_error_db: own, level_scatter_db: scatter } = channels[`spindle.${axis}.acceleration`] ?? {};
    const error = own ?? accuracy.level_error_db;
    const known = typeof error === 'number' && numerical(error);
    // Shown if it exceeds the error and matters for a level with one decimal.
    const later = scatter > Math.max(error ?? 0, 0.05) && `over another time window ± ${number(scatter, 1)}`;
    return [known, later].filter(Boolean).join(', ');
  };
  return [
    h(
      'dl',
      { class: 'figures' },
      [
        ...['x', 'y', 'z'].map((axis) => of(axis) !== undefined && figure(`Level ${axis}`, level(of(axis)), LEVEL_UNIT, within(axis))),
        ...headlineFigures(metrics),
        contacts?.inner &&
          figure('Largest ball load', number(Math.max(contacts.inner.max_load_n, contacts.outer.max_load_n)), 'N'),
        contacts?.inner &&
          figure('Largest pressure', number(Math.max(contacts.inner.max_pressure_mpa, contacts.outer.max_pressure_mpa)), 'MPa'),
        kinematics?.cage_slip !== undefined && figure('Cage slip', number(kinematics.cage_slip * 100, 2), '%'),
      ].filter(Boolean),
    ),
    ...messageList(messages.filter(isWarning)),
  ];
}

/** Messages that are no warnings. */
export const notes = ({ messages = [] }) => messageList(messages.filter((message) => !isWarning(message)));

/** Velocity of the accelerations in the bands of bearing vibration; nothing without spectra. */
function bandTable(channels) {
  const rows = Object.entries(channels).filter(([, { bands }]) => bands?.length);
  if (rows.length === 0) return [];
  const edges = rows[0][1].bands.map(({ from_hz: from, to_hz: to }) => `${from}–${to} Hz`);
  return [
    h('h3', {}, 'Velocity by band, rms in µm/s'),
    table(
      'Bands',
      ['Channel', ...edges],
      rows.map(([name, { bands }]) => [channelName(name), ...bands.map((band) => measured(band.velocity_rms_um_s))]),
      { hidden: true },
    ),
  ];
}

/** All other metrics. */
export function tables(metrics) {
  const { channels = {}, contacts = {}, kinematics, cage, life, friction, frequencies_hz: f, solver, accuracy } = metrics;
  const rest = [
    ...['inner', 'outer'].flatMap((side) =>
      contacts[side]
        ? [
            [`Largest load, ${side}`, contacts[side].max_load_n, 'N'],
            [`Largest pressure, ${side}`, contacts[side].max_pressure_mpa, 'MPa'],
            [`Largest slip, ${side}`, contacts[side].max_slip_m_s, 'm/s'],
            [`Smallest film thickness, ${side}`, contacts[side].min_film_thickness_um, 'µm'],
            contacts[side].mean_off_share !== undefined && [`Off the raceway, ${side}`, contacts[side].mean_off_share * 100, '%'],
          ]
        : [],
    ),
    contacts.pocket && ['Largest load, pocket', contacts.pocket.max_load_n, 'N'],
    kinematics && ['Cage speed', kinematics.cage_speed_hz, 'Hz'],
    kinematics?.cage_slip_free_angle !== undefined && ['Cage slip, free contact angle', kinematics.cage_slip_free_angle * 100, '%'],
    kinematics && ['Ball spin', kinematics.ball_spin_hz, 'Hz'],
    cage && ['Cage orbit radius, rms', cage.orbit_radius_um, 'µm'],
    cage && ['Whirl ratio', cage.whirl_ratio, ''],
    life && ['Basic life L₁₀ₕ', life.basic_l10h, 'h'],
    life && ['Reference life at rest, ISO/TS 16281', life.reference_l10h_static, 'h'],
    life && ['Reference life by the motion', life.reference_l10h_dynamic, 'h'],
    life && ['Life factor a_ISO', life.a_iso, ''],
    friction && ['Friction torque', friction.total_n_mm, 'N mm'],
    friction && ['Friction power', friction.power_loss_w, 'W'],
    ['Shaft', f.shaft, 'Hz'],
    ['Cage (FTF)', f.cage, 'Hz'],
    ['BPFO', f.ball_pass_outer, 'Hz'],
    ['BPFI', f.ball_pass_inner, 'Hz'],
    ['BSF (ball spin)', f.ball_spin, 'Hz'],
    ['2×BSF (ball defect)', 2 * f.ball_spin, 'Hz'],
    ['Model', words(solver.rung)],
    ['Method', words(solver.method)],
    ['Steps', solver.steps, ''],
    ['Strips per contact', solver.strips, ''],
    ['Simulated', solver.simulated_time_s, 's'],
    ['Wall time', solver.wall_time_s, 's'],
    ['Real-time factor', solver.real_time_factor, ''],
  ].filter((row) => row && row[1] !== undefined);
  return [
    h(
      'section',
      { class: 'tables' },
      h('h3', {}, 'Vibration, 0 to 20 kHz'),
      table(
        'Channels',
        ['Channel', 'Unit', 'rms', 'Peak', 'Crest', 'Kurtosis', `Level, ${LEVEL_UNIT}`, '± over time, dB', 'Above 20 kHz'],
        Object.entries(channels).map(([name, c]) => [
          channelName(name),
          c.unit,
          measured(c.rms),
          measured(c.peak),
          measured(c.crest_factor),
          measured(c.kurtosis),
          level(c.level_db),
          measured(c.level_scatter_db),
          measured(c.above_band),
        ]),
        { hidden: true },
      ),
      ...bandTable(channels),
      h('h3', {}, 'Contacts, speeds, run'),
      h(
        'dl',
        { class: 'pairs columns' },
        rest.map(([name, value, unit]) =>
          h(
            'div',
            {},
            h('dt', {}, name),
            h(
              'dd',
              {},
              typeof value === 'string' ? value : `${Number.isInteger(value) ? number(value, 9) : measured(value, 4)} ${unit}`,
            ),
          ),
        ),
      ),
    ),
    more(`Accuracy: ${MOTIONS[accuracy.motion] ?? 'motion not classified'}`, h('p', {}, accuracy.how), h('p', {}, solver.check)),
    more(`Omitted terms: ${metrics.left_out.length}`, leftOut(metrics.left_out)),
  ];
}
