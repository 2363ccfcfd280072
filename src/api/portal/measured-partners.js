// Partners of predicted lines among measured ones: all lines of one source share a shift, as in the API.

/** Largest shift of a line against its prediction: slip, contact angle and speed move lines by about 1 %. */
const MOST_SHIFT = 0.02;
/** Distance from its expected place within which a line may always lie, in bins. */
export const SHIFT_BINS = 1.5;
/** Label of the rotation of the shaft. */
const SHAFT = 'f_r';

/** Source of a line such as `2·BPFO + f_r − FTF@A`, and the part of its order that comes from the shaft; `null` without a label. */
function sourceOf(label) {
  if (!label) return null;
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

/** Logarithm of the odds against chance of the strongest line in the range of a shift. A line of its rank or stronger would lie in the range by
 *  chance with the probability rank over places. */
function evidenceOf({ order, ofShaft, near }, shift, reach) {
  const [low, high] = rangeOf({ order, ofShaft }, shift, reach);
  const rank = near.findIndex((one) => low <= one && one <= high);
  return rank < 0 ? 0 : -Math.log(Math.min(((rank + 1) * (high - low)) / (2 * mostOf(order, reach)), 1));
}

/** Mean evidence at a shift that says nothing. */
function byChance({ order, near }, reach) {
  const places = placesOf(order, reach);
  let sum = 0;
  for (let rank = 1; rank <= Math.min(near.length, Math.floor(places)); rank += 1) sum += Math.log(places / rank) / places;
  return sum;
}

const better = (one, other) => (other && (!one || other.odds > one.odds) ? other : one);

const knownShift = (lines, value, reach) => ({ value, odds: lines.reduce((sum, line) => sum + evidenceOf(line, value, reach) - byChance(line, reach), 0) });

/** The best shift that moves a predicted line onto a measured one. It pays for each place that might have been found. */
function searchedShift(lines, reach) {
  const places = Math.max(1, ...lines.filter(({ near }) => near.length > 0).map(({ order }) => placesOf(order, reach)));
  const shifts = lines.flatMap(({ order, near }) => near.map((one) => one / order - 1));
  const best = shifts.map((shift) => knownShift(lines, shift, reach)).reduce(better, null);
  return best && { ...best, odds: best.odds - Math.log(places) };
}

/** The shifts with the most evidence. A series has none, that of the most evident series, or one of its own if that is worth its search.
 *  `predicted`: `{ order, label }`; `measured`: orders, strongest first. */
export function shiftsOf(predicted, measured, reach) {
  const members = new Map();
  for (const { order, label } of predicted) {
    const { series, ofShaft } = sourceOf(label) ?? { series: '', ofShaft: 0 };
    const near = measured.filter((one) => Math.abs(one - order) <= mostOf(order, reach));
    members.set(series, [...(members.get(series) ?? []), { order, ofShaft, near }]);
  }
  const own = (lines) => better(knownShift(lines, 0, reach), searchedShift(lines, reach));
  // In the sequence of the API, so that equal evidence chooses the same.
  const names = [...members.keys()].sort();
  const best = names.map((name) => own(members.get(name))).filter(({ odds }) => odds > 0).reduce(better, null)?.value;
  const ofSeries = (lines) => {
    const found = best === undefined ? own(lines) : better(knownShift(lines, best, reach), own(lines));
    return found.odds > 0 ? found.value : (best ?? 0);
  };
  return { best, bySeries: new Map(names.map((name) => [name, ofSeries(members.get(name))])) };
}

/** Whether a measured order may be the partner of a predicted line. A line whose source is unknown has its own order or that of the most evident
 *  shift, and no partner where no shift is known. */
function joins({ order, label }, { bySeries, best }, measured, reach) {
  const source = sourceOf(label);
  if (!source) return best !== undefined && [order, order * (1 + best)].some((place) => Math.abs(measured - place) <= reach);
  const [low, high] = rangeOf({ order, ofShaft: source.ofShaft }, bySeries.get(source.series) ?? best ?? 0, reach);
  return low <= measured && measured <= high;
}

/** Partner of each predicted line among measured ones, `undefined` without one; stronger predicted lines choose first. Both have orders. */
export function partnersOf(predicted, measured, shifts, reach) {
  const taken = new Set();
  const partners = predicted.map(() => undefined);
  const sequence = predicted.map((_, k) => k).sort((a, b) => predicted[b].amplitude - predicted[a].amplitude);
  for (const k of sequence) {
    partners[k] = measured.find((line) => !taken.has(line) && joins(predicted[k], shifts, line.order, reach));
    if (partners[k]) taken.add(partners[k]);
  }
  return partners;
}
