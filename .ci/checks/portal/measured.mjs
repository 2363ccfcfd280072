// Measured files on the page: the readers and the spectrum alone, and a file on an opened result.

import assert from 'node:assert/strict';
import { cpSync, mkdtempSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { ok } from './tools.mjs';

const RATE = 51200;
const SPEED = 50;
/** Amplitude and phase by order. */
const TONES = [
  [1, 0.3, 1],
  [3.585, 1, 0],
  [16, 0.5, 2],
  [40, 0.2, 3],
];

/** Tones at orders of a shaft of `speed` [Hz] over `duration` [s]. */
const signal = (speed = SPEED, duration = 1, rate = RATE) =>
  Float64Array.from({ length: Math.round(duration * rate) }, (_, k) =>
    TONES.reduce((sum, [order, amplitude, phase]) => sum + amplitude * Math.sin((2 * Math.PI * order * speed * k) / rate + phase), 0),
  );

const buffer = (...parts) => {
  const bytes = Buffer.concat(parts.map((part) => (typeof part === 'string' ? Buffer.from(part, 'latin1') : Buffer.from(part.buffer ?? part, part.byteOffset, part.byteLength))));
  return bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.byteLength);
};
const text = (string) => new TextEncoder().encode(string).buffer;

/** A WAV file with one channel of whole numbers of 16 or 24 bits, or of floats. */
export function wavOf(values, { bits = 16, rate = RATE } = {}) {
  const size = bits / 8;
  const data = Buffer.alloc(values.length * size);
  values.forEach((value, k) => {
    if (bits === 32) data.writeFloatLE(value, k * size);
    else data.writeIntLE(Math.round(value * (2 ** (bits - 1) - 1)), k * size, size);
  });
  const head = Buffer.alloc(44);
  head.write('RIFF', 0);
  head.writeUInt32LE(36 + data.length, 4);
  head.write('WAVEfmt ', 8);
  head.writeUInt32LE(16, 16);
  head.writeUInt16LE(bits === 32 ? 3 : 1, 20);
  head.writeUInt16LE(1, 22);
  head.writeUInt32LE(rate, 24);
  head.writeUInt32LE(rate * size, 28);
  head.writeUInt16LE(size, 32);
  head.writeUInt16LE(bits, 34);
  head.write('data', 36);
  head.writeUInt32LE(data.length, 40);
  return buffer(head, data);
}

function npyOf(shape, data, descr = "'<f4'", fortran = 'False') {
  const head = `{'descr': ${descr}, 'fortran_order': ${fortran}, 'shape': (${shape}), }`.padEnd(117) + '\n';
  return buffer('\x93NUMPY\x01\x00', String.fromCharCode(head.length & 255, head.length >> 8), head, data);
}

function uffOf(values, { binary = false } = {}) {
  const head = [
    'bearing housing',
    'NONE',
    '01-Jan-26 12:00:00',
    'NONE',
    'NONE',
    '    1         0    0         0       NONE         0   0       NONE         0   0',
    `         2${String(values.length).padStart(10)}         1  0.00000E+00  ${(1 / RATE).toExponential(5).toUpperCase()}  0.00000E+00`,
    '        17    0    0    0                 Time                    s',
    '        12    0    0    0                  ACC                    g',
    '         0    0    0    0                 NONE                 NONE',
    '         0    0    0    0                 NONE                 NONE',
  ];
  const kind = binary ? `    58b     1     2          11${String(4 * values.length).padStart(12)}     0     0           0           0` : '    58';
  const open = `    -1\n   151\nof another kind\n    -1\n    -1\n${[kind, ...head].join('\n')}\n`;
  if (binary) return buffer(open, Float32Array.from(values), '\n    -1\n');
  const rows = [];
  for (let k = 0; k < values.length; k += 6) rows.push([...values.slice(k, k + 6)].map((v) => v.toExponential(5).toUpperCase().padStart(13)).join(''));
  return buffer(`${open}${rows.join('\n')}\n    -1\n`);
}

const near = (found, expected, tolerance, what) => assert.ok(Math.abs(found - expected) <= tolerance, `${what}: ${found}, not ${expected}`);

/** Modules of the page in Node.js. */
export async function alone() {
  const page = mkdtempSync(join(tmpdir(), 'raceway-measured-'));
  cpSync(new URL('../../../src/api/portal', import.meta.url), page, { recursive: true });
  writeFileSync(join(page, 'package.json'), '{ "type": "module" }');
  try {
    files(await import(`${page}/measured-files.js`));
    await spectra(await import(`${page}/measured-spectrum.js`), await import(`${page}/measured-files.js`));
  } finally {
    rmSync(page, { recursive: true });
  }
  ok('measured files of four formats, their spectra, levels and lines by order');
}

function files({ readMeasured }) {
  const csv = (string) => readMeasured(text(string));
  const values = (read, k = 0) => [...read.columns[k].values];
  const time = csv('\ufefftime [s];acc [m/s²]; tacho\r\n0,000;1,5;0\r\n0,001;-2e-1;5\r\n0,002;0,25;0\r\n');
  assert.deepEqual([time.rate_hz.toFixed(3), time.unit, time.columns.map(({ name }) => name)], ['1000.000', 'm/s2', ['acc [m/s²]', 'tacho']]);
  assert.deepEqual(values(time), [1.5, -0.2, 0.25]);
  assert.deepEqual(values(csv('1.5,7\n2.5,6\n-3,9\n')), [1.5, 2.5, -3]);
  assert.deepEqual(values(csv('0,5\n-0,25\n1\n')), [0.5, -0.25, 1], 'one column with decimal commas');
  assert.deepEqual(values(csv('recorder X\nno 5\nms\tg\n0\t1\n0.5\t2\n1.0\t3\n')), [1, 2, 3]);
  assert.equal(csv('time_ms,acc_g\n0,1\n0.5,2\n1.0,3\n').rate_hz, 2000);
  assert.equal(csv('acc_g\n1\n2\n').unit, 'g');
  for (const heading of ['m/s²', 'acc [m/s²]', 'acc (m/s^2)', 'acc m/s2']) assert.equal(csv(`${heading}\n1\n2\n`).unit, 'm/s2', heading);
  assert.equal(csv('[µm/s]\n1\n2\n').unit, 'um/s');
  assert.throws(() => csv('1\n2\nx\n'), /Line 3: 1 numbers expected, found “x”/);
  assert.throws(() => csv('a\nb\n'), /no row of numbers/);
  assert.throws(() => readMeasured(new ArrayBuffer(65 * 1024 * 1024)), /at most 64 MB/);
  const own = signal(SPEED, 0.01);
  const close = (read, tolerance, k = 0) => read.columns[k].values.forEach((value, i) => near(value, own[i], tolerance, `value ${i}`));
  const single = readMeasured(npyOf(`${own.length},`, Float32Array.from(own)));
  assert.equal(single.columns.length, 1);
  close(single, 1e-6);
  const pairs = Float64Array.from({ length: 2 * own.length }, (_, k) => (k % 2 ? own[(k - 1) / 2] : 7));
  close(readMeasured(npyOf(`${own.length}, 2`, pairs, "'<f8'")), 0, 1);
  const rows = Float64Array.from({ length: 2 * own.length }, (_, k) => (k < own.length ? 7 : own[k - own.length]));
  close(readMeasured(npyOf(`2, ${own.length}`, rows, "'<f8'")), 0, 1);
  close(readMeasured(npyOf(`${own.length}, 2`, rows, "'<f8'", 'True')), 0, 1);
  const records = Float64Array.from({ length: 2 * own.length }, (_, k) => (k % 2 ? own[(k - 1) / 2] : k / 2 / RATE));
  const series = readMeasured(npyOf(`${own.length},`, records, "[('time_s', '<f8'), ('value', '<f8')]"));
  near(series.rate_hz, RATE, 1e-6, 'rate of a series of this service');
  close(series, 0);
  assert.throws(() => readMeasured(npyOf('9,', Float32Array.from(own).subarray(0, 5))), /shorter than its head/);
  for (const [bits, tolerance] of [
    [16, 4e-5],
    [24, 2e-7],
    [32, 1e-7],
  ]) {
    const read = readMeasured(wavOf(own.map((value) => value / 4), { bits }));
    assert.deepEqual([read.rate_hz, read.hasFullScale, read.columns.length], [RATE, true, 1]);
    read.columns[0].values.forEach((value, i) => near(value, own[i] / 4, tolerance, `${bits} bits`));
  }
  for (const binary of [false, true]) {
    const read = readMeasured(uffOf(own, { binary }));
    assert.deepEqual([read.format, read.unit, read.columns[0].name, read.columns[0].values.length], ['UFF 58', 'g', 'ACC', own.length]);
    near(read.rate_hz, RATE, 0.5, 'rate');
    close(read, 1e-5);
  }
  assert.throws(() => readMeasured(buffer('    -1\n   151\nname\n    -1\n')), /no dataset 58/);
}

function spectra({ spectrumOf, linesOf, peaksOf, comparedLines, comparedLevels, byAngle, pulsesOf, bandOf, requireVibration }, { readMeasured }) {
  const constant = readMeasured(text('acc_g\n0.3\n0.3\n0.3\n')).columns[0];
  assert.throws(() => requireVibration(constant), /All values of acc_g are 0.3: there is no vibration to compare/);
  assert.throws(() => requireVibration({ name: 'zeros', values: new Float64Array(5) }), /are 0: there is no vibration/);
  requireVibration({ name: 'offset', values: signal().map((value) => 1e3 + 1e-6 * value) });
  const predicted = spectrumOf(signal(), RATE, 1);
  assert.deepEqual([predicted.resolution_hz, predicted.averages, predicted.highest_hz], [1, 1, 20480]);
  near(predicted.amplitude[800], 0.5, 1e-9, 'a tone on a bin reads its amplitude');
  near(bandOf(predicted, 300, 1800).own, 0.5 / Math.SQRT2, 1e-6, 'and its rms');
  near(bandOf(predicted, 300, 1800).integral, 0.5 / Math.SQRT2 / (2 * Math.PI * 800), 1e-8, 'and that of its integral');
  // A length that is no power of two, and a prime.
  for (const rate of [48828, 10007]) near(spectrumOf(signal(SPEED, 1, rate), rate, 1).amplitude[800], 0.5, 1e-6, `${rate} values`);
  assert.equal(spectrumOf(signal(SPEED, 3.5), RATE, 1, 2).averages, 2);
  assert.throws(() => spectrumOf(signal(SPEED, 0.5), RATE, 1), /lasts 0.500 s: the spectrum needs 1.00 s/);
  const lines = linesOf(predicted, 20000);
  assert.equal(lines.length, 4);
  const named = lines.map((line) => ({ ...line, label: 'line' }));
  // Peaks of the prediction that are no listed lines have partners, too.
  const weaker = comparedLines(named.slice(0, 1), lines, [SPEED, SPEED], 1, peaksOf(predicted, 20000));
  assert.deepEqual([weaker.lines.length, weaker.others.length], [4, 0]);
  seriesShareTheirShift(comparedLines);
  const compare = (values, rate, speed, length = 1) => {
    const measured = spectrumOf(values, rate, 1, length);
    const { lines: found, others } = comparedLines(named, linesOf(measured, 20000), [SPEED, speed], 1);
    const levels = comparedLevels(measured, predicted, [[50, 300], [300, 1800]], { isAcceleration: true, unit: 'm/s²', from: 2, to: 20000 });
    assert.equal(others.length, 0);
    assert.equal(levels.length, 6);
    return [...levels, ...found];
  };
  const worst = (rows, decibels, percent, tolerance = [1e-6, 1e-6]) =>
    rows.forEach((row) => {
      if (decibels !== null) near(row.level_ratio_db, decibels, tolerance[0], 'ratio');
      if (row.label) near(row.order_difference_percent, percent, tolerance[1], 'difference of orders');
    });
  worst(compare(signal(), RATE, SPEED), 0, 0);
  worst(compare(signal().map((value) => 2 * value), RATE, SPEED), 20 * Math.log10(2), 0);
  // 16 bits: 0.01 dB.
  const { columns } = readMeasured(wavOf(signal().map((value) => value / 4)));
  worst(compare(columns[0].values.map((value) => 4 * value), RATE, SPEED), 0, 0, [0.01, 1e-3]);
  // Time stretched by 1 %: with a tachometer the orders are the same.
  const fast = signal(1.01 * SPEED, 1.2);
  worst(compare(fast, RATE, SPEED), null, 1, [0, 5e-3]);
  const pulses = pulsesOf(Float64Array.from({ length: fast.length }, (_, k) => Math.sin((2 * Math.PI * 4 * 1.01 * SPEED * k) / RATE)), RATE);
  const turned = byAngle(fast, RATE, pulses, 4);
  near(turned.speed_hz, 1.01 * SPEED, 1e-4, 'speed by the tachometer');
  worst(compare(turned.values, RATE, turned.speed_hz), null, 0, [0, 5e-3]);
  assert.throws(() => byAngle(fast, RATE, [0.1, 0.2], 1), /2 pulses within the record/);
}

/** Harmonics of BPFO and sidebands of the shaft beside stronger lines of the machine, as in the tests of the API. */
function seriesShareTheirShift(comparedLines) {
  const line = (order, label) => ({ frequency_hz: SPEED * order, amplitude: 1 / order, label });
  const harmonics = [1, 2, 3, 8, 11, 15].map((k) => line(3.585 * k, k === 1 ? 'BPFO' : `${k}·BPFO`));
  const predicted = [...harmonics, line(10 * 3.585 - 4, '10·BPFO − 4·f_r'), line(3, '3·f_r')];
  const stray = [8 * 1.018, 11 * 0.988, 15 * 1.012].map((k) => line(3.585 * k));
  for (const shift of [1, 0.994, 1.013]) {
    const slipped = [...harmonics.map(({ frequency_hz }) => line((shift * frequency_hz) / SPEED)), line(10 * 3.585 * shift - 4), line(3)];
    const { lines, others } = comparedLines(predicted, [...stray, ...slipped], [SPEED, SPEED], 0.5);
    lines.forEach((row, k) => near(row.measured_order, slipped[k].frequency_hz / SPEED, 1e-9, `${row.label} at a shift of ${shift}`));
    assert.deepEqual(others.map((one) => one.order), stray.map((one) => one.frequency_hz / SPEED));
  }
}

/** A file on an opened result of a run at 3000 r/min: no request carries it. */
export async function onResult(page) {
  const panel = page.locator('details.measured');
  await panel.waitFor();
  await panel.locator('summary').click();
  const sent = [];
  const note = (request) => request.method() === 'POST' && sent.push(request.url());
  page.on('request', note);
  const file = { name: 'measured.wav', mimeType: 'audio/wav', buffer: Buffer.from(wavOf(signal(SPEED, 1.2).map((value) => value / 4))) };
  await panel.locator('input[type=file]').setInputFiles(file);
  await panel.getByRole('region', { name: 'Measured and predicted levels, rms' }).waitFor();
  await panel.getByLabel('Full scale').fill('4');
  await panel.getByLabel('Full scale').press('Enter');
  await panel.getByText(/apparent transfer/).waitFor();
  await panel.locator('figure canvas').waitFor();
  assert.ok((await panel.getByRole('region', { name: 'Measured and predicted lines by order' }).locator('tbody tr').count()) > 0);
  const wrong = { name: 'measured.csv', mimeType: 'text/csv', buffer: Buffer.from('1\n2\nx\n') };
  await panel.locator('input[type=file]').setInputFiles(wrong);
  await panel.getByText('Line 3: 1 numbers expected').waitFor();
  const constant = { name: 'constant.csv', mimeType: 'text/csv', buffer: Buffer.from(`acc_g\n${'0.3\n'.repeat(20)}`) };
  await panel.locator('input[type=file]').setInputFiles(constant);
  await panel.getByText('there is no vibration to compare').waitFor();
  page.off('request', note);
  assert.deepEqual(sent, [], 'no file leaves the browser');
  ok('a measured file is drawn over a result, compared by order, and never sent');
}
