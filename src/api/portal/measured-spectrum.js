// Spectrum, levels and lines of a measured signal, with the window and the resolution of a prediction.

import { partnersOf, SHIFT_BINS, shiftsOf, shiftsOfPeaks } from './measured-partners.js';

/** Noise bandwidth of the Hann window in bins. */
const BANDWIDTH = 1.5;
/** A line is a local maximum within this many bins … */
const LOBE = 2;
/** … this far above the median of so many bins around it, and at least this share of the strongest line. */
const FLOOR_FACTOR = 4;
const FLOOR_REACH = 25;
/** Share of an edge of a band within which a bin is at the edge. */
const EDGE_SHARE = 1e-6;
const LEAST_SHARE = 1e-3;
/** Most weaker peaks of a prediction that are listed, as in the API. */
const MOST_WEAKER = 20;
/** Share of the sampling rate up to which a record is compared, as in the API. */
const PASS = 0.4;
/** Least number of pulses: the slope at each is that between its neighbours. */
const FEWEST_PULSES = 3;

/** Variation of a record over its largest value that is rounding, as in the API. */
const ROUNDING = 1e-12;

/** Refuses a signal whose values are all equal: its levels would be 0. */
export function requireVibration({ name, values }) {
  const [least, most] = extremesOf(values);
  if (most - least <= ROUNDING * Math.max(Math.abs(least), Math.abs(most))) throw new Error(`All values of ${name} are ${most}: there is no vibration to compare.`);
}

/** Least and greatest value. */
const extremesOf = (values) => values.reduce(([low, high], value) => [Math.min(low, value), Math.max(high, value)], [Infinity, -Infinity]);

/** Values of a signal at equal angles in place of equal times, by the times of pulses [s]: `{ values, speed_hz }` at the same rate. A frequency is
 *  then an order times the mean speed. */
export function byAngle(values, rate, pulses, perTurn) {
  const within = pulses.filter((time) => time >= 0 && time <= (values.length - 1) / rate);
  if (within.length < FEWEST_PULSES) throw new Error(`The tachometer has ${within.length} pulses within the record: at least ${FEWEST_PULSES} are needed.`);
  const last = within.length - 1;
  const speed = last / perTurn / (within[last] - within[0]);
  const at = (k) => (k < 0 ? 3 * within[0] - 3 * within[1] + within[2] : k > last ? 3 * within[last] - 3 * within[last - 1] + within[last - 2] : within[k]);
  const time = (turns) => {
    const place = Math.min(Math.max(turns * perTurn, 0), last);
    const before = Math.min(Math.floor(place), last - 1);
    const t = place - before;
    const [a, b, c, d] = [-1, 0, 1, 2].map((k) => at(before + k));
    return b + 0.5 * t * (c - a + t * (2 * a - 5 * b + 4 * c - d + t * (3 * (b - c) + d - a)));
  };
  const weight = kernel();
  const count = Math.floor((within[last] - within[0]) * rate);
  const resampled = Float64Array.from({ length: count }, (_, k) => between(values, time((k / rate) * speed) * rate, weight));
  return { values: resampled, speed_hz: speed };
}

/** Times at which a signal rises through the middle of its range [s]. */
export function pulsesOf(signal, rate) {
  const [least, most] = extremesOf(signal);
  const threshold = (least + most) / 2;
  const armedBelow = threshold - 0.1 * (most - least);
  const pulses = [];
  let armed = false;
  for (let k = 1; k < signal.length; k += 1) {
    armed ||= signal[k - 1] <= armedBelow;
    if (armed && signal[k - 1] < threshold && signal[k] >= threshold) {
      pulses.push((k - 1 + (threshold - signal[k - 1]) / (signal[k] - signal[k - 1])) / rate);
      armed = false;
    }
  }
  return pulses;
}

const ENTRIES = 512;
const HALF = 13;

/** The filter between samples, as a table: a sinc under a Kaiser window of 86 dB. */
function kernel() {
  const beta = 0.1102 * (86 - 8.7);
  const i0 = (x) => {
    let [term, sum] = [1, 1];
    for (let k = 1; term > 1e-17 * sum; k += 1) {
      term *= (x / 2 / k) ** 2;
      sum += term;
    }
    return sum;
  };
  const scale = i0(beta);
  const table = Array.from({ length: HALF * ENTRIES + 2 }, (_, k) => {
    const x = k / ENTRIES;
    const inside = 1 - (x / HALF) ** 2;
    return inside < 0 ? 0 : ((x === 0 ? 1 : Math.sin(Math.PI * x) / (Math.PI * x)) * i0(beta * Math.sqrt(inside))) / scale;
  });
  return (distance) => {
    const entry = distance * ENTRIES;
    const below = Math.floor(entry);
    return below >= HALF * ENTRIES ? 0 : table[below] + (entry - below) * (table[below + 1] - table[below]);
  };
}

function between(values, place, weight) {
  let [sum, weights] = [0, 0];
  const first = Math.max(Math.ceil(place - HALF), 0);
  const last = Math.min(Math.floor(place + HALF), values.length - 1);
  for (let k = first; k <= last; k += 1) {
    const share = weight(Math.abs(k - place));
    sum += share * values[k];
    weights += share;
  }
  return weights > 0 ? sum / weights : 0;
}

/** One-sided Hann amplitude spectrum of windows as long as those of a prediction of a resolution [Hz]; at most `most` windows. */
export function spectrumOf(values, rate, resolution, most = 1) {
  const length = Math.round(rate / resolution);
  const count = Math.min(Math.floor(values.length / length + 1e-9), most);
  if (count < 1 || length < 8) {
    throw new Error(`The record lasts ${(values.length / rate).toPrecision(3)} s: the spectrum needs ${(1 / resolution).toPrecision(3)} s.`);
  }
  const transform = fourier(length);
  const half = Math.floor(length / 2);
  const squares = new Float64Array(half + 1);
  for (let window = 0; window < count; window += 1) {
    const part = values.slice(window * length, (window + 1) * length);
    const mean = part.reduce((sum, value) => sum + value, 0) / length;
    const re = Float64Array.from(part, (value, k) => (value - mean) * (0.5 - 0.5 * Math.cos((2 * Math.PI * k) / length)));
    const im = new Float64Array(length);
    transform(re, im);
    for (let k = 0; k <= half; k += 1) squares[k] += (re[k] ** 2 + im[k] ** 2) / count;
  }
  const isEnd = (k) => k === 0 || (length % 2 === 0 && k === half);
  return {
    resolution_hz: rate / length,
    averages: count,
    highest_hz: PASS * rate,
    frequency_hz: Array.from({ length: half + 1 }, (_, k) => (k * rate) / length),
    amplitude: Array.from(squares, (square, k) => ((isEnd(k) ? 2 : 4) / length) * Math.sqrt(square)),
  };
}

/** Fourier transform in place of complex numbers, of any length: Bluestein's on powers of two. */
function fourier(length) {
  if (Number.isInteger(Math.log2(length))) return (re, im) => powerOfTwo(re, im);
  const size = 2 ** Math.ceil(Math.log2(2 * length - 1));
  const [cos, sin] = [new Float64Array(length), new Float64Array(length)];
  for (let k = 0; k < length; k += 1) {
    // k² modulo twice the length keeps the angle exact for long signals.
    const angle = (Math.PI * ((k * k) % (2 * length))) / length;
    [cos[k], sin[k]] = [Math.cos(angle), Math.sin(angle)];
  }
  const [chirpRe, chirpIm] = [new Float64Array(size), new Float64Array(size)];
  for (let k = 0; k < length; k += 1) {
    chirpRe[k] = cos[k];
    chirpIm[k] = sin[k];
    if (k) [chirpRe[size - k], chirpIm[size - k]] = [cos[k], sin[k]];
  }
  powerOfTwo(chirpRe, chirpIm);
  return (re, im) => {
    const [a, b] = [new Float64Array(size), new Float64Array(size)];
    for (let k = 0; k < length; k += 1) {
      a[k] = re[k] * cos[k] + im[k] * sin[k];
      b[k] = im[k] * cos[k] - re[k] * sin[k];
    }
    powerOfTwo(a, b);
    for (let k = 0; k < size; k += 1) {
      // The conjugate, so that a second transform is the inverse one.
      const [x, y] = [a[k] * chirpRe[k] - b[k] * chirpIm[k], a[k] * chirpIm[k] + b[k] * chirpRe[k]];
      [a[k], b[k]] = [x, -y];
    }
    powerOfTwo(a, b);
    for (let k = 0; k < length; k += 1) {
      const [x, y] = [a[k] / size, -b[k] / size];
      re[k] = x * cos[k] + y * sin[k];
      im[k] = y * cos[k] - x * sin[k];
    }
  };
}

function powerOfTwo(re, im) {
  const n = re.length;
  for (let i = 1, j = 0; i < n; i += 1) {
    let bit = n >> 1;
    for (; j & bit; bit >>= 1) j ^= bit;
    j ^= bit;
    if (i < j) {
      [re[i], re[j]] = [re[j], re[i]];
      [im[i], im[j]] = [im[j], im[i]];
    }
  }
  const [cos, sin] = [new Float64Array(n / 2), new Float64Array(n / 2)];
  for (let k = 0; k < n / 2; k += 1) [cos[k], sin[k]] = [Math.cos((2 * Math.PI * k) / n), -Math.sin((2 * Math.PI * k) / n)];
  for (let size = 2; size <= n; size *= 2) {
    const [half, stride] = [size / 2, n / size];
    for (let start = 0; start < n; start += size) {
      for (let k = 0; k < half; k += 1) {
        const [i, j, c, s] = [start + k, start + k + half, cos[k * stride], sin[k * stride]];
        const [x, y] = [re[j] * c - im[j] * s, re[j] * s + im[j] * c];
        re[j] = re[i] - x;
        im[j] = im[i] - y;
        re[i] += x;
        im[i] += y;
      }
    }
  }
}

/** Root mean squares of a spectrum in a band: of itself, and of its integral over time. */
export function bandOf({ frequency_hz: frequency, amplitude }, from, to) {
  let [own, integral] = [0, 0];
  // The rate of a record may be known to seven digits: an edge that meets a bin stays at it.
  const isBelow = (f, edge) => f < edge * (1 - EDGE_SHARE);
  frequency.forEach((f, k) => {
    if (isBelow(f, from) || !isBelow(f, to)) return;
    const square = (0.5 * amplitude[k] ** 2) / BANDWIDTH;
    own += square;
    integral += square / (2 * Math.PI * f) ** 2;
  });
  return { own: Math.sqrt(own), integral: Math.sqrt(integral) };
}

/** Lines of a spectrum up to a frequency [Hz], strongest first: `{ frequency_hz, amplitude, over_floor_db }`. */
export function linesOf(spectrum, highest) {
  const peaks = peaksOf(spectrum, highest);
  return peaks.filter(({ amplitude }) => amplitude > LEAST_SHARE * peaks[0].amplitude);
}

/** Lines of a spectrum and all weaker ones above its floor, however strong the strongest is. */
export function peaksOf({ amplitude, resolution_hz: resolution }, highest) {
  const end = Math.min(amplitude.length - LOBE, Math.floor(highest / resolution) + 1);
  const isMaximum = (bin) => [1, 2].every((d) => amplitude[bin] > amplitude[bin - d] && amplitude[bin] >= amplitude[bin + d]);
  const lines = [];
  for (let bin = LOBE; bin < end; bin += 1) {
    if (!isMaximum(bin)) continue;
    const floor = floorOf(amplitude, bin);
    if (amplitude[bin] <= FLOOR_FACTOR * floor) continue;
    const line = interpolated(amplitude, bin);
    lines.push({
      frequency_hz: line.bin * resolution,
      amplitude: line.amplitude,
      over_floor_db: floor > 0 ? 20 * Math.log10(line.amplitude / floor) : null,
    });
  }
  return lines.sort((one, other) => other.amplitude - one.amplitude);
}

/** Median of the bins around a line without other lines. */
function floorOf(amplitude, bin) {
  const around = [];
  for (let k = Math.max(bin - FLOOR_REACH, 0); k <= Math.min(bin + FLOOR_REACH, amplitude.length - 1); k += 1) {
    if (Math.abs(k - bin) > LOBE) around.push(amplitude[k]);
  }
  around.sort((one, other) => one - other);
  for (let rest = around; rest.length; ) {
    const median = rest[Math.floor(rest.length / 2)];
    const noise = rest.filter((entry) => entry <= FLOOR_FACTOR * median);
    if (noise.length === rest.length) return median;
    rest = noise;
  }
  return 0;
}

/** Place [bins] and amplitude of the tone at a bin, exact for one tone under a Hann window. */
function interpolated(amplitude, bin) {
  const [before, at, after] = [amplitude[bin - 1], amplitude[bin], amplitude[bin + 1]];
  const offset = Math.min(Math.max((2 * (after - before)) / (before + 2 * at + after), -0.5), 0.5);
  const sinc = offset === 0 ? 1 : Math.sin(Math.PI * offset) / (Math.PI * offset);
  return { bin: bin + offset, amplitude: (at * (1 - offset ** 2)) / sinc };
}

const decibels = (measured, predicted) => (measured > 0 && predicted > 0 ? 20 * Math.log10(measured / predicted) : null);

/** Predicted lines with their partners, by order, then weaker peaks of the prediction that were measured, and the measured lines where the
 *  prediction has none. `peaks`: all of the predicted spectrum. `speeds_hz`: of the predicted and of the measured shaft. */
export function comparedLines(predicted, measured, [own, other], resolution, peaks = []) {
  const reach = (SHIFT_BINS * resolution) / other;
  const ordered = (lines, speed) => lines.map((line) => ({ ...line, order: line.frequency_hz / speed }));
  const row = (line, found) => ({
    label: line.label,
    predicted_order: line.order,
    predicted_amplitude: line.amplitude,
    ...(found && {
      measured_order: found.order,
      order_difference_percent: 100 * (found.order / line.order - 1),
      measured_amplitude: found.amplitude,
      level_ratio_db: decibels(found.amplitude, line.amplitude),
      over_floor_db: found.over_floor_db,
    }),
  });
  const [listed, lines] = [ordered(predicted, own), ordered(measured, other)];
  const shifts = shiftsOf(listed, lines.map(({ order }) => order), reach);
  const partners = partnersOf(listed, lines, shifts, reach);
  const left = lines.filter((line) => !partners.includes(line));
  const isListed = ({ frequency_hz }) => predicted.some((line) => Math.abs(line.frequency_hz - frequency_hz) <= SHIFT_BINS * resolution);
  const weaker = ordered(peaks.filter((peak) => !isListed(peak)), own);
  const ofPeaks = shiftsOfPeaks(shifts, weaker, left.map(({ order }) => order), reach);
  const ofWeaker = partnersOf(weaker, left, ofPeaks, reach);
  const pairs = weaker.map((line, k) => [line, ofWeaker[k]]).filter(([, found]) => found).slice(0, MOST_WEAKER);
  // A pair that is not shown leaves its measured line among the others.
  const shown = pairs.map(([, found]) => found);
  return {
    lines: [...listed.map((line, k) => row(line, partners[k])), ...pairs.map(([line, found]) => row(line, found))],
    others: left.filter((line) => !shown.includes(line)),
  };
}

/** Levels of both spectra of an acceleration [m/s²] in bands `[from, to]` [Hz] that both cover. Other motions have no velocity. */
export function comparedLevels(measured, predicted, bands, { isAcceleration, unit, from, to }) {
  const rows = [[from, to, false], ...(isAcceleration ? [[10, 1000, true], ...bands.flatMap(([low, high]) => [[low, high, false], [low, high, true]])] : [])];
  return rows
    .filter(([low, high]) => low >= from * (1 - 1e-9) && high <= to * (1 + 1e-9))
    .map(([low, high, isVelocity]) => {
      const [one, other] = [measured, predicted].map((spectrum) => bandOf(spectrum, low, high)).map((band) => (isVelocity ? 1e6 * band.integral : band.own));
      return { from_hz: low, to_hz: high, unit: isVelocity ? 'µm/s' : unit, measured: one, predicted: other, level_ratio_db: decibels(one, other) };
    });
}
