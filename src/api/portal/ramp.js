// A speed ramp: two points of the speed's profile, recorded from the first to the last, with orders.

import { readNumber } from './form.js';
import { write } from './request.js';

const SPEED = '/scene/operation/speed_rpm';
/** Time at the first speed before recording begins [s], and time of a ramp that has none yet [s]. */
const SETTLE = 0.05;
const TIME = 1;

export const RAMP_HELP = {
  to: 'Last speed of a run-up or a run-down. The run is recorded over the ramp and opens as a waterfall. Empty: constant speed.',
  time: 'Time from the first to the last speed.',
};

/** First and last speed [r/min] and time [s] of a request's ramp; of a constant speed only the first. */
export function rampOf(request) {
  const speed = request.scene?.operation?.speed_rpm;
  if (!Array.isArray(speed) || speed.length !== 2) return { from: speed };
  const [first, last] = speed;
  return { from: first.rpm, to: last.rpm, time: Number((last.at_s - first.at_s).toPrecision(9)) };
}

/** The `value` of a typed ramp time, undefined if the text is empty, or an `error`. */
export function readRampTime(text) {
  const read = readNumber(text);
  return read.value <= 0 ? { error: 'The time of a ramp must be above 0 s.' } : read;
}

/** Fields of a ramp by the pointers into its profile. */
const OF_PROFILE = {
  [`${SPEED}/0/rpm`]: SPEED,
  [`${SPEED}/1/rpm`]: '/ramp/to',
  [`${SPEED}/1/at_s`]: '/ramp/time',
};

/** Errors of a ramp's profile, at the fields of the ramp. */
export const atRamp = (errors) => errors.map((error) => ({ ...error, pointer: OF_PROFILE[error.pointer] ?? error.pointer }));

/** A request with this ramp; without a last speed, with a constant one. */
export function withRamp(request, { from, to, time = TIME }) {
  if (to === undefined) {
    if (rampOf(request).to === undefined) return write(request, SPEED, from);
    const plain = ['/settle_s', '/duration_s', '/outputs/orders'].reduce((one, pointer) => write(one, pointer, undefined), request);
    return write(plain, SPEED, from);
  }
  const settle = request.settle_s ?? SETTLE;
  const profile = [
    { at_s: settle, rpm: from },
    { at_s: Number((settle + time).toPrecision(9)), rpm: to },
  ];
  const ramped = [
    [SPEED, profile],
    ['/settle_s', settle],
    ['/duration_s', time],
  ].reduce((one, [pointer, value]) => write(one, pointer, value), request);
  return { ...ramped, outputs: { ...ramped.outputs, orders: ramped.outputs?.orders ?? {} } };
}
