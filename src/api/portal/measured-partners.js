// Partners of predicted lines among measured ones: all lines of one source share a shift, as in the API.

/** Largest shift of a line against its prediction: slip, contact angle and speed move lines by about 1 %. */
const MOST_SHIFT = 0.02;
/** Distance from its expected place within which a line may always lie, in bins. */
export const SHIFT_BINS = 1.5;
/** Label of the rotation of the shaft. */
const SHAFT = 'f_r';

/** Source of a line such as `2·BPFO + f_r − FTF@A`, and the part of its order that comes from the shaft. All lines without label are one series. */
function sourceOf(label) {
  const [sum, bearing = ''] = label.split('@');
  const terms = sum.replaceAll(' − ', ' + −').split(' + ').map((text) => {
    const [order, name] = text.includes('·') ? text.replace('−', '').split('·') : ['1', text.replace('−', '')];
    return { name, order: (text.startsWith('−') ? -1 : 1) * Number(order) };
  });
  const slipping = terms.find(({ name }) => name !== SHAFT);
  // The whole order of a line of the shaft shifts, if the stated speed is wrong.
  if (!slipping) return { series: SHAFT, ofShaft: 0 };
  const ofShaft = terms.filter(({ name }) => name === SHAFT).reduce((total, { order }) => total + order, 0);
  return { series: `${slipping.name}@${bearing}`, ofShaft };
}

/** Orders between which a line lies at a shift of its series. Slip leaves the part of the shaft in place; a wrong speed shifts it, too. */
function rangeOf({ order, ofShaft }, shift, reach) {
  const ends = [order + shift * (order - ofShaft), order * (1 + shift)];
  return [Math.min(...ends) - reach, Math.max(...ends) + reach];
}

const isWithin = (order, [low, high]) => low <= order && order <= high;

/** Predicted lines `{ order, label }` with their sources, and the measured orders within their largest distance, strongest first. Beyond half of the
 *  distance to the next line of its series a line would be taken for that one. */
function membersOf(predicted, measured, reach) {
  const sources = predicted.map(({ order, label }) => ({ order, ...sourceOf(label ?? '') }));
  const orders = new Map();
  for (const { series, order } of sources) orders.set(series, (orders.get(series) ?? []).concat(order));
  return sources.map((line) => {
    const nearest = orders.get(line.series).reduce((least, other) => (other === line.order ? least : Math.min(least, Math.abs(other - line.order))), Infinity);
    const most = Math.max(Math.min(MOST_SHIFT * line.order, nearest / 2), reach);
    return { ...line, most, near: measured.filter((one) => Math.abs(one - line.order) <= most) };
  });
}

const sumOf = (values) => values.reduce((sum, value) => sum + value, 0);
const better = (one, other) => (one && one.odds >= other.odds ? one : other);

/** Logarithm of the odds that a shift is true rather than says nothing, and whether a measured line is in its range. If it is true, the line is
 *  measured with even odds, and is then one of the `near` ones, of rank r with odds 1/r. Chance puts each of these into the range with the
 *  probability 1/places. */
function oddsOf(line, shift, reach) {
  const range = rangeOf(line, shift, reach);
  const rank = line.near.findIndex((one) => isWithin(one, range)) + 1;
  if (!rank) return { odds: Math.log(0.5), meets: false };
  const places = Math.max((2 * line.most) / (range[1] - range[0]), 1);
  const harmonic = sumOf(line.near.map((_, k) => 1 / (k + 1)));
  return { odds: Math.log(0.5 * (1 + places / (rank * harmonic))), meets: true };
}

/** A shift of lines: the logarithm of its odds against chance, and whether a line meets a measured one. */
function knownShift(lines, value, reach) {
  const all = lines.map((line) => oddsOf(line, value, reach));
  return { value, odds: sumOf(all.map(({ odds }) => odds)), meets: all.some(({ meets }) => meets) };
}

/** Chance does not explain better what the lines meet. */
const isEvident = ({ odds, meets }) => meets && odds >= 0;

/** No shift, or the best one that moves a predicted line onto a measured one. It pays for each place that might have been found. */
function ownShift(lines, reach) {
  const places = Math.max(1, ...lines.filter(({ near }) => near.length > 0).map(({ most }) => most / reach));
  const shifts = lines.flatMap(({ order, near }) => near.map((one) => one / order - 1));
  const none = knownShift(lines, 0, reach);
  if (!shifts.length) return none;
  const best = shifts.map((shift) => knownShift(lines, shift, reach)).reduce(better, null);
  return better(none, { ...best, odds: best.odds - Math.log(places) });
}

/** Shifts of each series, as in the API. `predicted`: `{ order, label }`; `measured`: orders, strongest first. The shift of a series is the most
 *  evident one of three: none, that of the most evident series, and one of its own. A wrong speed shifts all lines alike. */
export function shiftsOf(predicted, measured, reach) {
  const all = membersOf(predicted, measured, reach);
  // In the sequence of the API, so that equal evidence chooses the same.
  const names = [...new Set(all.map(({ series }) => series))].sort();
  const members = names.map((name) => all.filter(({ series }) => series === name));
  const best = [...members, all].map((lines) => ownShift(lines, reach)).filter(isEvident).reduce(better, null)?.value;
  const ofSeries = (lines) => {
    const own = ownShift(lines, reach);
    const found = best === undefined ? own : better(knownShift(lines, best, reach), own);
    if (isEvident(found)) return [found.value];
    return best === undefined ? [] : [best];
  };
  return { best, bySeries: new Map(names.map((name, k) => [name, ofSeries(members[k])])) };
}

/** Shifts of peaks without labels, strongest first: none and the best one, if what was measured meets more of the peaks than chance would. Peaks of
 *  shaft and balls are among them. */
export function shiftsOfPeaks({ best }, peaks, measured, reach) {
  const lines = measured.map((order) => ({ order, label: '' }));
  const known = best === undefined ? [0] : [0, best];
  const shifts = known.filter((shift) => {
    const moved = peaks.map(({ order }) => (1 + shift) * order);
    return isEvident(knownShift(membersOf(lines, moved, reach), 0, reach));
  });
  return { best, bySeries: new Map([[sourceOf('').series, shifts]]) };
}

/** Orders between which the partner of a predicted line lies, for each shift of its series. */
function rangesOf({ order, label }, { bySeries }, reach) {
  const { series, ofShaft } = sourceOf(label ?? '');
  return (bySeries.get(series) ?? []).map((shift) => rangeOf({ order, ofShaft }, shift, reach));
}

/** Partner of each predicted line among measured ones, `undefined` without one; stronger predicted lines choose first. Both have orders. */
export function partnersOf(predicted, measured, shifts, reach) {
  const taken = new Set();
  const partners = predicted.map(() => undefined);
  const sequence = predicted.map((_, k) => k).sort((a, b) => predicted[b].amplitude - predicted[a].amplitude);
  for (const k of sequence) {
    const ranges = rangesOf(predicted[k], shifts, reach);
    partners[k] = measured.find((line) => !taken.has(line) && ranges.some((range) => isWithin(line.order, range)));
    if (partners[k]) taken.add(partners[k]);
  }
  return partners;
}
