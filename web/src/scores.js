/**
 * Choices by scores: each feature of a choice adds to its score, and the probability of a choice is in proportion to the exponential of its score.
 * Scores are integers, in units of 1/65536 of a natural logarithm. A decision is a choice between a score and 0.
 * @module
 */
import { DECISION_RATE, FALLS_LENGTH, MOST_SCORE, WHOLE } from './constants.js';

/** @import { RangeDecoder } from './range_coder.js' */

/** Falls by one part in 32 of a natural logarithm. */
export const FALLS = new Int32Array(FALLS_LENGTH);
FALLS[0] = 1 << 24;
for (let k = 1; k < FALLS_LENGTH; k++) FALLS[k] = Math.floor((FALLS[k - 1] * 63520) / 65536);

/** The shares of `WHOLE` of a decision whose score is less than 0. */
const LESS = FALLS.map((fall) => Math.floor((fall * WHOLE) / (fall + (1 << 24))));

/**
 * Returns where in `FALLS` a difference of scores is.
 * @param {number} difference at least 0
 */
export function placeOf(difference) {
  const place = difference >> 11;
  return place < FALLS_LENGTH ? place : FALLS_LENGTH - 1;
}

/**
 * Moves a score by an error in 1/65536, at a rate in 1/128.
 * @param {Int32Array} scores
 * @param {number} at
 * @param {number} error
 * @param {number} rate
 */
export function learn(scores, at, error, rate) {
  const score = scores[at] + ((error * rate) >> 7);
  scores[at] = score > MOST_SCORE ? MOST_SCORE : score < -MOST_SCORE ? -MOST_SCORE : score;
}

/** The scores of one kind of decision, which has three features. */
export class Scores {
  #scores;

  /** @param {number} size */
  constructor(size) {
    this.#scores = new Int32Array(size);
  }

  /**
   * Decodes a decision: 1 or 0.
   * @param {RangeDecoder} coder
   * @param {number} a @param {number} b @param {number} c its features
   * @returns {number}
   */
  decode(coder, a, b, c) {
    const scores = this.#scores;
    const sum = scores[a] + scores[b] + scores[c];
    const less = LESS[placeOf(sum < 0 ? -sum : sum)];
    const share = sum < 0 ? less : WHOLE - less;
    const bit = coder.decode(share);
    const error = bit * WHOLE - share;
    learn(scores, a, error, DECISION_RATE);
    learn(scores, b, error, DECISION_RATE);
    learn(scores, c, error, DECISION_RATE);
    return bit;
  }
}
