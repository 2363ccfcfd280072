// Kinds of jobs, and where the page shows them.

/** The tab on which jobs of a kind open. Kinds that are not listed open as a result: with their plots and their answer as JSON. */
const TABS = { simulation: 'result', optimum: 'result', accuracy: 'result', uncertainty: 'result', study: 'study', rotor: 'shaft', machine: 'shaft' };

export const tabOf = ({ kind }) => TABS[kind] ?? 'result';

/** Members of `links` that lead to plots. */
export const plotsOf = (job) => Object.entries(job.links).filter(([name]) => name.endsWith('_svg'));

/** The answer of a job that has one of its own, as a path. */
export const answerOf = ({ kind, links }) => links[kind] ?? links.metrics ?? links.table;
