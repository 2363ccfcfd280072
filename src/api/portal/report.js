// The report of a job: one page to print, with its inputs, results, messages and version. It takes the place of the page until it is closed.

import * as api from './api.js';
import { button, h, lineName, table } from './dom.js';
import { flat } from './download.js';
import { axisName } from './fields.js';
import { channelName, measured, number, quantity, title, UNITS, words } from './format.js';
import { answerOf } from './kinds.js';
import { MachineView } from './machine.js';
import { messageList } from './messages.js';
import { linesOf, summary, tables } from './metrics.js';
import { answerView, pictures } from './pictures.js';
import { isId } from './request.js';
import { metricName } from './study-metrics.js';

/** Plots of a report, for the kinds that have many. */
const PLOTS = ['spectrum_svg', 'envelope_svg', 'waterfall_svg', 'orders_svg', 'trend_svg', 'map_svg', 'optimum_svg', 'uncertainty_svg', 'work_precision_svg', 'campbell_svg', 'shapes_svg'];

export class Report {
  constructor(host, { say }) {
    Object.assign(this, { host, say });
  }

  /** Opens the report of a job; closing it leads back to the hash. */
  open(id, back) {
    this.back = back;
    location.hash = `report=${id}`;
  }

  /** Shows the report that the address names, or hides it; returns whether the address names one. */
  follow() {
    const id = new URLSearchParams(location.hash.slice(1)).get('report');
    document.body.classList.toggle('reporting', id !== null);
    this.host.hidden = id === null;
    this.controller?.abort();
    if (id === null) {
      this.host.replaceChildren();
      return false;
    }
    this.controller = new AbortController();
    this.#show(id, this.controller.signal);
    return true;
  }

  #close(id) {
    location.hash = this.back ?? `run=${id}`;
    // A page that opened with a report has no form yet behind it.
    if (this.back === undefined) location.reload();
  }

  async #show(id, signal) {
    const actions = h(
      'div',
      { class: 'tools unprinted' },
      button('Print', () => print(), { class: 'primary' }),
      button('Back', () => this.#close(id)),
    );
    const body = h('div', { class: 'report-body' }, h('p', { class: 'note', role: 'status' }, 'Loading.'));
    this.host.replaceChildren(actions, body);
    actions.firstChild.focus();
    try {
      if (!isId(id)) throw new Error('The address names no job.');
      const job = await api.get(`/v1/jobs/${id}`, { signal });
      const [service, results, inputs] = await Promise.all([
        api.get('/openapi.json', { signal }),
        job.status === 'succeeded' ? this.#results(job, signal) : { elements: [], messages: [] },
        this.#inputs(job, signal),
      ]);
      if (signal.aborted) return;
      document.title = `raceway: report of ${title(job.request)}`;
      body.replaceChildren(
        h('h1', {}, title(job.request)),
        this.#facts(job, service.info.version),
        job.error ? h('p', { class: 'error' }, `${job.error.title}: ${job.error.detail}`) : '',
        h('h2', {}, 'Results'),
        ...(results.elements.length ? results.elements : [h('p', {}, `The job has no result: ${job.status}.`)]),
        h('h2', {}, 'Messages'),
        ...(results.messages.length ? messageList(results.messages) : [h('p', {}, 'None.')]),
        h('h2', {}, 'Inputs'),
        ...inputs,
      );
    } catch (error) {
      if (!signal.aborted) body.replaceChildren(h('p', { class: 'error' }, error.message));
    }
  }

  #facts(job, version) {
    const moment = (text) => (text ? new Date(text).toISOString().replace('T', ' ').replace(/\.\d+Z$/, ' UTC') : '–');
    const pairs = [
      ['Job', job.id],
      ['Kind', job.kind],
      ['Status', job.status],
      ['Submitted', moment(job.created_at)],
      ['Ended', moment(job.finished_at)],
      ['Labels', job.labels.join(', ')],
      ['Program', `raceway ${version}`],
      ['Service', location.origin],
    ];
    return h('dl', { class: 'pairs' }, pairs.filter(([, text]) => text).map(([name, text]) => h('div', {}, h('dt', {}, name), h('dd', {}, text))));
  }

  /** What the job has found: its elements and its messages. */
  async #results(job, signal) {
    const path = answerOf(job);
    const [answer, plots] = await Promise.all([path ? api.get(path, { signal }) : {}, pictures(job, { signal, only: PLOTS, theme: 'light' })]);
    const messages = answer.messages ?? answer.metrics?.messages ?? [];
    const of = {
      simulation: () => [...simulation(answer), ...plots, ...lineTables(answer), ...opened(tables(answer))],
      machine: () => [...new MachineView({ say: this.say }).summary(job, answer), ...plots, ...lineTables(answer)],
      study: () => [...plots, ...bestPoints(answer)],
      rotor: () => [...plots, ...criticalSpeeds(answer)],
    }[job.kind];
    if (of) return { elements: of(), messages };
    // Messages have a part of their own.
    const { first, rest } = answerView(job.kind, { ...answer, messages: [] });
    return { elements: [...first, ...plots, ...opened(rest)], messages };
  }

  /** Each value of the request, and the defaults that the service adds to it. */
  async #inputs(job, signal) {
    const given = new Map(flat(job.request).map(([pointer, value]) => [pointer, value]));
    const whole = await this.#resolved(job, signal);
    const rows = flat({ ...job.request, ...whole }).map(([pointer, value]) => [
      words(pointer.slice(1).replaceAll('/', ' › ').replace(UNIT_SUFFIX, '')),
      typeof value === 'number' ? quantity(value, UNITS[pointer.match(UNIT_SUFFIX)?.[1]] ?? '', 6) : String(value),
      given.has(pointer) ? 'given' : 'default',
    ]);
    return [
      table('Inputs', ['Field', 'Value', 'Source'], rows, { hidden: true }),
      h('h3', {}, 'The request as JSON'),
      h('pre', { class: 'request-text', tabindex: '0' }, JSON.stringify(job.request, null, 1)),
    ];
  }

  /** The scene with its defaults; nothing where it cannot be resolved. */
  async #resolved({ request }, signal) {
    try {
      if (!request.scene?.bearing) return {};
      const { scene, solver, outputs, settle_s, duration_s } = await api.resolve(request, signal);
      return JSON.parse(JSON.stringify({ scene, solver, outputs, settle_s, duration_s }));
    } catch (error) {
      if (error.name === 'AbortError') throw error;
      return {};
    }
  }
}

/** Units at the end of field names. */
const UNIT_SUFFIX = new RegExp(`_(${Object.keys(UNITS).join('|')})$`);

/** Levels of a run without its messages, which have a part of their own. */
const simulation = (metrics) => summary({ ...metrics, messages: [] });

/** Parts that open on request stand open on paper. */
const opened = (elements) =>
  elements.map((element) => {
    if (element.tagName === 'DETAILS') element.open = true;
    return element;
  });

function lineTables(answer) {
  return ['amplitude', 'envelope'].flatMap((kind) => {
    const lines = linesOf(answer, kind);
    if (lines.length === 0) return [];
    const rows = lines.map((line) => [
      h('span', {}, line.label ? lineName(line.label) : '–'),
      channelName(line.channel),
      number(line.frequency_hz, 5),
      number(line.amplitude, 3),
    ]);
    const name = kind === 'envelope' ? 'Lines of the envelope spectra' : 'Lines of the spectra';
    return [h('h3', {}, name), table(name, ['Line', 'Channel', 'Frequency, Hz', 'Amplitude'], rows, { hidden: true })];
  });
}

function bestPoints({ axes, best, points, succeeded }) {
  const names = axes.map(({ axis }) => axisName(axis).filter(Boolean).join(', '));
  const value = (one) => (typeof one === 'number' ? number(one, 5) : words(one));
  const rows = Object.entries(best).map(([pointer, one]) => [
    metricName(pointer).filter(Boolean).join(', '),
    ...axes.map(({ axis }) => value(one.point[axis])),
    number(one.value, 5),
    measured(one.error),
    words(one.goal),
  ]);
  return [
    h('p', {}, `${succeeded} of ${points} points have a result.`),
    h('h3', {}, 'Best points'),
    table('Best points', ['Metric', ...names, 'Value', 'Estimated error', 'Best value'], rows, { hidden: true }),
  ];
}

function criticalSpeeds({ criticals: speeds = [] }) {
  if (speeds.length === 0) return [h('p', {}, 'No critical speed in the range.')];
  const rows = speeds.map((one, i) => [String(i + 1), number(one.speed_rpm, 5), words(one.whirl ?? '–')]);
  return [h('h3', {}, 'Critical speeds'), table('Critical speeds', ['Number', 'Speed, r/min', 'Whirl'], rows, { hidden: true })];
}
