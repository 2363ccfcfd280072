// List of recent jobs: open, compare, delete.

import * as api from './api.js';
import { h, small, tools } from './dom.js';
import { moment, title } from './format.js';

export class JobList {
  constructor(host, { open, compare, report, say }) {
    Object.assign(this, { open, compare, report, say });
    this.rows = h('tbody', {});
    this.older = small('Older jobs', () => this.#load(this.next), { hidden: true });
    this.empty = h('p', { class: 'empty', hidden: true }, 'No jobs yet. Run a scene.');
    host.replaceChildren(
      tools(
        h('h2', {}, 'Jobs'),
        small('Refresh', () => this.refresh()),
      ),
      h(
        'div',
        { class: 'scroll', tabindex: '0', role: 'region', 'aria-label': 'Recent jobs' },
        h(
          'table',
          { class: 'jobs' },
          h('caption', { class: 'unseen' }, 'Recent jobs'),
          h(
            'thead',
            {},
            h(
              'tr',
              {},
              ['Job', 'Status', 'Submitted', ''].map((text) =>
                h('th', { scope: 'col' }, text || h('span', { class: 'unseen' }, 'Actions')),
              ),
            ),
          ),
          this.rows,
        ),
      ),
      this.empty,
      this.older,
    );
  }

  /** Shows the newest jobs only. */
  async refresh() {
    this.hasOlder = false;
    await this.#follow();
  }

  /** Updates the newest jobs while one of them runs. */
  async #follow() {
    clearTimeout(this.timer);
    const page = await this.#load();
    if (page?.some((job) => !api.hasEnded(job))) this.timer = setTimeout(() => this.#follow(), 2000);
  }

  async #load(path) {
    try {
      const { jobs, next } = await api.recentJobs(path);
      const rows = jobs.map((job) => this.#row(job));
      if (path) {
        this.rows.append(...rows);
        this.hasOlder = true;
      } else if (this.hasOlder) {
        const newest = new Set(jobs.map(({ id }) => id));
        [...this.rows.children].filter(({ dataset }) => newest.has(dataset.id)).forEach((row) => row.remove());
        this.rows.prepend(...rows);
      } else this.rows.replaceChildren(...rows);
      // The page after the oldest one shown.
      if (path || !this.hasOlder) this.next = next;
      this.older.hidden = !this.next;
      this.empty.hidden = this.rows.children.length > 0;
      return jobs;
    } catch (error) {
      this.say(error.message);
      return null;
    }
  }

  #row(job) {
    const name = title(job.request);
    const action = (text, act) => small(text, act, { 'aria-label': `${text}: ${name}` });
    const open = action('Open', () => this.open(job));
    const report = job.status === 'succeeded' && action('Report', () => this.report(job));
    const compare = job.kind === 'simulation' && job.status === 'succeeded' && action('Compare', () => this.compare(job));
    const row = h(
      'tr',
      { 'data-id': job.id },
      h('th', { scope: 'row' }, h('span', { class: 'prose' }, name), h('small', {}, [job.kind, ...job.labels].join(', '))),
      h(
        'td',
        {},
        h(
          'span',
          { class: 'chip', 'data-status': job.status },
          job.status === 'running' ? `${Math.round(job.progress * 100)} %` : job.status,
        ),
      ),
      h('td', {}, moment(job.created_at)),
      h('td', { class: 'actions' }, open, report, compare, api.hasEnded(job) && this.#deletion(job, name, () => row)),
    );
    return row;
  }

  /** A button that deletes on the second click; leaving it resets it. */
  #deletion(job, name, row) {
    let armed = false;
    const button = h('button', { type: 'button', class: 'small', 'aria-label': `Delete: ${name}` }, 'Delete');
    const reset = () => {
      armed = false;
      button.textContent = 'Delete';
      button.setAttribute('aria-label', `Delete: ${name}`);
    };
    button.addEventListener('blur', reset);
    button.addEventListener('click', async () => {
      if (!armed) {
        armed = true;
        button.textContent = 'Confirm';
        button.setAttribute('aria-label', `Confirm: delete ${name}`);
        return;
      }
      try {
        await api.remove(job.links.self);
        row().remove();
        this.say('Deleted.');
      } catch (error) {
        this.say(error.message);
      }
    });
    return button;
  }
}
