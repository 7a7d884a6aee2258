/**
 * Numbers as decisions: the size as a bucket relative to what is expected, one of sixteen symbols, then the place within the bucket, then the sign.
 *
 * Buckets have the bounds 0, 1, 2, 3, 4, 6, 8, 12, 16, 24, … : the bucket of a size is the whole part of twice its binary logarithm. The logarithm of the
 * size that is expected, the level, is a weighted sum of features, whose weights follow the gradient of the square of the error.
 *
 * Based on: Widrow, Hoff, "Adaptive Switching Circuits", 1960.
 * @module
 */
import { LAST_SYMBOL, LEVELS, MIDDLE_SYMBOL, MOST_BUCKET, MOST_LEVEL_WEIGHT, MOST_SMALL_BITS, SMALL_CONTEXTS } from './constants.js';
import { Simple } from './slots.js';

/** @import { RangeDecoder } from './range_coder.js' */

/**
 * @param {number} x
 * @param {number} least
 * @param {number} most
 */
export function clamped(x, least, most) {
  return x < least ? least : x > most ? most : x;
}

/**
 * Returns the binary logarithm of a whole number, at least 1, in 1/8, with straight lines between the powers of two.
 * @param {number} x below 2⁵³
 * @returns {number}
 */
export function logarithm(x) {
  let more = 248;
  if (x < 1) return 0;
  // The four highest bits tell the result.
  for (; x >= 4294967296; more += 128) x = Math.floor(x / 65536);
  const zeros = Math.clz32(x);
  return more - 8 * zeros + (((x << zeros) >>> 28) & 7);
}

/** Expects the levels of numbers of one kind, in 1/16 of an octave. */
export class Level {
  #weights;

  /** @param {number[]} weights in 1/65536 */
  constructor(weights) {
    this.#weights = Int32Array.from(weights);
  }

  /**
   * @param {Int32Array} features
   * @returns {number}
   */
  expect(features) {
    const weights = this.#weights;
    let sum = 0;
    for (let i = 0; i < weights.length; i++) sum += weights[i] * features[i];
    return sum >> 16;
  }

  /**
   * Learns from how far a level was from what was expected.
   * @param {Int32Array} features
   * @param {number} error
   */
  learn(features, error) {
    const weights = this.#weights;
    error = clamped(error, -32, 32);
    for (let i = 0; i < weights.length; i++) {
      weights[i] = clamped(weights[i] + ((error * features[i]) >> 3), -MOST_LEVEL_WEIGHT, MOST_LEVEL_WEIGHT);
    }
  }
}

/** The model of numbers of one kind. */
export class NumberModel {
  #symbols;
  #halves;
  #escapes;

  /** @param {number} sets */
  constructor(sets) {
    this.#symbols = new Simple(16 * LEVELS * sets);
    this.#halves = new Simple(16);
    this.#escapes = new Simple(SMALL_CONTEXTS);
    /** How far the level of the last number is from what was expected. */
    this.error = 0;
  }

  /**
   * Decodes a number of a set, and sets `error`.
   * @param {RangeDecoder} coder
   * @param {number} set
   * @param {number} level
   * @returns {number}
   */
  decode(coder, set, level) {
    const usual = clamped(level >> 3, 0, MOST_BUCKET);
    const context = clamped((level + 32) >> 2, 0, LEVELS - 1);
    // 1. The bucket.
    const symbol = this.#symbols.decodeSymbol(coder, set * LEVELS + context);
    let bucket = usual - MIDDLE_SYMBOL + symbol;
    if (symbol === 0 && bucket > 0) bucket -= decodeSmall(coder, this.#escapes);
    else if (symbol === LAST_SYMBOL) bucket += decodeSmall(coder, this.#escapes);
    bucket = clamped(bucket, 0, MOST_BUCKET);
    // 2. The place within the bucket, and the sign.
    let size = bucket;
    let rest = 0;
    if (bucket >= 4) {
      rest = (bucket >> 1) - 2;
      size = ((2 | (bucket & 1)) << (rest + 1)) | (this.#halves.decode(coder, symbol) << rest);
    }
    const low = bucket > 0 ? coder.decodeBits(rest + 1) : 0;
    size |= low >> 1;
    this.error = 2 * logarithm(2 * size + 1) - 16 - level;
    return low & 1 ? -size : size;
  }
}

/**
 * Decodes a number that is usually small, below 2²⁴.
 * @param {RangeDecoder} coder
 * @param {Simple} model of `SMALL_CONTEXTS`
 * @returns {number}
 */
export function decodeSmall(coder, model) {
  let bits = 1;
  while (bits < MOST_SMALL_BITS && model.decode(coder, bits)) bits++;
  return ((1 << (bits - 1)) | coder.decodeBits(bits - 1)) - 1;
}
