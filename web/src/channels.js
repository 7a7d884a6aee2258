/**
 * Vertex attributes as integers on a grid. All levels have the same grid.
 *
 * Each component of a new vertex is predicted as the mean of the surrounding vertices, and the
 * residual is decoded. Joint indices are predicted by those of the kept vertex.
 * @module
 */
import { CHANNEL_LEVEL, MAX_AXES } from './constants.js';
import { grown, integers } from './growth.js';
import { abs, clamped, floor, logarithm, max, min } from './math.js';
import { expectLevel, learnLevel, NumberModel } from './numbers.js';
import { Simple } from './slots.js';

/** @import { RangeDecoder } from './range_coder.js' */

/**
 * The kinds of channels: grid steps; a unit vector on an octahedron; an octahedral vector and a
 * sign, 0 or 1; unordered names.
 */
export const LINEAR = 0;
export const OCTAHEDRAL = 1;
export const TANGENT = 2;
export const NAMES = 3;

const features = integers(3);

/**
 * Returns the level of a number: the binary logarithm of x + 1/2, in 1/16.
 * @param {number} x
 */
function sizeOf(x) {
  return 2 * logarithm(2 * x + 1) - 16;
}

/** The model that decodes a channel. */
export class ChannelModel {
  #numbers;
  #levels;
  #isKept;

  /**
   * @param {number} kind
   * @param {number} width integers per vertex
   * @param {number} bits maximum bits per integer
   */
  constructor(kind, width, bits) {
    this.kind = kind;
    this.width = width;
    this.bits = bits;
    const axes = min(width, MAX_AXES);
    this.#numbers = new NumberModel(axes);
    this.#levels = Array.from({ length: axes }, () => Int32Array.from(CHANNEL_LEVEL));
    this.#isKept = new Simple(axes);
    /** The integers of all vertices. */
    this.values = integers(0);
  }

  /**
   * Decodes the integers of the next vertex from the surrounding vertices, the kept one first.
   * @param {RangeDecoder} coder
   * @param {number} vertex
   * @param {Int32Array} around
   * @param {number} length of `around`
   */
  decode(coder, vertex, around, length) {
    const { width } = this;
    const numbers = this.#numbers;
    const most = 2 ** this.bits - 1;
    const values = (this.values = grown(this.values, width * (vertex + 1)));
    for (let component = 0; component < width; component++) {
      const axis = component < MAX_AXES ? component : MAX_AXES - 1;
      const kept = length > 0 ? values[width * around[0] + component] : 0;
      const at = width * vertex + component;
      if (this.kind === NAMES || (this.kind === TANGENT && component === 2)) {
        values[at] = this.#isKept.decode(coder, axis) ? kept : coder.bits(this.bits);
        continue;
      }
      let sum = 0;
      let lowest = kept;
      let highest = length > 0 ? kept : most;
      for (let i = 0; i < length; i++) {
        const value = values[width * around[i] + component];
        sum += value;
        lowest = min(lowest, value);
        highest = max(highest, value);
      }
      const count = length > 0 ? length : 1;
      const expected = floor((2 * sum + count) / (2 * count));
      const spread = sizeOf(highest - lowest);
      features[0] = 32;
      features[1] = spread;
      features[2] = sizeOf(abs(expected - kept)) - spread;
      const level = this.#levels[axis];
      const difference = numbers.decode(coder, axis, expectLevel(level, features));
      learnLevel(level, features, numbers.error);
      values[at] = clamped(expected + difference, 0, most);
    }
  }
}
