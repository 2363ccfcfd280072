// Waterfall and orders of a run-up, as the service draws them.

import * as api from './api.js';
import { picture } from './plots.js';

export const RUN_UP_VIEWS = [
  ['waterfall', 'Waterfall'],
  ['orders', 'Orders'],
];

const TEXTS = {
  waterfall: 'Spectra over the shaft speed, with labelled orders.',
  orders: 'The mean order spectrum, and amplitudes of orders over the shaft speed.',
};

/** One shaft frequency says nothing about a run-up. */
export const isRunUp = ({ request }) => Array.isArray(request.scene?.operation?.speed_rpm);

/** A plot of a job: its element, its text and its path. */
export async function drawn(job, view, text, signal) {
  const path = `/v1/jobs/${job.id}/plots/${view}.svg`;
  const svg = await api.getText(path, 'image/svg+xml', { signal });
  return { element: picture(svg, text), svg, path };
}

/** The waterfall or the orders of a job. */
export const runUp = (job, view, signal) => drawn(job, view, TEXTS[view], signal);
