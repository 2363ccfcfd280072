// Numbers and names as text.

/** A number with at most `digits` digits, grouped thousands, and a power of ten if that is shorter. */
export function number(value, digits = 4, least = 1) {
  if (typeof value !== 'number' || !Number.isFinite(value)) return '–';
  if (value === 0) return '0';
  const size = Math.abs(value);
  if (size >= 1e6 || size < 1e-3) {
    const [mantissa, exponent] = value.toExponential(Math.min(digits, 3) - 1).split('e');
    const short = least === 1 ? String(Number(mantissa)) : mantissa;
    return minus(`${{ 1: '', '-1': '-' }[short] ?? `${short} × `}10${superscript(Number(exponent))}`);
  }
  const text = value.toLocaleString('en-US', {
    minimumSignificantDigits: least,
    maximumSignificantDigits: digits,
    useGrouping: size >= 1e4,
  });
  return minus(text.replaceAll(',', '\u202f'));
}

/** A computed number with a fixed number of digits, so that columns agree. */
export const measured = (value, digits = 3) => (value === 0 ? '0' : number(value, digits, digits));

/** A number rounded to the second digit of its error. */
export function rounded(value, error) {
  if (!(error > 0) || typeof value !== 'number') return number(value, 5);
  const digits = Math.max(1 - Math.floor(Math.log10(error)), 0);
  const text = value.toLocaleString('en-US', { minimumFractionDigits: digits, maximumFractionDigits: digits, useGrouping: Math.abs(value) >= 1e4 });
  return minus(text.replaceAll(',', '\u202f'));
}

/** An error of the computation alone: nothing is known of the spread by tolerances. */
export const numerical = (error, digits = 1) => `± ${number(error, digits)} numerical only`;

/** A number with its unit, separated by a non-breaking space. */
export function quantity(value, unit, digits) {
  return unit ? `${number(value, digits)}${unit === '°' ? '' : '\u00a0'}${unit}` : number(value, digits);
}

/** The unit of a level with its reference. */
export const LEVEL_UNIT = 'dB re 9.81 mm/s²';

/** A level with one decimal. */
export const level = (value) => (typeof value === 'number' ? minus(value.toFixed(1)) : '–');

/** A duration in a suitable unit. */
export function seconds(value) {
  if (typeof value !== 'number') return '–';
  if (value < 1) return quantity(value * 1000, 'ms', 2);
  if (value < 120) return quantity(value, 's', 2);
  return value < 7200 ? quantity(value / 60, 'min', 2) : quantity(value / 3600, 'h', 2);
}

/** A power of ten for the axis of a logarithmic plot. */
export const power = (value) =>
  value >= 0.0009 && value <= 1001 ? String(Number(value.toPrecision(3))) : `10${superscript(Math.round(Math.log10(value)))}`;

const minus = (text) => text.replace('-', '−');
const superscript = (exponent) => [...String(exponent)].map((c) => (c === '-' ? '⁻' : '⁰¹²³⁴⁵⁶⁷⁸⁹'[c])).join('');

/** `radially_condensed` with spaces. */
export const words = (name) => String(name ?? '').replaceAll('_', ' ');

/** `spindle.y.acceleration` with spaces. */
export const channelName = (channel) => channel.replaceAll('.', ' ');

/** A time of today, else date and time. */
export function moment(text) {
  const date = new Date(text);
  const time = date.toLocaleTimeString([], { hour: '2-digit', minute: '2-digit', second: '2-digit', hour12: false });
  return date.toDateString() === new Date().toDateString() ? time : `${date.toLocaleDateString()} ${time}`;
}

/** Units at the end of field names. */
export const UNITS = {
  um: 'µm', mm: 'mm', nm: 'nm', g: 'g', kg: 'kg', n: 'N', rpm: 'r/min', deg: '°', pa_s: 'Pa·s', hz: 'Hz', c: '°C', db: 'dB', s: 's', gpa: 'GPa', m_s2: 'm/s²', m_s: 'm/s',
};
const UNIT = new RegExp(`_(${Object.keys(UNITS).join('|')})$`);

/** A field of a bearing in a title. */
function fieldTitle([name, value]) {
  if (name === 'radial_clearance_group') return `clearance ${value}`;
  if (typeof value === 'number') return `${words(name.replace(UNIT, ''))} ${quantity(value, UNITS[name.match(UNIT)?.[1]])}`;
  const classes = name === 'fits' ? [value?.shaft, value?.housing].filter(Boolean).join('/') : '';
  return [words(name), classes].filter(Boolean).join(' ');
}

/** The fields of a preset that a request changes; the first two by name. */
function changes(fields) {
  const changed = Object.entries(fields).map(fieldTitle);
  return changed.length > 2 ? [...changed.slice(0, 2), `${changed.length - 2} more`] : changed;
}

/** Surfaces of raceways and balls in few words. */
function surfacesTitle({ preset, inner = {}, outer = {}, balls = [], every_ball: every = {} }) {
  const defects = [
    ['outer', outer.defects],
    ['inner', inner.defects],
    ['ball', balls.flatMap((ball) => ball.defects ?? [])],
  ].map(([part, all = []]) =>
    all.length === 1 ? `${part} defect ${quantity(all[0].length_mm ?? all[0].diameter_mm, 'mm')}` : all.length > 1 && `${all.length} ${part} defects`,
  );
  const isWavy = ({ waviness = [], axial_waviness: axial = [], random_waviness: random }) => waviness.length > 0 || axial.length > 0 || random;
  return [
    ...defects,
    [inner, outer].some(isWavy) && 'wavy raceways',
    [every, ...balls].some(isWavy) && 'wavy balls',
    (every.diameter_spread_um || balls.some((ball) => ball.diameter_um)) && 'unequal balls',
    preset,
  ]
    .filter(Boolean)
    .join(', ');
}

/** Name of a lubricant. One without kind is an oil by its viscosities, else grease, as in the API. */
function lubricantTitle(lubricant) {
  if (typeof lubricant !== 'object' || lubricant === null) return lubricant;
  const { kind, viscosity_grade: grade, viscosity_40_mm2_s: viscosity } = lubricant;
  const usual = grade ? '' : viscosity === undefined ? 'grease' : 'oil';
  return [kind ?? usual, grade].filter(Boolean).join(' ');
}

/** Rigid preloads of pairs of bearings, then those by springs. */
function preloadTitle({ preloads = [], bearings = [] }) {
  const rigid = preloads.map(({ force_n: force, offset_um: offset }) => (force === undefined ? quantity(offset, 'µm') : quantity(force, 'N')));
  const springs = bearings.map(({ outer_ring: ring }) => ring?.spring_force_n).filter((force) => force !== undefined);
  const named = (name, values) => values.length > 0 && `${name} ${unique(values).join(', ')}`;
  return [named('preload', rigid), named('spring', springs.map((force) => quantity(force, 'N')))].filter(Boolean).join(', ');
}

const unique = (values) => [...new Set(values)];

const speedOf = ({ speed_rpm: speed }) => (typeof speed === 'number' ? quantity(speed, 'r/min') : 'varying speed');

/** Length, bearings, speed, preload and lubricants of a shaft or a rigid spindle. */
function shaftTitle(scene) {
  const { shaft, bearings = [], supports = [], operation = {} } = scene;
  const length = (shaft?.sections ?? []).reduce((sum, section) => sum + (Number(section.length_mm) || 0), 0);
  const names = bearings.map(({ name, bearing }) => [name, typeof bearing === 'string' ? bearing : bearing?.preset].filter(Boolean).join('\u00a0'));
  const on = [...names, supports.length && `${supports.length} supports`].filter(Boolean).join(', ');
  const lubricants = unique(bearings.map(({ lubricant }) => lubricantTitle(lubricant)).filter(Boolean)).join(', ');
  return [
    shaft ? `Shaft ${quantity(length, 'mm')}` : 'Rigid spindle',
    on && `on ${on}`,
    speedOf(operation),
    preloadTitle(scene),
    lubricants,
    termsTitle(scene.terms),
  ]
    .filter(Boolean)
    .join(' · ');
}

/** Terms that are switched off. */
function termsTitle(terms = {}) {
  const off = Object.keys(terms).filter((name) => terms[name] === 'off');
  return off.length > 0 && `without ${off.map(words).join(', ')}`;
}

/** A one-line title of a request. */
export function title(request) {
  const { scene = {}, axes = [], inputs = [] } = request ?? {};
  if (scene.shaft ?? scene.bearings) return shaftTitle(scene);
  const { bearing, operation = {}, spindle = {}, lubricant, surfaces } = scene;
  const { preset, ...changed } = typeof bearing === 'string' ? { preset: bearing } : (bearing ?? {});
  const name = preset ? [preset, ...changes(changed)].join(', ') : 'own bearing';
  const speed = speedOf(operation);
  const load = Math.hypot(operation.radial_load_y_n ?? 0, operation.radial_load_z_n ?? 0);
  const loads = [
    load && quantity(load, 'N'),
    operation.axial_load_n && `${quantity(operation.axial_load_n, 'N')} axial`,
    spindle.balance_grade && `G\u00a0${number(spindle.balance_grade)}`,
    lubricantTitle(lubricant),
    surfaces && surfacesTitle(surfaces),
    termsTitle(scene.terms),
  ];
  const field = ({ path, quantity: derived }) => words((path ?? derived ?? '').split('/').pop().replace(UNIT, ''));
  const varied = axes.map((axis) => `over ${field(axis)}`);
  const uncertain = inputs.length > 0 && `uncertain ${inputs.map(field).join(', ')}`;
  return [name, speed, ...loads, ...varied, uncertain].filter(Boolean).join(' · ');
}

/** Between two numbers of one field. */
export const PAIR = ' to ';

/** Two numbers with `to` or a dash between them, or as in JSON, `[890, 3500]`; null if the text is none. */
export function pairOf(text) {
  const list = text.match(/^\s*\[(.*)\]\s*$/)?.[1];
  const numbers = (list === undefined ? text.split(/\s*(?:to|[–…])\s*/) : list.split(/,\s*/)).map((part) => (part.trim() === '' ? NaN : Number(plainNumber(part))));
  return numbers.length === 2 && numbers.every(Number.isFinite) ? numbers : null;
}

/** A number of five digits without spaces between groups. */
export const plain = (value) => number(value, 5).replaceAll('\u202f', '');

/** A typed number with a point, without spaces between groups of digits. A comma that may separate thousands stays. */
export function plainNumber(text) {
  const plain = text.trim().replaceAll(/(?<=\d)\s(?=\d{3})/g, '').replace('−', '-');
  return /^\d{1,3}(,\d{3})+$/.test(plain) ? plain : plain.replace(',', '.');
}

/** A statistic over uncertain inputs in words. */
export const statisticName = (statistic) => (typeof statistic === 'string' ? statistic : `percentile ${number(statistic.percentile)}`);
