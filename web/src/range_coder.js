/**
 * A binary range decoder: turns bytes into decisions with known probabilities.
 *
 * Based on: Martin, "Range encoding: an algorithm for removing redundancy from a digitised message", 1979.
 * @module
 */
import { LEAST_RANGE, MOST_TRIMMED, WHOLE } from './constants.js';

/** Reads decisions. Zeros follow the bytes. */
export class RangeDecoder {
  #bytes;
  #end;
  #at;
  #state;

  /** @param {Uint8Array} bytes */
  constructor(bytes) {
    this.#bytes = bytes;
    this.#end = bytes.length;
    this.#at = 4;
    /** The range, and where in it the bytes are. A typed array, since a field holds only 31 bits without an allocation. */
    this.#state = new Uint32Array(2);
    this.#state[0] = 0xffffffff;
    for (let i = 0; i < 4; i++) this.#state[1] = (this.#state[1] << 8) | (i < this.#end ? bytes[i] : 0);
  }

  /**
   * Decodes a decision that is true in `probability` of `WHOLE` cases: 1 or 0.
   * @param {number} probability
   * @returns {number}
   */
  decode(probability) {
    const state = this.#state;
    let range = state[0];
    let code = state[1];
    const bound = Math.imul(range >>> 16, probability) >>> 0;
    let bit = 0;
    if (code < bound) {
      range = bound;
      bit = 1;
    } else {
      code = (code - bound) >>> 0;
      range = (range - bound) >>> 0;
    }
    while (range < LEAST_RANGE) {
      const byte = this.#at < this.#end ? this.#bytes[this.#at] : 0;
      this.#at++;
      code = ((code << 8) | byte) >>> 0;
      range = (range << 8) >>> 0;
    }
    state[0] = range;
    state[1] = code;
    return bit;
  }

  /**
   * Decodes the lowest bits of a number, each as likely as not, the highest first.
   * @param {number} count at most 32
   * @returns {number}
   */
  decodeBits(count) {
    let number = 0;
    for (let i = 0; i < count; i++) number = (number << 1) | this.decode(WHOLE >> 1);
    return number >>> 0;
  }

  /** Whether more has been read than there is: what follows was not written by an encoder. */
  get isPastEnd() {
    return this.#at > this.#end + MOST_TRIMMED;
  }
}
