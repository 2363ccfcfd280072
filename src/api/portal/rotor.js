// The analysis of a rotor: natural motions, Campbell diagram, mode shapes, response to unbalance, deflection and forces at rest.

import { Chart } from './chart.js';
import { leftOut } from './derived.js';
import { h, more, s, table } from './dom.js';
import { number, quantity } from './format.js';
import { messageList } from './messages.js';
import { lengthOf, listAt, sectionsOf } from './shaft-request.js';

/** Sign, name and line of a whirl. */
const WHIRLS = {
  forward: ['↻', 'forward', 'first'],
  backward: ['↺', 'backward', 'second dashed'],
  none: ['↕', 'in a plane', 'third dotted'],
  axial: ['↔', 'axial', 'third dotted'],
};
const MARKS = { forward: 'up', backward: 'down', none: 'dot', axial: 'dot' };
const STYLES = ['first', 'second dashed', 'third dotted', 'first dashed', 'second dotted', 'third', 'first dotted', 'second'];
/** Heights of the drawing of a shape [px]. */
const SHAPE_HEIGHT = 230;

const percent = (ratio) => quantity(ratio * 100, '%', 3);

/** A place with the name of what stands there. */
function placeName(request, at) {
  const near = (pointer) => listAt(request, pointer).find((item) => Math.abs(item.at_mm - at) < 1e-6);
  const bearing = near('/scene/bearings');
  const other = ['/scene/shaft/discs', '/scene/supports', '/scene/shaft/unbalances'].find(near);
  const kind = { '/scene/shaft/discs': 'disc', '/scene/supports': 'support', '/scene/shaft/unbalances': 'unbalance' }[other];
  return `${bearing ? `${bearing.name}, ` : kind ? `${kind}, ` : ''}${number(at, 4)} mm`;
}

export class RotorView {
  constructor(host, presets) {
    Object.assign(this, { host, presets });
    this.campbell = new Chart(420);
    this.response = new Chart(320);
    this.deflection = new Chart(240);
    this.messages = h('div', {});
    this.figures = h('dl', { class: 'figures' });
    this.motions = h('div', {});
    this.shape = h('div', { class: 'shape' });
    this.shapeText = h('figcaption', { 'aria-live': 'polite' });
    this.forces = h('div', {});
    this.omitted = h('div', {});
    const figure = (title, ...content) => h('section', {}, h('h3', {}, title), h('figure', {}, content));
    this.element = h(
      'div',
      { class: 'rotor' },
      this.messages,
      this.figures,
      h('div', { class: 'pair' }, this.motions, figure('Shape', this.shape, this.shapeText)),
      figure(
        'Campbell diagram',
        this.campbell.element,
        h(
          'figcaption',
          {},
          'Triangles: critical speeds, filled for forward, hollow for backward whirl. A click or Enter shows the shape.',
        ),
      ),
      h(
        'div',
        { class: 'pair' },
        figure('Response to unbalance', this.response.element, h('figcaption', {}, 'Longest half axis of the orbit.')),
        figure('Deflection at rest', this.deflection.element, h('figcaption', {}, 'Under weight and loads; +y down.')),
      ),
      this.forces,
      this.omitted,
    );
    new ResizeObserver(() => {
      if (this.answer && this.shape.clientWidth !== this.shapeWidth) this.#drawShape();
    }).observe(this.shape);
  }

  /** Shows an analysis of a request. */
  show(answer, request) {
    Object.assign(this, { answer, request });
    if (!this.element.isConnected) this.host.replaceChildren(this.element);
    if (!this.chosen || !this.#motion())
      this.chosen = `mode-${Math.max(
        answer.operating.modes.findIndex(({ whirl }) => whirl !== 'axial'),
        0,
      )}`;
    this.messages.replaceChildren(...messageList(answer.messages));
    this.#summary();
    this.#list();
    this.#drawCampbell();
    this.#drawResponse();
    this.#drawDeflection();
    this.#drawForces();
    this.#drawShape();
  }

  #choose(motion) {
    this.chosen = motion;
    const radio = this.motions.querySelector(`input[value="${motion}"]`);
    if (radio) radio.checked = true;
    this.#drawCampbell();
    this.#drawShape();
  }

  /** The chosen motion: a natural motion at the operating speed, or a critical speed. */
  #motion() {
    const [of, index] = this.chosen.split('-');
    return (of === 'mode' ? this.answer.operating.modes : this.answer.criticals)[index];
  }

  #summary() {
    const { answer } = this;
    const { operating, criticals } = answer;
    // Unbalance excites no backward motion, and those in a plane by half.
    const excited = criticals.find(({ whirl }) => whirl === 'forward' || whirl === 'none');
    const most = Math.max(...answer.static.y_um.map(Math.abs));
    const figure = (name, value, more) =>
      h('div', {}, h('dt', {}, name), h('dd', {}, h('b', {}, value), more && h('small', {}, more)));
    this.figures.replaceChildren(
      figure(
        'Lowest natural frequency',
        quantity(operating.modes[0]?.frequency_hz, 'Hz', 4),
        WHIRLS[operating.modes[0]?.whirl]?.[1],
      ),
      figure(
        'First critical speed, not backward',
        excited ? quantity(Math.round(excited.speed_rpm), 'r/min', 5) : 'none',
        excited ? WHIRLS[excited.whirl][1] : `up to ${quantity(answer.speeds_rpm.at(-1), 'r/min', 5)}`,
      ),
      figure(
        operating.is_stable ? 'Stable' : 'Unstable',
        `${number(operating.growth_rate_per_s, 3)}/s`,
        operating.is_stable ? 'slowest decay' : 'growth',
      ),
      figure('Mass', quantity(answer.mass_kg, 'kg', 4)),
      figure('Largest deflection y', quantity(most, 'µm', 3)),
    );
    const omitted = answer.model.left_out ?? [];
    this.omitted.replaceChildren(omitted.length > 0 ? more(`Omitted terms: ${omitted.length}`, leftOut(omitted)) : '');
  }

  #list() {
    const { operating, criticals } = this.answer;
    const row = (motion, value, { damping_ratio: damping, whirl }) => {
      const [sign, name] = WHIRLS[whirl];
      const radio = h('input', {
        type: 'radio',
        name: 'motion',
        value: motion,
        checked: motion === this.chosen,
        onchange: () => this.#choose(motion),
      });
      return [
        h('label', {}, radio, ` ${value}`),
        percent(damping),
        h('span', {}, h('span', { 'aria-hidden': 'true' }, `${sign} `), name),
      ];
    };
    const focused = this.motions.contains(document.activeElement) ? document.activeElement.value : null;
    const rows = operating.modes.map((mode, i) => row(`mode-${i}`, quantity(mode.frequency_hz, 'Hz', 5), mode));
    const others = criticals.map((one, i) => row(`critical-${i}`, quantity(Math.round(one.speed_rpm), 'r/min', 6), one));
    this.motions.replaceChildren(
      table(`Natural motions at ${quantity(operating.speed_rpm, 'r/min', 6)}`, ['Frequency', 'Damping ratio', 'Whirl'], rows),
      others.length
        ? table('Critical speeds', ['Speed', 'Damping ratio', 'Whirl'], others)
        : h('p', { class: 'note' }, `No critical speed up to ${quantity(this.answer.speeds_rpm.at(-1), 'r/min', 6)}.`),
    );
    if (focused) this.motions.querySelector(`input[value="${focused}"]`)?.focus();
  }

  #drawCampbell() {
    const { speeds_rpm: speeds, modes, criticals, operating } = this.answer;
    const last = speeds.at(-1);
    const lines = modes.flatMap(({ frequency_hz: frequency, whirl }) => courses(speeds, frequency, whirl));
    // The region of the critical speeds: twice the frequency of rotation, and the two lowest motions at least.
    const tops = modes.map(({ frequency_hz: frequency }) => Math.max(...frequency)).sort((a, b) => a - b);
    const top = Math.max((2 * last) / 60, tops[1] ?? tops[0] ?? 1);
    const above = tops.filter((one) => one > top * 1.06).length;
    this.campbell.draw({
      x: { from: speeds[0], to: Math.max(last, speeds[0] + 1), label: 'Speed, r/min' },
      y: { from: 0, to: top * 1.06, label: 'Natural frequency, Hz' },
      lines: [
        {
          style: 'once',
          points: [
            [speeds[0], speeds[0] / 60],
            [last, last / 60],
          ],
        },
        ...lines,
      ],
      legend: [
        ['first', 'forward'],
        ['second dashed', 'backward'],
        ['third dotted', 'in a plane, axial'],
        ['once', `1×${above ? `; ${above} motions above` : ''}`],
      ],
      verticals:
        operating.speed_rpm >= speeds[0] && operating.speed_rpm <= last ? [{ at: operating.speed_rpm, name: 'operating' }] : [],
      marks: criticals.map((one, i) => ({
        x: one.speed_rpm,
        y: one.speed_rpm / 60,
        shape: MARKS[one.whirl],
        name: `Critical speed ${quantity(Math.round(one.speed_rpm), 'r/min', 6)}, ${WHIRLS[one.whirl][1]}`,
        chosen: this.chosen === `critical-${i}`,
        choose: () => this.#choose(`critical-${i}`),
      })),
      text: `Campbell diagram: natural frequencies from ${number(speeds[0], 5)} to ${quantity(last, 'r/min', 6)}, ${criticals.length} critical speeds.`,
    });
  }

  #drawResponse() {
    const { speeds_rpm: speeds, response, criticals, operating } = this.answer;
    // Peaks lie at critical speeds, which stand between the requested speeds.
    const curves = response.map(({ major_um: values }, place) =>
      [...speeds.map((speed, k) => [speed, values[k]]), ...criticals.map((one) => [one.speed_rpm, one.major_um[place]])].sort(
        (a, b) => a[0] - b[0],
      ),
    );
    const known = curves
      .flat()
      .map(([, value]) => value)
      .filter((value) => value > 0);
    if (!known.length) known.push(1);
    const most = 10 ** Math.ceil(Math.log10(Math.max(...known)));
    this.response.draw({
      x: { from: speeds[0], to: Math.max(speeds.at(-1), speeds[0] + 1), label: 'Speed, r/min' },
      y: {
        from: Math.max(most * 1e-6, 10 ** Math.floor(Math.log10(Math.min(...known)))),
        to: most,
        label: 'Amplitude, µm',
        log: true,
      },
      lines: curves.map((points, i) => ({ points, style: STYLES[i % STYLES.length] })),
      legend: response.map(({ at_mm: at }, i) => [STYLES[i % STYLES.length], placeName(this.request, at)]),
      verticals: [{ at: operating.speed_rpm, name: 'operating' }].filter(({ at }) => at >= speeds[0] && at <= speeds.at(-1)),
      text: `Response to unbalance over speed at ${response.length} places.`,
    });
  }

  #drawDeflection() {
    const { nodes_mm: nodes, static: rest } = this.answer;
    const range = [...rest.y_um, ...rest.z_um, 0];
    const [least, most] = [Math.min(...range), Math.max(...range)];
    const room = (most - least || 1) * 0.1;
    this.deflection.draw({
      x: { from: nodes[0], to: nodes.at(-1), label: 'Place, mm' },
      // +Y points down.
      y: { from: most + room, to: least - room, label: 'Displacement, µm' },
      lines: [
        { style: 'first', points: nodes.map((at, k) => [at, rest.y_um[k]]) },
        { style: 'second dashed', points: nodes.map((at, k) => [at, rest.z_um[k]]) },
      ],
      legend: [
        ['first', 'y'],
        ['second dashed', 'z'],
      ],
      text: `Deflection at rest: y from ${quantity(Math.min(...rest.y_um), 'µm', 3)} to ${quantity(Math.max(...rest.y_um), 'µm', 3)}.`,
    });
  }

  #drawForces() {
    const { supports, bearings = [], mounts = [], sensors = [], speeds_rpm: speeds, operating } = this.answer;
    const linear = supports.length - bearings.length;
    const nearest = speeds.reduce(
      (best, speed, k) => (Math.abs(speed - operating.speed_rpm) < Math.abs(speeds[best] - operating.speed_rpm) ? k : best),
      0,
    );
    const names = [
      ...Array.from({ length: linear }, (_, k) => `support ${k + 1}`),
      ...bearings.map((one) => one.name),
      ...mounts.map((_, k) => `mount ${k + 1}`),
    ];
    /** What rounding leaves of zero is zero. */
    const force = (value) => number(Math.abs(value) < 1e-6 ? 0 : value, 4);
    const rows = [...supports, ...mounts].map(({ static_force_n: rest, unbalance_force_y_n: y, unbalance_force_z_n: z }, k) => [
      names[k],
      ...rest.map(force),
      force(y[nearest]),
      force(z[nearest]),
    ]);
    const stiffness = bearings.map((one) => [
      one.name,
      ...[0, 1, 2].map((axis) => number(one.stiffness[axis][axis] / 1e6, 4)),
      number(Math.max(one.largest_inner_load_n, one.largest_outer_load_n), 4),
      percent(one.loaded_share),
    ]);
    this.forces.replaceChildren(
      table(
        `Forces, N; from unbalance at ${quantity(speeds[nearest], 'r/min', 6)}`,
        ['On', 'x', 'y', 'z', 'unbalance y', 'unbalance z'],
        rows,
      ),
      bearings.length
        ? table(
            'Bearings at the operating point',
            ['Bearing', 'Kxx, N/µm', 'Kyy, N/µm', 'Kzz, N/µm', 'Largest ball load, N', 'Balls loaded'],
            stiffness,
          )
        : '',
      sensors.length
        ? table(
            `Displacement at the sensors; from unbalance at ${quantity(speeds[nearest], 'r/min', 6)}`,
            ['Sensor', 'at rest, µm', 'unbalance, µm'],
            sensors.map((one) => [one.name, force(one.static_um), number(one.displacement_um[nearest], 4)]),
          )
        : '',
    );
  }

  /** The chosen shape on the outline of the shaft: deflected in the plane of the larger motion, with the line of centres across it. */
  #drawShape() {
    const width = this.shape.clientWidth;
    const motion = this.#motion();
    if (!width || !motion) return;
    this.shapeWidth = width;
    const { shape } = motion;
    const { nodes_mm: nodes, supports } = this.answer;
    const sections = sectionsOf(this.request, this.presets);
    const length = lengthOf(this.request);
    const axis = SHAPE_HEIGHT / 2;
    const x = (at) => 10 + ((width - 20) * at) / length;
    const widest = Math.max(...sections.map((section) => section.outer_diameter_mm / 2), 1);
    const radial = Math.min((width - 20) / length, (SHAPE_HEIGHT * 0.2) / widest);
    const across = SHAPE_HEIGHT * 0.26;
    const planes = [
      ['y', atLargest(shape.y, shape.y_phase_deg)],
      ['z', atLargest(shape.z, shape.z_phase_deg)],
    ];
    if (Math.max(...shape.z) > Math.max(...shape.y)) planes.reverse();
    const [[plane, main], [other, side]] = planes;
    const path = (points) => `M${points.map(([a, b]) => `${x(a).toFixed(1)} ${b.toFixed(1)}`).join('L')}`;
    const outline = (sign) => {
      let end = 0;
      return sections.flatMap((section) => {
        const from = end;
        end += section.length_mm;
        const offset = (sign * section.outer_diameter_mm * radial) / 2;
        return nodes
          .map((at, k) => [at, axis + offset + across * main[k]])
          .filter(([at]) => at >= from - 1e-6 && at <= end + 1e-6);
      });
    };
    let end = 0;
    const rest = sections.map((section) => {
      const from = end;
      end += section.length_mm;
      const half = (section.outer_diameter_mm * radial) / 2;
      return s('rect', { class: 'rest', x: x(from), y: axis - half, width: x(end) - x(from), height: 2 * half });
    });
    const [, name] = WHIRLS[motion.whirl];
    const what =
      motion.speed_rpm !== undefined
        ? `Critical speed ${quantity(Math.round(motion.speed_rpm), 'r/min', 6)}`
        : quantity(motion.frequency_hz, 'Hz', 5);
    const bodies = (shape.bodies ?? []).map((body) => `${body.name} ${number(Math.max(...body.amplitude), 2)}`);
    const housing = bodies.length ? ` Housing relative to the largest motion: ${bodies.join(', ')}.` : '';
    const text = `${what}, ${name}, damping ratio ${percent(motion.damping_ratio)}.${housing}`;
    this.shape.replaceChildren(
      s(
        'svg',
        { width, height: SHAPE_HEIGHT, viewBox: `0 0 ${width} ${SHAPE_HEIGHT}`, role: 'img', 'aria-label': `Shape: ${text}` },
        rest,
        s('path', { class: 'axis', d: `M4 ${axis}H${width - 4}` }),
        supports.map(({ at_mm: at }) => s('path', { class: 'support', d: `M${x(at)} ${SHAPE_HEIGHT - 16}l6 10h-12z` })),
        s('path', { class: 'outline', d: `${path([...outline(-1), ...outline(1).reverse()])}Z` }),
        s('path', { class: 'line second dashed', d: path(nodes.map((at, k) => [at, axis + across * side[k]])) }),
      ),
    );
    this.shapeText.textContent = `${text} ${motion.whirl === 'axial' ? 'The motion is along x. ' : ''}Outline: plane x${plane}, dashed: x${other}, each at its largest. Triangles: bearings and supports.`;
  }
}

/** A course in pieces of one whirl; a piece reaches to the first point of the next one. A frequency of 0 is no oscillation. */
function courses(speeds, frequency, whirl) {
  const pieces = [];
  for (let from = 0; from < speeds.length - 1;) {
    let to = from + 1;
    while (to < speeds.length - 1 && whirl[to] === whirl[from]) to += 1;
    const points = speeds.slice(from, to + 1).map((speed, k) => [speed, frequency[from + k] || NaN]);
    pieces.push({ style: WHIRLS[whirl[from]][2], points });
    from = to;
  }
  return pieces;
}

/** Displacements at the instant of the largest one. */
function atLargest(amplitude, phase) {
  const largest = amplitude.indexOf(Math.max(...amplitude));
  return amplitude.map((value, k) => value * Math.cos(((phase[k] - phase[largest]) * Math.PI) / 180));
}
