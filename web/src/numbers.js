/**
 * Decoding of numbers: the magnitude as a bucket relative to the expected one (one of sixteen
 * symbols), then the position in the bucket and the sign.
 *
 * Buckets have the bounds 0, 1, 2, 3, 4, 6, 8, 12, 16, 24, …: the bucket of a magnitude is the
 * integer part of twice its binary logarithm. The expected logarithm, called the level, is a
 * weighted sum of features. The weights are learned by gradient descent on the squared error.
 *
 * Based on: Widrow, Hoff, "Adaptive Switching Circuits", 1960.
 * @module
 */
import { LAST_SYMBOL, LEVELS, MIDDLE_SYMBOL, MAX_BUCKET, MAX_SMALL_BITS, SMALL_CONTEXTS } from './constants.js';
import { clamped, logarithm } from './math.js';
import { Simple } from './slots.js';

/** @import { RangeDecoder } from './range_coder.js' */

/**
 * Predicts the level of a number, in 1/16 of an octave.
 * @param {Int32Array} weights of its features, in 1/65536
 * @param {Int32Array} features
 * @returns {number}
 */
export function expectLevel(weights, features) {
  let sum = 0;
  for (let i = 0; i < weights.length; i++) sum += weights[i] * features[i];
  return sum >> 16;
}

/**
 * Updates the weights by the prediction error of a level.
 * @param {Int32Array} weights
 * @param {Int32Array} features
 * @param {number} error
 */
export function learnLevel(weights, features, error) {
  error = clamped(error, -32, 32);
  for (let i = 0; i < weights.length; i++) weights[i] += (error * features[i]) >> 3;
}

/** The model of one kind of numbers. */
export class NumberModel {
  #symbols;
  #escapes = new Simple(SMALL_CONTEXTS);
  /** The prediction error of the level of the last number. */
  error = 0;

  /** @param {number} sets */
  constructor(sets) {
    this.#symbols = new Simple(16 * LEVELS * sets);
  }

  /**
   * Decodes a number of a set, and updates `error`.
   * @param {RangeDecoder} coder
   * @param {number} set
   * @param {number} level
   * @returns {number}
   */
  decode(coder, set, level) {
    const usual = clamped(level >> 3, 0, MAX_BUCKET);
    const context = clamped((level + 32) >> 2, 0, LEVELS - 1);
    // 1. The bucket.
    const symbol = this.#symbols.decodeNumber(coder, set * LEVELS + context, 4);
    let bucket = usual - MIDDLE_SYMBOL + symbol;
    if (symbol === 0 && bucket > 0) bucket -= decodeSmall(coder, this.#escapes);
    else if (symbol === LAST_SYMBOL) bucket += decodeSmall(coder, this.#escapes);
    bucket = clamped(bucket, 0, MAX_BUCKET);
    // 2. The position in the bucket, and the sign.
    const rest = bucket < 4 ? 0 : (bucket >> 1) - 1;
    const low = bucket > 0 ? coder.bits(rest + 1) : 0;
    const size = (bucket < 4 ? bucket : (2 | (bucket & 1)) << rest) | (low >> 1);
    this.error = (2 * logarithm(2 * size + 1) - 16 - level) | 0;
    return low & 1 ? -size : size;
  }
}

/**
 * Decodes a number below 2²⁴ that is usually small.
 * @param {RangeDecoder} coder
 * @param {Simple} model of `SMALL_CONTEXTS`
 * @returns {number}
 */
export function decodeSmall(coder, model) {
  let bits = 1;
  while (bits < MAX_SMALL_BITS && model.decode(coder, bits)) bits++;
  return ((1 << (bits - 1)) | coder.bits(bits - 1)) - 1;
}
