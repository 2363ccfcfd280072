// Files with measured signals, read in the browser: CSV, NPY, WAV and UFF 58. Nothing is sent.

/** Largest file [bytes]. */
export const LARGEST = 64 * 1024 * 1024;

/** The signals of a file: `{ format, columns: [{ name, values }], rate_hz, unit }`. Rate and unit are null where the file does not say them. */
export function readMeasured(buffer) {
  if (buffer.byteLength > LARGEST) throw new Error(`The file has ${Math.round(buffer.byteLength / 1048576)} MB: at most 64 MB.`);
  const bytes = new Uint8Array(buffer);
  const start = latin(bytes, 0, 12);
  if (start.startsWith('\x93NUMPY')) return npy(bytes);
  if (start.startsWith('RIFF') && start.endsWith('WAVE')) return wav(bytes);
  if (/^\s*-1\s*$/.test(latin(bytes, 0, 200).split(/\r?\n/).find((line) => line.trim()) ?? '')) return uff(bytes);
  return csv(new TextDecoder().decode(bytes));
}

/** Bytes as Latin-1 text. */
function latin(bytes, from, to) {
  let text = '';
  for (let at = from; at < Math.min(to, bytes.length); at += 32768) text += String.fromCharCode(...bytes.subarray(at, Math.min(at + 32768, to)));
  return text;
}

const finite = (columns) => {
  if (!columns.length || columns[0].values.length < 2) throw new Error('The file has fewer than two values.');
  for (const { name, values } of columns) {
    const at = values.findIndex((value) => !Number.isFinite(value));
    if (at >= 0) throw new Error(`Value ${at + 1} of ${name} is no finite number.`);
  }
  return columns;
};

// CSV

const NUMBER = /^[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?$/;

/** Separator and decimal comma of the lines of a table. */
function dialect(lines) {
  const all = (character) => lines.length > 0 && lines.every((line) => line.includes(character));
  if (all(';')) return { separator: ';', comma: !lines.some((line) => /\d\.\d/.test(line)) };
  if (all('\t')) return { separator: '\t', comma: !lines.some((line) => /\d\.\d/.test(line)) };
  // A single column with decimal commas has one comma in each line and no point.
  const single = lines.every((line) => /^\s*[+-]?\d+(,\d+)?([eE][+-]?\d+)?\s*$/.test(line)) && lines.some((line) => line.includes(','));
  if (single) return { separator: ';', comma: true };
  return { separator: ',', comma: false };
}

function csv(text) {
  const lines = text.replace(/^\ufeff/, '').split(/\r\n|\n|\r/);
  const sample = lines.slice(0, 300).filter((line) => /^\s*"?[+-]?\.?\d/.test(line)).slice(-20);
  const { separator, comma } = dialect(sample);
  const cells = (line) => line.split(separator).map((cell) => cell.trim().replace(/^"(.*)"$/, '$1'));
  const numberOf = (cell) => {
    const plain = comma ? cell.replace(',', '.') : cell;
    return NUMBER.test(plain) ? Number(plain) : NaN;
  };
  let heading = null;
  let columns = null;
  lines.forEach((line, k) => {
    if (!line.trim()) return;
    const row = cells(line);
    // A separator at the end of a line makes no column.
    if (row.length > 1 && row.at(-1) === '') row.pop();
    const numbers = row.map(numberOf);
    if (!columns) {
      if (numbers.some(Number.isNaN)) {
        heading = row;
        if (k > 200) throw new Error('The first 200 lines have no row of numbers.');
        return;
      }
      columns = numbers.map(() => []);
    }
    if (numbers.length !== columns.length || numbers.some(Number.isNaN)) {
      throw new Error(`Line ${k + 1}: ${columns.length} numbers expected, found “${line.slice(0, 40)}”.`);
    }
    numbers.forEach((value, i) => columns[i].push(value));
  });
  if (!columns) throw new Error('The file has no row of numbers.');
  const named = columns.map((values, i) => ({
    name: (heading?.length === columns.length && heading[i]) || `column ${i + 1}`,
    values: Float64Array.from(values),
  }));
  const time = timeColumn(finite(named));
  const rest = time ? named.slice(1) : named;
  return { format: 'CSV', columns: rest, rate_hz: time, unit: unitIn(rest[0].name) };
}

/** Rate of the first column if it is an even time [Hz], else null. */
function timeColumn(columns) {
  if (columns.length < 2) return null;
  const [{ name, values }] = columns;
  const step = (values.at(-1) - values[0]) / (values.length - 1);
  if (!(step > 0)) return null;
  for (let k = 1; k < values.length; k += 1) if (Math.abs(values[k] - values[k - 1] - step) > 0.1 * step) return null;
  return (/\bms\b|\[ms\]|_ms$/i.test(name) ? 1000 : 1) / step;
}

/** The unit that a heading names, as in `acc [m/s²]` or `acc_g`, else null. */
function unitIn(name) {
  const text = name.replace('²', '2').replace('^2', '2').replace(/[µμ]/g, 'u').toLowerCase();
  const found = text.match(/(?:[[(_ ]|^)(m\/s2|um\/s|mm\/s|m\/s|mm|um|g)(?:[\])]|$)/);
  return found?.[1] ?? null;
}

// NPY

const KINDS = { f4: [4, 'getFloat32'], f8: [8, 'getFloat64'], i2: [2, 'getInt16'], i4: [4, 'getInt32'] };

function npy(bytes) {
  const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
  const isLong = bytes[6] > 1;
  const length = isLong ? view.getUint32(8, true) : view.getUint16(8, true);
  const begin = (isLong ? 12 : 10) + length;
  const head = latin(bytes, isLong ? 12 : 10, begin);
  const shape = head.match(/'shape':\s*\(([^)]*)\)/)?.[1].split(',').filter((part) => part.trim()).map(Number);
  const fields = [...head.matchAll(/\('([^']+)',\s*'([<>|=])(\w\d)'\)/g)].map(([, name, order, kind]) => ({ name, order, kind }));
  const plain = head.match(/'descr':\s*'([<>|=])(\w\d)'/);
  const types = fields.length ? fields : plain ? [{ name: 'values', order: plain[1], kind: plain[2] }] : [];
  if (!shape || !types.length || types.some(({ kind }) => !KINDS[kind])) throw new Error('The NPY file must hold numbers of the types f4, f8, i2 or i4.');
  if (shape.length < 1 || shape.length > 2 || (fields.length && shape.length !== 1)) throw new Error('The NPY file must have one or two dimensions.');
  const [rows, columns] = shape.length === 2 ? shape : [shape[0], 1];
  const width = types.reduce((sum, { kind }) => sum + KINDS[kind][0], 0);
  if (begin + rows * columns * width > bytes.length) throw new Error('The NPY file is shorter than its head says.');
  if (fields.length) {
    let offset = begin;
    const read = types.map(({ name, order, kind }) => {
      const [size, method] = KINDS[kind];
      const values = Float64Array.from({ length: rows }, (_, k) => view[method](offset + k * width, order !== '>'));
      offset += size;
      return { name, values };
    });
    const time = timeColumn(finite(read));
    return { format: 'NPY', columns: time ? read.slice(1) : read, rate_hz: time, unit: null };
  }
  const [size, method] = KINDS[types[0].kind];
  const little = types[0].order !== '>';
  const byColumn = /'fortran_order':\s*True/.test(head);
  const at = (row, column) => view[method](begin + size * (byColumn ? column * rows + row : row * columns + column), little);
  // Signals are the longer dimension.
  const isTall = rows >= columns;
  const [signals, values] = isTall ? [columns, rows] : [rows, columns];
  const read = Array.from({ length: signals }, (_, signal) => ({
    name: `column ${signal + 1}`,
    values: Float64Array.from({ length: values }, (__, k) => (isTall ? at(k, signal) : at(signal, k))),
  }));
  return { format: 'NPY', columns: finite(read), rate_hz: null, unit: null };
}

// WAV

function wav(bytes) {
  const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
  let format = null;
  for (let at = 12; at + 8 <= bytes.length; ) {
    const [name, size] = [latin(bytes, at, at + 4), view.getUint32(at + 4, true)];
    const body = at + 8;
    if (name === 'fmt ') {
      const code = view.getUint16(body, true);
      format = {
        // The extensible form names the code in its first field of the sub-format.
        code: code === 0xfffe ? view.getUint16(body + 24, true) : code,
        channels: view.getUint16(body + 2, true),
        rate: view.getUint32(body + 4, true),
        bits: view.getUint16(body + 14, true),
      };
    } else if (name === 'data' && format) {
      return samples(view, body, Math.min(size, bytes.length - body), format);
    }
    // Chunks begin at even places.
    at = body + size + (size % 2);
  }
  throw new Error('The WAV file has no samples.');
}

function samples(view, begin, length, { code, channels, rate, bits }) {
  const readers = {
    '1,16': (at) => view.getInt16(at, true) / 0x8000,
    '1,24': (at) => (view.getUint16(at, true) + view.getInt8(at + 2) * 0x10000) / 0x800000,
    '1,32': (at) => view.getInt32(at, true) / 0x80000000,
    '3,32': (at) => view.getFloat32(at, true),
    '3,64': (at) => view.getFloat64(at, true),
  };
  const read = readers[[code, bits]];
  if (!read || channels < 1) throw new Error(`A WAV file of code ${code} with ${bits} bits is not read: PCM of 16, 24 or 32 bits, or float.`);
  const frame = (channels * bits) / 8;
  const count = Math.floor(length / frame);
  const columns = Array.from({ length: channels }, (_, channel) => ({
    name: `channel ${channel + 1}`,
    values: Float64Array.from({ length: count }, (__, k) => read(begin + k * frame + (channel * bits) / 8)),
  }));
  return { format: 'WAV', columns: finite(columns), rate_hz: rate, unit: null, hasFullScale: true };
}

// UFF 58

/** Datasets 58 of a universal file, ASCII or binary: each is one column. */
function uff(bytes) {
  const columns = [];
  let [rate, unit] = [null, null];
  const lines = new Lines(bytes);
  for (let line = lines.next(); line !== null; line = lines.next()) {
    if (line.trim() !== '-1') continue;
    const kind = lines.next();
    if (kind === null) break;
    const isBinary = /^\s*58b/i.test(kind);
    if (!isBinary && kind.trim() !== '58') {
      // Another dataset, up to its end.
      for (let rest = lines.next(); rest !== null && rest.trim() !== '-1'; ) rest = lines.next();
      continue;
    }
    const found = dataset(lines, isBinary ? kind : null, columns.length + 1);
    if (rate !== null && Math.abs(found.rate_hz / rate - 1) > 1e-6) throw new Error('The records of the UFF file have different rates.');
    columns.push({ name: found.name, values: found.values });
    rate = found.rate_hz;
    unit ??= found.unit;
  }
  if (!columns.length) throw new Error('The UFF file has no dataset 58.');
  const shortest = Math.min(...columns.map(({ values }) => values.length));
  for (const column of columns) column.values = column.values.subarray(0, shortest);
  return { format: 'UFF 58', columns: finite(columns), rate_hz: rate, unit };
}

class Lines {
  constructor(bytes) {
    Object.assign(this, { bytes, at: 0 });
  }

  /** The next line; null at the end. */
  next() {
    if (this.at >= this.bytes.length) return null;
    const end = this.bytes.indexOf(10, this.at);
    const to = end < 0 ? this.bytes.length : end;
    const line = latin(this.bytes, this.at, to).replace(/\r$/, '');
    this.at = to + 1;
    return line;
  }
}

const TIME_RESPONSE = [0, 1];

function dataset(lines, binary, number) {
  const head = Array.from({ length: 11 }, () => lines.next() ?? '');
  const type = parseInt(head[5].slice(0, 5), 10);
  if (!TIME_RESPONSE.includes(type)) throw new Error(`Dataset ${number} of the UFF file is of function type ${type}: only time responses (1) are read.`);
  const [ordinate, count, spacing, , step] = head[6].trim().split(/\s+/).map(Number);
  if (![2, 4].includes(ordinate)) throw new Error(`Dataset ${number} of the UFF file holds no real numbers.`);
  if (spacing !== 1 || !(step > 0)) throw new Error(`Dataset ${number} of the UFF file is not evenly spaced.`);
  const isDouble = ordinate === 4;
  const values = binary ? binaryValues(lines, binary, count, isDouble) : asciiValues(lines, count);
  if (values.length < count) throw new Error(`Dataset ${number} of the UFF file has ${values.length} of ${count} values.`);
  // Ordinate: type, three exponents, label and unit.
  const [label, units] = [head[8].slice(26, 46).trim(), head[8].slice(47, 67).trim()];
  const name = [label, head[0].trim()].find((text) => text && text !== 'NONE') ?? `record ${number}`;
  return { name, values, rate_hz: 1 / step, unit: unitIn(units) };
}

function asciiValues(lines, count) {
  const values = new Float64Array(count);
  let found = 0;
  while (found < count) {
    const line = lines.next();
    if (line === null || line.trim() === '-1') break;
    // Fields of a fixed width may touch each other.
    for (const [text] of line.matchAll(/[+-]?(\d+\.?\d*|\.\d+)([eEdD][+-]?\d+)?/g)) {
      if (found < count) values[found++] = Number(text.replace(/[dD]/, 'e'));
    }
  }
  return values.subarray(0, found);
}

function binaryValues(lines, kind, count, isDouble) {
  const [order, form] = kind.trim().split(/\s+/).slice(1).map(Number);
  if (form !== 2) throw new Error('The binary UFF file is not in IEEE 754 numbers.');
  const size = isDouble ? 8 : 4;
  const { bytes } = lines;
  const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
  const there = Math.max(Math.min(count, Math.floor((bytes.length - lines.at) / size)), 0);
  const read = isDouble ? 'getFloat64' : 'getFloat32';
  const values = Float64Array.from({ length: there }, (_, k) => view[read](lines.at + k * size, order === 1));
  lines.at += there * size;
  return values;
}
