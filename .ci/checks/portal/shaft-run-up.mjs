// A run-up of a shaft on the page: it opens as a waterfall, shows orders and spectrum, and keeps its outputs when it is edited. A study over
// uncertain inputs names its statistic.

import assert from 'node:assert/strict';
import { ok, picture, tab } from './tools.mjs';

const RUN_UP = {
  kind: 'machine',
  scene: {
    shaft: { sections: [{ length_mm: 300, outer_diameter_mm: 40 }], unbalances: [{ at_mm: 150, unbalance_g_mm: 20 }] },
    bearings: ['A', 'B'].map((name, i) => ({ name, bearing: '6205', at_mm: 40 + 220 * i, faces: i ? '-x' : '+x' })),
    preloads: [{ between: ['A', 'B'], force_n: 200 }],
    operation: { speed_rpm: [{ at_s: 0.05, rpm: 9000 }, { at_s: 0.35, rpm: 12000 }], radial_load_y_n: 100 },
  },
  settle_s: 0.05,
  outputs: { orders: { max_order: 20, turns_per_block: 8 } },
};

const STUDY = {
  kind: 'study',
  scene: { bearing: '6205', operation: { speed_rpm: 6000, radial_load_y_n: 500 } },
  settle_s: 0.02,
  duration_s: 0.05,
  solver: { rung: 'radially_condensed', model_tolerance_db: 1 },
  axes: [{ path: '/bearing/inner_groove_curvature', values: [0.515, 0.525] }],
  inputs: [{ path: '/operation/radial_load_y_n', distribution: { type: 'uniform', from: 400, to: 600 } }],
  samples: 16,
};

/** The finished job of a request that the page sends. */
async function finished(page, request) {
  const id = await page.evaluate(async (body) => {
    const headers = { 'Content-Type': 'application/json' };
    return (await (await fetch('/v1/jobs', { method: 'POST', headers, body: JSON.stringify(body) })).json()).id;
  }, request);
  await page.waitForFunction(
    async (path) => !['queued', 'running'].includes((await (await fetch(path)).json()).status),
    `/v1/jobs/${id}`,
    { timeout: 300000, polling: 1000 },
  );
  return id;
}

export async function shaftRunUp(page) {
  await finished(page, RUN_UP);
  await tab(page, 'jobs');
  await page.locator('#panel-jobs tr', { hasText: 'machine' }).first().getByRole('button', { name: 'Open' }).click();
  const panel = page.locator('#panel-shaft');
  await panel.getByRole('img', { name: 'Spectra over the shaft speed' }).waitFor({ timeout: 60000 });
  assert.ok((await panel.locator('h2', { hasText: 'varying speed' }).count()) > 0, 'the title of a run-up');
  await panel.locator('input[name=machine-view][value=orders]').check({ force: true });
  await panel.getByRole('img', { name: 'The mean order spectrum' }).waitFor({ timeout: 60000 });
  await picture(page, 'shaft-run-up');
  await panel.locator('input[name=machine-view][value=spectrum]').check({ force: true });
  await panel.locator('figcaption', { hasText: /spectrum of/i }).first().waitFor({ timeout: 60000 });
  await panel.getByRole('button', { name: 'Edit this scene' }).click();
  const request = async () => JSON.parse(await page.locator('#shaft-json').inputValue());
  assert.equal((await request()).outputs.orders.max_order, 20);
  ok('a run-up of a shaft opens as a waterfall, has orders and a spectrum, and keeps them when it is edited');

  const speeds = ['#s-scene-operation-speed_rpm', '#s-ramp-to', '#s-ramp-time'].map((id) => page.locator(id));
  assert.deepEqual(await Promise.all(speeds.map((input) => input.inputValue())), ['9000', '12000', '0.3']);
  await speeds[1].fill('');
  assert.equal((await request()).scene.operation.speed_rpm, 9000);
  assert.equal((await request()).outputs?.orders, undefined, 'a constant speed has no run-up');
  await speeds[1].fill('10000');
  await speeds[2].fill('0');
  await page.locator('#s-ramp-time-error', { hasText: 'above 0 s' }).waitFor();
  await speeds[1].fill('6000000');
  await speeds[2].fill('0.2');
  await page.locator('#s-ramp-to-error', { hasText: '6000000' }).waitFor();
  await speeds[1].fill('10000');
  const ramped = await request();
  assert.deepEqual(ramped.scene.operation.speed_rpm, [{ at_s: 0.05, rpm: 9000 }, { at_s: 0.25, rpm: 10000 }]);
  assert.deepEqual([ramped.duration_s, ramped.outputs], [0.2, { orders: {} }]);
  await page.locator('#shaft-run').click();
  await panel.getByRole('img', { name: 'Spectra over the shaft speed' }).waitFor({ timeout: 60000 });
  ok('the form of a shaft sets a ramp of the speed, which runs as a run-up');

  await finished(page, STUDY);
  await tab(page, 'jobs');
  await page.locator('#panel-jobs tr', { hasText: 'study' }).first().getByRole('button', { name: 'Open' }).click();
  await page.locator('#panel-study figcaption', { hasText: 'percentile 90 over the samples' }).waitFor({ timeout: 60000 });
  ok('a study over uncertain inputs names its statistic');
}
