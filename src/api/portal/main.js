// The page: the request, and the forms and panels that use it.

import * as api from './api.js';
import { Compare } from './compare.js';
import { cost, showDerived } from './derived.js';
import { button, h } from './dom.js';
import { command, curl } from './download.js';
import { recordedExample } from './example.js';
import { title } from './format.js';
import { JobList } from './jobs.js';
import { tabOf } from './kinds.js';
import { Report } from './report.js';
import { fromAddress, isId, START, toAddress } from './request.js';
import { Result } from './result.js';
import { SceneForm } from './scene.js';
import { Shaft } from './shaft.js';
import { ofJob } from './shaft-request.js';
import { Slider } from './slider.js';
import { Study } from './study.js';

const TABS = ['result', 'slider', 'study', 'compare', 'shaft', 'jobs'];

/** Pause in typing after which the scene is resolved [ms]. */
const TYPING_PAUSE = 180;

/** Pause before a retry when the service cannot be reached [ms]. */
const RETRY_PAUSE = 3000;

/** Below this width the result is above the form's fields, which open on request. */
const narrow = matchMedia('(max-width: 56rem)');

const at = (id) => document.getElementById(id);
const address = fromAddress();
const state = { ...address, job: address.job ?? START, resolved: null };
if (!TABS.includes(state.tab)) state.tab = 'result';

/** Shows a status message, which disappears after 6 s unless `stays`. */
function say(text, stays = false) {
  at('status').textContent = text;
  clearTimeout(say.timer);
  if (!stays)
    say.timer = setTimeout(() => {
      at('status').textContent = '';
    }, 6000);
}

api.hooks.waiting = (what, wait) => say(what ? `${what}; trying again in ${Math.ceil(wait)} s.` : '', Boolean(what));
api.hooks.askToken = askToken;

/** Asks for a token; null if none is entered. */
function askToken(refused) {
  const dialog = at('token-dialog');
  at('token-note').textContent = refused
    ? 'The service does not know this token.'
    : 'This service requires a token. It is kept until this tab is closed.';
  at('token').value = '';
  dialog.returnValue = '';
  dialog.showModal();
  return new Promise((done) => {
    dialog.addEventListener(
      'close',
      () => {
        at('token-change').hidden = false;
        done(dialog.returnValue === 'use' ? at('token').value.trim() : null);
      },
      { once: true },
    );
  });
}

async function start() {
  at('token-change').hidden = !api.hasToken();
  at('token-change').addEventListener('click', async () => {
    const token = await askToken(false);
    if (token !== null) {
      api.setToken(token);
      location.reload();
    }
  });
  // The actions of the page that need the form come later, the example does not wait for it.
  const actions = {};
  const result = new Result(at('panel-result'), {
    say,
    onEnd: (job) => say(`${title(job.request)}: ${job.status}.`),
    rerun: (request) => actions.run(request),
    edit: (request) => actions.edit(request),
    report: (job) => openReport(job),
  });
  if (address.run === null && JSON.stringify(state.job) === JSON.stringify(START))
    recordedExample()
      .then((example) => {
        if (!state.run) return result.example(example);
      })
      .catch((error) => result.clear(error.message));
  const [document_, presets] = await Promise.all([api.get('/openapi.json'), firstPresets()]);
  api.features.events = Boolean(document_.paths['/v1/jobs/{id}/events']);
  api.features.plots = JSON.stringify(document_.paths['/v1/jobs/{id}/plots/{file}'] ?? '');

  const catalogue = () => api.get('/v1/catalogue');
  const form = new SceneForm(at('fields'), { document: document_, presets, onChange: change, compare: compareSurfaces, catalogue });
  const panels = { document: document_, request: () => state.job, resolved: () => state.resolved, say };
  const slider = new Slider(at('panel-slider'), {
    ...panels,
    apply: (job) => {
      change(job);
      form.show(job);
      say('The form has this value now.');
    },
  });
  const study = new Study(at('panel-study'), {
    ...panels,
    open,
    report: openReport,
  });
  const compare = new Compare(at('panel-compare'), { say, request: () => state.job, resolved: () => state.resolved });
  const shaft = new Shaft(at('panel-shaft'), {
    ...panels,
    presets,
    catalogue,
    report: openReport,
    request: address.shaft && ofJob(address.shaft),
    onChange: (request) => {
      state.shaft = request;
      remember();
    },
    onOpen: (job) => {
      state.run = job.id;
      remember();
    },
  });
  const show = (job) => ({ study, shaft, result })[tabOf(job)].show(job);
  const jobs = new JobList(at('panel-jobs'), {
    say,
    open,
    report: openReport,
    compare: async (job) => {
      choose('compare');
      await compare.add(job);
    },
  });
  const opened = {
    slider: () => slider.reset(),
    study: () => study.reset(),
    compare: () => compare.show(),
    shaft: () => shaft.open(),
    jobs: () => jobs.refresh(),
  };

  let timer = null;
  let controller = null;

  /** Updates everything that depends on the request. */
  function change(job, { fromText = false } = {}) {
    state.job = job;
    if (!fromText) {
      at('json').value = JSON.stringify(job, null, 2);
      at('json-error').textContent = '';
    }
    at('scene-title').textContent = title(job);
    at('request-curl').replaceChildren(command(curl({ method: 'POST', path: '/v1/jobs', body: job, token: api.hasToken() })));
    remember();
    clearTimeout(timer);
    timer = setTimeout(resolve, TYPING_PAUSE);
  }

  async function resolve() {
    controller?.abort();
    controller = new AbortController();
    const { signal } = controller;
    if (form.unreadable) {
      form.showErrors([]);
      at('scene-errors').textContent = '';
      return;
    }
    try {
      const resolved = await api.resolve(state.job, signal);
      state.resolved = resolved;
      form.resolved = resolved;
      form.showDefaults(resolved);
      showErrors([]);
      showDerived(at('derived'), resolved);
      at('derived').hidden = state.tab === 'shaft';
      at('derived').classList.remove('stale');
      at('cost').textContent = cost(resolved);
      if (['slider', 'study'].includes(state.tab) || !resolve.done) opened[state.tab]?.();
      resolve.done = true;
    } catch (error) {
      if (signal.aborted) return;
      at('derived').classList.add('stale');
      at('cost').textContent = '';
      showErrors(error.errors?.length ? error.errors : [{ pointer: '', detail: error.message }]);
      if (!error.status || error.status >= 500) timer = setTimeout(resolve, RETRY_PAUSE);
    }
  }

  function showErrors(errors) {
    const elsewhere = form.showErrors(errors);
    at('scene-errors').textContent = elsewhere
      .map(({ pointer, detail }) => (pointer ? `${pointer}: ${detail}` : detail))
      .join('\n');
  }

  async function run(request = state.job) {
    if (form.unreadable) {
      form.focusFirstError();
      return;
    }
    at('run').disabled = true;
    try {
      const job = await api.submit(request);
      say('Submitted.');
      await open(job);
    } catch (error) {
      showErrors(error.errors?.length ? error.errors : [{ pointer: '', detail: error.message }]);
      form.focusFirstError();
    } finally {
      at('run').disabled = false;
    }
  }

  /** Runs the scene of the form with and without its surfaces and compares both. */
  async function compareSurfaces() {
    if (form.unreadable) {
      form.focusFirstError();
      return;
    }
    choose('compare');
    at('panel-compare').scrollIntoView({ block: 'nearest' });
    await compare.withAndWithout();
  }

  /** Puts the scene of a run into the form. */
  function edit({ scene, solver, duration_s, settle_s, outputs }) {
    const job = JSON.parse(JSON.stringify({ kind: 'simulation', scene, solver, duration_s, settle_s, outputs }));
    form.show(job);
    change(job);
    say('The form has the scene of this run now.');
  }

  async function open(job) {
    state.run = job.id;
    choose(tabOf(job));
    // On a narrow page the result is below the form.
    if (narrow.matches)
      at('panel-result').parentElement.querySelector('[role=tablist]').scrollIntoView();
    await show(job);
  }

  function choose(tab, focus = false) {
    if (state.tab === 'slider' && tab !== 'slider') slider.stop();
    state.tab = tab;
    // A shaft has its own form, and a drawing in the place of the derived quantities of one bearing.
    const isShaft = tab === 'shaft';
    at('scene').hidden = isShaft;
    at('derived').hidden = isShaft || !state.resolved;
    for (const id of ['shaft-form', 'shaft-drawing']) at(id).hidden = !isShaft;
    if (!isShaft) shaft.close();
    for (const name of TABS) {
      const chosen = name === tab;
      at(`tab-${name}`).setAttribute('aria-selected', String(chosen));
      at(`tab-${name}`).tabIndex = chosen ? 0 : -1;
      at(`panel-${name}`).hidden = !chosen;
    }
    if (focus) at(`tab-${tab}`).focus();
    if (state.resolved || isShaft) opened[tab]?.();
    remember();
  }

  at('scene').addEventListener('submit', (event) => {
    event.preventDefault();
    run();
  });
  at('json').addEventListener('input', () => {
    try {
      const job = JSON.parse(at('json').value);
      if (typeof job !== 'object' || job === null || Array.isArray(job)) throw new Error('The request is an object.');
      at('json-error').textContent = '';
      form.show(job);
      change(job, { fromText: true });
    } catch (error) {
      at('json-error').textContent = `Not sent: ${error.message}`;
    }
  });
  for (const name of TABS) {
    at(`tab-${name}`).addEventListener('click', () => choose(name));
    at(`tab-${name}`).addEventListener('keydown', (event) => {
      const i = TABS.indexOf(name);
      const to = { ArrowRight: i + 1, ArrowLeft: i - 1 + TABS.length, Home: 0, End: TABS.length - 1 }[event.key];
      if (to === undefined) return;
      event.preventDefault();
      choose(TABS[to % TABS.length], true);
    });
  }
  // A link that is pasted over the current one.
  addEventListener('hashchange', () => {
    if (report.follow()) return;
    const { job, run, tab } = fromAddress();
    const other = run !== null && run !== state.run;
    if (job && JSON.stringify(job) !== JSON.stringify(state.job)) {
      form.show(job);
      change(job);
    }
    if (other) reopen({ job, run, tab });
  });

  Object.assign(actions, { run, edit });
  at('run').disabled = false;
  for (const name of TABS) at(`tab-${name}`).disabled = false;
  form.show(state.job);
  if (address.run !== null && !isId(address.run)) state.run = null;
  choose(state.tab);
  change(state.job);
  if (address.run !== null) await reopen(address);

  /** Shows the run of an address on its tab. If the address has no request, the form gets the scene of the run. */
  async function reopen({ job: request, run: id, tab }) {
    if (!isId(id)) {
      showReason(id ? 'The link names no run: its address is incomplete.' : 'The link names no run.');
      return;
    }
    let job;
    try {
      job = await api.get(`/v1/jobs/${id}`);
    } catch (error) {
      state.run = null;
      remember();
      showReason(error.status === 404 ? 'The run of this link is gone, or it belongs to another owner.' : error.message);
      return;
    }
    if (!request && job.request.scene?.bearing) edit(job.request);
    state.run = id;
    if (!TABS.includes(tab) || tab === 'result') choose(tabOf(job));
    await show(job);
  }

  /** Shows the reason why there is no result. */
  function showReason(reason) {
    say(reason);
    result.clear(reason);
  }
}

/** On a narrow page the fields of the scene open on request: what is on top are the results. */
function foldScene() {
  at('scene-whole').open = !narrow.matches;
}
narrow.addEventListener('change', foldScene);
foldScene();

/** The presets. Where the service requires a token, a button asks for it first: the example beside it needs none. */
async function firstPresets() {
  for (;;) {
    try {
      return await api.get('/v1/presets', { asks: api.hasToken() });
    } catch (error) {
      if (error.status !== 401) throw error;
    }
    await new Promise((done) => {
      at('fields').replaceChildren(
        h('p', { class: 'note' }, 'This service requires a token for runs. The example needs none.'),
        button('Enter a token', done, { id: 'token-enter' }),
      );
      at('scene-whole').open = true;
    });
    api.setToken(await askToken(false));
  }
}

const report = new Report(at('report'), { say });

/** Opens the report of a job; the page behind it stays as it is. */
function openReport({ id }) {
  report.open(id, location.hash);
}

function remember() {
  toAddress(state);
}

report.follow();
start().catch((error) => {
  at('fields').replaceChildren(
    h('p', { class: 'error' }, error.message),
    button('Try again', () => location.reload()),
  );
});
