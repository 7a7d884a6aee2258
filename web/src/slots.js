/**
 * Probabilities of decisions, learned while decoding. A slot is a probability of 22 bits, less one half, above a count of 10 bits: so new slots are
 * zeros, and memory that is not used is not touched.
 * @module
 */
import { LEAST_SHARE, MOST_COUNT, WHOLE } from './constants.js';

/** @import { RangeDecoder } from './range_coder.js' */

/** 2¹⁵ / (count + 1.5). */
const RATES = Int32Array.from({ length: MOST_COUNT + 1 }, (_, count) => Math.floor(65536 / (2 * count + 3)));

/** Decisions with a probability in each of some contexts. */
export class Simple {
  #slots;

  /** @param {number} size the contexts */
  constructor(size) {
    this.#slots = new Int32Array(size);
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
    const count = slot & 1023;
    const share = slot >> 10;
    const half = share >> 6;
    const least = LEAST_SHARE - (WHOLE >> 1);
    const bit = coder.decode((half < least ? least : half > -least ? -least : half) + (WHOLE >> 1));
    const target = (-bit & ((1 << 22) - 1)) - (1 << 21);
    const change = Math.imul((target - share) >> 6, RATES[count]) >> 9;
    // One more, up to the limit.
    slots[context] = ((share + change) << 10) | (count + ((count - MOST_COUNT) >>> 31));
    return bit;
  }

  /**
   * Decodes a number of less than 16 by four decisions, the highest bit first. Each context has 16 slots.
   * @param {RangeDecoder} coder
   * @param {number} context
   * @returns {number}
   */
  decodeSymbol(coder, context) {
    let node = 1;
    while (node < 16) node = 2 * node + this.decode(coder, 16 * context + node);
    return node - 16;
  }
}
