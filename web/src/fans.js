import { grown } from './growth.js';

/** The cells of a fan, and those that say where it is, when it arose and was split, what was unexpected, and its vertex. Batches have numbers from 1. */
export const FAN_CELLS = 8;
/** The batch in which the fan arose; 0 for the base mesh. */
export const BORN = 3;
/** The last batch that has split it. */
export const LAST_SPLIT = 4;
/** How much of its point was unexpected along the normal, and beside it. */
export const ALONG = 5;
export const BESIDE = 6;
export const VERTEX = 7;

/** Around each fan: the sum of the positions, and their number. */
export const AROUND_CELLS = 4;

/** What is known of each fan. */
export class Fans {
  constructor() {
    this.count = 0;
    this.vertexCount = 0;
    /** First the position, in steps of the current precision. */
    this.cells = new Int32Array(0);
    this.around = new Float64Array(0);
    /** The next fan of the same point; of one fan alone itself. */
    this.twins = new Int32Array(0);
    /** The first fan of the point. */
    this.leaders = new Int32Array(0);
  }

  /**
   * Adds a fan; its position is to be set.
   * @param {number} twin another fan of its point, or −1
   * @param {number} vertex the next vertex, or that of another fan
   * @param {number} batch
   * @returns {number} its number
   */
  push(twin, vertex, batch) {
    const fan = this.count++;
    const cells = (this.cells = grown(this.cells, FAN_CELLS * (fan + 1)));
    this.around = grown(this.around, AROUND_CELLS * (fan + 1));
    this.twins = grown(this.twins, fan + 1);
    this.leaders = grown(this.leaders, fan + 1);
    const at = FAN_CELLS * fan;
    cells[at + BORN] = batch;
    cells[at + LAST_SPLIT] = batch;
    cells[at + VERTEX] = vertex;
    this.leaders[fan] = twin < 0 ? fan : this.leaders[twin];
    this.twins[fan] = fan;
    if (twin >= 0) {
      this.twins[fan] = this.twins[twin];
      this.twins[twin] = fan;
    }
    if (vertex >= this.vertexCount) this.vertexCount = vertex + 1;
    return fan;
  }

  /**
   * Copies the position of another fan.
   * @param {number} fan
   * @param {number} other
   */
  copyPlace(fan, other) {
    const { cells } = this;
    for (let j = 0; j < 3; j++) cells[FAN_CELLS * fan + j] = cells[FAN_CELLS * other + j];
  }
}
