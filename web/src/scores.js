/**
 * Choices by scores: each feature of a choice adds to its score, and the probability of a choice is in proportion to the exponential of its score.
 * Scores are integers modulo 2³², in units of 1/65536 of a natural logarithm. A decision is a choice between a score and 0.
 * @module
 */
import { FALLS_LENGTH, SCORE_RATE, WHOLE } from './constants.js';
import { integers } from './growth.js';

/** @import { RangeDecoder } from './range_coder.js' */

/** Falls by one part in 32 of a natural logarithm: 2²⁴ e^(−k / 32). */
const falls = integers(FALLS_LENGTH);
falls[0] = 1 << 24;
for (let k = 1; k < FALLS_LENGTH; k++) falls[k] = Math.floor((falls[k - 1] * 63520) / 65536);

/** The weights of choices, by how much their score is less than the largest one. */
export const WEIGHTS = falls.map((fall) => fall >> 12);

/** The shares of `WHOLE` of a decision: those of scores less than 0 first. */
const SHARES = Int32Array.from({ length: 2 * FALLS_LENGTH }, (_, place) => {
  const fall = falls[place < FALLS_LENGTH ? FALLS_LENGTH - 1 - place : place - FALLS_LENGTH];
  const less = Math.floor((fall * WHOLE) / (fall + (1 << 24)));
  return place < FALLS_LENGTH ? less : WHOLE - less;
});

/** The scores of one kind of decision, which has three features. */
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
