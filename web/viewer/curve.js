/**
 * The curve of the chart: the points to draw and the range of the error axis.
 * @module
 */

/** @import { Point } from './figures.js' */

/**
 * A curve with a logarithmic error axis.
 * @typedef {object} Curve
 * @property {Point[]} points the points to draw, including the first and the last
 * @property {number} least the natural logarithm of the power of ten below all errors
 * @property {number} most the natural logarithm of the power of ten above all errors
 * @property {number} step between two grid lines
 * @property {number} totalBytes
 */

const DECADE = Math.LN10;
/** The maximum number of grid steps. */
const MAX_STEPS = 3.5;
/** The approximate maximum number of points: two per unit of the chart's width. */
const MAX_POINTS = 500;

/**
 * Checks whether a point can be drawn on a logarithmic error axis.
 * @param {Point | undefined} point
 * @returns {point is Point}
 */
export const isOnCurve = (point) => point !== undefined && point.error > 0 && point.error < Infinity;

/**
 * Returns the curve through points in linear time, or `undefined` if no point can be drawn.
 * @param {Point[]} points ordered by bytes
 * @param {number} totalBytes
 * @returns {Curve | undefined}
 */
export function curveOf(points, totalBytes) {
  const known = points.filter(isOnCurve);
  const last = known.at(-1);
  if (!last) return undefined;
  let [least, most] = [Infinity, -Infinity];
  for (const { error } of known) {
    least = Math.min(least, error);
    most = Math.max(most, error);
  }
  least = Math.floor(Math.log(least) / DECADE) * DECADE;
  most = Math.ceil(Math.log(most) / DECADE + 1e-9) * DECADE;
  const total = Math.max(totalBytes, last.bytes);
  return { points: thin(known, total), least, most, step: Math.ceil((most - least) / DECADE / MAX_STEPS) * DECADE, totalBytes: total };
}

/**
 * @param {Point[]} points
 * @param {number} totalBytes
 */
function thin(points, totalBytes) {
  if (points.length <= MAX_POINTS) return points;
  let column = -1;
  return points.filter(({ bytes }, i) => {
    const next = Math.floor((MAX_POINTS * bytes) / totalBytes);
    if (next === column && i < points.length - 1) return false;
    column = next;
    return true;
  });
}
