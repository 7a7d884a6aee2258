/**
 * Numbers as decisions: the size as a bucket, found outward from the bucket that is usual for numbers of this scale, then the sign, then the rest.
 *
 * Buckets have the bounds 0, 1, 2, 3, 4, 6, 8, 12, 16, 24, … : the bucket of a size is the whole part of twice its logarithm.
 * @module
 */
import { FIRST_STEP, MOST_BUCKET, MOST_SMALL_BITS, SCALES, STEPS } from './constants.js';
import { Mixed, Simple } from './mixing.js';

/** @import { RangeDecoder } from './range_coder.js' */

/**
 * Returns twice the binary logarithm of a whole number, roughly.
 * @param {number} x at least 0
 * @returns {number}
 */
export function halves(x) {
  let more = 0;
  // The two highest bits tell the result; more of them than 32 are not needed.
  while (x >= 4294967296 && more < 96) {
    x = Math.floor(x / 65536);
    more += 32;
  }
  const low = x >>> 0;
  if (low < 2) return low;
  const bits = 31 - Math.clz32(low);
  return more + 2 * bits + ((low >>> (bits - 1)) & 1);
}

/** The model of numbers of one kind. */
export class NumberModel {
  #contextCount;
  #middles;
  #buckets;
  #signs;
  #halves;

  /**
   * @param {number} axes
   * @param {number} contextCount
   */
  constructor(axes, contextCount) {
    this.#contextCount = contextCount;
    /** The usual bucket of each axis and scale, in 1/16. */
    this.#middles = Int32Array.from({ length: axes * SCALES }, (_, i) => Math.max((i % SCALES) * 8 - 32, 0));
    this.#buckets = new Mixed(axes * SCALES * STEPS, axes * STEPS * contextCount, axes * STEPS);
    this.#signs = new Simple(axes);
    this.#halves = new Simple(MOST_BUCKET + 1);
    /** How many buckets the last number is above what is usual. */
    this.above = 0;
  }

  /**
   * Decodes a number, and sets `above`.
   * @param {RangeDecoder} coder
   * @param {number} axis which of the numbers that belong together it is
   * @param {number} scale twice the binary logarithm of the square of what it is expected to be
   * @param {number} a @param {number} b @param {number} c @param {number} d @param {number} e what else is known, each less than the number of contexts
   * @returns {number}
   */
  decode(coder, axis, scale, a, b, c, d, e) {
    const ofScale = axis * SCALES + (scale < SCALES ? scale : SCALES - 1);
    const middle = this.#middles[ofScale];
    const usual = (middle + 8) >> 4;
    // 1. The bucket, upwards or downwards from the usual one. The steps of a context lie together.
    const buckets = this.#buckets;
    const of = axis * this.#contextCount;
    const first = ofScale * STEPS;
    a = (of + a) * STEPS;
    b = (of + b) * STEPS;
    c = (of + c) * STEPS;
    d = (of + d) * STEPS;
    e = (of + e) * STEPS;
    const set = axis * STEPS;
    let bucket = usual;
    let step = FIRST_STEP;
    if (usual === 0 || buckets.decode(coder, first + step, a + step, b + step, c + step, d + step, e + step, set + step)) {
      while (bucket < MOST_BUCKET) {
        if (step < STEPS - 1) step++;
        if (!buckets.decode(coder, first + step, a + step, b + step, c + step, d + step, e + step, set + step)) break;
        bucket++;
      }
    } else {
      bucket--;
      while (bucket > 0) {
        if (step > 0) step--;
        if (!buckets.decode(coder, first + step, a + step, b + step, c + step, d + step, e + step, set + step)) break;
        bucket--;
      }
    }
    this.#middles[ofScale] = middle + ((bucket * 16 - middle) >> 4);
    this.above = bucket - usual;
    if (bucket === 0) return 0;
    // 2. The sign, and the place within the bucket.
    const isNegative = this.#signs.decode(coder, axis);
    let size = bucket;
    if (bucket >= 4) {
      const rest = (bucket >> 1) - 2;
      const high = this.#halves.decode(coder, bucket);
      size = ((2 | (bucket & 1)) << (rest + 1)) | (high << rest) | coder.decodeBits(rest);
    }
    return isNegative ? -size : size;
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
