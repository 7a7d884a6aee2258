/**
 * A range decoder: converts bytes to decisions with known probabilities.
 *
 * Based on: Martin, "Range encoding: an algorithm for removing redundancy from a digitised
 * message", 1979.
 * @module
 */
import { MIN_RANGE, MAX_TRIMMED } from './constants.js';

/** Reads decisions. The bytes are followed by implicit zeros. */
export class RangeDecoder {
  #bytes;
  #end;
  #at = 0;
  /**
   * The range, and the position of the bytes in it. A typed array, because a field with more than
   * 31 bits would be allocated.
   */
  #state = Uint32Array.of(0xffffffff, 0);

  /** @param {Uint8Array} bytes */
  constructor(bytes) {
    this.#bytes = bytes;
    this.#end = bytes.length;
    for (let i = 0; i < 4; i++) this.#read();
  }

  /**
   * Decodes a decision that is true with probability `probability` / `WHOLE`. Returns 1 or 0.
   * @param {number} probability
   * @returns {number}
   */
  decode(probability) {
    const state = this.#state;
    const bound = Math.imul(state[0] >>> 16, probability) >>> 0;
    const bit = state[1] < bound ? 1 : 0;
    // The outcome is unpredictable, so a branch would be expensive.
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
   * Divides the range into 2^`bits` equal parts, `bits` at most 16. Returns the index of the
   * current part, or the last one. Call `take` afterwards.
   * @param {number} bits
   * @returns {number}
   */
  seek(bits) {
    const state = this.#state;
    state[0] >>>= bits;
    return Math.min(Math.floor(state[1] / state[0]), (1 << bits) - 1);
  }

  /**
   * Narrows the range to some parts, which include the current one.
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
   * Decodes equiprobable bits.
   * @param {number} count at most 32
   * @returns {number}
   */
  bits(count) {
    const high = count > 16 ? this.bits(count - 16) * 65536 : 0;
    const low = this.seek(count > 16 ? 16 : count);
    this.take(low, 1);
    return high + low;
  }

  /** Whether more bytes were read than exist; the rest was not written by an encoder. */
  get isPastEnd() {
    return this.#at > this.#end + MAX_TRIMMED;
  }
}
