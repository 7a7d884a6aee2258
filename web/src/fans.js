import { grown } from './growth.js';
import { NONE } from './surface.js';

/** The cells of a fan: its position, in steps of the current precision; then as follows. */
export const FAN_CELLS = 16;
/** The sum of the positions of the fans around, modulo 2³², and their number, modulo 2¹⁶. */
export const SUM = 3;
export const COUNT = 6;
/** The fan that a batch visits after this one, or none. */
export const NEXT = 7;
/** The batches in which it arose and was last split; 0 for the base mesh. */
export const BORN = 8;
export const LAST_SPLIT = 9;
/** The corners that the batch has used, at most 255. */
export const USED = 10;
/** Whether it is open: 1 or 0. */
export const IS_OPEN = 11;
export const VERTEX = 12;
/** The next fan of the same point, of one fan alone itself; and the first fan of the point. */
export const TWIN = 13;
export const LEADER = 14;

/** What is known of each fan. */
export class Fans {
  constructor() {
    this.count = 0;
    this.vertexCount = 0;
    this.cells = new Int32Array(0);
  }

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
    cells[at + LAST_SPLIT] = batch;
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
   * Adds the position of another fan to those around a fan, or removes it.
   * @param {number} fan
   * @param {number} other
   * @param {number} sign 1 or −1
   */
  around(fan, other, sign) {
    const { cells } = this;
    const at = FAN_CELLS * fan;
    const from = FAN_CELLS * other;
    for (let j = 0; j < 3; j++) cells[at + SUM + j] += sign * cells[from + j];
    cells[at + COUNT] = (cells[at + COUNT] + sign) & 0xffff;
  }

  /**
   * Returns how far the position of a fan is from the mean of those around, times their number.
   * @param {number} fan
   * @param {number} j the axis
   */
  laplacian(fan, j) {
    const { cells } = this;
    const at = FAN_CELLS * fan;
    return (Math.imul(cells[at + j], cells[at + COUNT]) - cells[at + SUM + j]) | 0;
  }
}
