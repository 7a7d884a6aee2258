/**
 * Adaptive probabilities of decisions. A slot is a 24-bit probability above an 8-bit count.
 * @module
 */
import { MAX_COUNT } from './constants.js';
import { integers } from './growth.js';

/** @import { RangeDecoder } from './range_coder.js' */

/** 2¹⁵ / (count + 1.5). */
const RATES = Int32Array.from({ length: MAX_COUNT + 1 }, (_, count) => Math.floor(65536 / (2 * count + 3)));

/** Binary decisions with one probability per context. */
export class Simple {
  #slots;

  /** @param {number} size the number of contexts */
  constructor(size) {
    this.#slots = integers(size).fill(1 << 31);
  }

  /**
   * Decodes a decision in a context: 1 or 0.
   * @param {RangeDecoder} coder
   * @param {number} context
   * @returns {number}
   */
  decode(coder, context) {
    const slots = this.#slots;
    const slot = slots[context];
    const count = slot & 255;
    const bit = coder.decode((slot >>> 16) | 1);
    const change = Math.imul(((-bit & 0xffffff) - (slot >>> 8)) >> 8, RATES[count]);
    // Increment the count, up to the limit.
    slots[context] = slot + ((change << 1) & ~255) + ((count - MAX_COUNT) >>> 31);
    return bit;
  }

  /**
   * Decodes a number of up to four bits, highest bit first, one decision per bit. Each context has
   * 16 slots.
   * @param {RangeDecoder} coder
   * @param {number} context
   * @param {number} bits
   * @returns {number}
   */
  decodeNumber(coder, context, bits) {
    let node = 1;
    for (let i = 0; i < bits; i++) node = 2 * node + this.decode(coder, 16 * context + node);
    return node - (1 << bits);
  }
}
