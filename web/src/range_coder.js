/**
 * A range decoder: turns bytes into decisions with known probabilities.
 *
 * Based on: Martin, "Range encoding: an algorithm for removing redundancy from a digitised message", 1979.
 * @module
 */
import { LEAST_RANGE, MOST_TRIMMED } from './constants.js';

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
    const bound = Math.imul(state[0] >>> 16, probability) >>> 0;
    const bit = state[1] < bound ? 1 : 0;
    if (bit) {
      state[0] = bound;
    } else {
      state[1] -= bound;
      state[0] -= bound;
    }
    if (state[0] < LEAST_RANGE) this.#read(state);
    return bit;
  }

  /**
   * Cuts the range into `total` equal parts, from 1 to 2²⁴; returns the part that is meant, or the last one. `take` follows.
   * @param {number} total
   * @returns {number}
   */
  seek(total) {
    const state = this.#state;
    state[0] = state[0] / total;
    const part = Math.floor(state[1] / state[0]);
    return part < total ? part : total - 1;
  }

  /**
   * Takes some of the parts, that one among them.
   * @param {number} start
   * @param {number} size
   */
  take(start, size) {
    const state = this.#state;
    state[1] -= start * state[0];
    state[0] *= size;
    if (state[0] < LEAST_RANGE) this.#read(state);
  }

  /** @param {Uint32Array} state */
  #read(state) {
    do {
      const byte = this.#at < this.#end ? this.#bytes[this.#at] : 0;
      this.#at++;
      state[1] = (state[1] << 8) | byte;
      state[0] <<= 8;
    } while (state[0] < LEAST_RANGE);
  }

  /**
   * Decodes the lowest bits of a number, each as likely as not.
   * @param {number} count at most 32
   * @returns {number}
   */
  decodeBits(count) {
    const high = count > 16 ? this.decodeBits(count - 16) * 65536 : 0;
    const low = this.seek(1 << (count > 16 ? 16 : count));
    this.take(low, 1);
    return high + low;
  }

  /** Whether more has been read than there is: what follows was not written by an encoder. */
  get isPastEnd() {
    return this.#at > this.#end + MOST_TRIMMED;
  }
}
