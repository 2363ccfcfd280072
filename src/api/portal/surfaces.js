// The surfaces of the raceways: a drawing on which defects are placed, their fields and what a ball does there, and waviness.

import { bearingShapes } from './derived.js';
import { button, h, labelled, more, options, s, select, small, tools } from './dom.js';
import { help, schemaAt } from './fields.js';
import { field, Fields, idOf, textInput } from './form.js';
import { number, quantity, words } from './format.js';
import { read, write } from './request.js';

const SURFACES = '/scene/surfaces';
const RINGS = ['outer', 'inner'];
/** A new defect: one that the balls of most bearings feel. */
const NEW_DEFECT = { azimuth_deg: 0, length_mm: 1, depth_um: 10 };
const NEW_WAVE = { order: 10, amplitude_nm: 10 };

const DEFECT_FIELDS = [
  ['azimuth_deg', 'Azimuth', '°'],
  ['length_mm', 'Length', 'mm'],
  ['width_mm', 'Width', 'mm', 'whole'],
  ['depth_um', 'Depth', 'µm'],
];
const WAVE_FIELDS = [
  ['order', 'Order', ''],
  ['amplitude_nm', 'Amplitude', 'nm'],
  ['phase_deg', 'Phase', '°'],
];
/** Change of the azimuth by a key [°]. */
const KEYS = { ArrowRight: 1, ArrowUp: 1, ArrowLeft: -1, ArrowDown: -1, PageUp: 10, PageDown: -10 };

const listOf = (job, ring, kind) => read(job, `${SURFACES}/${ring}/${kind}`) ?? [];
/** An azimuth from −179° to 180°. */
const wrapped = (degrees) => {
  const turn = ((degrees % 360) + 360) % 360;
  return turn > 180 ? turn - 360 : turn;
};

export class SurfacesForm {
  #fields = new Fields();

  /** `onChange(job)` gets every changed request; `compare()` runs the scene with and without its surfaces. */
  constructor({ document: openapi, presets, onChange, compare }) {
    Object.assign(this, { openapi, onChange });
    const qualities = Object.entries(presets.surfaces ?? {});
    this.preset = select([['', 'none'], ...qualities.map(([name]) => [name, name])], (value) =>
      this.#change(write(this.job, `${SURFACES}/preset`, value || undefined)),
    );
    this.preset.id = 'surfaces-preset';
    this.preset.setAttribute('aria-describedby', 'surfaces-preset-note');
    this.presetNote = h('p', { id: 'surfaces-preset-note', class: 'note' });
    this.qualities = Object.fromEntries(qualities);
    this.place = h('div', { class: 'placing' });
    this.lists = h('div', {});
    this.error = h('p', { class: 'error', role: 'status' });
    this.both = button('Run with and without', () => compare(), { class: 'small', disabled: true });
    this.element = h(
      'details',
      { class: 'group', id: 'surfaces' },
      h('summary', {}, 'Surfaces'),
      h('div', { class: 'field wide' }, h('label', { for: 'surfaces-preset' }, 'Quality of both raceways'), this.preset, this.presetNote),
      this.place,
      this.error,
      this.lists,
      tools(this.both),
    );
  }

  /** Whether a field contains text that is not a number. */
  get unreadable() {
    return this.#fields.unreadable;
  }

  /** Shows a request. The field that is being edited keeps its text. */
  show(job) {
    this.job = job;
    const preset = read(job, `${SURFACES}/preset`);
    this.preset.value = preset ?? '';
    this.presetNote.textContent = this.qualities[preset]?.description ?? '';
    this.preset.closest('.field').classList.toggle('edited', preset !== undefined);
    this.both.disabled = read(job, SURFACES) === undefined;
    const shape = JSON.stringify(RINGS.map((ring) => ['defects', 'waviness'].map((kind) => listOf(job, ring, kind).length)));
    if (shape !== this.shape) {
      this.shape = shape;
      this.#build();
      if (!this.element.open && this.#any()) this.element.open = true;
    }
    for (const [pointer, { input }] of this.#fields) {
      const value = read(job, pointer);
      if (!this.#fields.isUnreadable(pointer) && document.activeElement !== input) input.value = value ?? '';
    }
    this.#draw();
  }

  /** Shows the defaults of empty fields, and what a ball does at each defect. */
  showDefaults(resolved) {
    this.resolved = resolved;
    for (const [pointer, { input, fallback }] of this.#fields) {
      const value = read(resolved, pointer);
      if (input.tagName === 'INPUT') input.placeholder = typeof value === 'number' ? number(value, 5) : (fallback ?? '');
    }
    for (const ring of RINGS) {
      const derived = resolved.derived.surfaces?.[ring];
      // The service lists defects with a depth only.
      const felt = [...(derived?.defects ?? [])];
      listOf(resolved, ring, 'defects').forEach(({ depth_um: depth }, i) => {
        this.facts[ring][i]?.replaceChildren(...facts(depth > 0 ? felt.shift() : undefined));
      });
      this.waves[ring].replaceChildren(...waveFacts(derived));
    }
    this.#draw();
  }

  /** Shows errors at their fields, others of the surfaces above the lists. Returns those that concern other parts. */
  showErrors(errors) {
    const own = errors.filter(({ pointer }) => pointer.startsWith(SURFACES));
    const { places } = this.#fields.showErrors(own, (pointer) => pointer === SURFACES);
    this.error.textContent = (places.get(SURFACES) ?? []).join('\n');
    if (own.length || this.unreadable) this.element.open = true;
    return errors.filter((error) => !own.includes(error));
  }

  #any() {
    return this.preset.value !== '' || RINGS.some((ring) => ['defects', 'waviness'].some((kind) => listOf(this.job, ring, kind).length));
  }

  #change(job) {
    this.show(job);
    this.onChange(job);
  }

  #setList(ring, kind, list) {
    return write(this.job, `${SURFACES}/${ring}/${kind}`, list.length ? list : undefined);
  }

  #add(ring, kind, item) {
    const list = [...listOf(this.job, ring, kind), item];
    this.selected = kind === 'defects' ? { ring, index: list.length - 1 } : this.selected;
    this.#change(this.#setList(ring, kind, list));
    const field = kind === 'defects' ? 'azimuth_deg' : 'order';
    document.getElementById(idOf('f', `${SURFACES}/${ring}/${kind}/${list.length - 1}/${field}`))?.focus();
  }

  #remove(ring, kind, index) {
    const list = listOf(this.job, ring, kind).filter((_, i) => i !== index);
    this.selected = null;
    // Indices move: every field is built anew.
    this.shape = '';
    this.#change(this.#setList(ring, kind, list));
    this.adders[kind][ring].focus();
  }

  #setItem(ring, kind, index, changes) {
    this.#change(this.#withItem(ring, kind, index, changes));
  }

  #build() {
    this.#fields.forget();
    this.facts = { outer: [], inner: [] };
    this.waves = { outer: h('p', { class: 'note' }), inner: h('p', { class: 'note' }) };
    this.adders = { defects: {}, waviness: {} };
    const adder = (kind, ring, item, text) => {
      this.adders[kind][ring] = small(text, () => this.#add(ring, kind, item));
      return this.adders[kind][ring];
    };
    const defects = RINGS.flatMap((ring) => listOf(this.job, ring, 'defects').map((_, i) => this.#defect(ring, i)));
    this.lists.replaceChildren(
      ...defects,
      tools(RINGS.map((ring) => adder('defects', ring, NEW_DEFECT, `Add ${ring} defect`))),
      ...RINGS.map((ring) => {
        const rows = listOf(this.job, ring, 'waviness').map((_, i) => this.#wave(ring, i));
        const amplitude = this.#number(`${SURFACES}/${ring}/random_waviness/amplitude_nm`, 'Random waviness', 'nm', {
          fallback: 'none',
          change: (value) => write(this.job, `${SURFACES}/${ring}/random_waviness`, value === undefined ? undefined : { ...read(this.job, `${SURFACES}/${ring}/random_waviness`), amplitude_nm: value }),
        });
        const head = `Waviness, ${ring} raceway`;
        const group = more(
          rows.length ? `${head}: ${rows.length}` : head,
          h('div', { class: 'fields' }, amplitude),
          ...rows,
          tools(adder('waviness', ring, NEW_WAVE, `Add ${ring} wave`)),
          this.waves[ring],
        );
        group.open = rows.length > 0;
        return group;
      }),
    );
  }

  #defect(ring, index) {
    const at = `${SURFACES}/${ring}/defects/${index}`;
    const fields = DEFECT_FIELDS.map(([name, label, unit, fallback]) =>
      this.#number(`${at}/${name}`, label, unit, {
        fallback,
        change: (value) => this.#withItem(ring, 'defects', index, { [name]: value }),
      }),
    );
    const shapes = schemaAt(this.openapi, `${SURFACES}/${ring}/defects`).items?.enum ?? ['rectangular', 'half_sine'];
    const shape = select([['', 'default'], ...shapes.map((name) => [name, words(name)])], (value) =>
      this.#setItem(ring, 'defects', index, { shape: value || undefined }),
    );
    const floor = field({ id: idOf('f', `${at}/shape`), label: 'Floor', input: shape });
    const raceway = select(RINGS.map((name) => [name, `${name} raceway`]), (value) => this.#move(ring, index, value));
    raceway.value = ring;
    const on = field({ id: idOf('f', `${at}/ring`), label: 'On the', input: raceway });
    this.facts[ring][index] = h('dl', { class: 'pairs', 'aria-live': 'polite' });
    return h(
      'fieldset',
      { class: 'item', onfocusin: () => this.#select(ring, index) },
      h('legend', {}, `Defect ${index + 1}, ${ring} raceway`),
      h(
        'div',
        { class: 'fields' },
        ...fields,
        this.#fields.add(`${at}/shape`, floor),
        on.element,
      ),
      this.facts[ring][index],
      small('Remove', () => this.#remove(ring, 'defects', index), { 'aria-label': `Remove defect ${index + 1}, ${ring} raceway` }),
    );
  }

  #wave(ring, index) {
    const at = `${SURFACES}/${ring}/waviness/${index}`;
    const fields = WAVE_FIELDS.map(([name, label, unit]) =>
      this.#number(`${at}/${name}`, label, unit, {
        change: (value) => this.#withItem(ring, 'waviness', index, { [name]: value }),
      }),
    );
    return h(
      'fieldset',
      { class: 'item wave' },
      h('legend', { class: 'unseen' }, `Wave ${index + 1}, ${ring} raceway`),
      h('div', { class: 'fields three' }, ...fields),
      small('Remove', () => this.#remove(ring, 'waviness', index), { 'aria-label': `Remove wave ${index + 1}, ${ring} raceway` }),
    );
  }

  /** The request with changes of an item. */
  #withItem(ring, kind, index, changes) {
    const list = listOf(this.job, ring, kind).map((item, i) => (i === index ? { ...item, ...changes } : item));
    for (const [name, value] of Object.entries(list[index])) if (value === undefined) delete list[index][name];
    return this.#setList(ring, kind, list);
  }

  /** A number; `change(value)` returns the changed request. */
  #number(pointer, label, unit, { change, fallback }) {
    const input = textInput(() => {
      const { value, error } = this.#fields.read(pointer);
      if (error) this.onChange(this.job);
      else this.#change(change(value));
    });
    const parts = pointer.split('/');
    const inList = /^\d+$/.test(parts.at(-2));
    const schema = inList ? itemSchema(this.openapi, parts) : schemaAt(this.openapi, pointer);
    return this.#fields.add(pointer, { ...field({ id: idOf('f', pointer), label, unit, input, help: help(schema) }), fallback });
  }

  /** Moves a defect to the other raceway. */
  #move(from, index, to) {
    if (from === to) return;
    const item = listOf(this.job, from, 'defects')[index];
    const rest = listOf(this.job, from, 'defects').filter((_, i) => i !== index);
    const list = [...listOf(this.job, to, 'defects'), item];
    this.selected = { ring: to, index: list.length - 1 };
    this.shape = '';
    let job = this.#setList(from, 'defects', rest);
    job = write(job, `${SURFACES}/${to}/defects`, list);
    this.#change(job);
    document.getElementById(idOf('f', `${SURFACES}/${to}/defects/${list.length - 1}/ring`))?.focus();
  }

  #select(ring, index) {
    if (this.selected?.ring === ring && this.selected.index === index) return;
    this.selected = { ring, index };
    this.#draw();
  }

  /** The bearing to scale, with each defect on its raceway. A handle moves it by pointer or keys. */
  #draw() {
    if (!this.resolved) return;
    const { shapes, half, rim, raceway, bore } = bearingShapes(this.resolved.scene.bearing, this.resolved.derived.static?.ball_loads_n);
    // An element in use stays: a new one would lose focus and pointer.
    if (!this.svg || this.drawnBearing !== JSON.stringify([half, rim, raceway, bore])) {
      this.drawnBearing = JSON.stringify([half, rim, raceway, bore]);
      this.background = s('g', { 'aria-hidden': 'true' });
      this.marks = s('g', {});
      this.svg = s(
        'svg',
        {
          viewBox: `${-half * 1.03} ${-half * 1.03} ${half * 2.06} ${half * 2.06}`,
          role: 'group',
          'aria-label': 'Bearing to scale, +Y down, with the defects of its raceways',
          onpointerdown: (event) => this.#grab(event),
        },
        this.background,
        this.marks,
      );
      this.handles = new Map();
      this.place.replaceChildren(
        h(
          'figure',
          {},
          this.svg,
          h('figcaption', {}, 'Click a raceway to place a defect; drag its handle or use the arrow keys. 0° is +Y, down; azimuths turn towards +Z, right.'),
        ),
      );
    }
    this.radii = { half, rim, raceway, bore };
    this.background.replaceChildren(...shapes.flat(Infinity).filter(Boolean));
    const kept = new Set();
    for (const ring of RINGS) {
      const radius = ring === 'outer' ? rim : raceway;
      listOf(this.job, ring, 'defects').forEach((defect, index) => {
        const key = `${ring}/${index}`;
        kept.add(key);
        const handle = this.handles.get(key) ?? this.#handle(key, ring, index);
        const azimuth = Number(defect.azimuth_deg ?? 0);
        const on = ring === 'outer' ? (rim + half) / 2 : (raceway + bore / 2) / 2;
        const [x, y] = point(on, azimuth);
        handle.knob.setAttribute('cx', x);
        handle.knob.setAttribute('cy', y);
        handle.knob.setAttribute('r', Math.min(half - rim, raceway - bore / 2) * 0.42);
        const angle = ((Number(defect.length_mm) || 0) / radius) * (90 / Math.PI);
        handle.arc.setAttribute('d', arc(radius, azimuth - angle, azimuth + angle));
        handle.group.setAttribute('aria-valuenow', azimuth);
        handle.group.setAttribute('aria-valuetext', `${number(azimuth, 5)} degrees`);
        const chosen = this.selected?.ring === ring && this.selected.index === index;
        handle.group.setAttribute('class', chosen ? 'defect chosen' : 'defect');
      });
    }
    for (const [key, { group }] of this.handles) {
      if (kept.has(key)) continue;
      group.remove();
      this.handles.delete(key);
    }
  }

  #handle(key, ring, index) {
    const [knob, path] = [s('circle', { class: 'knob' }), s('path', { class: 'recess' })];
    const group = s(
      'g',
      {
        tabindex: 0,
        role: 'slider',
        'aria-label': `Azimuth of defect ${index + 1}, ${ring} raceway`,
        'aria-valuemin': -180,
        'aria-valuemax': 180,
        onfocus: () => this.#select(ring, index),
        onkeydown: (event) => this.#key(event, ring, index),
      },
      path,
      knob,
    );
    const handle = { group, knob, arc: path };
    group.dataset.key = key;
    this.handles.set(key, handle);
    this.marks.append(group);
    return handle;
  }

  #key(event, ring, index) {
    const azimuth = Number(listOf(this.job, ring, 'defects')[index]?.azimuth_deg ?? 0);
    if (event.key === 'Delete') {
      event.preventDefault();
      this.#remove(ring, 'defects', index);
      return;
    }
    const to = event.key === 'Home' ? 0 : KEYS[event.key] && wrapped(azimuth + KEYS[event.key]);
    if (to === undefined) return;
    event.preventDefault();
    this.#setItem(ring, 'defects', index, { azimuth_deg: to });
  }

  /** Place of a pointer: azimuth in whole degrees, and radius in the units of the drawing. */
  #pointer({ clientX, clientY }) {
    const { left, top, width, height } = this.svg.getBoundingClientRect();
    const [x, y] = [clientX - left - width / 2, clientY - top - height / 2];
    return { azimuth: wrapped(Math.round((Math.atan2(x, y) * 180) / Math.PI)), radius: (Math.hypot(x, y) / (width / 2)) * this.radii.half * 1.03 };
  }

  #grab(event) {
    const group = event.target.closest?.('[data-key]');
    const { azimuth, radius } = this.#pointer(event);
    if (!group) {
      const { half, rim, raceway, bore } = this.radii;
      const middle = (rim + raceway) / 2;
      if (radius > half * 1.05 || radius < bore / 2) return;
      const ring = radius > middle ? 'outer' : 'inner';
      this.#add(ring, 'defects', { ...NEW_DEFECT, azimuth_deg: azimuth });
      return;
    }
    event.preventDefault();
    const [ring, index] = [group.dataset.key.split('/')[0], Number(group.dataset.key.split('/')[1])];
    group.focus();
    this.svg.setPointerCapture(event.pointerId);
    const move = (moved) => this.#setItem(ring, 'defects', index, { azimuth_deg: this.#pointer(moved).azimuth });
    const stop = () => {
      this.svg.removeEventListener('pointermove', move);
      this.svg.removeEventListener('pointerup', stop);
      this.svg.removeEventListener('pointercancel', stop);
    };
    this.svg.addEventListener('pointermove', move);
    this.svg.addEventListener('pointerup', stop);
    this.svg.addEventListener('pointercancel', stop);
  }
}

/** The schema of a field of an item of a list. */
function itemSchema(openapi, parts) {
  const list = schemaAt(openapi, parts.slice(0, -2).join('/'));
  const name = list.items?.$ref?.split('/').pop();
  return openapi.components.schemas[name]?.properties?.[parts.at(-1)] ?? {};
}

/** A point at a radius and an azimuth [°]: +Y down, +Z to the right. */
function point(radius, azimuth) {
  const angle = (azimuth * Math.PI) / 180;
  return [radius * Math.sin(angle), radius * Math.cos(angle)].map((value) => Number(value.toFixed(3)));
}

function arc(radius, from, to) {
  const [a, b] = [point(radius, from), point(radius, to)];
  return `M${a.join(' ')}A${radius} ${radius} 0 ${to - from > 180 ? 1 : 0} 0 ${b.join(' ')}`;
}

/** What a ball does at a defect. */
function facts(defect) {
  if (!defect) return [];
  const { entry_to_impact_us: entry, impact_beside_middle_us: beside } = defect;
  return [
    ['Drop between the edges', quantity(defect.edge_drop_um, 'µm', 3)],
    ['Ball', defect.reaches_floor ? 'reaches the floor' : beside > 0 ? 'is carried beside the defect' : 'stays on the edges'],
    ['Fall', quantity(defect.fall_um, 'µm', 3)],
    ['Width over contact', defect.width_over_contact === undefined ? 'whole groove' : number(defect.width_over_contact, 3)],
    ['Speed of the contact', quantity(defect.contact_speed_m_s, 'm/s', 3)],
    entry !== undefined && ['Entry to last impact', quantity(entry, 'µs', 3)],
    beside > 0 && ['Between two impacts', quantity(2 * beside, 'µs', 3)],
    ['Ball load there', quantity(defect.ball_load_n, 'N', 3)],
    ['In the load zone', defect.in_load_zone ? 'yes' : 'no'],
    defect.longest_step_us !== undefined && ['Longest step', quantity(defect.longest_step_us, 'µs', 3)],
  ]
    .filter(Boolean)
    .map(([name, value]) => h('div', {}, h('dt', {}, name), h('dd', {}, value)));
}

/** What the contacts leave of the waves of a raceway. */
function waveFacts(derived) {
  if (!derived?.kept && !derived?.left_out.length) return [];
  const ranges = derived.left_out.map(({ from_order: from, to_order: to, reason }) => `${from === to ? from : `${from} to ${to}`} (${reason})`);
  const omitted = ranges.length ? ` Left out: orders ${ranges.slice(0, 3).join(', ')}${ranges.length > 3 ? ', …' : ''}.` : '';
  return [`${derived.kept} waves in the model; the contact averages order ${number(derived.first_zero_order, 3)} to zero.${omitted}`];
}
