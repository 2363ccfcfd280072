// The scene of a shaft with the settings of its analysis and of its run in time: one object, from which both jobs are made.

import { read, write } from './request.js';

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
const OF_RUN = ['duration_s', 'settle_s', 'step_us', 'mode_range', 'outputs', 'solver'];

const pick = (object, names) =>
  Object.fromEntries(names.filter((name) => object[name] !== undefined).map((name) => [name, object[name]]));

/** The analysis without time steps, for `POST /v1/rotor` or as a job. */
export const rotorJob = (request) => ({ kind: 'rotor', ...pick(request, ['scene', ...OF_ANALYSIS]) });
/** The run in time. */
export const machineJob = (request) => ({ kind: 'machine', ...pick(request, ['scene', ...OF_RUN]) });
/** The scene and the settings of a job of either kind. */
export const ofJob = (job) => structuredClone(pick(job, ['scene', ...OF_ANALYSIS, ...OF_RUN]));

/** Items of a list. */
export function listAt(request, pointer) {
  const list = read(request, pointer);
  return Array.isArray(list) ? list : [];
}

/** The dimensions of a bearing: those of its preset, with its changes. */
export function dimensions(choice, presets) {
  const { preset, ...changes } = typeof choice === 'string' ? { preset: choice } : (choice ?? {});
  return { ...presets.bearings[preset]?.bearing, ...changes };
}

/** The type of a bearing that gives none; empty where its designation decides. */
export function typeOf(choice, presets) {
  const name = typeof choice === 'string' ? choice : choice?.preset;
  const isDesignated = name !== undefined && !(name in presets.bearings);
  return isDesignated ? '' : (dimensions(choice, presets).type ?? 'deep_groove');
}

const BODIES = '/scene/housing/bodies';
/** Fields of items that name an item of a list. An item without a name that it needs is removed with it. */
const NAMING = {
  '/scene/bearings': [{ list: '/scene/preloads', needs: ['between/0', 'between/1'] }],
  [BODIES]: [
    { list: '/scene/bearings', takes: ['outer_ring/on'] },
    { list: '/scene/supports', takes: ['on'] },
    { list: '/scene/housing/mounts', needs: ['body', 'to'] },
    { list: '/scene/sensors', needs: ['on'], takes: ['relative_to'] },
  ],
};

/** A copy with a new name of an item, also where other items name it. */
export function renamed(request, pointer, name) {
  const list = pointer.split('/').slice(0, -2).join('/');
  const old = read(request, pointer);
  let copy = write(request, pointer, name);
  for (const { list: other, needs = [], takes = [] } of NAMING[list] ?? [])
    listAt(request, other).forEach((item, i) =>
      [...needs, ...takes]
        .filter((path) => read(item, `/${path}`) === old)
        .forEach((path) => {
          copy = write(copy, `${other}/${i}/${path}`, name);
        }),
    );
  return copy;
}

/** A copy without an item. Items that need it go with it, others name it no longer. */
export function without(request, list, index) {
  const { name } = listAt(request, list)[index];
  const put = (copy, pointer, items) => write(copy, pointer, items.length || pointer.endsWith('sections') ? items : undefined);
  let copy = request;
  for (const { list: other, needs = [], takes = [] } of name === undefined ? [] : (NAMING[list] ?? [])) {
    listAt(copy, other).forEach((item, i) =>
      takes
        .filter((path) => read(item, `/${path}`) === name)
        .forEach((path) => {
          copy = write(copy, `${other}/${i}/${path}`, undefined);
        }),
    );
    const kept = listAt(copy, other).filter((item) => !needs.some((path) => read(item, `/${path}`) === name));
    if (kept.length < listAt(copy, other).length) copy = put(copy, other, kept);
  }
  return put(
    copy,
    list,
    listAt(copy, list).filter((_, i) => i !== index),
  );
}

/** Whether a rigid spindle stands in place of the shaft. */
export const isRigid = (request) => !request.scene.shaft;

/** Whether a sensor sits on the shaft or measures from it. */
export const concernsShaft = ({ on = 'shaft', relative_to: from }) => on === 'shaft' || from === 'shaft';

/** Length of the shaft [mm]; of a rigid spindle up to the farthest place on it. */
export function lengthOf(request) {
  if (!isRigid(request))
    return listAt(request, '/scene/shaft/sections').reduce((sum, { length_mm: length }) => sum + (Number(length) || 0), 0);
  const items = ['/scene/bearings', '/scene/supports', '/scene/operation/loads'].flatMap((list) => listAt(request, list));
  const places = [...items, ...listAt(request, '/scene/sensors').filter(concernsShaft)].map(({ at_mm: at }) => Number(at) || 0);
  return Math.max(1, read(request, '/scene/spindle/centre_mm') ?? 0, ...places);
}

/** Sections of the shaft as they are drawn; a rigid spindle is a bar with the smallest bore of its bearings. */
export function sectionsOf(request, presets) {
  if (!isRigid(request)) return listAt(request, '/scene/shaft/sections');
  const bores = listAt(request, '/scene/bearings').map(({ bearing }) => dimensions(bearing, presets).inner_diameter_mm);
  const diameter = Math.min(...bores.filter((bore) => bore > 0));
  return [{ length_mm: lengthOf(request), outer_diameter_mm: Number.isFinite(diameter) ? diameter : 20 }];
}

/** The arrangement of two bearings by their places and the thrusts that they carry. */
export function arrangement([one, other]) {
  const [low, high] = one.at_mm <= other.at_mm ? [one, other] : [other, one];
  const [left, right] = [low.faces ?? '+x', high.faces ?? '+x'];
  if (left === right) return 'tandem (DT)';
  return left === '+x' ? 'back to back (DB)' : 'face to face (DF)';
}
