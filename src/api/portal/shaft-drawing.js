// A shaft to scale with what sits on it. Items with a place move by pointer or by keys; a click or Enter leads to their fields.

import { h, s } from './dom.js';
import { number, quantity } from './format.js';
import { dimensions, lengthOf, listAt } from './shaft-request.js';

const PAD = 26;
/** Largest half height of the drawing, without marks [px]. */
const MOST_HALF = 120;
/** Room above the shaft for names, and below it for supports and dimensions [px]. */
const ABOVE = 46;
const BELOW = 88;
/** Rows of names [px]. */
const NAMES = { bearing: 14, sensor: 30 };
/** Change of a place by a key [mm]. */
const KEYS = { ArrowRight: 1, ArrowLeft: -1, PageUp: 10, PageDown: -10 };
/** Pointer movement from which on an item moves [px]. */
const MOVE_FROM = 4;

/** A number of the request, which may still be text or missing. */
const finite = (value, fallback = 0) => (Number.isFinite(value) ? value : fallback);

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
          'To scale, mm. Drag an item or move it with the arrow keys; Enter or a click leads to its fields, Delete removes it. Dash-dotted: lines of contact and their pressure centres.',
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
    const sections = listAt(this.request, '/scene/shaft/sections');
    const discs = listAt(this.request, '/scene/shaft/discs').map(solid);
    const bearings = listAt(this.request, '/scene/bearings').map(({ bearing }) => dimensions(bearing, this.presets));
    const radii = [
      ...sections.map((section) => finite(section.outer_diameter_mm) / 2),
      ...discs.map(({ radius }) => radius),
      ...bearings.map((bearing) => finite(bearing.outer_diameter_mm) / 2),
    ];
    const largest = Math.max(...radii, 1);
    // Discs and bearings at the ends reach beyond the shaft.
    const before = Math.max(0, ...this.#reaches(discs, bearings).map(([at, half]) => half - at));
    const after = Math.max(0, ...this.#reaches(discs, bearings).map(([at, half]) => at + half - length));
    const scale = Math.min((width - 2 * PAD) / (length + before + after), MOST_HALF / largest);
    const left = (width - scale * (length + before + after)) / 2 + scale * before;
    const half = largest * scale;
    const axis = ABOVE + half;
    const height = ABOVE + 2 * half + BELOW;
    this.frame = { left, scale, length };
    // A place beyond the shaft is an error of its field; the drawing shows it at the end.
    const view = { x: (at) => left + scale * Math.min(Math.max(at, 0), length), scale, axis, half, width };
    const focused = this.place.contains(document.activeElement) ? document.activeElement.dataset.pointer : null;
    const svg = s(
      'svg',
      {
        viewBox: `0 0 ${width} ${height}`,
        width,
        height,
        role: 'group',
        'aria-label': `Shaft of ${quantity(length, 'mm')}, ${quantity(bearings.length, '')} ball bearings`,
        onpointerdown: (event) => this.#grab(event),
        onkeydown: (event) => this.#key(event),
      },
      this.#sections(sections, view),
      this.#housing(bearings, view),
      s('line', { class: 'axis', x1: view.x(0) - 14, x2: view.x(length) + 14, y1: axis, y2: axis }),
      discs.map((disc, i) => this.#disc(disc, i, view)),
      bearings.map((bearing, i) => this.#bearing(bearing, i, view)),
      listAt(this.request, '/scene/supports').map((support, i) => this.#support(support, i, view)),
      listAt(this.request, '/scene/shaft/unbalances').map((unbalance, i) => this.#unbalance(unbalance, i, sections, view)),
      listAt(this.request, '/scene/sensors').map((sensor, i) => this.#sensor(sensor, i, sections, view)),
      this.#measures(sections, view, height),
    );
    this.svg = svg;
    this.place.replaceChildren(svg);
    if (focused) svg.querySelector(`[data-pointer="${focused}"]`)?.focus();
  }

  /** Places and half widths of discs and bearings [mm]. */
  #reaches(discs, bearings) {
    const places = listAt(this.request, '/scene/bearings').map(({ at_mm: at }) => finite(at));
    const all = [
      ...discs.map(({ at, width }) => [at, width / 2]),
      ...bearings.map((bearing, i) => [places[i], finite(bearing.width_mm) / 2]),
    ];
    return all.map(([at, half]) => [Math.min(Math.max(at, 0), lengthOf(this.request)), half]);
  }

  /** A group for an item with a place on the shaft. */
  #item(list, index, name, at, ...shapes) {
    return s(
      'g',
      {
        class: 'movable',
        tabindex: 0,
        role: 'slider',
        'aria-label': `Place of ${name}`,
        'aria-valuemin': 0,
        'aria-valuemax': Math.round(this.frame.length),
        'aria-valuenow': at,
        'aria-valuetext': `${number(at, 5)} mm`,
        'data-pointer': `${list}/${index}`,
      },
      s('title', {}, `${name}, ${number(at, 5)} mm`),
      ...shapes,
    );
  }

  #sections(sections, { x, scale, axis }) {
    let at = 0;
    return sections.map((section, i) => {
      const [from, length] = [at, finite(section.length_mm)];
      at += length;
      const [radius, bore] = [section.outer_diameter_mm, section.inner_diameter_mm].map((d) => (finite(d) / 2) * scale);
      const name = `Section ${i + 1}: ${number(length)} mm long, diameter ${number(finite(section.outer_diameter_mm))} mm`;
      const wide = length * scale;
      return s(
        'g',
        { class: 'section', tabindex: 0, role: 'button', 'aria-label': name, 'data-pointer': `/scene/shaft/sections/${i}` },
        s('title', {}, name),
        s('rect', { class: 'body', x: x(from), y: axis - radius, width: Math.max(wide, 0), height: 2 * radius }),
        bore > 0 && s('rect', { class: 'bore', x: x(from), y: axis - bore, width: Math.max(wide, 0), height: 2 * bore }),
        // Within the lower wall, where it has the room.
        wide > 34 &&
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
  #disc({ at, radius, width, mass }, i, { x, scale, axis }) {
    const [r, w] = [Math.max(radius * scale, 9), Math.max(width * scale, 5)];
    return this.#item(
      '/scene/shaft/discs',
      i,
      `disc ${i + 1}, ${number(mass)} kg`,
      at,
      s('rect', { class: 'disc', x: x(at) - w / 2, y: axis - r, width: w, height: 2 * r }),
    );
  }

  #bearing(bearing, i, view) {
    const { x, scale, axis } = view;
    const { at_mm: place, name, faces } = listAt(this.request, '/scene/bearings')[i];
    const at = finite(place);
    const mm = (field) => finite(bearing[field]) * scale;
    const [outer, bore, pitch, ball, width] = [
      'outer_diameter_mm',
      'inner_diameter_mm',
      'pitch_diameter_mm',
      'ball_diameter_mm',
      'width_mm',
    ].map(mm);
    const angle = (finite(bearing.contact_angle_deg) * Math.PI) / 180;
    const lean = (faces === '-x' ? -1 : 1) * Math.tan(angle);
    const ring = (from, to, side) =>
      s('rect', {
        class: 'ring',
        x: x(at) - width / 2,
        y: axis + (side < 0 ? -to : from),
        width,
        height: Math.max(to - from, 1),
      });
    const shapes = [-1, 1].flatMap((side) => {
      const middle = axis + (side * pitch) / 2;
      const reach = Math.max(outer / 2 - pitch / 2, ball / 2);
      return [
        ring(pitch / 2 + ball * 0.22, outer / 2, side),
        ring(bore / 2, pitch / 2 - ball * 0.22, side),
        s('circle', { class: 'ball', cx: x(at), cy: middle, r: ball / 2 }),
        // The line of contact from the pressure centre on the axis to the outside of the outer ring.
        angle > 0 &&
          s('line', {
            class: 'contact',
            x1: x(at) - (lean * pitch) / 2,
            y1: axis,
            x2: x(at) + lean * reach,
            y2: middle + side * reach,
          }),
      ];
    });
    return this.#item(
      '/scene/bearings',
      i,
      `bearing ${name}`,
      at,
      shapes,
      s('text', { class: 'name', x: x(at), y: NAMES.bearing, 'text-anchor': 'middle' }, name),
    );
  }

  #support({ at_mm: place }, i, { x, axis, half }) {
    const at = finite(place);
    const top = axis + half + 4;
    return this.#item(
      '/scene/supports',
      i,
      `support ${i + 1}`,
      at,
      s('line', { class: 'lead', x1: x(at), x2: x(at), y1: axis, y2: top }),
      spring(x(at), top),
    );
  }

  /** Bodies as frames around what they hold, and their mounts to the ground. */
  #housing(bearings, view) {
    const { x, axis, half } = view;
    const seats = listAt(this.request, '/scene/bearings').map(({ outer_ring: ring, at_mm: at }, i) => [
      ring?.on,
      finite(at),
      finite(bearings[i].width_mm) / 2,
    ]);
    const supports = listAt(this.request, '/scene/supports').map(({ on, at_mm: at }) => [on, finite(at), 4]);
    const bodies = listAt(this.request, '/scene/housing/bodies').map(({ name, at_mm: place, mass_kg: mass }, i) => {
      const at = finite(place);
      const held = [...seats, ...supports]
        .filter(([on]) => on === name)
        .flatMap(([, one, reach]) => [one - reach, one + reach]);
      const [from, to] = [Math.min(...held, at - 8), Math.max(...held, at + 8)];
      const [left, right] = [x(from) - 5, x(to) + 5];
      return this.#item(
        '/scene/housing/bodies',
        i,
        `body ${name}, ${number(finite(mass))} kg`,
        at,
        s('rect', { class: 'housing', x: left, y: axis - half - 5, width: right - left, height: 2 * half + 10, rx: 4 }),
        s('path', { class: 'centre', d: `M${x(at) - 5} ${axis - half - 5}h10M${x(at)} ${axis - half - 10}v10` }),
        s('text', { class: 'soft', x: left + 4, y: axis - half + 9 }, name),
      );
    });
    const mounts = listAt(this.request, '/scene/housing/mounts').map(({ body, at_mm: place }, i) => {
      const at = finite(place);
      return this.#item('/scene/housing/mounts', i, `mount of ${body}`, at, spring(x(at), axis + half + 4));
    });
    return [bodies, mounts];
  }

  #unbalance({ at_mm: place, unbalance_g_mm: size, phase_deg: phase }, i, sections, { x, scale, axis }) {
    const at = finite(place);
    const radius = radiusAt(sections, at) * scale;
    // +Y is down: the mark shows the height of the heavy spot.
    const y = axis + radius * 0.82 * Math.cos((finite(phase) * Math.PI) / 180);
    return this.#item(
      '/scene/shaft/unbalances',
      i,
      `unbalance ${i + 1}, ${number(finite(size))} g·mm`,
      at,
      s('circle', { class: 'heavy', cx: x(at), cy: y, r: 4.5 }),
    );
  }

  #sensor({ at_mm: place, name, direction }, i, sections, { x, scale, axis }) {
    const at = finite(place);
    const tip = axis - radiusAt(sections, at) * scale - 1;
    return this.#item(
      '/scene/sensors',
      i,
      `sensor ${name}, ${direction}`,
      at,
      s('line', { class: 'lead', x1: x(at), x2: x(at), y1: NAMES.sensor + 4, y2: tip - 9 }),
      s('path', { class: 'sensor', d: `M${x(at)} ${tip}l-5 -9h10z` }),
      s('text', { x: x(at), y: NAMES.sensor, 'text-anchor': 'middle' }, `${name} ${direction}`),
    );
  }

  /** Lengths of the sections, and below them the places of bearings and supports. Numbers without room are left out. */
  #measures(sections, { x, axis, half }, height) {
    const rows = [axis + half + 44, height - 16];
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
      marks.push(
        s('path', { class: 'measure-line', d: `M${a} ${rows[0] - 5}v10M${b} ${rows[0] - 5}v10M${a} ${rows[0]}H${b}` }),
      );
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
    else if (KEYS[event.key] && !list.endsWith('sections'))
      this.#to(pointer, finite(listAt(this.request, list)[index].at_mm) + KEYS[event.key]);
    else return;
    event.preventDefault();
  }

  #to(pointer, at) {
    this.move(pointer, Math.min(Math.max(at, 0), this.frame.length));
  }

  #grab(event) {
    const group = event.target.closest?.('[data-pointer]');
    if (!group) return;
    event.preventDefault();
    const { pointer } = group.dataset;
    const [list, index] = split(pointer);
    const start = {
      x: event.clientX,
      at: finite(listAt(this.request, list)[index].at_mm),
      moved: list.endsWith('sections') ? null : false,
    };
    const move = ({ clientX }) => {
      if (start.moved === null || (!start.moved && Math.abs(clientX - start.x) < MOVE_FROM)) return;
      start.moved = true;
      this.#to(pointer, Math.round(start.at + (clientX - start.x) / this.frame.scale));
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

/** A spring to the ground. */
function spring(x, top) {
  const turns = [0, 1, 2, 3, 4].map((k) => `${x + (k % 2 ? 4 : -4)} ${top + 3 * k}`).join('L');
  return [s('path', { class: 'spring', d: `M${turns}` }), s('path', { class: 'ground', d: `M${x - 9} ${top + 14}h18` })];
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
