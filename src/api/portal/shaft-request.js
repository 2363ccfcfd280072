// The scene of a shaft with the settings of its analysis and of its run in time: one object, from which both jobs are made.

/** A 7008 AC: 40 × 68 × 15 mm, 17 balls, 25°. */
const ANGULAR_CONTACT_7008 = {
  type: 'angular_contact',
  outer_diameter_mm: 68,
  inner_diameter_mm: 40,
  width_mm: 15,
  ball_count: 17,
  ball_diameter_mm: 7.938,
  pitch_diameter_mm: 54,
  contact_angle_deg: 25,
};

/** A motor spindle on two 7008 in DB arrangement, with tool and rotor as discs. */
export const EXAMPLE = {
  scene: {
    shaft: {
      sections: [
        { length_mm: 35, outer_diameter_mm: 55, inner_diameter_mm: 20 },
        { length_mm: 45, outer_diameter_mm: 40, inner_diameter_mm: 20 },
        { length_mm: 150, outer_diameter_mm: 46, inner_diameter_mm: 20 },
        { length_mm: 60, outer_diameter_mm: 40, inner_diameter_mm: 20 },
      ],
      discs: [
        { at_mm: 0, mass_kg: 0.6, transverse_inertia_kg_m2: 2.5e-4, axial_inertia_kg_m2: 2.2e-4 },
        { at_mm: 155, mass_kg: 2.4, transverse_inertia_kg_m2: 3.4e-3, axial_inertia_kg_m2: 2e-3 },
      ],
      unbalances: [
        { at_mm: 0, unbalance_g_mm: 1 },
        { at_mm: 155, unbalance_g_mm: 3, phase_deg: 90 },
      ],
      axial: 'free',
    },
    bearings: [
      { name: 'A', bearing: ANGULAR_CONTACT_7008, at_mm: 55, faces: '+x' },
      { name: 'B', bearing: ANGULAR_CONTACT_7008, at_mm: 255, faces: '-x' },
    ],
    preloads: [{ between: ['A', 'B'], force_n: 300 }],
    sensors: [{ name: 'nose', at_mm: 20, direction: 'y' }],
    operation: { speed_rpm: 12000, radial_load_y_n: 100 },
  },
  speeds_rpm: { from: 0, to: 60000, count: 31 },
};

const OF_ANALYSIS = ['speeds_rpm', 'modes'];
const OF_RUN = ['duration_s', 'settle_s', 'step_us', 'mode_range'];

const pick = (object, names) =>
  Object.fromEntries(names.filter((name) => object[name] !== undefined).map((name) => [name, object[name]]));

/** The analysis without time steps, for `POST /v1/rotor` or as a job. */
export const rotorJob = (request) => ({ kind: 'rotor', ...pick(request, ['scene', ...OF_ANALYSIS]) });
/** The run in time. */
export const machineJob = (request) => ({ kind: 'machine', ...pick(request, ['scene', ...OF_RUN]) });
/** The scene and the settings of a job of either kind. */
export const ofJob = (job) => structuredClone(pick(job, ['scene', ...OF_ANALYSIS, ...OF_RUN]));

const steps = (pointer) => pointer.split('/').slice(1);
const isIndex = (step) => /^\d+$/.test(step);
/** Nothing, an object of nothing, or a list of zeros. */
const isEmpty = (value) =>
  value === undefined ||
  (Array.isArray(value) && value.every((one) => one === 0)) ||
  (typeof value === 'object' && value !== null && Object.values(value).every(isEmpty));

/** A copy with one value set, or removed if it is `undefined`. A bearing that is only named becomes an object for its changes, and a
 *  name again without them. `size`: length of a list of numbers that begins with this value. */
export function set(request, pointer, value, size = 0) {
  const copy = structuredClone(request);
  const path = steps(pointer);
  const parents = [];
  let at = copy;
  path.slice(0, -1).forEach((step, i) => {
    if (typeof at[step] === 'string') at[step] = { preset: at[step] };
    at[step] ??= isIndex(path[i + 1]) ? Array(size).fill(0) : {};
    parents.push([at, step]);
    at = at[step];
  });
  const last = path.at(-1);
  // A list of numbers has no gaps.
  if (value !== undefined) at[last] = value;
  else if (Array.isArray(at)) at[last] = 0;
  else delete at[last];
  for (const [parent, step] of value === undefined ? parents.toReversed() : []) {
    const inner = parent[step];
    if (Object.keys(inner).join() === 'preset') parent[step] = inner.preset;
    const isRequired = ['scene', 'shaft', 'operation', 'sections', 'bearings'].includes(step) || isIndex(step);
    if (isEmpty(inner) && !isRequired) delete parent[step];
  }
  return copy;
}

/** Items of a list. */
export const listAt = (request, pointer) => steps(pointer).reduce((at, step) => at?.[step], request) ?? [];

/** The dimensions of a bearing: those of its preset, with its changes. */
export function dimensions(choice, presets) {
  const { preset, ...changes } = typeof choice === 'string' ? { preset: choice } : (choice ?? {});
  return { ...presets.bearings[preset]?.bearing, ...changes };
}

const BODIES = '/scene/housing/bodies';
/** Lists and the fields of their items that name a bearing or a body. */
const NAMING = {
  '/scene/bearings': [['/scene/preloads', ['between/0', 'between/1']]],
  [BODIES]: [
    ['/scene/bearings', ['outer_ring/on']],
    ['/scene/supports', ['on']],
    ['/scene/housing/mounts', ['body']],
    ['/scene/sensors', ['on', 'relative_to']],
  ],
};

/** A copy with a new name of an item, also where other items name it. */
export function renamed(request, pointer, name) {
  const list = pointer.split('/').slice(0, -2).join('/');
  const valueAt = (from, path) => steps(path).reduce((at, step) => at?.[step], from);
  const old = valueAt(request, pointer);
  let copy = set(request, pointer, name);
  for (const [other, paths] of NAMING[list] ?? [])
    listAt(request, other).forEach((item, i) =>
      paths
        .filter((path) => valueAt(item, `/${path}`) === old)
        .forEach((path) => {
          copy = set(copy, `${other}/${i}/${path}`, name);
        }),
    );
  return copy;
}

/** Length of the shaft [mm]. */
export const lengthOf = (request) =>
  listAt(request, '/scene/shaft/sections').reduce((sum, { length_mm: length }) => sum + (Number(length) || 0), 0);

/** The arrangement of two bearings by their places and the thrusts that they carry. */
export function arrangement([one, other]) {
  const [low, high] = one.at_mm <= other.at_mm ? [one, other] : [other, one];
  const [left, right] = [low.faces ?? '+x', high.faces ?? '+x'];
  if (left === right) return 'tandem (DT)';
  return left === '+x' ? 'back to back (DB)' : 'face to face (DF)';
}
