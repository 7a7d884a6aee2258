/**
 * Returns an array of zeros.
 * @param {number} length
 */
export const integers = (length) => new Int32Array(length);

/**
 * Returns an array of at least the given length that starts with the same values: the array itself,
 * or one of twice the length.
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

/** A buffer of bytes that are not complete yet. */
export class Waiting {
  #bytes = new Uint8Array(0);
  length = 0;

  /**
   * Appends bytes, and returns all of them.
   * @param {Uint8Array} bytes
   */
  add(bytes) {
    const { length } = this;
    this.length += bytes.length;
    this.#bytes = grown(this.#bytes, this.length);
    this.#bytes.set(bytes, length);
    return this.#bytes.subarray(0, this.length);
  }
}

/**
 * Returns bytes as a `Uint8Array`.
 * @param {Uint8Array | ArrayBuffer} bytes
 */
export function arrayOf(bytes) {
  return bytes instanceof Uint8Array ? bytes : new Uint8Array(bytes);
}
