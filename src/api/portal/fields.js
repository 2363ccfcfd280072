// Names and units of the fields in the form, the slider and the study. Limits and help come from the OpenAPI document of the service,
// so they agree with the service.

import { number, words } from './format.js';
import { RAMP_HELP } from './ramp.js';

const field = (pointer, label, symbol, unit, more = {}) => ({ pointer, label, symbol, unit, ...more });

/** `range`: range of slider and study if the value gives none, or always with `always`. `near`: relative width of the range around the
 *  value. `fixed`: not varied. `pair`: two numbers. `ramp`: which value of a speed ramp. `materials`: a choice of materials. `help`: where the
 *  schema has none. `automatic`: the service chooses the value of an empty field. `absent`: what an empty choice
 *  means. `derived`: pointer to the derived value of an empty field. */
export const GROUPS = [
  {
    name: 'Operation',
    open: true,
    fields: [
      field('/scene/operation/speed_rpm', 'Speed', 'n', 'r/min', { ramp: 'from' }),
      field('/ramp/to', 'Ramp to', '', 'r/min', { ramp: 'to', help: RAMP_HELP.to }),
      field('/scene/operation/radial_load_y_n', 'Radial load y', 'Fy', 'N', { range: [0, 1000] }),
      field('/scene/operation/radial_load_z_n', 'Radial load z', 'Fz', 'N', { range: [0, 1000] }),
      field('/scene/operation/axial_load_n', 'Axial load', 'Fx', 'N', { range: [0, 500] }),
      field('/ramp/time', 'Ramp time', '', 's', { ramp: 'time', help: RAMP_HELP.time }),
    ],
  },
  {
    name: 'Bearing dimensions',
    open: true,
    fields: [
      field('/scene/bearing/type', 'Type', '', '', { choices: true, wide: true }),
      field('/scene/bearing/outer_diameter_mm', 'Outer diameter', 'D', 'mm', { fixed: true }),
      field('/scene/bearing/inner_diameter_mm', 'Bore', '', 'mm', { fixed: true }),
      field('/scene/bearing/width_mm', 'Width', '', 'mm', { fixed: true }),
      field('/scene/bearing/ball_count', 'Balls', 'Z', '', { whole: true }),
      field('/scene/bearing/ball_diameter_mm', 'Ball diameter', 'd', 'mm', { near: 0.05 }),
      field('/scene/bearing/pitch_diameter_mm', 'Pitch diameter', 'Dm', 'mm', { near: 0.03 }),
      field('/scene/bearing/inner_groove_curvature', 'Inner curvature', 'fi', '', { range: [0.51, 0.55], always: true }),
      field('/scene/bearing/outer_groove_curvature', 'Outer curvature', 'fo', '', { range: [0.51, 0.55], always: true }),
      field('/scene/bearing/radial_clearance_um', 'Clearance', '', 'µm', {
        range: [0, 40],
        from: 0,
        derived: '/derived/radial_clearance_um',
      }),
      field('/scene/bearing/radial_clearance_group', 'Clearance group', '', '', { choices: true, derived: '/derived/clearance/group' }),
      field('/scene/bearing/fits/shaft', 'Shaft class', '', '', { choices: true, absent: 'none' }),
      field('/scene/bearing/fits/shaft_interference_um', 'Shaft interference', '', 'µm', { fixed: true }),
      field('/scene/bearing/fits/housing', 'Housing class', '', '', { choices: true, absent: 'none' }),
      field('/scene/bearing/fits/housing_interference_um', 'Housing interference', '', 'µm', { fixed: true }),
      field('/scene/bearing/contact_angle_deg', 'Contact angle', 'α', '°', {
        range: [5, 30],
        derived: '/derived/free_contact_angle_deg',
      }),
    ],
  },
  {
    name: 'Materials',
    fields: [
      ['ball', 'Balls'],
      ['inner_raceway', 'Inner raceway'],
      ['outer_raceway', 'Outer raceway'],
      ['cage', 'Cage material'],
    ].map(([part, label]) => field(`/scene/bearing/materials/${part}`, label, '', '', { materials: true, fixed: true })),
  },
  {
    name: 'Cage',
    fields: [
      field('/scene/bearing/cage/pocket_clearance_mm', 'Pocket clearance', '', 'mm'),
      field('/scene/bearing/cage/mass_g', 'Cage mass', '', 'g'),
      field('/scene/bearing/cage/friction', 'Pocket friction', 'µ', ''),
      field('/scene/bearing/cage/seat', 'Pocket seat', '', '', { choices: true }),
    ],
  },
  {
    name: 'Spindle',
    open: true,
    fields: [
      field('/scene/spindle/balance_grade', 'Balance grade', 'G', 'mm/s', { range: [0, 16] }),
      field('/scene/spindle/mass_kg', 'Mass', 'm', 'kg'),
      field('/scene/spindle/axial/offset_um', 'Preload offset', '', 'µm', {
        fixed: true,
        help: 'Axial displacement at which the spindle is held: a rigid preload. Empty: free under an axial load, else held without preload.',
      }),
    ],
  },
  {
    name: 'Lubricant',
    open: true,
    fields: [
      field('/scene/lubricant', 'Lubricant', '', '', { lubricants: true, wide: true }),
      field('/scene/lubricant/viscosity_grade', 'Oil, or base oil', '', '', { choices: true, derived: '/derived/oil/grade' }),
      field('/scene/lubricant/temperature_c', 'Oil temperature', 'T', '°C', { fixed: true, derived: '/derived/oil/temperature_c' }),
      field('/scene/lubricant/viscosity_pa_s', 'Viscosity', 'η', 'Pa·s'),
      field('/scene/lubricant/fill', 'Fill', 'X', ''),
    ],
  },
  {
    name: 'Run',
    fields: [
      field('/duration_s', 'Recorded time', '', 's'),
      field('/settle_s', 'Settling time', '', 's'),
      field('/solver/model_tolerance_db', 'Model tolerance', '', 'dB'),
      field('/solver/relative_tolerance', 'Step tolerance', '', '', { automatic: true }),
      field('/solver/rung', 'Model', '', '', { choices: true, wide: true }),
      field('/outputs/envelope_band_hz', 'Envelope band', '', 'Hz', { pair: true, wide: true }),
      field('/outputs/envelope', 'Envelope', '', '', { choices: true }),
    ],
  },
];

export const FIELDS = GROUPS.flatMap((group) => group.fields);

/** Fields that can be varied: numbers of the scene except catalogue dimensions. */
export const VARIED = FIELDS.filter((f) => f.pointer.startsWith('/scene/') && !f.choices && !f.lubricants && !f.fixed);

/** Name and unit of a varied field, by its path in the scene. */
export function axisName(path) {
  const spec = VARIED.find(({ pointer }) => pointer === `/scene${path}`);
  return spec ? [spec.label, spec.unit] : [words(path.split('/').pop()), ''];
}

/** The schema of a field of a job. If a name or an object is allowed, the schema of the object. */
export function schemaAt(document, pointer) {
  const schemas = document.components.schemas;
  const plain = (schema) => {
    if (schema.$ref) return plain({ ...schemas[schema.$ref.split('/').pop()], ...described(schema) });
    // The schema of a field with a type and a default uses `allOf`.
    const inner = schema.allOf ? plain(schema.allOf[0]) : schema.oneOf?.map(plain).find((one) => one.properties);
    return inner ? { ...inner, ...described(schema) } : schema;
  };
  const described = (schema) => (schema.description ? { description: schema.description } : {});
  return pointer
    .split('/')
    .slice(1)
    .reduce((schema, step) => plain(schema?.properties?.[step] ?? {}), plain({ $ref: '#/components/schemas/JobInput' }));
}

/** Meaning and limits of a field, as text. */
export function help(schema) {
  const text = (schema.description ?? '')
    .replaceAll('\n', ' ')
    .replaceAll('`', '')
    .replace(/ \[[^\]]*\]/g, '')
    .trim();
  const limits = range(schema);
  return [text, limits && `Allowed: ${limits}.`].filter(Boolean).join(' ');
}

function range({ minimum, maximum, exclusiveMinimum, exclusiveMaximum }) {
  const least =
    minimum !== undefined ? number(minimum) : exclusiveMinimum !== undefined ? `above ${number(exclusiveMinimum)}` : null;
  const most =
    maximum !== undefined ? number(maximum) : exclusiveMaximum !== undefined ? `below ${number(exclusiveMaximum)}` : null;
  if (minimum !== undefined && most) return `${least} to ${most}`;
  if (least && most) return `${least}, at most ${most}`;
  return least ? (minimum !== undefined ? `at least ${least}` : least) : most && `at most ${most}`;
}

/** A range around a value for a sweep. */
export function rangeAround(spec, value, schema) {
  let [from, to] = spec.range ?? [0, 1];
  if (!spec.always && typeof value === 'number' && value !== 0) {
    const share = spec.near ?? 0.5;
    from = spec.from ?? value * (1 - share);
    to = value * (1 + 2 * share);
    if (spec.whole) [from, to] = [Math.max(2, value - 3), value + 1];
  }
  const least = schema.minimum ?? schema.exclusiveMinimum ?? -Infinity;
  const round = (x) => Number(x.toPrecision(4));
  return [round(Math.max(Math.min(from, to), least)), round(Math.min(Math.max(from, to), schema.maximum ?? Infinity))];
}
