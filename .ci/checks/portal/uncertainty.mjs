// An uncertainty job on the page: filled in and run by keyboard, its numbers compared with those of the API.

import assert from 'node:assert/strict';
import { readFile } from 'node:fs/promises';
import { DESKTOP, PHONE, accessible, fits, noLeftovers, ok, picture, reportOf } from './tools.mjs';

/** Short runs of a fast model. */
const SCENE = {
  kind: 'simulation',
  scene: { bearing: '6205', operation: { speed_rpm: 6000, radial_load_y_n: 500 }, spindle: { balance_grade: 6.3 } },
  settle_s: 0.02,
  duration_s: 0.05,
  solver: { rung: 'radially_condensed', model_tolerance_db: 1 },
};
const SAMPLES = 16;
const [LEVEL, LOAD] = ['/channels/spindle.y.acceleration/level_db', '/contacts/inner/max_load_n'];
const GROUP = '/bearing/radial_clearance_um';
const MASS = '/spindle/mass_kg';
const LOAD_Y = '/operation/radial_load_y_n';

/** Presses Tab until an element has the focus, as a user of the keyboard does. */
async function tabTo(page, element) {
  const isFocused = () => element.evaluate((one) => one === document.activeElement);
  for (let press = 0; press < 40; press += 1) {
    if (await isFocused()) return;
    await page.keyboard.press('Tab');
  }
  assert.fail(`no focus by keyboard: ${element}`);
}

/** Asserts that a text begins with a number that is the expected one, rounded to the digits shown. */
function assertShown(text, expected, what) {
  const found = text.match(/(−?)(\d[\d\u202f]*(?:\.(\d+))?)(?: × 10([⁻⁰¹²³⁴⁵⁶⁷⁸⁹]+))?/);
  assert.ok(found, `${what}: ${text}`);
  const [, sign, digits, decimals = '', power = '⁰'] = found;
  const scale = 10 ** Number([...power].map((c) => (c === '⁻' ? '-' : '⁰¹²³⁴⁵⁶⁷⁸⁹'.indexOf(c))).join(''));
  const value = (sign ? -1 : 1) * Number(digits.replaceAll('\u202f', '')) * scale;
  // Half of the last digit; a whole number may end with zeros that are not digits.
  const room = decimals ? 0.5 * 10 ** -decimals.length * scale : 0.005 * Math.abs(expected) + 0.5 * scale;
  assert.ok(Math.abs(value - expected) <= room * 1.001, `${what}: ${text}, API ${expected}`);
}

/** Rows of a table by their first cell. */
const rowsOf = async (table) =>
  new Map(await table.locator('tbody tr').evaluateAll((rows) => rows.map((row) => [...row.children].map((cell) => cell.textContent)).map(([name, ...cells]) => [name, cells])));

export async function uncertainty(page) {
  const panel = page.locator('#panel-study');
  const result = page.locator('#panel-result');
  await page.locator('#request summary').first().click();
  await page.locator('#json').fill(JSON.stringify(SCENE));
  await page.waitForFunction(() => document.querySelector('#f-duration_s').value === '0.05');
  await page.locator('#request summary').first().click();
  // The values of the form have reached the panels once the scene is resolved.
  await page.locator('#cost').filter({ hasText: /./ }).waitFor();
  await page.locator('#tab-result').focus();
  for (let press = 0; press < 2; press += 1) await page.keyboard.press('ArrowRight');
  const keys = async (element, text) => {
    await tabTo(page, element);
    await page.keyboard.type(text);
  };
  await keys(panel.getByRole('combobox', { name: 'Task' }), 'uncertainty');
  const [first, second, third] = ['Input 1', 'Input 2', 'Input 3'].map((name) => panel.getByRole('group', { name }));
  await keys(first.getByRole('combobox', { name: 'Parameter', exact: true }), 'Mass');
  await keys(first.getByRole('combobox', { name: 'Distribution', exact: true }), 'uniform');
  await keys(first.getByRole('textbox', { name: 'From', exact: true }), '0,6');
  await keys(first.getByRole('textbox', { name: 'To', exact: true }), '0.74');
  await tabTo(page, panel.getByRole('button', { name: 'Add input' }));
  await page.keyboard.press('Enter');
  await keys(second.getByRole('combobox', { name: 'Distribution', exact: true }), 'clearance');
  await keys(second.getByRole('combobox', { name: 'Group', exact: true }), 'C3');
  await tabTo(page, panel.getByRole('button', { name: 'Add input' }));
  await page.keyboard.press('Enter');
  await keys(third.getByRole('combobox', { name: 'Parameter', exact: true }), 'Radial load y');
  await keys(third.getByRole('combobox', { name: 'Distribution', exact: true }), 'discrete');
  await keys(third.getByRole('textbox', { name: 'Values', exact: true }), '400; 500; 600');
  await keys(third.getByRole('textbox', { name: 'Weights', exact: true }), '1; 2; 1');
  const samples = panel.getByRole('spinbutton', { name: 'Samples' });
  await keys(samples, '20');
  await tabTo(page, panel.getByRole('checkbox', { name: 'Largest ball load, inner' }));
  await page.keyboard.press('Space');
  await tabTo(page, panel.getByRole('button', { name: 'Run samples' }));
  await page.keyboard.press('Enter');
  await panel.locator('[role=alert]', { hasText: 'must be a power of two' }).waitFor();
  await picture(page, 'uncertainty-form');
  await accessible(page, 'the form of an uncertainty job');
  await page.setViewportSize(PHONE);
  await fits(page, 'the form of an uncertainty job');
  await picture(page, 'uncertainty-form-390');
  await page.setViewportSize(DESKTOP);
  await samples.focus();
  await samples.press('ControlOrMeta+A');
  await page.keyboard.type(String(SAMPLES));
  await panel.getByText(`${SAMPLES + 1} runs`).waitFor();
  await page.keyboard.press('Enter');
  await result.locator('.chip', { hasText: 'succeeded' }).waitFor({ timeout: 300000 });
  await result.locator('figure img').waitFor();
  ok('an uncertainty job is filled in and run by keyboard; a wrong number of samples is refused');

  const id = new URLSearchParams(new URL(page.url()).hash.slice(1)).get('run');
  const of = async (path) => (await fetch(new URL(`/v1/jobs/${id}${path}`, page.url()))).json();
  const { request } = await of('');
  assert.deepEqual(request.inputs, [
    { path: MASS, distribution: { type: 'uniform', from: 0.6, to: 0.74 } },
    { path: GROUP, distribution: { type: 'clearance_group', group: 'C3' } },
    { path: LOAD_Y, distribution: { type: 'discrete', values: [400, 500, 600], weights: [1, 2, 1] } },
  ]);
  assert.deepEqual([request.samples, request.design, request.seed, request.metrics], [SAMPLES, 'sobol', 1, [LEVEL, LOAD]]);
  const { metrics, messages } = await of('/uncertainty');
  const shown = await result.locator('.figures').evaluateAll((lists) =>
    lists.map((list) => Object.fromEntries([...list.children].map((pair) => [...pair.children].map((one) => one.textContent)))),
  );
  assert.equal(shown.length, 2);
  const figures = { [LEVEL]: shown[0], [LOAD]: shown[1] };
  for (const [metric, name] of [
    [LEVEL, 'Level y'],
    [LOAD, 'Largest ball load, inner'],
  ]) {
    const [found, api] = [figures[metric], metrics[metric]];
    const { errors } = api;
    assertShown(found.Mean, api.mean, `${name}: mean`);
    assertShown(found.Nominal, api.nominal, `${name}: nominal value`);
    assert.match(found.Mean, /± .* tolerance spread/);
    assertShown(found.Mean.split('±')[1], errors.tolerance_spread, `${name}: tolerance spread`);
    assertShown(found['Integration error'], errors.integration, `${name}: integration error`);
    assertShown(found['Sampling error'], errors.sampling, `${name}: sampling error`);
    assertShown(found['Model bound'], errors.model.model_tolerance_db, `${name}: model bound`);
    assert.equal(found.Verdict, { resolved: 'spread resolved', spread_not_resolved: 'spread not resolved' }[api.verdict]);
    for (const effect of errors.model.without_bound) await result.getByText(effect).waitFor();
    const percentiles = await rowsOf(result.getByRole('table', { name: `Percentiles: ${name}` }));
    assert.deepEqual([...percentiles.keys()], ['P5', 'P10', 'P50', 'P90', 'P95']);
    for (const { percentile, ...ends } of api.percentiles)
      ['value', 'from', 'to'].forEach((end, i) => {
        const [value, interval] = percentiles.get(`P${percentile}`);
        const text = [value, ...interval.split(' to ')][i];
        if (ends[end] === undefined) assert.equal(text, '–');
        else assertShown(text, ends[end], `${name}: P${percentile}, ${end}`);
      });
    const ranking = await rowsOf(result.getByRole('table', { name: `Ranking of the inputs: ${name}` }));
    const labels = { [MASS]: 'Mass, kg', [GROUP]: 'Clearance, µm', [LOAD_Y]: 'Radial load y, N' };
    for (const { input, share, share_interval: [from, to], sign } of api.sensitivity.inputs) {
      const [shownSign, shownShare, interval] = ranking.get(labels[input]);
      assert.equal(shownSign, sign === undefined ? '–' : sign > 0 ? '+' : '−');
      assertShown(shownShare, share, `${name}: share of ${input}`);
      interval.split(' to ').forEach((text, i) => assertShown(text, [from, to][i], `${name}: interval of ${input}`));
    }
    const largest = [...api.sensitivity.inputs].sort((a, b) => b.share - a.share)[0];
    assert.equal([...ranking.keys()][0], labels[largest.input], 'the largest share stands first');
    const q2 = await result.locator('.spread', { has: page.getByRole('heading', { name }) }).locator('p', { hasText: 'Q² =' }).textContent();
    assertShown(q2.split('=')[1], api.sensitivity.q2, `${name}: Q²`);
    assert.equal(q2.includes('Ranking not resolved'), !api.sensitivity.resolved);
  }
  assert.ok(figures[LEVEL]['Integration error'].includes('dB') && figures[LOAD]['Integration error'].includes('N'));
  for (const { text } of messages) await result.getByText(text).waitFor();
  const [top, plot] = await Promise.all([result.locator('.figures').first().boundingBox(), result.locator('figure img').boundingBox()]);
  assert.ok(top.y < plot.y, 'levels stand above the plot');
  const [download] = await Promise.all([page.waitForEvent('download'), result.getByRole('button', { name: 'Table CSV' }).click()]);
  assert.equal((await readFile(await download.path(), 'utf8')).trim().split('\n').length, SAMPLES + 2, 'a head, the nominal point and the samples');
  await picture(page, 'uncertainty');
  await accessible(page, 'an uncertainty job');
  await noLeftovers(page);
  await page.setViewportSize(PHONE);
  await fits(page, 'an uncertainty job');
  await picture(page, 'uncertainty-390');
  await accessible(page, 'an uncertainty job, 390 px');
  await page.setViewportSize(DESKTOP);
  ok('its spread, errors, percentiles and ranking are those of the API');

  await result.getByRole('button', { name: 'Report' }).click();
  await reportOf(page, 'uncertainty', ['tolerance spread', 'Effects that no model contains', 'Uncertain inputs', 'Q² =']);
  await page.reload();
  await result.locator('.figures', { hasText: 'tolerance spread' }).first().waitFor();
  ok('it opens from its address');
}
