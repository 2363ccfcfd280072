// The lists of a shaft's scene with the fields of their items. Limits and help come from the OpenAPI document.

import { RAMP_HELP } from './ramp.js';
import { read } from './request.js';
import { lengthOf, listAt, typeOf } from './shaft-request.js';

const field = (path, label, unit = '', more = {}) => ({ path, label, unit, ...more });
const at = field('at_mm', 'Place', 'mm');

const DIRECTIONS = [
  ['x', 'x'],
  ['y', 'y'],
  ['z', 'z'],
];

/** A place that is still free: a share of the length, in whole millimetres. */
const place = (request, share) => Math.round(lengthOf(request) * share);

/** A name that no item of a list has. */
function freeName(request, pointer, candidates) {
  const taken = listAt(request, pointer).map(({ name }) => name);
  return candidates.find((name) => !taken.includes(name)) ?? `${candidates[0]}${taken.length + 1}`;
}

const materials = ({ materials: known }) => [['', 'default'], ...Object.keys(known).map((name) => [name, name])];

const BODIES = '/scene/housing/bodies';
/** The body that holds an item; the ground without one. */
const on = (path, label = 'Held by') => field(path, label, '', { names: BODIES, others: [['', 'the ground']] });
const triple = (path, label, unit, more) =>
  ['x', 'y', 'z'].map((axis, i) => field(`${path}/${i}`, `${label} ${axis}`, unit, { size: 3, ...more }));
const aboutBoth = (path, label, unit) =>
  ['y', 'z'].map((axis, i) => field(`${path}/${i}`, `${label} ${axis}`, unit, { fallback: '0', size: 2 }));
/** Fields of an item against tilt. */
const tilts = [
  ...aboutBoth('tilt_n_m_per_mrad', 'Against tilt', 'N·m/mrad'),
  ...aboutBoth('tilt_damping_n_m_s_per_rad', 'Damping of tilt', 'N·m·s/rad'),
];
/** A field of an outer ring that belongs to some seats only. */
const seated = (seats, path, label, unit, more) =>
  field(`outer_ring/${path}`, label, unit, { when: ['outer_ring/seat', seats], ...more });
const MOVING = ['elastic', 'sliding'];

const LETTERS = [...'ABCDEFGH'];
const numbered = (name) => Array.from({ length: 16 }, (_, i) => `${name}${i + 1}`);

/** `fresh(request)`: a new item. `choices`: pairs, or a function of the presets; the first stands for an absent value. `names`: a list
 *  whose items may be named, after the `others`. `of`: schema of an item. `more`: fields behind a summary. `when`: a field of the item
 *  and its values for which this one exists. `alike`: a list starts with equal numbers. `part`: of a shaft only. */
export const LISTS = [
  {
    pointer: '/scene/shaft/sections',
    part: 'shaft',
    title: 'Sections',
    item: 'Section',
    of: 'SectionInput',
    open: true,
    fields: [
      field('length_mm', 'Length', 'mm'),
      field('outer_diameter_mm', 'Diameter', 'mm'),
      field('inner_diameter_mm', 'Bore', 'mm', { fallback: '0' }),
    ],
    fresh: (request) => {
      const last = listAt(request, '/scene/shaft/sections').at(-1);
      return { ...last, length_mm: 50, outer_diameter_mm: last?.outer_diameter_mm ?? 40 };
    },
  },
  {
    pointer: '/scene/bearings',
    title: 'Ball bearings',
    item: 'Bearing',
    of: 'RotorBearingInput',
    open: true,
    fields: [
      field('name', 'Name', '', { text: true }),
      at,
      field('faces', 'Carries thrust', '', {
        choices: [
          ['+x', '+x'],
          ['-x', '−x'],
        ],
      }),
    ],
    fresh: (request) => {
      const bearings = listAt(request, '/scene/bearings');
      return {
        name: freeName(request, '/scene/bearings', LETTERS),
        bearing: structuredClone(bearings.at(-1)?.bearing ?? '6205'),
        at_mm: place(request, 0.5),
        faces: '+x',
      };
    },
    more: [
      {
        summary: 'Dimensions',
        of: 'BearingInput',
        fields: [
          field('bearing/type', 'Type', '', {
            choices: [
              ['deep_groove', 'deep groove'],
              ['angular_contact', 'angular contact'],
              ['', 'by designation'],
            ],
            unset: (request, pointer, presets) => typeOf(read(request, pointer.replace(/\/type$/, '')), presets),
            help: 'Own dimensions are those of a deep-groove bearing unless chosen.',
          }),
          field('bearing/outer_diameter_mm', 'Outer diameter', 'mm'),
          field('bearing/inner_diameter_mm', 'Bore', 'mm'),
          field('bearing/width_mm', 'Width', 'mm'),
          field('bearing/ball_count', 'Balls', ''),
          field('bearing/ball_diameter_mm', 'Ball diameter', 'mm'),
          field('bearing/pitch_diameter_mm', 'Pitch diameter', 'mm'),
          field('bearing/contact_angle_deg', 'Contact angle', '°'),
          field('bearing/radial_clearance_um', 'Clearance', 'µm'),
          field('bearing/inner_groove_curvature', 'Inner curvature', '', { fallback: '0.52' }),
          field('bearing/outer_groove_curvature', 'Outer curvature', '', { fallback: '0.53' }),
          field('bearing/materials/ball', 'Balls of', '', {
            of: 'MaterialsInput',
            choices: materials,
          }),
        ],
      },
      {
        summary: 'Outer ring',
        of: 'OuterRingInput',
        fields: [
          field('outer_ring/seat', 'Seat', '', {
            choices: [
              ['rigid', 'rigid'],
              ['elastic', 'elastic'],
              ['sliding', 'sliding'],
            ],
          }),
          on('outer_ring/on'),
          seated(['elastic'], 'stiffness_n_per_um/0', 'Stiffness along x', 'N/µm', { size: 2 }),
          seated(['elastic'], 'stiffness_n_per_um/1', 'Stiffness across', 'N/µm', { size: 2 }),
          seated(['elastic'], 'tilt_n_m_per_mrad', 'Against tilt', 'N·m/mrad', { fallback: 'of the stiffness' }),
          seated(['sliding'], 'spring_force_n', 'Force of the spring', 'N'),
          seated(['sliding'], 'spring_n_per_um', 'Stiffness of the spring', 'N/µm', { fallback: '0' }),
          seated(MOVING, 'damping_n_s_per_m/0', 'Damping along x', 'N·s/m', { fallback: '0', size: 2 }),
          seated(['elastic'], 'damping_n_s_per_m/1', 'Damping across', 'N·s/m', { fallback: '0', size: 2 }),
          seated(['elastic'], 'tilt_damping_n_m_s_per_rad', 'Damping of tilt', 'N·m·s/rad', { fallback: '0' }),
          seated(MOVING, 'mass_kg', 'Mass of the ring', 'kg', { fallback: 'of steel' }),
          ...['x', 'y', 'z'].map((axis) =>
            field(`outer_ring/offset_um/${axis}`, `Offset ${axis}`, 'µm', { fallback: '0', of: 'OffsetInput' }),
          ),
          field('outer_ring/tilt_mrad/y', 'Tilt about y', 'mrad', { fallback: '0', of: 'OuterTiltInput' }),
          field('outer_ring/tilt_mrad/z', 'Tilt about z', 'mrad', { fallback: '0', of: 'OuterTiltInput' }),
        ],
      },
      {
        summary: 'Spall of the outer raceway',
        of: 'DefectInput',
        fields: [
          field('surfaces/outer/defects/0/azimuth_deg', 'Azimuth', '°'),
          field('surfaces/outer/defects/0/length_mm', 'Length', 'mm'),
          field('surfaces/outer/defects/0/width_mm', 'Width', 'mm', { fallback: 'whole' }),
          field('surfaces/outer/defects/0/depth_um', 'Depth', 'µm'),
        ],
      },
    ],
  },
  {
    pointer: '/scene/preloads',
    title: 'Preloads of pairs',
    item: 'Preload',
    of: 'PreloadInput',
    open: true,
    fields: [
      field('between/0', 'Between', '', { names: '/scene/bearings' }),
      field('between/1', 'and', '', { names: '/scene/bearings' }),
      field('force_n', 'Force', 'N'),
      field('offset_um', 'or offset', 'µm'),
    ],
    fresh: (request) => {
      const [one, other] = listAt(request, '/scene/bearings').map(({ name }) => name);
      return { between: [one ?? 'A', other ?? 'B'], force_n: 200 };
    },
  },
  {
    pointer: '/scene/shaft/discs',
    part: 'shaft',
    title: 'Discs',
    item: 'Disc',
    of: 'DiscInput',
    fields: [
      at,
      field('mass_kg', 'Mass', 'kg'),
      field('transverse_inertia_kg_m2', 'Inertia about a diameter', 'kg m²', { fallback: '0' }),
      field('axial_inertia_kg_m2', 'Inertia about the axis', 'kg m²', { fallback: '0' }),
    ],
    fresh: (request) => ({
      at_mm: place(request, 0.5),
      mass_kg: 1,
      transverse_inertia_kg_m2: 8e-4,
      axial_inertia_kg_m2: 1.5e-3,
    }),
  },
  {
    pointer: '/scene/shaft/unbalances',
    part: 'shaft',
    title: 'Unbalance planes',
    item: 'Unbalance',
    of: 'UnbalanceInput',
    fields: [at, field('unbalance_g_mm', 'Unbalance', 'g·mm'), field('phase_deg', 'Phase', '°', { fallback: '0' })],
    fresh: (request) => ({ at_mm: place(request, 0.5), unbalance_g_mm: 5 }),
  },
  {
    pointer: '/scene/operation/loads',
    title: 'Loads at a place',
    item: 'Load',
    of: 'LoadInput',
    fields: [
      at,
      field('direction', 'Direction', '', { choices: [...DIRECTIONS, ['about_y', 'about y'], ['about_z', 'about z']] }),
      field('constant_n', 'Constant force', 'N'),
      field('constant_n_m', 'or moment', 'N·m'),
    ],
    more: [
      {
        summary: 'Harmonic',
        of: 'HarmonicLoadInput',
        fields: [
          field('harmonic/amplitude_n', 'Amplitude of the force', 'N'),
          field('harmonic/amplitude_n_m', 'or of the moment', 'N·m'),
          field('harmonic/frequency_hz', 'Frequency', 'Hz'),
          field('harmonic/order', 'or order', ''),
          field('harmonic/phase_deg', 'Phase', '°', { fallback: '0' }),
        ],
      },
      {
        summary: 'Shock',
        of: 'ShockInput',
        fields: [
          field('shock/peak_n', 'Largest force', 'N'),
          field('shock/peak_n_m', 'or moment', 'N·m'),
          field('shock/at_s', 'Begins at', 's'),
          field('shock/duration_s', 'Duration', 's'),
        ],
      },
    ],
    fresh: (request) => ({ at_mm: place(request, 0.5), direction: 'y', constant_n: 100 }),
  },
  {
    pointer: '/scene/supports',
    title: 'Linear supports',
    item: 'Support',
    of: 'SupportInput',
    fields: [
      at,
      on('on'),
      ...triple('stiffness_n_per_um', 'Stiffness', 'N/µm'),
      ...triple('damping_n_s_per_m', 'Damping', 'N·s/m', { fallback: '0' }),
    ],
    more: [{ summary: 'Tilt', of: 'SupportInput', fields: tilts }],
    fresh: (request) => ({ at_mm: place(request, 0.9), stiffness_n_per_um: [0, 50, 50], damping_n_s_per_m: [0, 200, 200] }),
  },
  {
    pointer: BODIES,
    title: 'Housing bodies',
    item: 'Body',
    of: 'BodyInput',
    fields: [field('name', 'Name', '', { text: true }), at, field('mass_kg', 'Mass', 'kg')],
    more: [
      {
        summary: 'Inertia',
        of: 'BodyInput',
        // A body without given inertia is a cube, so the others start equal to the first one that is entered.
        fields: triple('inertia_kg_m2', 'About', 'kg m²', { fallback: 'of a cube', alike: true }),
      },
    ],
    fresh: (request) => ({
      name: freeName(request, BODIES, ['head', ...numbered('body')]),
      at_mm: place(request, 0.5),
      mass_kg: 8,
    }),
  },
  {
    pointer: '/scene/housing/mounts',
    title: 'Housing mounts',
    item: 'Mount',
    of: 'MountInput',
    fields: [
      field('body', 'Of the body', '', { names: BODIES }),
      field('to', 'To', '', { names: BODIES, others: [['', 'the ground']] }),
      field('at_mm', 'Place', 'mm', { fallback: 'of the body' }),
      ...triple('stiffness_n_per_um', 'Stiffness', 'N/µm'),
      ...triple('damping_n_s_per_m', 'Damping', 'N·s/m', { fallback: '0' }),
    ],
    more: [{ summary: 'Tilt', of: 'MountInput', fields: tilts }],
    fresh: (request) => {
      const bodies = listAt(request, BODIES);
      const mounted = listAt(request, '/scene/housing/mounts').map(({ body: of }) => of);
      const body = bodies.find(({ name }) => !mounted.includes(name)) ?? bodies[0];
      const usual = {
        stiffness_n_per_um: [50, 50, 50],
        damping_n_s_per_m: [300, 300, 300],
        tilt_n_m_per_mrad: [20, 20],
        tilt_damping_n_m_s_per_rad: [1, 1],
      };
      return { body: body?.name ?? 'head', at_mm: body?.at_mm ?? place(request, 0.5), ...usual };
    },
  },
  {
    pointer: '/scene/sensors',
    title: 'Sensors',
    item: 'Sensor',
    of: 'SensorInput',
    fields: [
      field('name', 'Name', '', { text: true }),
      at,
      field('direction', 'Direction', '', { choices: DIRECTIONS }),
      field('on', 'On', '', { names: BODIES, others: [['shaft', 'the shaft']] }),
      field('relative_to', 'Relative to', '', {
        names: BODIES,
        others: [
          ['', 'the ground'],
          ['shaft', 'the shaft'],
        ],
      }),
    ],
    fresh: (request) => ({
      name: freeName(request, '/scene/sensors', numbered('s')),
      at_mm: place(request, 0.1),
      direction: 'y',
    }),
  },
];

const single = (pointer, label, unit, more = {}) => ({ pointer, label, unit, ...more });

/** Single fields, in groups before and after the lists. `of` and `name`: schema and property of the help. */
export const OPERATION = {
  title: 'Operation',
  open: true,
  of: 'RotorOperationInput',
  fields: [
    single('/scene/operation/speed_rpm', 'Speed', 'r/min', { ramp: 'from' }),
    single('/ramp/to', 'Ramp to', 'r/min', { ramp: 'to', help: RAMP_HELP.to }),
    single('/ramp/time', 'Ramp time', 's', { ramp: 'time', help: RAMP_HELP.time }),
    single('/scene/operation/outer_speed_rpm', 'Speed of outer rings', 'r/min', { fallback: '0' }),
    single('/scene/operation/radial_load_y_n', 'Radial load y', 'N', { fallback: '0' }),
    single('/scene/operation/radial_load_z_n', 'Radial load z', 'N', { fallback: '0' }),
    single('/scene/operation/axial_load_n', 'Axial load', 'N', { fallback: '0' }),
  ],
};

const AXIAL = [
  ['', 'default'],
  ['fixed', 'fixed'],
  ['free', 'free'],
];

/** A rigid spindle in place of the shaft. */
export const SPINDLE = {
  title: 'Rigid spindle',
  part: 'spindle',
  open: true,
  of: 'SpindleInput',
  fields: [
    single('/scene/spindle/mass_kg', 'Mass', 'kg', { fallback: 'of the bores' }),
    single('/scene/spindle/centre_mm', 'Mass centre', 'mm', { fallback: 'middle' }),
    single('/scene/spindle/balance_grade', 'Balance grade', 'mm/s'),
    single('/scene/spindle/unbalance_g_mm', 'or unbalance', 'g·mm', { fallback: '0' }),
    single('/scene/spindle/axial', 'Motion along x', '', { choices: AXIAL }),
    single('/scene/spindle/tilt', 'Tilt', '', {
      choices: [
        ['', 'default'],
        ['held', 'held'],
        ['free', 'free'],
      ],
    }),
    single('/scene/spindle/transverse_inertia_kg_m2', 'Inertia about a diameter', 'kg m²', { fallback: 'of a cylinder' }),
    single('/scene/spindle/axial_inertia_kg_m2', 'Inertia about the axis', 'kg m²', { fallback: 'of a cylinder' }),
  ],
};

export const SHAFT = {
  title: 'Material and damping',
  part: 'shaft',
  of: 'ShaftInput',
  fields: [
    single('/scene/shaft/material', 'Material', '', {
      choices: materials,
    }),
    single('/scene/shaft/axial', 'Motion along x', '', { choices: AXIAL }),
    single('/scene/shaft/damping_ratio', 'Damping ratio', '', { fallback: '0.005' }),
    single('/scene/shaft/rotating_share', 'Share that turns', '', { fallback: '0' }),
  ],
};

const TERM = [
  ['', 'automatic'],
  ['on', 'on'],
  ['off', 'off'],
];

/** What the equations of shaft and housing contain. */
export const TERMS = {
  title: 'Terms',
  of: 'SystemTerms',
  fields: [
    single('/scene/terms/shaft_bending', 'Bending of the shaft', '', { choices: TERM }),
    single('/scene/terms/tilt', 'Tilt of the rings', '', { choices: TERM }),
    single('/scene/terms/gyroscopic', 'Gyroscopic moments', '', { choices: TERM }),
    single('/scene/terms/housing', 'Motion of the housing', '', { choices: TERM }),
  ],
};

export const ANALYSIS = {
  title: 'Speeds of the Campbell diagram',
  open: true,
  of: 'SpeedRangeInput',
  fields: [
    single('/speeds_rpm/from', 'From', 'r/min', { fallback: '0' }),
    single('/speeds_rpm/to', 'To', 'r/min'),
    single('/speeds_rpm/count', 'Number', '', { fallback: '50' }),
    single('/modes', 'Motions', '', { fallback: '8', of: 'RotorJob' }),
  ],
};

export const RUN = {
  title: 'Run in time',
  of: 'MachineJob',
  fields: [
    single('/duration_s', 'Recorded time', 's', { fallback: '0.2' }),
    single('/settle_s', 'Settling time', 's', { fallback: 'automatic' }),
    single('/solver/model_tolerance_db', 'Model error, at most', 'dB', { fallback: 'complete model', of: 'MachineSolverInput' }),
  ],
};
