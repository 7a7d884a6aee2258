import { grown, integers } from './growth.js';
import { NONE } from './surface.js';

/** The cells of a fan: its position, in steps of the current precision; then as follows. */
export const FAN_CELLS = 16;
/** The sum of the positions of the fans around, modulo 2³², and their number, modulo 2¹⁶. */
export const SUM = 3;
export const COUNT = 6;
/** The fan that a batch visits after this one, or none. */
export const NEXT = 7;
/** The batch in which it arose; 0 for the base mesh. */
export const BORN = 8;
/** The corners that a batch has used, at most 255, and the number of the batch. */
export const USED = 9;
export const USED_IN = 10;
/** Whether it is open: 1 or 0. */
export const IS_OPEN = 11;
export const VERTEX = 12;
/** The next fan of the same point, of one fan alone itself; and the first fan of the point. */
export const TWIN = 13;
export const LEADER = 14;

/** What is known of each fan. */
export class Fans {
  count = 0;
  vertexCount = 0;
  cells = integers(0);

  /**
   * Adds a fan; its position is to be set.
   * @param {number} twin another fan of its point, or none
   * @param {number} vertex the next vertex, or that of another fan
   * @param {number} batch
   * @param {number} isOpen
   * @returns {number} its number
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
   * Adds positions to those around a fan.
   * @param {number} at the first cell of the fan
   * @param {number} x @param {number} y @param {number} z their sum
   * @param {number} count their number
   */
  add(at, x, y, z, count) {
    const { cells } = this;
    cells[at + SUM] += x;
    cells[at + SUM + 1] += y;
    cells[at + SUM + 2] += z;
    cells[at + COUNT] = (cells[at + COUNT] + count) & 0xffff;
  }

  /**
   * Returns the corners that a batch has used, at most 255.
   * @param {number} at the first cell of a fan
   * @param {number} batch
   */
  used(at, batch) {
    return this.cells[at + USED_IN] === batch ? this.cells[at + USED] : 0;
  }

  /**
   * Counts corners that a batch has used, and takes others away that it had counted.
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
   * Returns how far the position of a fan is from the mean of those around, times their number.
   * @param {number} at the first cell of the fan
   * @param {number} j the axis
   */
  laplacian(at, j) {
    const { cells } = this;
    return (Math.imul(cells[at + j], cells[at + COUNT]) - cells[at + SUM + j]) | 0;
  }
}
