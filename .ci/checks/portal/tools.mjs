// Tools of the checks of the page: the service, pages that note their faults, places on a page, pictures and findings of axe.

import assert from 'node:assert/strict';
import { spawn } from 'node:child_process';
import { mkdtempSync, rmSync } from 'node:fs';
import { readFile } from 'node:fs/promises';
import { createRequire } from 'node:module';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { createInterface } from 'node:readline';

export const AXE = await readFile(createRequire(import.meta.url).resolve('axe-core/axe.min.js'), 'utf8');
export const PICTURES = process.env.SCREENSHOTS;
export const DESKTOP = { width: 1280, height: 900 };
export const PHONE = { width: 390, height: 844 };
export const TABS = ['result', 'slider', 'study', 'compare', 'shaft', 'jobs'];
export const TOKEN = 'token-of-the-check';
export const ARGUMENTS = [
  '--headless',
  '--no-sandbox',
  '--disable-gpu',
  '--disable-quic',
  '--no-first-run',
  '--disable-background-networking',
  '--disable-component-update',
  '--disable-sync',
];

/** What all pages have noted, told when the check fails for another reason, of which it may be the cause. */
export const noted = [];

export const ok = (what) => console.log(`ok: ${what}`);

/** `raceway serve` on a free port, with a database of its own. */
export async function serve(environment = {}) {
  const place = mkdtempSync(join(tmpdir(), 'raceway-portal-'));
  const kept = Object.fromEntries(Object.entries(process.env).filter(([name]) => !name.startsWith('RACEWAY')));
  const service = spawn(
    process.env.RACEWAY,
    ['serve', '--listen', '127.0.0.1:0', '--database', `sqlite://${join(place, 'portal.db')}`],
    { env: { ...kept, ...environment }, stdio: ['ignore', 'pipe', 'ignore'] },
  );
  const ended = new Promise((done) => service.once('exit', done));
  for await (const line of createInterface({ input: service.stdout })) {
    const stop = async () => {
      service.kill('SIGTERM');
      await ended;
      rmSync(place, { recursive: true });
    };
    return { url: line.replace('listening on ', ''), stop };
  }
  throw new Error('the service does not start');
}

/** A page that notes everything that must not happen. `expected(status, path)`: refusals that the check provokes, which Chromium itself logs; status 0: no connection. */
export async function open(browser, settings, expected = () => false) {
  const context = await browser.newContext({ viewport: DESKTOP, ...settings });
  const faults = [];
  noted.push(faults);
  context.on('weberror', (error) => faults.push(`page error: ${error.error().stack}`));
  context.on('console', (message) => {
    if (!['error', 'warning'].includes(message.type())) return;
    const refused = message.text().match(/Failed to load resource: (?:.*status of (\d+)|net::ERR_INTERNET_DISCONNECTED)/);
    if (refused && expected(Number(refused[1] ?? 0), new URL(message.location().url).pathname)) return;
    faults.push(`console: ${message.text()} (${message.location().url})`);
  });
  context.on('request', (request) => {
    const { protocol, hostname } = new URL(request.url());
    if (!['blob:', 'data:'].includes(protocol) && hostname !== '127.0.0.1') faults.push(`request to ${request.url()}`);
  });
  return { page: await context.newPage(), context, faults };
}

export const picture = async (page, name) => {
  if (PICTURES) await page.screenshot({ path: join(PICTURES, `${name}.png`), fullPage: true });
};

/** Findings of axe, of every impact. */
export async function accessible(page, where) {
  if (!(await page.evaluate(() => Boolean(globalThis.axe)))) await page.evaluate(AXE);
  const found = await page.evaluate(async () => {
    const { violations } = await globalThis.axe.run(document, { resultTypes: ['violations'] });
    return violations
      .map(
        ({ id, nodes }) =>
          `${id}: ${nodes
            .slice(0, 4)
            .map((node) => `${node.target} ${node.failureSummary?.split('\n')[1] ?? ''}`)
            .join(' | ')}`,
      );
  });
  assert.deepEqual(found, [], `axe finds nothing: ${where}`);
}

/** Nothing on the page is wider than its window. */
export async function fits(page, what) {
  const { wide, inner } = await page.evaluate(() => ({ wide: document.documentElement.scrollWidth, inner: innerWidth }));
  assert.ok(wide <= inner, `${what} at ${inner} px is ${wide} px wide`);
}

export const field = (page, pointer) => page.locator(`#f${pointer.replaceAll('/', '-')}`);
export const ofShaft = (page, pointer) => page.locator(`#s${pointer.replaceAll('/', '-')}`);
export const shaftRequest = async (page) => JSON.parse(await page.locator('#shaft-json').inputValue());
export const tab = (page, name) => page.locator(`#tab-${name}`).click();

/** No label of a line covers another one or a curve: the pixels of the plot behind it have no ink of a curve. */
export async function labelsAreClear(page, panel) {
  const covered = await page.locator(`${panel} .u-over`).first().evaluate((over) => {
    const canvas = over.parentElement.querySelector('canvas');
    const [ratio, frame] = [canvas.width / canvas.clientWidth, canvas.getBoundingClientRect()];
    const { data } = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height);
    const accent = getComputedStyle(document.documentElement).getPropertyValue('--accent').trim();
    const wanted = [1, 3, 5].map((at) => parseInt(accent.slice(at, at + 2), 16));
    const labels = [...over.querySelectorAll('.line-label')].map((label) => [label.textContent, label.getBoundingClientRect()]);
    const isInk = (x, y) => {
      const at = 4 * (Math.round(y) * canvas.width + Math.round(x));
      return data[at + 3] > 200 && wanted.every((value, k) => Math.abs(data[at + k] - value) < 40);
    };
    const onCurve = labels.filter(([, box]) => {
      const [left, right] = [box.left, box.right].map((at) => (at - frame.left) * ratio);
      const [top, bottom] = [box.top + 1, box.bottom - 1].map((at) => (at - frame.top) * ratio);
      for (let x = left; x < right; x += 1) for (let y = top; y < bottom; y += 1) if (isInk(x, y)) return true;
      return false;
    });
    const onLabel = labels.filter(([, a], i) =>
      labels.some(([, b], k) => k > i && a.left < b.right - 4 && b.left < a.right - 4 && a.top < b.bottom - 1 && b.top < a.bottom - 1),
    );
    return [...onCurve, ...onLabel].map(([text]) => text);
  });
  assert.deepEqual(covered, [], 'labels cross no curve and no label');
}

/** What a page says where a value was forgotten. */
export async function noLeftovers(page) {
  const found = await page.evaluate(() => {
    const walker = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
    const texts = [];
    while (walker.nextNode()) texts.push(walker.currentNode.data.trim());
    return texts.filter((text) => /\b(null|undefined|NaN)\b|\[object /.test(text));
  });
  assert.deepEqual(found, [], 'no value is missing on the page');
  ok('nothing on the page says null, undefined or NaN');
}

/** The report of the job that is shown: one page with inputs, results, messages and version. Leads back. */
export async function reportOf(page, kind, texts) {
  const report = page.locator('#report');
  for (const text of ['Results', 'Messages', 'Inputs', 'raceway 0.', kind, ...texts]) await report.getByText(text).first().waitFor();
  await report.locator('figure img').first().waitFor();
  await report.locator('td', { hasText: 'given' }).first().waitFor();
  assert.ok(!(await page.locator('.desk').isVisible()));
  await page.emulateMedia({ media: 'print' });
  assert.ok(!(await report.getByRole('button', { name: 'Print' }).isVisible()), 'buttons are not printed');
  await page.emulateMedia({ media: null });
  await picture(page, `report-${kind}`);
  await accessible(page, `the report, kind ${kind},`);
  await noLeftovers(page);
  await page.getByRole('button', { name: 'Back' }).click();
  await page.locator('.desk').waitFor();
  ok(`the report, kind ${kind}, has inputs, results, messages and version`);
}
