import { grown, integers } from './growth.js';
import { NONE } from './surface.js';

/**
 * The number of cells per fan. The first three are its position in steps of the current precision.
 */
export const FAN_CELLS = 16;
/** The sum of the positions of the neighbouring fans, modulo 2³², and their count, modulo 2¹⁶. */
export const SUM = 3;
export const COUNT = 6;
/** The fan that a batch visits after this one, or none. */
export const NEXT = 7;
/** The batch that created it; 0 for the base mesh. */
export const BORN = 8;
/** The number of corners used by a batch, at most 255, and the index of that batch. */
export const USED = 9;
export const USED_IN = 10;
/** Whether the fan is open: 1 or 0. */
export const IS_OPEN = 11;
export const VERTEX = 12;
/** The next fan of the same point in a cycle, and the first fan of the point. */
export const TWIN = 13;
export const LEADER = 14;

/** The data of all fans. */
export class Fans {
  count = 0;
  vertexCount = 0;
  cells = integers(0);

  /**
   * Adds a fan; the caller sets its position.
   * @param {number} twin another fan of its point, or none
   * @param {number} vertex the next vertex, or that of another fan
   * @param {number} batch
   * @param {number} isOpen
   * @returns {number} its index
   */
  push(twin, vertex, batch, isOpen) {
    const fan = this.count++;
    const cells = (this.cells = grown(this.cells, FAN_CELLS * (fan + 1)));
    const at = FAN_CELLS * fan;
    cells[at + NEXT] = NONE;
    cells[at + BORN] = batch;
    cells[at + USED_IN] = batch;
    cells[at + IS_OPEN] = isOpen;
    cells[at + VERTEX] = vertex;
    cells[at + LEADER] = fan;
    cells[at + TWIN] = fan;
    if (twin !== NONE) {
      const other = FAN_CELLS * twin;
      cells[at + LEADER] = cells[other + LEADER];
      cells[at + TWIN] = cells[other + TWIN];
      cells[other + TWIN] = fan;
    }
    if (vertex >= this.vertexCount) this.vertexCount = vertex + 1;
    return fan;
  }

  /**
   * Adds positions to the sum of the neighbours of a fan.
   * @param {number} at the first cell of the fan
   * @param {number} x @param {number} y @param {number} z their sum
   * @param {number} count their count
   */
  add(at, x, y, z, count) {
    const { cells } = this;
    cells[at + SUM] += x;
    cells[at + SUM + 1] += y;
    cells[at + SUM + 2] += z;
    cells[at + COUNT] = (cells[at + COUNT] + count) & 0xffff;
  }

  /**
   * Returns the number of corners used by a batch, at most 255.
   * @param {number} at the first cell of a fan
   * @param {number} batch
   */
  used(at, batch) {
    return this.cells[at + USED_IN] === batch ? this.cells[at + USED] : 0;
  }

  /**
   * Adds used corners of a batch, and subtracts corners that were counted twice.
   * @param {number} at the first cell of a fan
   * @param {number} batch
   * @param {number} count
   * @param {number} tooMany
   */
  use(at, batch, count, tooMany) {
    const { cells } = this;
    const used = this.used(at, batch) + count;
    cells[at + USED] = Math.max((used < 255 ? used : 255) - tooMany, 0);
    cells[at + USED_IN] = batch;
  }

  /**
   * Returns the offset of a fan from the mean of its neighbours, times their count.
   * @param {number} at the first cell of the fan
   * @param {number} j the axis
   */
  laplacian(at, j) {
    const { cells } = this;
    return (Math.imul(cells[at + j], cells[at + COUNT]) - cells[at + SUM + j]) | 0;
  }
}
