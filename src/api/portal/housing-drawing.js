// The housing in the drawing of a shaft: frames of its bodies, seats of outer rings, mounts, and the part that a sensor sits on.

import { s } from './dom.js';
import { concernsShaft, listAt } from './shaft-request.js';

/** Least reach of a body on either side of what it holds [mm]. */
const REACH = 4;
/** Distance of a body from the widest part of the shaft: room for seats [px]. */
const GAP = 12;
/** Height of the line with the name of a body [px]. */
const STRIP = 18;
/** Estimated width of a letter [px]. */
export const LETTER = 7;
/** Distance between the lower edges of bodies one around the other [px]. */
const STEP = 6;
/** Distance of the line of a seat from its ring [px]. */
const DISTANCES = { rigid: 2, elastic: 9, sliding: 3.5 };
/** Height of a spring with its ground [px]. */
export const SPRING = 15;

/** A number of the request, which may still be text or missing. */
export const finite = (value, fallback = 0) => (Number.isFinite(value) ? value : fallback);

/** Place of a mount [mm]. */
export const mountAt = ({ at_mm: at, body }, bodies) => finite(at, bodies.find(({ name }) => name === body)?.at ?? 0);

/** Bodies from end to end of what they hold [mm], with the number of bodies within each. `widths`: those of the bearings [mm]. */
export function bodiesOf(request, widths) {
  const masses = listAt(request, '/scene/housing/bodies').map(({ name, at_mm: at, mass_kg: mass }) => ({
    name,
    at: finite(at),
    mass: finite(mass),
  }));
  const held = [
    ...listAt(request, '/scene/housing/mounts').map((mount) => [mount.body, mountAt(mount, masses), REACH]),
    ...listAt(request, '/scene/bearings').map(({ outer_ring: ring, at_mm: at }, i) => [
      ring?.on,
      finite(at),
      finite(widths[i]) / 2,
    ]),
    ...listAt(request, '/scene/supports').map(({ on, at_mm: at }) => [on, finite(at), REACH]),
    ...listAt(request, '/scene/sensors').flatMap(({ on, relative_to: from, at_mm: at }) => [
      [on, finite(at), REACH],
      [from, finite(at), REACH],
    ]),
  ];
  const bodies = masses.map((body) => {
    const ends = held.filter(([on]) => on === body.name).flatMap(([, at, reach]) => [at - reach, at + reach]);
    return { ...body, from: Math.min(...ends, body.at - 2 * REACH), to: Math.max(...ends, body.at + 2 * REACH), level: 0 };
  });
  // The shortest lies within the others.
  const placed = [];
  for (const body of [...bodies].sort((one, other) => one.to - one.from - (other.to - other.from))) {
    const within = placed.filter(({ from, to }) => from < body.to + REACH && to > body.from - REACH);
    body.level = Math.max(-1, ...within.map(({ level }) => level)) + 1;
    placed.push(body);
  }
  return bodies;
}

/** Room above and below the shaft for frames of bodies [px]. */
export function roomOf(bodies) {
  const levels = Math.max(-1, ...bodies.map(({ level }) => level)) + 1;
  return levels ? { above: GAP + levels * STRIP, below: GAP + levels * STEP } : { above: 0, below: 4 };
}

/** Edges of the frame of a body [px]. */
export function frameOf({ from, to, level }, { x, axis, half }) {
  return {
    left: x(from) - 5 - 4 * level,
    right: x(to) + 5 + 4 * level,
    top: axis - half - GAP - STRIP * (level + 1),
    bottom: axis + half + GAP + STEP * (level + 1),
  };
}

/** Frame, name and mass centre of a body. */
export function bodyShapes(body, label, view) {
  const { left, right, top, bottom } = frameOf(body, view);
  const centre = view.x(body.at);
  // A name begins at the left of its frame, as far as it ends within the drawing.
  const begin = Math.max(Math.min(left + 5, view.width - label.length * LETTER - 2), 2);
  return [
    s('rect', { class: 'housing', x: left, y: top, width: right - left, height: bottom - top, rx: 4 }),
    s('text', { class: 'tag', x: begin, y: top + 15 }, label),
    massCentre(centre, top),
  ];
}

/** A mass centre: a circle with two filled quarters. */
export const massCentre = (x, y) => [
  s('circle', { class: 'centre', cx: x, cy: y, r: 5 }),
  s('path', { class: 'quarters', d: `M${x} ${y}v-5a5 5 0 0 1 5 5zM${x} ${y}v5a5 5 0 0 1 -5 -5z` }),
];

/** A mount as a spring from its body to the ground, or to another body. */
export function mountShapes(mount, bodies, view) {
  const { x, base } = view;
  const [of, to] = [mount.body, mount.to].map((name) => bodies.find((body) => body.name === name));
  const place = x(mountAt(mount, bodies));
  const inside = (body, at) => {
    const { left, right, bottom } = frameOf(body, view);
    return [Math.min(Math.max(at, left + 6), right - 6), bottom];
  };
  const [near, top] = of ? inside(of, place) : [place, base - SPRING];
  const lead = `M${near} ${top}V${base - SPRING}H${place}`;
  if (!to) return [s('path', { class: 'lead', d: lead }), spring(place, base - SPRING), ground(place, base)];
  const [far, end] = inside(to, place + (to.at < (of?.at ?? 0) ? -14 : 14));
  return [
    s('path', { class: 'lead', d: lead }),
    spring(place, base - SPRING),
    s('path', { class: 'link', d: `M${place} ${base - 3}V${base + 1}H${far}V${end}` }),
  ];
}

/** A support of the shaft as a spring to the ground or to a body. */
export function supportShapes({ on }, place, bodies, view) {
  const body = bodies.find(({ name }) => name === on);
  const end = body ? frameOf(body, view).bottom : view.base;
  return [
    s('line', { class: 'lead', x1: place, x2: place, y1: view.axis, y2: end - SPRING }),
    spring(place, end - SPRING),
    !body && ground(place, end),
  ];
}

/** The seat of an outer ring on both sides of the axis. `outer`, `height`, `width`: of the ring [px]; `sense`: 1 if it carries thrust along +X. */
export function seatShapes({ seat = 'rigid', spring_force_n: force }, place, { outer, height, width, sense }, axis) {
  const half = width / 2 + 2;
  return [-1, 1].map((side) => {
    const edge = axis + (side * outer) / 2;
    const y = edge + side * (DISTANCES[seat] ?? DISTANCES.rigid);
    const line = s('path', { class: `seat ${seat}`, d: `M${place - half} ${y}H${place + half}` });
    if (seat === 'elastic')
      return [
        line,
        [-1, 1].map((end) => s('path', { class: 'spring', d: zigzag(place + (end * width) / 4, edge, 0, side * 1.8) })),
      ];
    if (seat !== 'sliding' || !(force > 0)) return line;
    // The spring pushes the ring against the balls: that of a `+x` bearing along -X.
    const from = place + (sense * width) / 2;
    const middle = edge - (side * height) / 2;
    const stop = from + sense * 14;
    return [
      line,
      s('path', { class: 'spring', d: zigzag(from, middle, sense * 2.6, 0) }),
      s('path', { class: 'ground', d: `M${stop} ${middle - 6}v12` }),
    ];
  });
}

/** Words for the seat of an outer ring, for the name of its bearing. */
export function seatName({ seat = 'rigid', on, spring_force_n: force } = {}) {
  if (seat === 'rigid' && !on) return '';
  const how = { rigid: 'rigid', elastic: 'elastic', sliding: force > 0 ? 'sliding under a spring' : 'sliding' }[seat] ?? seat;
  return `, ${how} in ${on ?? 'the ground'}`;
}

/** Words for the parts of a sensor. */
export function sensorName({ name, direction, on, relative_to: from }) {
  return [`sensor ${name}, ${direction}`, on && on !== 'shaft' && `on ${on}`, from && `relative to ${from}`]
    .filter(Boolean)
    .join(', ');
}

/** Height at which a sensor sits, and that of the part from which it measures [px]. `surface`: height of the shaft's surface there. */
export function sensorTips(sensor, bodies, surface, view) {
  const height = (part) => {
    if (part === 'shaft') return surface;
    const body = bodies.find(({ name }) => name === part);
    return body ? frameOf(body, view).top : undefined;
  };
  return { tip: height(sensor.on ?? 'shaft') ?? surface, from: height(sensor.relative_to) };
}

/** Whether an item may lie beyond the ends of the shaft. */
export const mayLieBeyond = (pointer, item) =>
  pointer.startsWith('/scene/housing/') || (pointer.startsWith('/scene/sensors') && !concernsShaft(item));

const spring = (x, top) => s('path', { class: 'spring', d: zigzag(x, top, 0, (SPRING - 3) / 5) });
const ground = (x, base) => s('path', { class: 'ground', d: `M${x - 9} ${base - 1.5}h18` });

/** Five steps along x or y, across it to both sides in turn. */
function zigzag(x, y, dx, dy) {
  const across = (k) => (k === 0 || k === 5 ? 0 : k % 2 ? 4 : -4);
  const at = (k) => (dx ? `${x + k * dx} ${y + across(k)}` : `${x + across(k)} ${y + k * dy}`);
  return `M${[0, 1, 2, 3, 4, 5].map(at).join('L')}`;
}
