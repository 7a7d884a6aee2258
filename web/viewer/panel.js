/**
 * The panel: loading progress, metrics of the shown model, and the level slider.
 * @module
 */
import { drawChart } from './chart.js';
import { bytesText, countText, element, errorText, make, setText, timeText } from './elements.js';

/** @import { Viewer } from './viewer.js' */

const bar = element('bar', HTMLElement);
const loaded = element('loaded', HTMLElement);
const facts = element('facts', HTMLElement);
const level = element('level', HTMLInputElement);
const levelText = element('level-text', HTMLElement);
const play = element('play', HTMLButtonElement);
const streamed = Array.from(document.querySelectorAll('.streamed'));

/**
 * The elements of the facts by name.
 * @type {Map<string, HTMLElement>}
 */
const values = new Map();

/**
 * @param {string} name
 * @param {string} value empty to hide the fact
 */
function setFact(name, value) {
  let shown = values.get(name);
  if (!shown) {
    shown = make('dd', {});
    values.set(name, shown);
    facts.append(make('div', {}, make('dt', {}, name), shown));
  }
  setText(shown, value);
  shown.parentElement?.toggleAttribute('hidden', value === '');
}

/** The state of the connection as text. */
let connection = '';

/** @param {string} words empty to show nothing */
export function setConnection(words) {
  connection = words;
}

/** Whether the level follows the download. */
let isFollowing = true;

/** Makes the level follow the download. */
export function follow() {
  isFollowing = true;
}

/**
 * Connects the level slider.
 * @param {Viewer} viewer
 */
export function connectLevel(viewer) {
  level.addEventListener('input', () => {
    isFollowing = level.valueAsNumber >= Number(level.max);
    viewer.show(isFollowing ? Infinity : level.valueAsNumber);
    describeLevel(viewer, level.valueAsNumber);
  });
}

/**
 * @param {Viewer} viewer
 * @param {number} chunks
 */
function describeLevel({ figures: { points } }, chunks) {
  const point = points[chunks - 1];
  const text = point ? `chunk ${chunks} of ${points.length}: ${countText(point.triangles)} triangles, error ${errorText(point.error)}` : '';
  setText(levelText, text);
  level.setAttribute('aria-valuetext', text || 'nothing received');
}

/**
 * Updates the metrics of the model.
 * @param {Viewer} viewer
 */
export function updatePanel(viewer) {
  const { figures, state, isPaused } = viewer;
  const { progress, points, baseChunks, isStreamed, outside } = figures;
  const { receivedBytes = 0, shownBytes = 0, totalBytes = 0, shownChunks = 0 } = progress ?? {};
  const percent = (/** @type {number} */ bytes) => (totalBytes > 0 ? Math.min(100, (100 * bytes) / totalBytes) : 0);
  const isEnd = state === 'complete';
  const received = isEnd ? 100 : percent(receivedBytes);
  bar.setAttribute('aria-valuenow', String(Math.round(received)));
  const [arrived, shown] = /** @type {HTMLElement[]} */ (Array.from(bar.children));
  arrived.style.width = `${received}%`;
  shown.style.width = `${isStreamed || !isEnd ? percent(shownBytes) : 100}%`;
  const words = state === 'failed' ? 'ended early' : isEnd ? 'complete' : isPaused ? 'paused' : connection || 'loading';
  setText(loaded, totalBytes > 0 ? `${bytesText(isEnd ? totalBytes : receivedBytes)} of ${bytesText(totalBytes)}, ${words}` : words);
  setText(play, isPaused ? 'Resume' : 'Pause');
  // A disabled button would lose the focus.
  play.setAttribute('aria-disabled', String(state !== 'loading'));
  for (const group of streamed) group.toggleAttribute('hidden', !isStreamed && state !== 'loading');

  const sums = figures.sums;
  const isShown = sums.fullTriangles > 0;
  setFact('Triangles', isShown ? `${countText(sums.triangles + outside)} of ${countText(sums.fullTriangles + outside)}` : outside > 0 ? countText(outside) : isStreamed ? 'base mesh' : '');
  setFact('Vertices', isShown ? countText(sums.vertices) : '');
  setFact('Strips', sums.strips > 0 ? countText(sums.strips) : '');
  setFact('Vertices sent', sums.sent > 0 ? countText(sums.sent) : '');
  setFact('Vertices per triangle', sums.sent > 0 ? (sums.sent / sums.triangles).toFixed(2) : '');
  setFact('Error', isShown ? errorText(sums.error) : '');
  setFact('Missing files', [...viewer.missing].map((name) => name.slice(0, 100)).join(', '));
  setFact('Worker', progress && isShown ? `decoding ${timeText(progress.decodeMilliseconds)}, strips ${timeText(progress.buildMilliseconds)}` : '');

  level.min = String(Math.min(baseChunks, Math.max(points.length, 1)));
  level.max = String(Math.max(points.length, 1));
  level.disabled = points.length <= baseChunks;
  if (isFollowing) {
    level.value = String(Math.max(shownChunks, 1));
    describeLevel(viewer, shownChunks);
  }
  drawChart(points, shownChunks, totalBytes);
}
