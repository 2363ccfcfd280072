// The tab of a shaft: form, drawing, analysis, run in time, housing, and a rigid spindle in its place.

import assert from 'node:assert/strict';
import { accessible, field, noLeftovers, ofShaft, ok, picture, shaftRequest, tab } from './tools.mjs';

/** Bearings of a shaft by designation, and loads at a place. */
export async function namedOnShaft(page) {
  await tab(page, 'shaft');
  await page.locator('.rotor table').first().waitFor({ timeout: 30000 });
  const loads = async () => (await shaftRequest(page)).scene.operation.loads;
  await page.locator('summary', { hasText: 'Loads at a place' }).click();
  await page.getByRole('button', { name: 'Add load' }).click();
  assert.deepEqual(await loads(), [{ at_mm: 145, direction: 'y', constant_n: 100 }]);
  await ofShaft(page, '/scene/operation/loads/0/constant_n').fill('');
  await page.locator('summary', { hasText: /^Shock$/ }).click();
  for (const [name, value] of [['peak_n', '50'], ['at_s', '0.1'], ['duration_s', '0.001']])
    await ofShaft(page, `/scene/operation/loads/0/shock/${name}`).fill(value);
  assert.deepEqual(await loads(), [{ at_mm: 145, direction: 'y', shock: { peak_n: 50, at_s: 0.1, duration_s: 0.001 } }]);
  await page.locator('.analysis:not(.stale)').waitFor();
  await picture(page, 'load at a place');
  await page.getByRole('button', { name: 'Remove load 1' }).click();
  assert.equal(await loads(), undefined);
  ok('a shock at a place of the shaft is added and removed');

  const designation = page.locator('#s-scene-bearings-0-bearing-designation');
  await designation.fill('7008C');
  await designation.press('Tab');
  const angle = await ofShaft(page, '/scene/bearings/0/bearing/contact_angle_deg').getAttribute('id');
  await page.waitForFunction((id) => document.getElementById(id).placeholder === '15', angle);
  assert.equal((await shaftRequest(page)).scene.bearings[0].bearing, '7008C');
  await page.locator('.analysis:not(.stale)').waitFor();
  await accessible(page, 'a bearing of the shaft by designation');
  await designation.fill('7206');
  await designation.press('Enter');
  await page.locator('#s-scene-bearings-0-bearing-error', { hasText: '7206A' }).waitFor();
  ok('a bearing of the shaft goes by designation; an unknown one has suggestions');
}

/** A shaft: drawn, moved by keys and pointer, analysed with each edit, run in time, and opened from the list. */
export async function shaft(page) {
  await tab(page, 'shaft');
  const natural = page.locator('.rotor table').first();
  await natural.waitFor({ timeout: 30000 });
  const of = (pointer) => ofShaft(page, pointer);
  const place = of('/scene/bearings/0/at_mm');
  const drawn = page.locator('[data-pointer="/scene/bearings/0"]');
  assert.equal(await place.inputValue(), '55');
  await drawn.press('PageUp');
  await drawn.press('ArrowRight');
  assert.equal(await place.inputValue(), '66');
  assert.equal(await drawn.getAttribute('aria-valuenow'), '66');
  const ball = await drawn.locator('.ball').first().boundingBox();
  await page.mouse.move(ball.x + ball.width / 2, ball.y + ball.height / 2);
  await page.mouse.down();
  await page.mouse.move(ball.x + ball.width / 2 - 60, ball.y + ball.height / 2, { steps: 4 });
  await page.mouse.up();
  assert.ok(Number(await place.inputValue()) < 60, await place.inputValue());
  await drawn.press('Enter');
  assert.equal(await page.evaluate(() => document.activeElement.id), 's-scene-bearings-0-bearing');
  ok('a bearing of the shaft moves by keys and pointer; Enter leads to its fields');

  await place.fill('999');
  const error = page.locator('#s-scene-bearings-0-at_mm-error', { hasText: 'from 0 to 290 mm' });
  await error.waitFor();
  assert.equal(await place.getAttribute('aria-invalid'), 'true');
  await page.locator('.analysis.stale').waitFor();
  await accessible(page, 'an error of the shaft');
  await place.fill('x');
  await page.locator('#s-scene-bearings-0-at_mm-error', { hasText: 'not a number' }).waitFor();
  await place.fill('55');
  await page.locator('.analysis:not(.stale)').waitFor();
  ok('an error of the shaft stands at its field');

  const firstCritical = () => page.locator('input[value=critical-0]').locator('xpath=..').textContent();
  await page.waitForFunction(() => document.querySelector('input[value=critical-0]'));
  const before = await firstCritical();
  await of('/scene/shaft/sections/2/outer_diameter_mm').fill('60');
  await page.waitForFunction((text) => document.querySelector('input[value=critical-0]')?.parentElement.textContent !== text, before);
  await of('/scene/shaft/sections/2/outer_diameter_mm').fill('46');
  await page.waitForFunction((text) => document.querySelector('input[value=critical-0]')?.parentElement.textContent === text, before);
  ok(`the analysis follows each edit; first critical speed${before}`);

  await page.locator('.chart .mark').first().press('Enter');
  assert.equal(await page.locator('input[name=motion]:checked').inputValue(), 'critical-0');
  await page.locator('input[name=motion]:checked').press('ArrowDown');
  await page.locator('.shape + figcaption', { hasText: 'forward' }).waitFor();
  ok('a mode shape is chosen on the diagram and by keys');

  await page.locator('summary', { hasText: 'Linear supports' }).click();
  await page.getByRole('button', { name: 'Add support' }).click();
  await page.locator('.rotor td, .rotor th', { hasText: 'support 1' }).waitFor();
  await page.locator('[data-pointer="/scene/supports/0"]').press('Delete');
  await page.locator('.rotor th', { hasText: 'support 1' }).waitFor({ state: 'detached' });
  assert.equal((await shaftRequest(page)).scene.supports, undefined);
  ok('a support is added and removed');

  await page.locator('summary', { hasText: 'Spall of the outer raceway' }).first().click();
  for (const [name, value] of [
    ['azimuth_deg', '0'],
    ['length_mm', '0.8'],
    ['depth_um', '3'],
  ])
    await of(`/scene/bearings/0/surfaces/outer/defects/0/${name}`).fill(value);
  await page.locator('summary', { hasText: /^Run in time$/ }).click();
  await of('/duration_s').fill('0.05');
  await of('/settle_s').fill('0.02');
  await page.locator('#shaft-run').click();
  await page.locator('#panel-shaft .line-label', { hasText: 'BPFO@A' }).first().waitFor({ timeout: 300000 });
  await page.locator('#panel-shaft figcaption', { hasText: 'Envelope spectrum of sensor nose acceleration' }).waitFor();
  await picture(page, 'machine');
  await accessible(page, 'the run of a shaft in time');
  assert.deepEqual((await shaftRequest(page)).speeds_rpm, { from: 0, to: 60000, count: 31 }, 'the run keeps the settings of the analysis');
  ok('a run in time shows levels, spectrum and envelope with lines of the bearing');

  await page.locator('input[name=shaft-view][value=analysis]').check({ force: true });
  await page.getByRole('button', { name: 'Keep as a job' }).click();
  await page.getByRole('button', { name: 'Campbell SVG' }).waitFor({ timeout: 60000 });
  await page.reload();
  await page.getByRole('button', { name: 'Campbell SVG' }).waitFor({ timeout: 60000 });
  await tab(page, 'jobs');
  await page.locator('#panel-jobs tr', { hasText: 'machine' }).first().getByRole('button', { name: 'Open' }).click();
  await page.locator('#panel-shaft .line-label').first().waitFor({ timeout: 60000 });
  await tab(page, 'jobs');
  await page.locator('#panel-jobs tr', { hasText: 'rotor' }).first().getByRole('button', { name: 'Open' }).click();
  await page.getByRole('button', { name: 'Campbell SVG' }).waitFor();
  ok('jobs of a shaft are kept, survive a reload and open from the list');
}

/** A motor spindle in a housing, built in the form: analysed, run in time to the spectrum of a sensor on it, then changed and taken apart. Returns its request. */
export async function housing(page) {
  await tab(page, 'shaft');
  const of = (pointer) => ofShaft(page, pointer);
  const drawn = (pointer) => page.locator(`[data-pointer="${pointer}"]`);
  const row = (text) => page.locator('.rotor th', { hasText: text });
  await row('B').first().waitFor({ timeout: 30000 });

  await page.locator('#shaft-fields summary', { hasText: 'Housing bodies' }).click();
  await page.getByRole('button', { name: 'Add body' }).click();
  assert.equal(await page.evaluate(() => document.activeElement.id), 's-scene-housing-bodies-0-at_mm');
  await page.locator('fieldset', { hasText: 'Body 1' }).getByText('nothing restrains `head` along x').waitFor();
  await page.locator('#shaft-fields summary', { hasText: 'Housing mounts' }).click();
  await page.getByRole('button', { name: 'Add mount' }).click();
  await row('mount 1').waitFor();
  ok('a body that nothing holds is refused at its fields; a mount holds it');

  for (const bearing of [0, 1]) {
    await page.locator('summary', { hasText: 'Outer ring' }).nth(bearing).click();
    await of(`/scene/bearings/${bearing}/outer_ring/on`).selectOption('head');
  }
  await page.getByRole('button', { name: 'Remove preload 1' }).click();
  const seat = of('/scene/bearings/1/outer_ring/seat');
  const [stiffness, spring] = ['stiffness_n_per_um/1', 'spring_force_n'].map((name) => of(`/scene/bearings/1/outer_ring/${name}`));
  assert.ok((await stiffness.isHidden()) && (await spring.isHidden()));
  await seat.selectOption('elastic');
  await of('/scene/bearings/1/outer_ring/stiffness_n_per_um/0').fill('200');
  await page.locator('#s-scene-bearings-1-outer_ring-stiffness_n_per_um-1-error', { hasText: 'from 0.001' }).waitFor();
  assert.equal(await stiffness.getAttribute('aria-invalid'), 'true');
  await seat.selectOption('sliding');
  await page.locator('#s-scene-bearings-1-outer_ring-spring_force_n-error:not(:empty)').waitFor();
  assert.ok((await stiffness.isHidden()) && (await spring.isVisible()));
  await accessible(page, 'an error of a housing');
  await spring.fill('300');
  await of('/scene/bearings/1/outer_ring/spring_n_per_um').fill('0.1');
  await page.locator('.analysis:not(.stale)').waitFor();
  assert.deepEqual((await shaftRequest(page)).scene.bearings[1].outer_ring, {
    on: 'head',
    seat: 'sliding',
    spring_force_n: 300,
    spring_n_per_um: 0.1,
  });
  assert.equal(await drawn('/scene/bearings/1').getAttribute('aria-label'), 'Place of bearing B, sliding under a spring in head');
  ok('a seat shows its own fields, and their errors stand at them');

  await page.locator('#shaft-fields summary', { hasText: 'Sensors' }).click();
  await page.getByRole('button', { name: 'Add sensor' }).click();
  const sensor = '/scene/sensors/1';
  await of(`${sensor}/name`).fill('acc');
  await of(`${sensor}/at_mm`).fill('55');
  await of(`${sensor}/on`).selectOption('head');
  await of('/scene/sensors/0/relative_to').selectOption('head');
  await row('acc').waitFor();
  assert.equal(await drawn(sensor).getAttribute('aria-label'), 'Place of sensor acc, y, on head');
  assert.equal(await drawn('/scene/sensors/0').getAttribute('aria-label'), 'Place of sensor nose, y, relative to head');
  await drawn('/scene/housing/bodies/0').press('PageUp');
  assert.equal(await of('/scene/housing/bodies/0/at_mm').inputValue(), '155');
  await drawn('/scene/housing/mounts/0').press('ArrowLeft');
  assert.equal(await of('/scene/housing/mounts/0/at_mm').inputValue(), '144');
  const [frame, ring] = await Promise.all([
    drawn('/scene/housing/bodies/0').locator('rect').boundingBox(),
    drawn('/scene/bearings/1').locator('.ring').first().boundingBox(),
  ]);
  assert.ok(frame.x < ring.x && frame.x + frame.width > ring.x + ring.width && frame.y < ring.y, 'the body is drawn around what it holds');
  await of('/scene/housing/bodies/0/name').fill('case');
  await page.locator('.analysis:not(.stale)').waitFor();
  const { scene } = await shaftRequest(page);
  assert.deepEqual(
    [scene.bearings[0].outer_ring.on, scene.housing.mounts[0].body, scene.sensors[1].on, scene.sensors[0].relative_to],
    ['case', 'case', 'case', 'case'],
  );
  ok('bodies, mounts and sensors are drawn and move by keys; a new name of a body goes wherever it is named');

  await of('/scene/operation/outer_speed_rpm').fill('100');
  await page.locator('#s-scene-bearings-0-outer_ring-on-error', { hasText: 'does not turn' }).waitFor();
  await of('/scene/operation/outer_speed_rpm').fill('');
  await page.locator('.analysis:not(.stale)').waitFor();
  await page.locator('summary', { hasText: /^Run in time$/ }).click();
  await of('/duration_s').fill('0.05');
  await of('/settle_s').fill('0.02');
  const built = await shaftRequest(page);
  await page.locator('#shaft-run').click();
  const channel = page.locator('#panel-shaft .stage label', { hasText: 'Channel' }).locator('select');
  await channel.waitFor({ timeout: 300000 });
  await channel.selectOption('sensor.acc.acceleration');
  const caption = page.locator('#panel-shaft figcaption', { hasText: 'Amplitude spectrum of sensor acc acceleration' });
  await caption.waitFor();
  await picture(page, 'housing-run');
  await noLeftovers(page);
  ok(`a spindle in a housing runs in time: ${(await caption.textContent()).split('. ').at(-2)}`);

  await page.locator('input[name=shaft-view][value=analysis]').check({ force: true });
  await drawn('/scene/housing/bodies/0').press('Delete');
  await row('mount 1').waitFor({ state: 'detached' });
  const left = (await shaftRequest(page)).scene;
  assert.deepEqual([left.housing, left.bearings[0].outer_ring, left.sensors.map(({ name }) => name)], [undefined, undefined, ['nose']]);
  assert.equal(left.sensors[0].relative_to, undefined);
  ok('with a body go its mounts and sensors; rings stand in the ground again');
  return built;
}

/** A rigid spindle on the bearings of the example, with outer rings that turn. */
export async function rigidSpindle(page) {
  await tab(page, 'shaft');
  const of = (pointer) => ofShaft(page, pointer);
  await page.locator('.rotor table').first().waitFor({ timeout: 30000 });
  const sections = page.locator('#shaft-fields summary', { hasText: /^Sections/ });
  // A field that goes away takes its error with it.
  await of('/scene/shaft/sections/0/length_mm').fill('x');
  await page.locator('#s-scene-shaft-sections-0-length_mm-error', { hasText: 'not a number' }).waitFor();
  await page.getByLabel('Rigid spindle', { exact: true }).check({ force: true });
  await page.locator('.shaft-drawing svg[aria-label^="Rigid spindle of 255"]').waitFor();
  assert.ok((await sections.isHidden()) && (await of('/scene/spindle/mass_kg').isVisible()));
  await of('/scene/spindle/mass_kg').fill('0');
  await page.locator('#s-scene-spindle-mass_kg-error:not(:empty)').waitFor();
  await of('/scene/spindle/mass_kg').fill('5');
  await of('/scene/spindle/balance_grade').fill('2.5');
  await of('/scene/operation/outer_speed_rpm').fill('-600');
  await page.locator('.rotor .figures', { hasText: '5 kg' }).waitFor();
  assert.deepEqual(await shaftRequest(page).then(({ scene }) => [scene.shaft, scene.spindle]), [undefined, { mass_kg: 5, balance_grade: 2.5 }]);
  await picture(page, 'rigid-spindle');
  await accessible(page, 'a rigid spindle');
  await page.locator('summary', { hasText: /^Run in time$/ }).click();
  await of('/duration_s').fill('0.02');
  await of('/settle_s').fill('0.01');
  await page.locator('#shaft-fields summary', { hasText: /^Terms$/ }).click();
  await of('/scene/terms/tilt').selectOption('off');
  await page.locator('#shaft-run').click();
  await page.locator('#panel-shaft .line-label').first().waitFor({ timeout: 300000 });
  await page.locator('#panel-shaft summary:visible', { hasText: 'Omitted terms: 1' }).click();
  assert.match(await page.locator('#panel-shaft table:visible', { hasText: 'terms.tilt' }).locator('tbody tr').textContent(), /convention.*\sdB$/);
  await noLeftovers(page);
  await page.reload();
  await page.locator('.shaft-drawing svg[aria-label^="Rigid spindle"]').waitFor();
  await page.getByLabel('Shaft of sections').check({ force: true });
  await sections.waitFor();
  ok('a rigid spindle on two bearings is analysed and run, with outer rings that turn');
}
