// Modules of the page without a browser: commands, requests, titles and messages.

import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { cpSync, mkdtempSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { ok } from './tools.mjs';

/** What needs no browser: a command holds in a shell what it is to say, and a request says no more than it was told. */
export async function alone() {
  // Node.js takes `.js` for a module where a package says so, and the page has none.
  const page = mkdtempSync(join(tmpdir(), 'raceway-portal-'));
  cpSync(new URL('../../../src/api/portal', import.meta.url), page, { recursive: true });
  writeFileSync(join(page, 'package.json'), '{ "type": "module" }');
  globalThis.location = { origin: 'http://127.0.0.1:1' };
  const { curl, quoted } = await import(`${page}/download.js`);
  const evil = `it's $HOME, "two" \`words\` \\ and ünits\n`;
  assert.equal(execFileSync('sh', ['-c', `printf %s ${quoted(evil)}`], { encoding: 'utf8' }), evil);
  const said = execFileSync(
    'sh',
    [
      '-c',
      `curl() { for word; do printf '%s\\n' "$word"; done; }; ${curl({ method: 'POST', path: '/v1/jobs', body: { labels: [evil] }, token: true })}`,
    ],
    { encoding: 'utf8', env: { RACEWAY_TOKEN: 't' } },
  ).split('\n');
  assert.ok(said.includes('Authorization: Bearer t') && said.includes(JSON.stringify({ labels: [evil] })), said);
  const { write } = await import(`${page}/request.js`);
  const job = { kind: 'simulation', scene: { bearing: '6205', operation: { speed_rpm: 3000 } } };
  let changed = write(job, '/scene/bearing/ball_count', 8);
  changed = write(changed, '/scene/lubricant', 'oil');
  changed = write(changed, '/scene/lubricant/fill', 0.2);
  assert.deepEqual(changed.scene, {
    bearing: { preset: '6205', ball_count: 8 },
    operation: { speed_rpm: 3000 },
    lubricant: { kind: 'oil', fill: 0.2 },
  });
  for (const pointer of ['/scene/bearing/ball_count', '/scene/lubricant/fill', '/scene/lubricant'])
    changed = write(changed, pointer, undefined);
  assert.deepEqual(changed, job);
  const { title } = await import(`${page}/format.js`);
  titles(title);
  const { messageList } = await import(`${page}/messages.js`);
  globalThis.document = {
    createElement: () => {
      const element = { attributes: {}, children: [] };
      element.setAttribute = (name, value) => Object.assign(element.attributes, { [name]: value });
      element.append = (...children) => element.children.push(...children);
      return element;
    },
  };
  const shown = messageList([
    { code: 'at-limit', severity: 'info', text: 'An info.' },
    { code: 'not-stationary', severity: 'warning', text: 'A <b>warning</b>.' },
  ]);
  delete globalThis.document;
  assert.deepEqual(
    shown.map(({ attributes, children }) => [attributes.class, attributes['data-code'], ...children]),
    [
      ['warning', 'not-stationary', 'A <b>warning</b>.'],
      ['note', 'at-limit', 'An info.'],
    ],
  );
  assert.deepEqual(messageList(undefined), []);
  rmSync(page, { recursive: true });
  ok('commands are quoted, requests contain only what was edited, messages are sorted by severity');
}

/** Titles name the lubricant that the service takes, and the preloads of a shaft. */
function titles(title) {
  const fitted = { preset: '6205', radial_clearance_group: 'C3', fits: { shaft: 'k5', housing: 'H7' } };
  assert.match(title({ scene: { bearing: fitted } }), /^6205, clearance C3, fits k5\/H7 /);
  const of = (lubricant) => title({ scene: { bearing: '6205', operation: { speed_rpm: 3000 }, lubricant } }).split(' · ').slice(2).join();
  assert.deepEqual(
    [undefined, {}, 'grease', { kind: 'grease', fill: 0.1 }, { viscosity_pa_s: 0.02 }].map(of),
    ['', 'grease', 'grease', 'grease', 'grease'],
  );
  assert.deepEqual(
    [
      'oil',
      { kind: 'oil' },
      { viscosity_grade: 'iso-vg-46', temperature_c: 60 },
      { kind: 'grease', viscosity_grade: 'iso-vg-46', temperature_c: 60 },
      { viscosity_40_mm2_s: 46, viscosity_100_mm2_s: 6.64, temperature_c: 60 },
    ].map(of),
    ['oil', 'oil', 'iso-vg-46', 'grease iso-vg-46', 'oil'],
  );
  const shaft = (more, bearing = {}) => {
    const bearings = ['A', 'B'].map((name) => ({ name, bearing: '7008C', ...bearing }));
    return title({ scene: { shaft: { sections: [{ length_mm: 300 }] }, bearings, operation: { speed_rpm: 3000 }, ...more } }).replaceAll('\u00a0', ' ');
  };
  const start = 'Shaft 300 mm · on A 7008C, B 7008C · 3000 r/min';
  assert.equal(shaft({}), start);
  assert.equal(shaft({ preloads: [{ between: ['A', 'B'], force_n: 200 }] }, { lubricant: 'oil' }), `${start} · preload 200 N · oil`);
  assert.equal(shaft({ preloads: [{ between: ['A', 'B'], offset_um: 5 }] }), `${start} · preload 5 µm`);
  assert.equal(shaft({ terms: { shaft_bending: 'off', tilt: 'auto', housing: 'off' } }), `${start} · without shaft bending, housing`);
  assert.equal(shaft({}, { outer_ring: { seat: 'sliding', spring_force_n: 150 }, lubricant: {} }), `${start} · spring 150 N · grease`);
}
