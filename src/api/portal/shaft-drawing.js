// A shaft to scale with what sits on it. Items with a place move by pointer or by keys; a click or Enter leads to their fields.

import { h, s } from './dom.js';
import { number, quantity } from './format.js';
import * as housing from './housing-drawing.js';
import { finite, LETTER, mayLieBeyond, mountAt, SPRING } from './housing-drawing.js';
import { read } from './request.js';
import { dimensions, isRigid, lengthOf, listAt, sectionsOf } from './shaft-request.js';

const PAD = 26;
/** Largest half height of the drawing, without marks [px]. */
const MOST_HALF = 120;
/** Room above the shaft for names of bearings and marks of sensors, and below it for dimensions [px]. */
const ABOVE = 32;
const BELOW = 70;
/** Height of the names of bearings, of the first row of those of sensors, and of a row [px]. */
const NAMES = { bearing: 14, sensor: 30, row: 15 };
/** Largest place of a rigid spindle [mm]. */
const LONGEST = 20000;
/** Change of a place by a key [mm]. */
const KEYS = { ArrowRight: 1, ArrowLeft: -1, PageUp: 10, PageDown: -10 };
/** Pointer movement from which on an item moves [px]. */
const MOVE_FROM = 4;

const within = (value, least, most) => Math.min(Math.max(value, least), most);
/** Name and direction of a sensor. */
const sensorText = ({ name, direction }) => `${name} ${direction}`;

export class ShaftDrawing {
  /** `move(pointer, at_mm)`, `choose(pointer)` and `remove(list, index)` are actions of the form. */
  constructor(host, { presets, move, choose, remove }) {
    Object.assign(this, { host, presets, move, choose, remove });
    this.place = h('div', { class: 'shaft-drawing' });
    host.replaceChildren(
      h(
        'figure',
        {},
        this.place,
        h(
          'figcaption',
          {},
          'To scale, mm. Drag an item or move it with the arrow keys; Enter or a click leads to its fields, Delete removes it. Dash-dotted: lines of contact and their pressure centres. Dashed frames: bodies of the housing, as far as they reach along the shaft.',
        ),
      ),
    );
    new ResizeObserver(() => this.#fit()).observe(this.place);
  }

  show(request) {
    this.request = request;
    this.#draw();
  }

  #fit() {
    if (this.place.clientWidth && this.place.clientWidth !== this.width) this.#draw();
  }

  #draw() {
    const width = this.place.clientWidth;
    const length = lengthOf(this.request);
    if (!width || !(length > 0)) return;
    this.width = width;
    const sections = sectionsOf(this.request, this.presets);
    const discs = listAt(this.request, '/scene/shaft/discs').map(solid);
    const bearings = listAt(this.request, '/scene/bearings').map(({ bearing }) => dimensions(bearing, this.presets));
    const widths = bearings.map((bearing) => bearing.width_mm);
    const bodies = housing.bodiesOf(this.request, widths);
    const radii = [
      ...sections.map((section) => finite(section.outer_diameter_mm) / 2),
      ...discs.map(({ radius }) => radius),
      ...bearings.map((bearing) => finite(bearing.outer_diameter_mm) / 2),
    ];
    const largest = Math.max(...radii, 1);
    const [from, to] = this.#extent(discs, bearings, bodies, length);
    const scale = Math.min((width - 2 * PAD) / (to - from), MOST_HALF / largest);
    const left = (width - scale * (to - from)) / 2;
    const half = largest * scale;
    const x = (at) => left + scale * (within(at, from, to) - from);
    const rows = this.#rows(x);
    const room = housing.roomOf(bodies);
    const axis = ABOVE + Math.max(1, ...rows.map((row) => row + 1)) * NAMES.row + room.above + half;
    // Ground of mounts and supports.
    const base = axis + half + room.below + SPRING;
    const height = base + BELOW;
    this.frame = { scale, length };
    // A place beyond the shaft is an error of its field; the drawing shows it at the end.
    const view = { x, on: (at) => x(within(finite(at), 0, length)), scale, axis, half, width, base };
    const focused = this.place.contains(document.activeElement) ? document.activeElement.dataset.pointer : null;
    const what = isRigid(this.request) ? 'Rigid spindle' : 'Shaft';
    const holding = bodies.length ? `, housing bodies: ${bodies.map(({ name }) => name).join(', ')}` : '';
    const svg = s(
      'svg',
      {
        viewBox: `0 0 ${width} ${height}`,
        width,
        height,
        role: 'group',
        'aria-label': `${what} of ${quantity(length, 'mm')}, ${quantity(bearings.length, '')} ball bearings${holding}`,
        onpointerdown: (event) => this.#grab(event),
        onkeydown: (event) => this.#key(event),
      },
      this.#leads(bodies, sections, rows, view),
      this.#housing(bodies, view),
      this.#sections(sections, bearings, view),
      s('line', { class: 'axis', x1: x(0) - 14, x2: x(length) + 14, y1: axis, y2: axis }),
      isRigid(this.request) && this.#centre(view),
      discs.map((disc, i) => this.#disc(disc, i, view)),
      bearings.map((bearing, i) => this.#bearing(bearing, i, view)),
      listAt(this.request, '/scene/supports').map((support, i) => this.#support(support, i, bodies, view)),
      listAt(this.request, '/scene/shaft/unbalances').map((unbalance, i) => this.#unbalance(unbalance, i, sections, view)),
      listAt(this.request, '/scene/sensors').map((sensor, i) => this.#sensor(sensor, i, bodies, sections, rows[i], view)),
      this.#measures(sections, view, height),
    );
    this.svg = svg;
    this.place.replaceChildren(svg);
    if (focused) svg.querySelector(`[data-pointer="${focused}"]`)?.focus();
  }

  /** First and last place of the drawing [mm]: the shaft with what reaches beyond it, at most a length to either side. */
  #extent(discs, bearings, bodies, length) {
    const mounts = listAt(this.request, '/scene/housing/mounts').map((mount) => mountAt(mount, bodies));
    const places = [
      ...this.#reaches(discs, bearings).flatMap(([at, half]) => [at - half, at + half]),
      ...bodies.flatMap(({ from, to }) => [from, to]),
      ...mounts,
    ];
    return [Math.max(Math.min(0, ...places), -length), Math.min(Math.max(length, ...places), 2 * length)];
  }

  /** The row of the name of each sensor: the first with room for it. */
  #rows(x) {
    const sensors = listAt(this.request, '/scene/sensors');
    const ends = [];
    const rows = sensors.map(() => 0);
    const byPlace = sensors.map(({ at_mm: at }, i) => [x(finite(at)), i]).sort(([one], [other]) => one - other);
    for (const [place, i] of byPlace) {
      const half = (sensorText(sensors[i]).length * LETTER) / 2 + 3;
      const row = ends.findIndex((end) => end < place - half);
      rows[i] = row < 0 ? ends.length : row;
      ends[rows[i]] = place + half;
    }
    return rows;
  }

  /** Places and half widths of discs and bearings [mm]. */
  #reaches(discs, bearings) {
    const places = listAt(this.request, '/scene/bearings').map(({ at_mm: at }) => finite(at));
    const all = [
      ...discs.map(({ at, width }) => [at, width / 2]),
      ...bearings.map((bearing, i) => [places[i], finite(bearing.width_mm) / 2]),
    ];
    return all.map(([at, half]) => [within(at, 0, lengthOf(this.request)), half]);
  }

  /** A group for an item with a place on the shaft. */
  #item(list, index, name, at, ...shapes) {
    const [least, most] = this.#range(`${list}/${index}`);
    return s(
      'g',
      {
        class: 'movable',
        tabindex: 0,
        role: 'slider',
        'aria-label': `Place of ${name}`,
        'aria-valuemin': Math.round(least),
        'aria-valuemax': Math.round(most),
        'aria-valuenow': at,
        'aria-valuetext': `${number(at, 5)} mm`,
        'data-pointer': `${list}/${index}`,
      },
      s('title', {}, `${name}, ${number(at, 5)} mm`),
      ...shapes,
    );
  }

  #sections(sections, bearings, { x, on, scale, axis }) {
    const places = listAt(this.request, '/scene/bearings').map(({ at_mm: place }) => on(place));
    const isCovered = (place) =>
      places.some((one, i) => Math.abs(one - place) < (finite(bearings[i].width_mm) * scale) / 2 + (3 * LETTER) / 2);
    let at = 0;
    return sections.map((section, i) => {
      const [from, length] = [at, finite(section.length_mm)];
      at += length;
      const [radius, bore] = [section.outer_diameter_mm, section.inner_diameter_mm].map((d) => (finite(d) / 2) * scale);
      const name = `Section ${i + 1}: ${number(length)} mm long, diameter ${number(finite(section.outer_diameter_mm))} mm`;
      const wide = length * scale;
      const isFixed = isRigid(this.request);
      const item = { tabindex: 0, role: 'button', 'aria-label': name, 'data-pointer': `/scene/shaft/sections/${i}` };
      return s(
        'g',
        isFixed ? { class: 'rigid' } : { class: 'section', ...item },
        s('title', {}, isFixed ? 'Rigid spindle' : name),
        s('rect', { class: 'body', x: x(from), y: axis - radius, width: Math.max(wide, 0), height: 2 * radius }),
        bore > 0 && s('rect', { class: 'bore', x: x(from), y: axis - bore, width: Math.max(wide, 0), height: 2 * bore }),
        // Within the lower wall, where it has the room.
        !isFixed &&
          wide > 34 &&
          !isCovered(x(from) + wide / 2) &&
          radius - bore > 14 &&
          s(
            'text',
            { x: x(from) + wide / 2, y: axis + (radius + bore) / 2 + 4, 'text-anchor': 'middle' },
            `⌀${number(finite(section.outer_diameter_mm))}`,
          ),
      );
    });
  }

  /** A solid disc with the same mass and inertia. */
  #disc({ at, radius, width, mass }, i, { on, scale, axis }) {
    const [r, w] = [Math.max(radius * scale, 9), Math.max(width * scale, 5)];
    return this.#item(
      '/scene/shaft/discs',
      i,
      `disc ${i + 1}, ${number(mass)} kg`,
      at,
      s('rect', { class: 'disc', x: on(at) - w / 2, y: axis - r, width: w, height: 2 * r }),
    );
  }

  #bearing(bearing, i, view) {
    const { scale, axis } = view;
    const { at_mm: place, name, faces, outer_ring: ring = {} } = listAt(this.request, '/scene/bearings')[i];
    const at = finite(place);
    const middle = view.on(at);
    const mm = (field) => finite(bearing[field]) * scale;
    const [outer, bore, pitch, ball, width] = [
      'outer_diameter_mm',
      'inner_diameter_mm',
      'pitch_diameter_mm',
      'ball_diameter_mm',
      'width_mm',
    ].map(mm);
    const angle = (finite(bearing.contact_angle_deg) * Math.PI) / 180;
    const sense = faces === '-x' ? -1 : 1;
    const lean = sense * Math.tan(angle);
    const half = (from, to, side) =>
      s('rect', {
        class: 'ring',
        x: middle - width / 2,
        y: axis + (side < 0 ? -to : from),
        width,
        height: Math.max(to - from, 1),
      });
    const shapes = [-1, 1].flatMap((side) => {
      const centre = axis + (side * pitch) / 2;
      const reach = Math.max(outer / 2 - pitch / 2, ball / 2);
      return [
        half(pitch / 2 + ball * 0.22, outer / 2, side),
        half(bore / 2, pitch / 2 - ball * 0.22, side),
        s('circle', { class: 'ball', cx: middle, cy: centre, r: ball / 2 }),
        // The line of contact from the pressure centre on the axis to the outside of the outer ring.
        angle > 0 &&
          s('line', {
            class: 'contact',
            x1: middle - (lean * pitch) / 2,
            y1: axis,
            x2: middle + lean * reach,
            y2: centre + side * reach,
          }),
      ];
    });
    return this.#item(
      '/scene/bearings',
      i,
      `bearing ${name}${housing.seatName(ring)}`,
      at,
      shapes,
      housing.seatShapes(ring, middle, { outer, height: outer / 2 - pitch / 2 - ball * 0.22, width, sense }, axis),
      s('text', { class: 'name', x: middle, y: NAMES.bearing, 'text-anchor': 'middle' }, name),
    );
  }

  #support(support, i, bodies, view) {
    const { at_mm: at, on } = support;
    const name = `support ${i + 1}${on ? `, on ${on}` : ''}`;
    return this.#item('/scene/supports', i, name, finite(at), housing.supportShapes(support, view.on(at), bodies, view));
  }

  /** Bodies as frames around what they hold, and their mounts to the ground or to each other. */
  #housing(bodies, view) {
    const frames = bodies.map((body, i) => {
      const label = `${body.name}, ${number(body.mass)} kg`;
      return {
        level: body.level,
        item: this.#item('/scene/housing/bodies', i, `body ${label}`, body.at, housing.bodyShapes(body, label, view)),
      };
    });
    const mounts = listAt(this.request, '/scene/housing/mounts').map((mount, i) => {
      const name = `mount of ${mount.body} ${mount.to ? `to ${mount.to}` : 'to the ground'}`;
      return this.#item('/scene/housing/mounts', i, name, mountAt(mount, bodies), housing.mountShapes(mount, bodies, view));
    });
    // An outer frame would cover an inner one.
    return [frames.sort((one, other) => other.level - one.level).map(({ item }) => item), mounts];
  }

  /** The mass centre of a rigid spindle. */
  #centre({ x, axis }) {
    const { centre_mm: given } = this.request.scene.spindle ?? {};
    const places = listAt(this.request, '/scene/bearings').map(({ at_mm: at }) => finite(at));
    const at = finite(given, (Math.min(...places) + Math.max(...places)) / 2);
    return s('g', {}, s('title', {}, `Mass centre, ${number(at, 5)} mm`), housing.massCentre(x(at), axis));
  }

  #unbalance({ at_mm: place, unbalance_g_mm: size, phase_deg: phase }, i, sections, { on, scale, axis }) {
    const at = finite(place);
    const radius = radiusAt(sections, at) * scale;
    // +Y is down: the mark shows the height of the heavy spot.
    const y = axis + radius * 0.82 * Math.cos((finite(phase) * Math.PI) / 180);
    return this.#item(
      '/scene/shaft/unbalances',
      i,
      `unbalance ${i + 1}, ${number(finite(size))} g·mm`,
      at,
      s('circle', { class: 'heavy', cx: on(at), cy: y, r: 4.5 }),
    );
  }

  /** Lines from the names of sensors to their marks. */
  #leads(bodies, sections, rows, view) {
    const lines = listAt(this.request, '/scene/sensors').map((sensor, i) => {
      const { x, tip } = this.#sensorPlace(sensor, bodies, sections, view);
      return s('line', { class: 'lead', x1: x, x2: x, y1: NAMES.sensor + 4 + NAMES.row * rows[i], y2: tip - 9 });
    });
    return s('g', { 'aria-hidden': 'true' }, lines);
  }

  #sensorPlace(sensor, bodies, sections, view) {
    const at = finite(sensor.at_mm);
    const surface = view.axis - radiusAt(sections, at) * view.scale - 1;
    const x = mayLieBeyond('/scene/sensors', sensor) ? view.x(at) : view.on(at);
    return { x, ...housing.sensorTips(sensor, bodies, surface, view) };
  }

  #sensor(sensor, i, bodies, sections, row, view) {
    const { x, tip, from } = this.#sensorPlace(sensor, bodies, sections, view);
    return this.#item(
      '/scene/sensors',
      i,
      housing.sensorName(sensor),
      finite(sensor.at_mm),
      from !== undefined && s('path', { class: 'from', d: `M${x} ${tip}V${from}M${x - 5} ${from}h10` }),
      s('path', { class: 'sensor', d: `M${x} ${tip}l-5 -9h10z` }),
      s('text', { class: 'tag', x, y: NAMES.sensor + NAMES.row * row, 'text-anchor': 'middle' }, sensorText(sensor)),
    );
  }

  /** Lengths of the sections, and below them the places of bearings and supports. Numbers without room are left out. */
  #measures(sections, { x, base }, height) {
    const rows = [base + 26, height - 16];
    const marks = [];
    let [at, free] = [0, -Infinity];
    const bounds = [0, ...sections.map((section) => (at += finite(section.length_mm)))];
    const text = (place, y, value) => {
      const room = `${value}`.length * 7 + 4;
      if (place - room / 2 < free) return null;
      free = place + room / 2;
      return s('text', { class: 'dimension', x: place, y, 'text-anchor': 'middle' }, value);
    };
    bounds.slice(1).forEach((to, i) => {
      const [a, b] = [x(bounds[i]), x(to)];
      marks.push(s('path', { class: 'measure-line', d: `M${a} ${rows[0] - 5}v10M${b} ${rows[0] - 5}v10M${a} ${rows[0]}H${b}` }));
      marks.push(text((a + b) / 2, rows[0] - 4, number(to - bounds[i])));
    });
    free = -Infinity;
    const places = [...listAt(this.request, '/scene/bearings'), ...listAt(this.request, '/scene/supports')]
      .map(({ at_mm: place }) => finite(place))
      .concat(at)
      .sort((one, other) => one - other);
    marks.push(s('path', { class: 'measure-line', d: `M${x(0)} ${rows[1] - 5}v10M${x(0)} ${rows[1]}H${x(at)}` }));
    for (const place of places) {
      marks.push(s('path', { class: 'measure-line', d: `M${x(place)} ${rows[1] - 5}v10` }));
      marks.push(text(x(place), rows[1] - 7, number(place, 5)));
    }
    return s('g', { 'aria-hidden': 'true' }, marks);
  }

  #key(event) {
    const { pointer } = event.target.closest?.('[data-pointer]')?.dataset ?? {};
    if (!pointer) return;
    const [list, index] = split(pointer);
    if (event.key === 'Enter' || event.key === ' ') this.choose(pointer);
    else if (event.key === 'Delete') this.remove(list, index);
    else if (KEYS[event.key] && !list.endsWith('sections')) this.#to(pointer, this.#at(pointer) + KEYS[event.key]);
    else return;
    event.preventDefault();
  }

  /** Place of an item [mm]; a mount without one stands at its body. */
  #at(pointer) {
    const item = read(this.request, pointer);
    const bodies = listAt(this.request, '/scene/housing/bodies').map(({ name, at_mm: at }) => ({ name, at: finite(at) }));
    return pointer.startsWith('/scene/housing/mounts') ? mountAt(item, bodies) : finite(item.at_mm);
  }

  /** Least and largest place to which an item moves [mm]. */
  #range(pointer) {
    const { length } = this.frame;
    const at = this.#at(pointer);
    if (mayLieBeyond(pointer, read(this.request, pointer))) return [Math.min(-length, at), Math.max(2 * length, at)];
    return [0, isRigid(this.request) ? LONGEST : length];
  }

  #to(pointer, at) {
    this.move(pointer, within(at, ...this.#range(pointer)));
  }

  #grab(event) {
    const group = event.target.closest?.('[data-pointer]');
    if (!group) return;
    event.preventDefault();
    const { pointer } = group.dataset;
    const isSection = pointer.startsWith('/scene/shaft/sections');
    // The scale of the start: an item that leaves the drawing changes it.
    const start = {
      x: event.clientX,
      at: isSection ? 0 : this.#at(pointer),
      scale: this.frame.scale,
      moved: isSection ? null : false,
    };
    const move = ({ clientX }) => {
      if (start.moved === null || (!start.moved && Math.abs(clientX - start.x) < MOVE_FROM)) return;
      start.moved = true;
      this.#to(pointer, Math.round(start.at + (clientX - start.x) / start.scale));
    };
    const stop = ({ type }) => {
      removeEventListener('pointermove', move);
      removeEventListener('pointerup', stop);
      removeEventListener('pointercancel', stop);
      if (!start.moved && type === 'pointerup') this.choose(pointer);
    };
    addEventListener('pointermove', move);
    addEventListener('pointerup', stop);
    addEventListener('pointercancel', stop);
  }
}

/** List and index of the pointer to an item. */
function split(pointer) {
  const end = pointer.lastIndexOf('/');
  return [pointer.slice(0, end), Number(pointer.slice(end + 1))];
}

/** Radius of the shaft at a place [mm]. */
function radiusAt(sections, place) {
  let end = 0;
  const found = sections.find((section) => (end += finite(section.length_mm)) >= place);
  return finite((found ?? sections.at(-1))?.outer_diameter_mm) / 2;
}

/** Radius and width of the solid disc of the same mass and inertia [mm]. */
function solid({ at_mm: at, mass_kg: mass, axial_inertia_kg_m2: axial, transverse_inertia_kg_m2: across }) {
  const m = finite(mass);
  const radius = m > 0 ? Math.sqrt((2 * finite(axial)) / m) : 0;
  const square = m > 0 ? (12 * finite(across)) / m - 3 * radius ** 2 : 0;
  return { at: finite(at), mass: m, radius: radius * 1000, width: Math.sqrt(Math.max(square, 0)) * 1000 };
}
