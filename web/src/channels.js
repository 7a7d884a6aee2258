/**
 * Attributes of vertices as integers on a grid, the same grid for all levels.
 *
 * Each component of a new vertex is expected to be the mean of those of the vertices around it, and decoded as the difference; indices of joints are
 * expected to be those of the kept vertex.
 * @module
 */
import { CHANNEL_CONTEXTS, MOST_AXES } from './constants.js';
import { grown } from './growth.js';
import { Simple } from './mixing.js';
import { halves, NumberModel } from './numbers.js';

/** @import { RangeDecoder } from './range_coder.js' */

/** What the integers of a channel are: steps of a grid; a unit vector on an octahedron; the same and a sign, 0 or 1; names without an order. */
export const LINEAR = 0;
export const OCTAHEDRAL = 1;
export const TANGENT = 2;
export const NAMES = 3;

/** How a channel is decoded. */
export class ChannelModel {
  #numbers;
  #isKept;

  /**
   * @param {number} kind
   * @param {number} width the integers of each vertex
   * @param {number} bits those of an integer at most
   */
  constructor(kind, width, bits) {
    this.kind = kind;
    this.width = width;
    this.bits = bits;
    const axes = Math.min(width, MOST_AXES);
    this.#numbers = new NumberModel(axes, CHANNEL_CONTEXTS);
    this.#isKept = new Simple(axes);
    /** The integers of all vertices. */
    this.values = new Int32Array(0);
  }

  /**
   * Decodes the integers of the next vertex, given the vertices around it, the kept one first.
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
      const axis = component < MOST_AXES ? component : MOST_AXES - 1;
      const kept = length > 0 ? values[width * around[0] + component] : 0;
      const at = width * vertex + component;
      if (this.kind === NAMES || (this.kind === TANGENT && component === 2)) {
        values[at] = this.#isKept.decode(coder, axis) ? kept : coder.decodeBits(this.bits);
        continue;
      }
      let sum = 0;
      let lowest = kept;
      let highest = length > 0 ? kept : most;
      for (let i = 0; i < length; i++) {
        const value = values[width * around[i] + component];
        sum += value;
        if (value < lowest) lowest = value;
        if (value > highest) highest = value;
      }
      const count = length > 0 ? length : 1;
      const expected = Math.floor((2 * sum + count) / (2 * count));
      const spread = halves(highest - lowest);
      const relative = Math.min(Math.max(halves(Math.abs(expected - kept)) + 8 - spread, 0), 15);
      const a = relative * 4 + Math.min(length, 3);
      const difference = numbers.decode(coder, axis, 2 * spread, a, Math.min(length, 15), Math.min(2 * spread, 63), relative, 0);
      values[at] = Math.min(Math.max(expected + difference, 0), most);
    }
  }
}
