/**
 * Returns an array of at least some length that starts with the same values: the same one, or one of twice the length.
 * @template {Int32Array | Float64Array | Uint8Array} T
 * @param {T} array
 * @param {number} length
 * @returns {T}
 */
export function grown(array, length) {
  if (length <= array.length) return array;
  const Type = /** @type {new (length: number) => T} */ (array.constructor);
  const longer = new Type(Math.max(2 * array.length, length));
  longer.set(array);
  return longer;
}
