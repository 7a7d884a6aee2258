/**
 * Choices by scores. Each feature adds to the score of a choice, and the probability of a choice is
 * proportional to the exponential of its score. Scores are integers modulo 2³², in units of 1/65536
 * nat. A binary decision is a choice between a score and 0.
 * @module
 */
import { FALLS_LENGTH, SCORE_RATE, WHOLE } from './constants.js';
import { integers } from './growth.js';

/** @import { RangeDecoder } from './range_coder.js' */

/** Exponentials in steps of 1/32 nat: 2²⁴ e^(−k / 32). */
const falls = integers(FALLS_LENGTH);
falls[0] = 1 << 24;
for (let k = 1; k < FALLS_LENGTH; k++) falls[k] = Math.floor((falls[k - 1] * 63520) / 65536);

/** The weights of choices by the difference from the maximum score. */
export const WEIGHTS = falls.map((fall) => fall >> 12);

/**
 * The probabilities of a decision in units of 1 / `WHOLE`, by score; negative scores come first.
 */
const SHARES = Int32Array.from({ length: 2 * FALLS_LENGTH }, (_, place) => {
  const fall = falls[place < FALLS_LENGTH ? FALLS_LENGTH - 1 - place : place - FALLS_LENGTH];
  const less = Math.floor((fall * WHOLE) / (fall + (1 << 24)));
  return place < FALLS_LENGTH ? less : WHOLE - less;
});

/** The scores of one kind of decision with three features. */
export class Scores {
  #scores;

  /** @param {number} size */
  constructor(size) {
    this.#scores = integers(size);
  }

  /**
   * Decodes a decision: 1 or 0.
   * @param {RangeDecoder} coder
   * @param {number} a @param {number} b @param {number} c its features
   * @returns {number}
   */
  decode(coder, a, b, c) {
    const scores = this.#scores;
    const place = ((scores[a] + scores[b] + scores[c]) >> 11) + FALLS_LENGTH;
    const share = SHARES[place < 0 ? 0 : place < 2 * FALLS_LENGTH ? place : 2 * FALLS_LENGTH - 1];
    const bit = coder.decode(share);
    const error = (bit * WHOLE - share) >> SCORE_RATE;
    scores[a] += error;
    scores[b] += error;
    scores[c] += error;
    return bit;
  }
}
