/**
 * A range decoder: turns bytes into decisions with known probabilities.
 *
 * Based on: Martin, "Range encoding: an algorithm for removing redundancy from a digitised message", 1979.
 * @module
 */
import { MIN_RANGE, MAX_TRIMMED } from './constants.js';

/** Reads decisions. Zeros follow the bytes. */
export class RangeDecoder {
  #bytes;
  #end;
  #at = 0;
  /** The range, and where in it the bytes are. A typed array, since a field holds only 31 bits without an allocation. */
  #state = Uint32Array.of(0xffffffff, 0);

  /** @param {Uint8Array} bytes */
  constructor(bytes) {
    this.#bytes = bytes;
    this.#end = bytes.length;
    for (let i = 0; i < 4; i++) this.#read();
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
    // Which one it is cannot be predicted, so that a branch would be expensive.
    const no = bit - 1;
    state[1] -= bound & no;
    state[0] = (state[0] & no) + ((bound ^ no) - no);
    while (state[0] < MIN_RANGE) {
      this.#read();
      state[0] <<= 8;
    }
    return bit;
  }

  /**
   * Cuts the range into two to the power of `bits` equal parts, at most 2¹⁶; returns the part that is meant, or the last one. `take` follows.
   * @param {number} bits
   * @returns {number}
   */
  seek(bits) {
    const state = this.#state;
    state[0] >>>= bits;
    return Math.min(Math.floor(state[1] / state[0]), (1 << bits) - 1);
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
    while (state[0] < MIN_RANGE) {
      this.#read();
      state[0] <<= 8;
    }
  }

  #read() {
    const byte = this.#at < this.#end ? this.#bytes[this.#at] : 0;
    this.#at++;
    this.#state[1] = (this.#state[1] << 8) | byte;
  }

  /**
   * Decodes the lowest bits of a number, each as likely as not.
   * @param {number} count at most 32
   * @returns {number}
   */
  bits(count) {
    const high = count > 16 ? this.bits(count - 16) * 65536 : 0;
    const low = this.seek(count > 16 ? 16 : count);
    this.take(low, 1);
    return high + low;
  }

  /** Whether more has been read than there is: what follows was not written by an encoder. */
  get isPastEnd() {
    return this.#at > this.#end + MAX_TRIMMED;
  }
}
