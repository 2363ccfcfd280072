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

const mostOf = (order, reach) => Math.max(MOST_SHIFT * order, reach);
/** Number of places within the largest shift that a spectrum tells apart. */
const placesOf = (order, reach) => mostOf(order, reach) / reach;

const isWithin = (order, [low, high]) => low <= order && order <= high;

/** A predicted line `{ order, label }` with its source, and the measured orders within the largest shift, strongest first. */
const memberOf = ({ order, label }, measured, reach) => ({
  order,
  ...sourceOf(label ?? ''),
  near: measured.filter((one) => Math.abs(one - order) <= mostOf(order, reach)),
});

/** Logarithm of the odds against chance of the strongest line in the range of a shift; `null` without one. A line of its rank or stronger would lie
 *  in the range by chance with the probability rank over places. */
function evidenceOf(line, shift, reach) {
  const range = rangeOf(line, shift, reach);
  const rank = line.near.findIndex((one) => isWithin(one, range));
  return rank < 0 ? null : -Math.log(Math.min(((rank + 1) * (range[1] - range[0])) / (2 * mostOf(line.order, reach)), 1));
}

/** Mean evidence at a shift that says nothing. */
function byChance({ order, near }, reach) {
  const places = placesOf(order, reach);
  let sum = 0;
  for (let rank = 1; rank <= Math.min(near.length, Math.floor(places)); rank += 1) sum += Math.log(places / rank) / places;
  return sum;
}

const sumOf = (values) => values.reduce((sum, value) => sum + value, 0);
const better = (one, other) => (one && one.odds >= other.odds ? one : other);

/** A shift of lines: its odds against chance, and whether a line meets a measured one. */
function knownShift(lines, value, reach) {
  const evidence = lines.map((line) => evidenceOf(line, value, reach)).filter((one) => one !== null);
  return { value, odds: sumOf(evidence) - sumOf(lines.map((line) => byChance(line, reach))), meets: evidence.length > 0 };
}

/** Chance does not explain better what the lines meet. */
const isEvident = ({ odds, meets }) => meets && odds >= 0;

/** No shift, or the best one that moves a predicted line onto a measured one. It pays for each place that might have been found. */
function ownShift(lines, reach) {
  const places = Math.max(1, ...lines.filter(({ near }) => near.length > 0).map(({ order }) => placesOf(order, reach)));
  const shifts = lines.flatMap(({ order, near }) => near.map((one) => one / order - 1));
  const none = knownShift(lines, 0, reach);
  if (!shifts.length) return none;
  const best = shifts.map((shift) => knownShift(lines, shift, reach)).reduce(better, null);
  return better(none, { ...best, odds: best.odds - Math.log(places) });
}

/** Shifts of each series, as in the API. `predicted`: `{ order, label }`; `measured`: orders, strongest first. The shift of a series is the most
 *  evident one of three: none, that of the most evident series, and one of its own. A wrong speed shifts all lines alike. */
export function shiftsOf(predicted, measured, reach) {
  const all = predicted.map((line) => memberOf(line, measured, reach));
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

/** Shifts of peaks without labels: none and the best one, as far as they are evident. Peaks of shaft and balls are among them. */
export function shiftsOfPeaks({ best }, peaks, measured, reach) {
  const lines = peaks.map((line) => memberOf(line, measured, reach));
  const known = best === undefined ? [0] : [0, best];
  const shifts = known.filter((value) => isEvident(knownShift(lines, value, reach)));
  return { best, bySeries: new Map([[sourceOf('').series, shifts]]) };
}

/** Whether a measured order may be the partner of a predicted line. */
function join({ order, label }, { bySeries }, measured, reach) {
  const { series, ofShaft } = sourceOf(label ?? '');
  return (bySeries.get(series) ?? []).some((shift) => isWithin(measured, rangeOf({ order, ofShaft }, shift, reach)));
}

/** Partner of each predicted line among measured ones, `undefined` without one; stronger predicted lines choose first. Both have orders. */
export function partnersOf(predicted, measured, shifts, reach) {
  const taken = new Set();
  const partners = predicted.map(() => undefined);
  const sequence = predicted.map((_, k) => k).sort((a, b) => predicted[b].amplitude - predicted[a].amplitude);
  for (const k of sequence) {
    partners[k] = measured.find((line) => !taken.has(line) && join(predicted[k], shifts, line.order, reach));
    if (partners[k]) taken.add(partners[k]);
  }
  return partners;
}
