/**
 * The curve of the chart: which points are drawn, and between which powers of ten.
 * @module
 */

/** @import { Point } from './figures.js' */

/**
 * A curve with a logarithmic error.
 * @typedef {object} Curve
 * @property {Point[]} points those to draw, the first and the last one included
 * @property {number} least the logarithm of the power of ten below all errors
 * @property {number} most that of the one above them
 * @property {number} step between two lines of the grid
 * @property {number} totalBytes
 */

const DECADE = Math.LN10;
/** The grid has at most so many steps. */
const MAX_STEPS = 3.5;
/** About the most points that are drawn: two per unit of the width of the chart. */
const MAX_POINTS = 500;

/**
 * Returns whether a point is on a curve with a logarithmic error.
 * @param {Point | undefined} point
 * @returns {point is Point}
 */
export const isOnCurve = (point) => point !== undefined && point.error > 0 && point.error < Infinity;

/**
 * Returns the curve through points, in linear time; `undefined` if none is on it.
 * @param {Point[]} points in the order of their bytes
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
