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
const isWithin = (order, [low, high]) => low <= order && order <= high;

/** The shift of lines that is least likely by chance, and its evidence, as in the API; `null` where nothing was measured in reach. */
function commonShift(lines, measured, reach) {
  const near = lines.map(({ order }) => measured.filter((one) => Math.abs(one - order) <= mostOf(order, reach)));
  // A line of this rank lies somewhere within the largest shift, and would lie in the range by chance with this probability.
  const evidence = (shift) =>
    lines.reduce((sum, line, k) => {
      const range = rangeOf(line, shift, reach);
      const rank = near[k].findIndex((order) => isWithin(order, range));
      const chance = ((rank + 1) * (range[1] - range[0])) / (2 * mostOf(line.order, reach));
      return rank < 0 ? sum : sum - Math.log(Math.min(chance, 1));
    }, 0);
  const shifts = lines.flatMap(({ order, ofShaft }, k) => near[k].map((one) => (one - order) / (order - ofShaft))).filter(Number.isFinite);
  return shifts.map((shift) => ({ shift, evidence: evidence(shift) })).reduce((best, one) => (best && best.evidence >= one.evidence ? best : one), null);
}

/** Shift of each series of predicted lines `{ order, label }` against measured orders, strongest first, and the best one of all. */
export function shiftsOf(predicted, measured, reach) {
  const members = new Map();
  for (const { order, label } of predicted) {
    const source = sourceOf(label);
    if (source) members.set(source.series, [...(members.get(source.series) ?? []), { order, ofShaft: source.ofShaft }]);
  }
  // In the sequence of the API, so that equal evidence chooses the same.
  const series = [...members.keys()].sort();
  const found = series.map((name) => [name, commonShift(members.get(name), measured, reach)]).filter(([, common]) => common);
  const best = found.map(([, common]) => common).reduce((one, other) => (one && one.evidence >= other.evidence ? one : other), null);
  return { bySeries: new Map(found.map(([name, { shift }]) => [name, shift])), best: best?.shift };
}

/** Orders between which the partner of a predicted line lies; `nearest`: distance to the next predicted line. */
function reachOf({ order, label }, { bySeries, best }, nearest, reach) {
  const source = sourceOf(label);
  if (source) {
    const shift = bySeries.get(source.series);
    return shift === undefined ? [order, order] : rangeOf({ order, ofShaft: source.ofShaft }, shift, reach);
  }
  const most = mostOf(order, reach);
  const [low, high] = best === undefined ? [-most, most] : [Math.min(best, 0) * order - reach, Math.max(best, 0) * order + reach];
  const cap = Math.max(nearest / 2, reach);
  return [order + Math.max(low, -cap), order + Math.min(high, cap)];
}

/** Partner of each predicted line among measured ones, `undefined` without one; stronger predicted lines choose first. Both have orders. */
export function partnersOf(predicted, measured, shifts, reach) {
  const taken = new Set();
  const partners = predicted.map(() => undefined);
  const sequence = predicted.map((_, k) => k).sort((a, b) => predicted[b].amplitude - predicted[a].amplitude);
  for (const k of sequence) {
    const nearest = predicted.reduce((least, { order }, i) => (i === k ? least : Math.min(least, Math.abs(order - predicted[k].order))), Infinity);
    const range = reachOf(predicted[k], shifts, nearest, reach);
    partners[k] = measured.find((line) => !taken.has(line) && isWithin(line.order, range));
    if (partners[k]) taken.add(partners[k]);
  }
  return partners;
}
