// Derived quantities of a scene: a drawing to scale, stiffness, rating, frequencies, static loads, omitted terms, and the cost of a run.

import { h, s, table } from './dom.js';
import { number, quantity, seconds, words } from './format.js';
import { messageList } from './messages.js';

export function showDerived(host, resolved) {
  const { derived, scene } = resolved;
  const f = derived.frequencies_hz;
  const loaded = derived.frequencies_loaded_hz;
  const rest = derived.static;
  const rows = (pairs) =>
    h(
      'dl',
      { class: 'pairs' },
      pairs
        .filter(Boolean)
        .map(([name, value, unit, digits]) => h('div', {}, h('dt', {}, name), h('dd', {}, quantity(value, unit, digits)))),
    );
  const opened = host.querySelector('details')?.open;
  host.replaceChildren(
    h('h2', {}, 'Quantities of the scene in the form'),
    h(
      'div',
      { class: 'derived' },
      drawing(scene.bearing, rest?.ball_loads_n),
      h(
        'div',
        {},
        h('h3', {}, 'Frequencies'),
        rows([
          ['Shaft', f.shaft, 'Hz'],
          ['Cage (FTF)', f.cage, 'Hz'],
          ['BPFO', f.ball_pass_outer, 'Hz'],
          ['BPFI', f.ball_pass_inner, 'Hz'],
          ['BSF (ball spin)', f.ball_spin, 'Hz'],
          ['2×BSF (ball defect)', 2 * f.ball_spin, 'Hz'],
          loaded && ['Cage, loaded contact angle', loaded.cage, 'Hz'],
          loaded && ['BPFO, loaded contact angle', loaded.ball_pass_outer, 'Hz'],
          ...(derived.resonances ?? []).map((one) => [`Resonance on the contacts, ${mainAxis(one.direction)}`, one.frequency_hz, 'Hz']),
        ]),
      ),
      h(
        'div',
        {},
        h('h3', {}, 'Static equilibrium'),
        rest
          ? rows([
              ['Largest ball load', rest.max_ball_load_n, 'N'],
              ['Largest pressure', rest.max_pressure_mpa, 'MPa'],
              ['Radial displacement', rest.radial_displacement_um, 'µm'],
              scene.operation.axial_load_n ? ['Axial displacement', rest.axial_displacement_um, 'µm'] : null,
            ])
          : h('p', { class: 'note' }, 'No static equilibrium under these loads.'),
      ),
      h(
        'div',
        {},
        h('h3', {}, 'Bearing'),
        rows([
          ['Stiffness, inner', derived.inner_stiffness_n_per_m1_5 / 1e9, 'GN/m¹·⁵', 3],
          ['Stiffness, outer', derived.outer_stiffness_n_per_m1_5 / 1e9, 'GN/m¹·⁵', 3],
          ['Rating, dynamic', derived.dynamic_load_rating_n / 1000, 'kN'],
          ['Free contact angle', derived.free_contact_angle_deg, '°'],
          ['Clearance', derived.radial_clearance_um, 'µm'],
        ]),
        ...orderedParts(derived, rows),
        ...lifeParts(derived, rows),
      ),
    ),
    ...messageList(resolved.messages),
    ...unitWarnings(resolved.warnings),
    h(
      'details',
      { open: opened },
      h('summary', {}, `Omitted terms: ${resolved.left_out.length}`),
      leftOut(resolved.left_out),
    ),
  );
}

/** How clearance and viscosity follow from group, fits, temperatures and grade, and where the balls are from. */
function orderedParts({ clearance, oil, designation }, rows) {
  const part = (title, ...content) => h('div', {}, h('h3', {}, title), ...content);
  const fit = (name, seat) => (seat ? `${name}, ${seat.class}: ${quantity(seat.interference_um, 'µm')}` : name);
  return [
    clearance &&
      part(
        `Clearance, group ${clearance.group}`,
        rows([
          ['Unmounted', clearance.unmounted_um, 'µm'],
          [fit('Shaft fit', clearance.shaft), -clearance.shaft_fit_um, 'µm'],
          [fit('Housing fit', clearance.housing), -clearance.housing_fit_um, 'µm'],
          ['Temperature', -clearance.temperature_um, 'µm'],
          ['In operation', clearance.operating_um, 'µm'],
        ]),
        (clearance.shaft ?? clearance.housing) && h('p', { class: 'note' }, `Fits: ${(clearance.shaft ?? clearance.housing).assumption}.`),
      ),
    oil &&
      part(
        oil.grade ? words(oil.grade.toUpperCase()) : 'Oil',
        rows([
          ['Temperature', oil.temperature_c, '°C'],
          ['Kinematic viscosity', oil.kinematic_viscosity_mm2_s, 'mm²/s'],
          ['Density', oil.density_kg_m3, 'kg/m³'],
        ]),
      ),
    designation &&
      part(
        `Catalogue, ${designation.designation}`,
        h('p', { class: 'note' }, `Balls: ${designation.source}. Confidence: ${designation.confidence}.`),
        designation.note && h('p', { class: 'note' }, `${designation.note}.`),
      ),
  ].filter(Boolean);
}

/** Rating life under the loads at rest, and friction moments of empirical models. */
function lifeParts({ life, friction_reference: friction }, rows) {
  const part = (title, pairs) => h('div', {}, h('h3', {}, title), rows(pairs.filter(([, value]) => value !== undefined)));
  return [
    life?.basic_l10h !== undefined &&
      part('Rating life at rest', [
        ['Equivalent load P', life.equivalent_load_n, 'N'],
        ['Basic life L₁₀ₕ', life.basic_l10h, 'h'],
        ['Reference life, ISO/TS 16281', life.reference_l10h_static, 'h'],
        ['Viscosity ratio κ', life.kappa, ''],
        ['Life factor a_ISO', life.a_iso, ''],
      ]),
    friction &&
      part('Friction, empirical', [
        ['Rolling, SKF', friction.skf_rolling_n_mm, 'N mm'],
        ['Sliding, SKF', friction.skf_sliding_n_mm, 'N mm'],
        ['Viscous, Palmgren', friction.palmgren_viscous_n_mm, 'N mm'],
      ]),
  ].filter(Boolean);
}

/** Axis of the largest part of a direction. */
function mainAxis(direction) {
  const sizes = direction.map(Math.abs);
  return ['x', 'y', 'z'][sizes.indexOf(Math.max(...sizes))];
}

/** Values that suggest a wrong unit. */
function unitWarnings(warnings = []) {
  if (!warnings.length) return [];
  const items = warnings.map(({ pointer, detail }) => h('li', {}, h('code', {}, pointer), ` ${detail}`));
  return [h('div', { class: 'note', role: 'status' }, h('h3', {}, 'Check these values'), h('ul', {}, ...items))];
}

/** Terms that the equations omit, with the reason. */
export function leftOut(terms) {
  const rows = terms.map(({ term, by, reason, bound, unit }) => [
    words(term),
    by,
    h('span', { class: 'prose' }, reason),
    bound === undefined ? '' : quantity(bound, unit, 2),
  ]);
  return table('Omitted terms', ['Term', 'By', 'Reason', 'Bound'], rows, { hidden: true });
}

/** The cost of a run in one line. */
export function cost(resolved) {
  const { estimated_wall_time_s: estimate, most_wall_time_s: most } = resolved.cost;
  if (estimate === undefined) return `Models in order: ${resolved.rungs.map(words).join(', ')}.`;
  const range = most > 2 * estimate ? `${seconds(estimate)} to ${seconds(most)}` : seconds(estimate);
  return `About ${range} on one core. Model: ${resolved.rungs.map(words).join(', else ')}.`;
}

/** Shapes of the bearing in axial view, to scale, with the share of the load of each ball, and its radii [mm]. Ball 1 is at +Y, which
 *  points down like gravity. */
export function bearingShapes(bearing, loads = []) {
  const {
    outer_diameter_mm: outer,
    inner_diameter_mm: bore,
    pitch_diameter_mm: pitch,
    ball_diameter_mm: ball,
    ball_count: count,
  } = bearing;
  const half = outer / 2;
  const rim = (pitch + ball) / 2;
  const raceway = (pitch - ball) / 2;
  const largest = Math.max(...loads, 0);
  const circle = (r, name) => s('circle', { cx: 0, cy: 0, r, class: name });
  const balls = Array.from({ length: count }, (_, i) => {
    const angle = (2 * Math.PI * i) / count;
    const at = { cx: (Math.sin(angle) * pitch) / 2, cy: (Math.cos(angle) * pitch) / 2 };
    const share = largest ? loads[i] / largest : 0;
    return [
      s('circle', { ...at, r: ball / 2, class: 'ball' }),
      share > 0 && s('circle', { ...at, r: (ball / 2) * Math.sqrt(share) * 0.82, class: 'load' }),
    ];
  });
  const shapes = [circle(half, 'ring'), circle(rim, 'gap'), circle(raceway, 'ring'), circle(bore / 2, 'bore'), balls];
  return { shapes, half, rim, raceway, bore, largest };
}

function drawing(bearing, loads) {
  const { shapes, half, bore, largest } = bearingShapes(bearing, loads);
  const text =
    `${bearing.ball_count} balls of ${number(bearing.ball_diameter_mm)} mm between ${number(bore)} and ${number(2 * half)} mm` +
    (largest ? `; largest ball load ${number(largest)} N` : '');
  return h(
    'figure',
    { class: 'drawing' },
    s('svg', { viewBox: `${-half * 1.03} ${-half * 1.03} ${half * 2.06} ${half * 2.06}`, role: 'img', 'aria-label': text }, shapes),
    largest > 0 && h('figcaption', {}, 'Filled area: share of the load'),
  );
}
