/**
 * Functions of whole numbers.
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
 * Returns the binary logarithm of a whole number, at least 1, in 1/8, with straight lines between the powers of two: the exponent and the first bits of
 * the float that it is.
 * @param {number} x below 2⁵³
 * @returns {number}
 */
export function logarithm(x) {
  view.setFloat64(0, x);
  return (view.getInt32(0) >> 17) - 8 * 1023;
}
