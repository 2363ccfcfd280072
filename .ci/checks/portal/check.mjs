// The page at `/` in a real browser: from a preset to a labelled spectrum, orbit, comparison, slider, study and shaft; then the same door
// with a token. Fails on any error in the console, any request to another host, overflow at 390 px and serious findings of axe.
//
// RACEWAY: the binary. SCREENSHOTS: a folder for pictures (optional). CHROMIUM: the browser (default /usr/bin/chromium).

import assert from 'node:assert/strict';
import { mkdirSync } from 'node:fs';
import { readFile } from 'node:fs/promises';
import { chromium } from 'playwright-core';
import * as measured from './measured.mjs';
import { alone as modules } from './modules.mjs';
import { housing, namedOnShaft, rigidSpindle, shaft } from './shaft.mjs';
import { shaftRunUp } from './shaft-run-up.mjs';
import { ARGUMENTS, DESKTOP, PHONE, PICTURES, TABS, TOKEN, accessible, field, fits, labelsAreClear, noLeftovers, noted, ok, open, picture, reportOf, serve, tab } from './tools.mjs';
import { uncertainty } from './uncertainty.mjs';

/** The first opening shows a recorded example: named so, levels above a spectrum that is in view as a whole. */
async function example(browser, url, hasToken) {
  const { page, context, faults } = await open(browser, {}, (status, path) => hasToken && status === 401 && path === '/v1/presets');
  const times = [];
  // The first of three opens with cold caches, and the machine has other work.
  for (let opening = 0; opening < 3; opening += 1) {
    await page.goto(url);
    await page.waitForFunction(() => document.querySelector('#panel-result .line-label'), undefined, { polling: 'raf' });
    times.push(await page.evaluate(() => performance.now()));
  }
  assert.equal(await page.locator('#panel-result .chip').textContent(), 'example');
  const [levels, plot] = await Promise.all(
    ['.figures', '.canvas'].map((of) => page.locator(`#panel-result ${of}`).first().boundingBox()),
  );
  assert.match(await page.locator('#panel-result .figures').first().textContent(), /± \S+ numerical only/, 'an error says that it knows no tolerances');
  assert.ok(levels.y < plot.y && plot.y + plot.height <= DESKTOP.height, `levels at ${levels.y}, spectrum to ${plot.y + plot.height} px`);
  await labelsAreClear(page, '#panel-result');
  await picture(page, hasToken ? 'example-token' : 'example');
  await accessible(page, 'the example');
  if (!hasToken) {
    await page.locator('.drawing svg').waitFor();
    await page.keyboard.press('Tab');
    assert.equal(await page.evaluate(() => document.activeElement.className), 'skip', 'the first stop of the keyboard skips to the results');
  }
  assert.deepEqual(faults, []);
  await context.close();
  ok(`an example stands after ${times.map(Math.round)} ms (goal: 1000)${hasToken ? ', without a token' : ''}`);
}

/** A designation with a clearance group, a shaft fit and an oil by grade give the numbers that `resolve` shows. */
async function orderedByName(page) {
  const designation = page.locator('#designation');
  await designation.focus();
  await page.waitForFunction(() => document.querySelectorAll('#designations option').length === 394);
  await designation.fill('6206-2RS/C3');
  await designation.press('Tab');
  await page.getByText('Clearance, group C3').waitFor();
  await page.getByText('Catalogue, 6206').waitFor();
  await field(page, '/scene/bearing/fits/shaft_interference_um').fill('10');
  await page.waitForFunction(() => document.body.textContent.includes('Shaft fit'));
  await field(page, '/scene/bearing/fits/shaft_interference_um').fill('');
  await field(page, '/scene/bearing/fits/shaft').selectOption('k5');
  await page.getByText('Shaft fit, k5').waitFor();
  await field(page, '/scene/lubricant/viscosity_grade').selectOption('iso-vg-46');
  await page.locator('#f-scene-lubricant-temperature_c-error').filter({ hasText: 'required' }).waitFor();
  await field(page, '/scene/lubricant/temperature_c').fill('80');
  await page.getByText('10.89').waitFor();
  await picture(page, 'ordered');
  await accessible(page, 'a bearing by designation');
  await designation.fill('7206');
  await designation.press('Enter');
  await page.locator('#preset-error').filter({ hasText: '7206A' }).waitFor();
  ok('a designation, a clearance group and an oil go by name');
}

async function fromPresetToPlot(page) {
  await page.locator('.drawing svg').waitFor();
  const life = page.locator('h3', { hasText: 'Rating life at rest' }).locator('..');
  await life.getByText('Basic life L₁₀ₕ').waitFor();
  ok('the rating life of the scene stands below its static equilibrium');
  await page.selectOption('#preset', 'article-integrated');
  const speed = field(page, '/scene/operation/speed_rpm');
  await speed.fill('50000');
  await page.getByText('833.3').waitFor();
  ok('a preset and a speed give characteristic frequencies');

  const balls = field(page, '/scene/bearing/ball_count');
  await balls.fill('99');
  const error = page.locator('#f-scene-bearing-ball_count-error');
  await error.filter({ hasText: 'from 2 to 64' }).waitFor();
  assert.equal(await balls.getAttribute('aria-invalid'), 'true');
  assert.ok((await balls.getAttribute('aria-describedby')).includes(await error.getAttribute('id')));
  await picture(page, 'error');
  await accessible(page, 'an error at a field');
  await balls.fill('seven');
  await error.filter({ hasText: 'not a number' }).waitFor();
  await balls.fill('');
  await page.waitForFunction(() => !document.querySelector('[aria-invalid]'));
  ok('a wrong field says so, and is silent once mended');

  assert.deepEqual(JSON.parse(await page.locator('#json').inputValue()).scene.bearing, 'article-integrated');
  await page.locator('#request summary').first().click();
  const job = JSON.parse(await page.locator('#json').inputValue());
  job.scene.operation.radial_load_y_n = 200;
  await page.locator('#json').fill(JSON.stringify(job));
  await page.waitForFunction(() => document.querySelector('#f-scene-operation-radial_load_y_n').value === '200');
  await page.locator('#request summary').first().click();
  ok('the request as JSON and the form say the same');

  await page.locator('#run').click();
  await page.locator('.run-head .chip', { hasText: 'succeeded' }).waitFor({ timeout: 60000 });
  await page.locator('#panel-result .line-label').first().waitFor({ timeout: 60000 });
  const labels = await page.locator('#panel-result .line-label').allTextContents();
  assert.ok(
    labels.some((label) => label.includes('BPFO')),
    `labels: ${labels}`,
  );
  ok(`the spectrum names its lines: ${labels.slice(0, 5).join(', ')}`);

  await page.locator('#panel-result').getByLabel('Spectrum of the').selectOption('envelope');
  const caption = page.locator('#panel-result figcaption').first();
  await caption.filter({ hasText: 'Envelope spectrum' }).filter({ hasText: 'Strongest line' }).waitFor();
  await page.getByText('Velocity by band').waitFor();
  ok(`the envelope has lines, too: ${(await caption.textContent()).split('. ').at(-2)}`);
  await page.locator('#panel-result').getByLabel('Spectrum of the').selectOption('amplitude');
  await caption.filter({ hasText: 'Amplitude spectrum' }).waitFor();
}

/** A reload keeps the scene and the run; the tabs are a keyboard's. */
async function reloadAndKeys(page) {
  await page.reload();
  await page.locator('#panel-result .line-label').first().waitFor();
  assert.equal(await field(page, '/scene/operation/speed_rpm').inputValue(), '50000');
  await page.locator('#tab-result').press('ArrowRight');
  assert.equal(await page.locator('#tab-slider').getAttribute('aria-selected'), 'true');
  await page.keyboard.press('Home');
  assert.equal(await page.evaluate(() => document.activeElement.id), 'tab-result');
  ok('a reload keeps scene and run; arrow keys move between the tabs');
}

/** A full queue is waited for; a connection that was lost is found again. */
async function troubles(page, context) {
  let refusals = 1;
  await page.route('**/v1/jobs', (route) => {
    if (route.request().method() !== 'POST' || refusals === 0) return route.continue();
    refusals -= 1;
    return route.fulfill({
      status: 429,
      contentType: 'application/problem+json',
      headers: { 'Retry-After': '1' },
      body: '{"title":"full"}',
    });
  });
  await field(page, '/scene/operation/radial_load_y_n').fill('210');
  await page.locator('#run').click();
  await page.locator('#status', { hasText: 'The queue is full; trying again in 1 s.' }).waitFor();
  await page.getByRole('heading', { name: /210/ }).waitFor();
  await page.locator('.run-head .chip', { hasText: 'succeeded' }).waitFor({ timeout: 60000 });
  await page.unroute('**/v1/jobs');
  await context.setOffline(true);
  await field(page, '/scene/operation/radial_load_y_n').fill('220');
  await page.locator('#scene-errors', { hasText: 'cannot be reached' }).waitFor();
  await context.setOffline(false);
  await page.waitForFunction(() => document.querySelector('#scene-errors').textContent === '');
  await field(page, '/scene/operation/radial_load_y_n').fill('200');
  ok('a full queue is waited for, a lost connection is found again');
}

async function orbitAndRest(page) {
  const view = (value) => page.locator(`input[name=view][value=${value}]`).check({ force: true });
  await view('orbit');
  const shown = page.locator('#panel-result .stage img.picture, #panel-result svg.orbit');
  const again = page.getByRole('button', { name: 'Run again with time series' });
  await shown.or(again).first().waitFor();
  if (await again.isVisible()) await again.click();
  await shown.waitFor({ timeout: 60000 });
  await picture(page, 'orbit');
  ok('the orbit is shown');
  await view('velocity');
  await page.locator('#panel-result .stage .uplot, #panel-result .stage img.picture').first().waitFor();
  await view('loads');
  await page.locator('#panel-result .stage svg.bars, #panel-result .stage img.picture').first().waitFor();
  await view('spectrum');
  await page.locator('#panel-result .line-label').first().waitFor();
  await page.getByRole('button', { name: 'Zoom in' }).first().click();
  const [download] = await Promise.all([
    page.waitForEvent('download'),
    page.getByRole('button', { name: 'Spectrum CSV' }).click(),
  ]);
  assert.match(await readFile(await download.path(), 'utf8'), /^frequency_hz/m);
  ok('velocity, ball loads and a CSV of the spectrum are there');
  await noLeftovers(page);
}

async function compareTwo(page) {
  await field(page, '/scene/bearing/radial_clearance_um').fill('8');
  await page.locator('#run').click();
  await page.locator('.run-head .chip', { hasText: 'succeeded' }).waitFor({ timeout: 60000 });
  await tab(page, 'jobs');
  const buttons = page.getByRole('button', { name: /^Compare:/ });
  await buttons.first().waitFor();
  await buttons.nth(0).click();
  await tab(page, 'jobs');
  await buttons.nth(1).click();
  await page.locator('#panel-compare table tbody tr').first().waitFor();
  await page.locator('#panel-compare .line-label').first().waitFor();
  const rows = await page.locator('#panel-compare tbody tr').count();
  assert.ok(rows > 8, `${rows} differences`);
  ok('two runs lie over each other');
  const other = await page.context().newPage();
  await other.goto(page.url().split('#')[0]);
  await tab(other, 'compare');
  await other.locator('#panel-compare table tbody tr').first().waitFor();
  await other.close();
  ok('and so do the last two where none is chosen');
}

/** Median of redraws a second, over more than 3 s. */
async function slide(page) {
  await tab(page, 'slider');
  await page.locator('#panel-slider .line-label').first().waitFor({ timeout: 60000 });
  const count = () => page.evaluate(() => Number(document.querySelector('#panel-slider [data-redraws]').dataset.redraws));
  await page.getByRole('button', { name: 'Sweep' }).click();
  const counts = [];
  for (let second = 0; second <= 5; second += 1) {
    counts.push(await count());
    await page.waitForTimeout(1000);
  }
  await page.getByRole('button', { name: 'Stop' }).click();
  const rates = counts
    .slice(1)
    .map((now, i) => now - counts[i])
    .sort((a, b) => a - b);
  assert.ok(rates.at(-1) > 0, 'the slider draws');
  console.log(`slider: ${rates[Math.floor(rates.length / 2)]} redraws a second (median of ${rates.join(', ')})`);
}

async function study(page) {
  await tab(page, 'study');
  await page.getByLabel('Points').fill('5');
  await page.getByRole('button', { name: 'Run study' }).click();
  await page.locator('#panel-study .uplot canvas').waitFor({ timeout: 120000 });
  assert.match(await page.locator('#panel-study figcaption').textContent(), /5 of 5 points/);
  ok('a study of one parameter shows its trend');

  await page.getByLabel('Second parameter').selectOption('/scene/operation/radial_load_y_n');
  for (const count of [0, 1]) await page.getByLabel('Points').nth(count).fill('3');
  await page.getByRole('button', { name: 'Run study' }).click();
  const map = page.locator('#panel-study .chart svg');
  await map.waitFor({ timeout: 120000 });
  assert.equal(await map.locator('circle.best').count(), 1);
  assert.match(await map.getAttribute('aria-label'), /9 of 9 points\. Best/);
  await picture(page, 'map');
  await accessible(page, 'a map');
  ok('a study of two parameters opens as a map with its best point');

  await page.locator('#panel-study').getByRole('button', { name: 'Report' }).click();
  await reportOf(page, 'study', ['Best points', 'Radial load y, N']);
  await page.getByLabel('Second parameter').selectOption('');
}

/** An optimum and a comparison of methods run from the page, and open from the list. */
async function otherKinds(page) {
  await tab(page, 'study');
  const title = page.locator('#panel-result h2');
  await page.getByLabel('Task').selectOption('optimum');
  await page.getByRole('button', { name: 'Find optimum' }).click();
  await page.locator('#panel-result figure img').waitFor({ timeout: 300000 });
  await page.locator('#panel-result .figures', { hasText: 'Least value' }).waitFor();
  await picture(page, 'optimum');
  await accessible(page, 'an optimum');
  await tab(page, 'study');
  await page.getByLabel('Task').selectOption('accuracy');
  await page.getByRole('button', { name: 'Compare methods' }).click();
  await page.locator('#panel-result summary', { hasText: 'Points as a table' }).waitFor({ timeout: 300000 });
  await picture(page, 'accuracy');
  await accessible(page, 'an accuracy job');
  await tab(page, 'jobs');
  await page.locator('#panel-jobs tr', { hasText: 'optimum' }).first().getByRole('button', { name: 'Open' }).click();
  await page.locator('#panel-result summary', { hasText: 'Runs as a table' }).waitFor();
  await page.locator('#panel-result').getByRole('button', { name: 'Report' }).click();
  await reportOf(page, 'optimum', ['Runs of the search']);
  await title.waitFor();
  await tab(page, 'study');
  await page.getByLabel('Task').selectOption('study');
  ok('an optimum and an accuracy job run from the page and open from the list');
}

/** Defects placed by pointer, keys and fields, a quality of the raceways, and a comparison with ideal ones. */
async function surfaces(page) {
  await page.selectOption('#preset', 'article-integrated');
  await page.locator('#surfaces > summary').click();
  // The drawing of the preset takes the place of the first one, and with it the place to click.
  await page.locator('#f-scene-bearing-pitch_diameter_mm[placeholder="13"]').waitFor();
  const svg = page.locator('.placing svg');
  await svg.waitFor();
  await svg.evaluate((element) => element.scrollIntoView({ block: 'start' }));
  const middle = async () => {
    const { x, y, width, height } = await svg.boundingBox();
    return { x: x + width / 2, y: y + height / 2, half: width / 2 };
  };
  const { x, y, half } = await middle();
  await page.mouse.click(x + half * 0.85 * Math.sin(Math.PI / 6), y + half * 0.85 * Math.cos(Math.PI / 6));
  const azimuth = field(page, '/scene/surfaces/outer/defects/0/azimuth_deg');
  await azimuth.waitFor();
  assert.equal(await azimuth.inputValue(), '30');
  const handle = page.getByRole('slider', { name: 'Azimuth of defect 1, outer raceway' });
  await handle.press('PageDown');
  await handle.press('ArrowLeft');
  assert.equal(await azimuth.inputValue(), '19');
  const knob = await page.locator('.placing .knob').boundingBox();
  const now = await middle();
  await page.mouse.move(knob.x + knob.width / 2, knob.y + knob.height / 2);
  await page.mouse.down();
  await page.mouse.move(now.x, now.y + now.half * 0.85, { steps: 4 });
  await page.mouse.up();
  assert.equal(await azimuth.inputValue(), '0');
  ok('a defect is placed by a click, moved by keys and by its handle');

  const length = field(page, '/scene/surfaces/outer/defects/0/length_mm');
  await length.fill('900');
  const tooLong = page.locator('#surfaces .item .error', { hasText: 'must be below' });
  await tooLong.waitFor();
  await length.fill('0.3');
  await field(page, '/scene/surfaces/outer/defects/0/depth_um').fill('3');
  const facts = page.locator('.item .pairs').first();
  await facts.filter({ hasText: 'In the load zone' }).filter({ hasText: 'Entry to last impact' }).waitFor();
  await tooLong.waitFor({ state: 'detached' });
  ok('it has its facts beside it, and its errors at the field');

  await page.getByRole('button', { name: 'Add inner defect' }).click();
  await page.getByRole('button', { name: 'Remove defect 1, inner raceway' }).click();
  await page.locator('#surfaces-preset').selectOption('precision');
  await page.getByText('Waviness, outer raceway').click();
  await page.getByRole('button', { name: 'Add outer wave' }).click();
  await field(page, '/scene/surfaces/outer/waviness/0/order').fill('8');
  assert.deepEqual(JSON.parse(await page.locator('#json').inputValue()).scene.surfaces, {
    outer: { defects: [{ azimuth_deg: 0, length_mm: 0.3, depth_um: 3 }], waviness: [{ order: 8, amplitude_nm: 10 }] },
    preset: 'precision',
  });
  await picture(page, 'surfaces');
  await accessible(page, 'surfaces');
  ok('quality and waves stand in the request, removed defects do not');

  const band = field(page, '/outputs/envelope_band_hz');
  await page.locator('summary', { hasText: /^Run$/ }).click();
  await band.fill('890');
  await page.locator('.field', { has: band }).locator('.error', { hasText: 'not two numbers' }).waitFor();
  await band.fill('890 to 3500');
  await field(page, '/outputs/envelope').selectOption('squared');
  assert.deepEqual(JSON.parse(await page.locator('#json').inputValue()).outputs, {
    envelope_band_hz: [890, 3500],
    envelope: 'squared',
  });
  ok('band and square of the envelope stand in the request');

  const job = JSON.parse(await page.locator('#json').inputValue());
  await page.locator('#request summary').first().click();
  await page.locator('#json').fill(JSON.stringify({ ...job, settle_s: 0.02, duration_s: 0.03, solver: { rung: 'planar' } }));
  await page.waitForFunction(() => document.querySelector('#f-duration_s').value === '0.03');
  await page.locator('#request summary').first().click();
  await page.waitForTimeout(600);
  await page.getByRole('button', { name: 'Run with and without', exact: true }).click();
  await page.locator('#panel-compare .line-label').first().waitFor({ timeout: 300000 });
  await page.locator('#panel-compare').getByLabel('Spectrum of the').selectOption('envelope');
  await page.locator('#panel-compare figcaption', { hasText: 'Envelope spectra' }).waitFor();
  await picture(page, 'compare-surfaces');
  ok('with and without surfaces lie over each other');
  await tab(page, 'result');
  await page.locator('#run').click();
  await page.locator('.run-head .chip', { hasText: 'succeeded' }).waitFor({ timeout: 300000 });
  await page.locator('input[name=view][value=impact]').check({ force: true });
  await page.locator('#panel-result .stage img.picture').waitFor();
  await picture(page, 'impact');
  ok('the signal around an impact is shown');
  await noLeftovers(page);
}

/** Links that say no more than a run, or not even that. `hash`: that of a page with a run of 50 000 r/min. */
async function links(browser, url, hash) {
  const opened = await open(browser, {}, (status, path) => status === 404 && path.startsWith('/v1/jobs/'));
  const { context, faults } = opened;
  let { page } = opened;
  const run = new URLSearchParams(hash.slice(1)).get('run');
  // Each link opens in a tab of its own: in the same tab it would only change the fragment of the address.
  const to = async (said) => {
    await page.close();
    page = await context.newPage();
    await page.goto(`${url}/#${said}`);
  };
  const toForm = async (said) => {
    await to(said);
    await page.locator('.drawing svg').waitFor();
  };
  await toForm(`run=${run}`);
  await page.locator('#panel-result .line-label').first().waitFor();
  assert.equal(await field(page, '/scene/operation/speed_rpm').inputValue(), '50000', 'the form has the scene of the run');
  for (const [said, told] of [
    ['run=', 'names no run'],
    ['run=..%2Fpresets', 'names no run'],
    [`run=${run.slice(0, -4)}0000`, 'is gone'],
  ]) {
    await toForm(said);
    await page.locator('#panel-result .empty', { hasText: told }).waitFor();
    assert.ok(!page.url().includes('run='), page.url());
  }
  const { jobs } = await (await fetch(`${url}/v1/jobs?kind=study&status=succeeded`)).json();
  await toForm(`run=${jobs[0].id}`);
  // The newest study has one axis, which is a curve, or two, which are a map.
  await page.locator('#panel-study').locator('.uplot canvas, .chart svg').first().waitFor();
  assert.equal(await page.locator('#tab-study').getAttribute('aria-selected'), 'true');
  // A link that is pasted over this one.
  await page.evaluate((id) => { location.hash = `run=${id}`; }, run);
  await page.locator('#panel-result .line-label').first().waitFor();
  // A link with the job of a shaft.
  const supports = [20, 300].map((at_mm) => ({ at_mm, stiffness_n_per_um: [0, 50, 50] }));
  const shaft = { sections: [{ length_mm: 321, outer_diameter_mm: 25 }] };
  const bar = { kind: 'rotor', scene: { shaft, supports, operation: { speed_rpm: 3000 } } };
  await to(new URLSearchParams({ job: JSON.stringify(bar) }));
  await page.locator('#panel-shaft .rotor').waitFor();
  assert.equal(await page.locator('#tab-shaft').getAttribute('aria-selected'), 'true');
  assert.ok(page.url().includes('321'), 'the address keeps the shaft');
  assert.deepEqual(faults, []);
  await context.close();
  ok('a link to a run alone opens it on its tab with its scene; one to none says so');
}

async function everywhere(browser, url, from, colorScheme) {
  for (const [name, viewport] of [
    ['1280', DESKTOP],
    ['390', PHONE],
  ]) {
    const { page, context, faults } = await open(browser, { viewport, colorScheme });
    await page.goto(url + from);
    await page.locator('.drawing svg').waitFor();
    await page.locator('#panel-result .line-label').first().waitFor();
    // On a narrow page the form is folded: the result is on top.
    if (viewport === PHONE) {
      assert.ok(!(await page.locator('#preset').isVisible()));
      await page.locator('#scene-whole > summary').click();
    }
    await page.locator('#surfaces > summary').click();
    await page.getByRole('button', { name: 'Add outer defect' }).click();
    await page.locator('.item .pairs', { hasText: 'In the load zone' }).waitFor();
    await picture(page, `surfaces-${name}-${colorScheme}`);
    await accessible(page, `surfaces, ${name} px, ${colorScheme}`);
    await page.getByRole('button', { name: 'Remove defect 1, outer raceway' }).click();
    for (const panel of TABS) {
      await tab(page, panel);
      if (panel === 'study') {
        await page.getByRole('button', { name: 'Run study' }).click();
        await page.locator('#panel-study .uplot').waitFor({ timeout: 120000 });
      }
      if (panel === 'compare') {
        for (const [i, label] of ['First run', 'Second run'].entries()) {
          const select = page.getByLabel(label);
          await select.locator('option').nth(2).waitFor({ state: 'attached' });
          await select.selectOption({ index: i + 1 });
        }
        await page.locator('#panel-compare .line-label').first().waitFor();
      }
      if (panel === 'slider') await page.locator('#panel-slider .line-label').first().waitFor({ timeout: 60000 });
      if (panel === 'jobs') await page.locator('#panel-jobs tbody tr').first().waitFor();
      if (panel === 'shaft') await page.locator('.rotor .shape svg').waitFor({ timeout: 30000 });
      await picture(page, `${panel}-${name}-${colorScheme}`);
      await fits(page, panel);
      await accessible(page, `${panel}, ${name} px, ${colorScheme}`);
    }
    assert.deepEqual(faults, []);
    await context.close();
  }
  ok(`every panel fits 1280 and 390 px and has no finding of axe: ${colorScheme}`);
}

/** The page of the OpenAPI document, under the same Content-Security-Policy as the page at `/`. */
async function apiDocument(browser, url) {
  const { page, context, faults } = await open(browser, {});
  const answer = await page.goto(`${url}/docs/`);
  const policy = answer.headers()['content-security-policy'];
  assert.ok(policy?.startsWith("default-src 'self';") && !policy.includes('unsafe'), `policy of /docs/: ${policy}`);
  const operation = page.locator('#operations-jobs-listJobs');
  // Swagger UI needs ten seconds of a core to unfold an operation, and other pages are open beside it.
  await operation.locator('.opblock-summary-control').click({ timeout: 120000 });
  await operation.locator('.try-out__btn').click({ timeout: 120000 });
  await operation.locator('.execute').click();
  await operation.locator('.live-responses-table .response-col_status').filter({ hasText: '200' }).waitFor();
  assert.deepEqual(faults, [], 'nothing in the console of /docs/, no other host');
  await picture(page, 'docs');
  await context.close();
  ok('the page of the API document sends a request and violates no policy');
}

async function withToken(browser) {
  const service = await serve({ RACEWAY_API_TOKENS: TOKEN });
  await example(browser, service.url, true);
  const { page, context, faults } = await open(browser, {}, (status, path) => status === 401 && path.startsWith('/v1/'));
  await page.goto(service.url);
  await page.locator('#token-enter').click();
  await page.locator('#token').fill('wrong');
  await page.locator('#token').press('Enter');
  await page.getByText('does not know this token').waitFor();
  await accessible(page, 'the question for a token');
  await page.locator('#token').fill(TOKEN);
  await page.locator('#token').press('Enter');
  await page.locator('.drawing svg').waitFor();
  await page.locator('#run').click();
  await page.locator('.run-head .chip', { hasText: 'succeeded' }).waitFor({ timeout: 60000 });
  await page.locator('#panel-result .line-label').first().waitFor({ timeout: 60000 });
  const command = await page.locator('#request-curl code').textContent();
  assert.ok(command.includes('"Authorization: Bearer $RACEWAY_TOKEN"') && !command.includes(TOKEN), command);
  assert.ok(!page.url().includes(TOKEN));
  await page.reload();
  await page.locator('#panel-result .line-label').first().waitFor();
  assert.deepEqual(faults, []);
  await context.close();
  await service.stop();
  ok('with a token: asked once, kept over a reload, in no address and no command');
}

assert.ok(process.env.RACEWAY, 'RACEWAY names the binary');
if (PICTURES) mkdirSync(PICTURES, { recursive: true });
await modules();
await measured.alone();
const browser = await chromium.launch({ executablePath: process.env.CHROMIUM ?? '/usr/bin/chromium', args: ARGUMENTS });
try {
  const service = process.env.PORTAL_URL ? { url: process.env.PORTAL_URL, stop: () => {} } : await serve();
  const second = process.env.PORTAL_URL ? service : await serve();
  const { page, context, faults } = await open(
    browser,
    {},
    (status, path) =>
      (status === 422 && path === '/v1/scenes/resolve') || (status === 429 && path === '/v1/jobs') || status === 0,
  );
  // Times are measured alone.
  await example(browser, service.url, false);
  await page.goto(service.url);
  await fromPresetToPlot(page);
  await measured.onResult(page);
  await slide(page);
  await tab(page, 'result');

  const plain = { hash: null };
  const resultsAndStudies = async () => {
    await reloadAndKeys(page);
    plain.hash = new URL(page.url()).hash;
    await orbitAndRest(page);
    await compareTwo(page);
    await study(page);
    await tab(page, 'result');
    await troubles(page, context);
    assert.deepEqual(faults, [], 'nothing in the console, no other host');
    await otherKinds(page);
    assert.deepEqual(faults, [], 'nothing in the console, no other host');
    await context.close();
  };
  /** The parts with scenes of their own, one after the other. Returns the request of the shaft that was built. */
  const ownScenes = async () => {
    let built;
    for (const [part, refused] of [
      [uncertainty, '/v1/jobs'],
      [orderedByName, '/v1/scenes/resolve'],
      [surfaces, '/v1/scenes/resolve'],
      [namedOnShaft, '/v1/rotor'],
      [shaft, '/v1/rotor'],
      [housing, '/v1/rotor'],
      [rigidSpindle, '/v1/rotor'],
      [shaftRunUp, '/v1/rotor'],
    ]) {
      const { page, context, faults } = await open(browser, {}, (status, path) => status === 422 && path === refused);
      await page.goto(second.url);
      await page.locator('.drawing svg').waitFor();
      built = (await part(page)) ?? built;
      assert.deepEqual(faults, []);
      await context.close();
    }
    return built;
  };
  // Lists of jobs are read, so only services of their own go side by side.
  const [, built] = second === service ? [await resultsAndStudies(), await ownScenes()] : await Promise.all([resultsAndStudies(), ownScenes()]);
  const from = `/${plain.hash}&${new URLSearchParams({ shaft: JSON.stringify(built) })}`;
  const rest = async () => {
    await links(browser, service.url, plain.hash);
    await apiDocument(browser, service.url);
    if (!process.env.PORTAL_URL) await withToken(browser);
  };
  await Promise.all([everywhere(browser, service.url, from, 'light'), everywhere(browser, service.url, from, 'dark'), rest()]);
  await service.stop();
  if (second !== service) await second.stop();
} catch (error) {
  noted.flat().forEach((fault) => console.error(fault));
  throw error;
} finally {
  await browser.close();
}
