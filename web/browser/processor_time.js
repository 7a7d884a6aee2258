/**
 * The CPU time of a page and its worker, from the browser's trace. Unlike wall-clock time, it does
 * not depend on other processes.
 * @module
 */
import { browser } from './chromium.js';

/** Trace categories of thread tasks and script calls. */
const CATEGORIES = ['toplevel', 'devtools.timeline', 'disabled-by-default-devtools.timeline', '__metadata'];
const SCRIPT_EVENTS = ['FunctionCall', 'RunMicrotasks', 'EvaluateScript'];

const PAGE_THREAD = 'CrRendererMain';
const WORKER_THREAD = 'DedicatedWorker thread';

/** @typedef {{ name: string, pid: number, tid: number, dur?: number, tdur?: number, args: any }} TraceEvent times in microseconds */

/**
 * Runs a function and returns its CPU time.
 * @param {import('playwright-core').Page} page
 * @param {() => Promise<unknown>} act
 * @returns {Promise<{ longest: number, sharing: number }>} the longest script call in the page, in
 *   milliseconds; and the ratio of wall-clock to CPU time of the worker's tasks
 */
export async function traced(page, act) {
  await browser.startTracing(page, { categories: CATEGORIES });
  await act();
  const trace = JSON.parse((await browser.stopTracing()).toString());
  const events = /** @type {TraceEvent[]} */ (trace.traceEvents);
  const threads = new Map();
  for (const { name, pid, tid, args } of events) if (name === 'thread_name') threads.set(`${pid}:${tid}`, args.name);
  const timesOf = (/** @type {string} */ thread, /** @type {string[]} */ names) =>
    events
      .filter(({ name, pid, tid, tdur }) => tdur !== undefined && names.includes(name) && threads.get(`${pid}:${tid}`) === thread)
      .map(({ dur = 0, tdur = 0 }) => ({ clock: dur / 1000, processor: tdur / 1000 }));
  const calls = timesOf(PAGE_THREAD, SCRIPT_EVENTS);
  // Skips short tasks, because the two clocks are not read at the same time.
  const tasks = timesOf(WORKER_THREAD, ['RunTask', 'ThreadControllerImpl::RunTask']).filter(({ processor }) => processor > 1);
  if (calls.length === 0 || tasks.length === 0) throw new Error('the trace has no times of processors');
  const sum = (/** @type {'clock' | 'processor'} */ kind) => tasks.reduce((all, task) => all + task[kind], 0);
  return { longest: Math.max(...calls.map(({ processor }) => processor)), sharing: Math.max(1, sum('clock') / sum('processor')) };
}
