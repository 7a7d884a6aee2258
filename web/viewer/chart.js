/**
 * A small chart of the error over the bytes received: a rate-distortion curve with a logarithmic
 * error axis.
 * @module
 */
import { curveOf, isOnCurve } from './curve.js';
import { bytesText, element, errorText } from './elements.js';

/** @import { Point } from './figures.js' */

const LEFT = 8;
const RIGHT = 240;
/** The right edge of the error labels. */
const LABELS = 299;
const TOP = 8;
const BOTTOM = 98;

const chart = element('chart', SVGSVGElement);

/**
 * @param {string} tag
 * @param {Record<string, string | number>} attributes
 * @param {string} [text]
 */
function shape(tag, attributes, text = '') {
  const made = document.createElementNS('http://www.w3.org/2000/svg', tag);
  for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, String(value));
  made.textContent = text;
  return made;
}

/**
 * Draws the chart.
 * @param {Point[]} points of the chunks received
 * @param {number} shown the number of points whose chunks are shown
 * @param {number} totalBytes
 */
export function drawChart(points, shown, totalBytes) {
  const curve = curveOf(points, totalBytes);
  if (!curve) {
    chart.replaceChildren();
    chart.setAttribute('aria-label', 'No chunks received');
    return;
  }
  const { points: known, least, most, step, totalBytes: total } = curve;
  const x = (/** @type {Point} */ { bytes }) => LEFT + ((RIGHT - LEFT) * bytes) / total;
  const y = (/** @type {number} */ log) => BOTTOM - ((BOTTOM - TOP) * (log - least)) / (most - least);
  const at = (/** @type {Point} */ point) => `${x(point).toFixed(1)} ${y(Math.log(point.error)).toFixed(1)}`;
  const shapes = [];
  for (let log = most; log > least - 0.1; log -= step) {
    shapes.push(shape('path', { d: `M${LEFT} ${y(log).toFixed(1)}H${RIGHT}`, class: 'grid' }));
    const percent = Number((100 * Math.exp(log)).toPrecision(1));
    shapes.push(shape('text', { x: LABELS, y: (y(log) + 4).toFixed(1), 'text-anchor': 'end' }, `${percent} %`));
  }
  shapes.push(shape('path', { d: `M${known.map(at).join('L')}`, class: 'curve' }));
  const marked = points[Math.min(shown, points.length) - 1];
  const isMarked = isOnCurve(marked);
  if (isMarked) shapes.push(shape('circle', { cx: x(marked).toFixed(1), cy: y(Math.log(marked.error)).toFixed(1), r: 4.5 }));
  shapes.push(shape('text', { x: LEFT, y: 114 }, '0'), shape('text', { x: RIGHT, y: 114, 'text-anchor': 'end' }, bytesText(total)));
  chart.replaceChildren(...shapes);
  const first = known[0];
  const last = known[known.length - 1];
  const now = isMarked ? ` Shown: ${errorText(marked.error)} after ${bytesText(marked.bytes)}.` : '';
  chart.setAttribute('aria-label', `Error from ${errorText(first.error)} after ${bytesText(first.bytes)} to ${errorText(last.error)} after ${bytesText(last.bytes)}.${now}`);
}
