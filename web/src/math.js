/**
 * Integer functions.
 * @module
 */
export const { abs, clz32, floor, imul, max, min } = Math;

/**
 * @param {number} x
 * @param {number} least
 * @param {number} most
 */
export function clamped(x, least, most) {
  return x < least ? least : x > most ? most : x;
}

const view = new DataView(new ArrayBuffer(8));

/**
 * Returns the binary logarithm of an integer of at least 1, in 1/8, linearly interpolated between
 * powers of two: the exponent and the leading mantissa bits of its float.
 * @param {number} x below 2⁵³
 * @returns {number}
 */
export function logarithm(x) {
  view.setFloat64(0, x);
  return (view.getInt32(0) >> 17) - 8 * 1023;
}
