/**
 * An index buffer that tracks its changed ranges.
 *
 * Changes are tracked per block. Nearby changed blocks form one range, because uploading a few
 * extra indices is cheaper than another call.
 * @module
 */

/** @import { IndexRange } from './client.js' */

/**
 * Indices per block, the maximum gap in blocks within a range, and the number of ranges above which
 * more distant ranges are merged.
 */
const BLOCK = 64;
const GAP = 2;
const MAX_RANGES = 256;

/** The minimum capacity of a non-empty buffer. */
const MIN_ROOM = 1024;

/** An index buffer and its changes. */
export class IndexBuffer {
  /** @type {Uint16Array | Uint32Array} */
  #indices = new Uint16Array(0);
  #changed = new Uint8Array(0);
  /** The number of indices to draw. */
  length = 0;

  /** The capacity in indices. */
  get capacity() {
    return this.#indices.length;
  }

  get bytesPerIndex() {
    return /** @type {2 | 4} */ (this.#indices.BYTES_PER_ELEMENT);
  }

  /** The primitive restart index. */
  get restart() {
    return this.bytesPerIndex === 2 ? 0xffff : 0xffffffff;
  }

  /** Switches to 4-byte indices. */
  widen() {
    if (this.bytesPerIndex === 4) return;
    const { restart, capacity } = this;
    this.#indices = Uint32Array.from(this.#indices, (index) => (index === restart ? 0xffffffff : index));
    this.touch(0, capacity);
  }

  /**
   * Ensures a capacity.
   * @param {number} length in indices
   */
  reserve(length) {
    const { capacity } = this;
    if (length <= capacity) return;
    const Type = /** @type {any} */ (this.#indices.constructor);
    const longer = new Type(Math.max(length, Math.ceil(1.5 * capacity), MIN_ROOM));
    longer.set(this.#indices);
    this.#indices = longer;
    const changed = new Uint8Array(Math.ceil(longer.length / BLOCK));
    changed.set(this.#changed);
    this.#changed = changed;
  }

  /**
   * Marks indices as changed.
   * @param {number} start
   * @param {number} end
   */
  touch(start, end) {
    for (let block = Math.floor(start / BLOCK); block * BLOCK < end; block++) this.#changed[block] = 1;
  }

  /**
   * Writes an index within the capacity, if it differs.
   * @param {number} at
   * @param {number} index
   */
  set(at, index) {
    if (this.#indices[at] === index) return;
    this.#indices[at] = index;
    this.#changed[Math.floor(at / BLOCK)] = 1;
  }

  /**
   * Writes indices within the capacity. Equal indices are not marked as changed.
   * @param {number} at
   * @param {Uint32Array} from
   * @param {number} start
   * @param {number} end
   */
  write(at, from, start, end) {
    for (let i = start; i < end; i++) this.set(at + i - start, from[i]);
  }

  /**
   * Fills a range with primitive restarts.
   * @param {number} start
   * @param {number} end
   */
  clear(start, end) {
    for (let i = start; i < end; i++) this.set(i, this.restart);
  }

  /**
   * Returns a copy of a range of indices.
   * @param {number} start
   * @param {number} end
   */
  slice(start, end) {
    return this.#indices.slice(start, end);
  }

  /**
   * Returns copies of the ranges changed since the last call, sorted.
   * @returns {IndexRange[]}
   */
  takeChanges() {
    const runs = this.#changedRuns();
    for (let gap = GAP; runs.length > MAX_RANGES; gap *= 2) joinNear(runs, gap);
    this.#changed.fill(0);
    return runs.map(({ first, end }) => ({ start: first * BLOCK, array: this.#indices.slice(first * BLOCK, Math.min(end * BLOCK, this.length)) }));
  }

  /** Returns the changed block ranges that are drawn, merged across small gaps. */
  #changedRuns() {
    /** @type {{ first: number, end: number }[]} */
    const runs = [];
    const count = Math.ceil(this.length / BLOCK);
    for (let block = 0; block < count; block++) {
      if (!this.#changed[block]) continue;
      const last = runs[runs.length - 1];
      if (last && block - last.end <= GAP) last.end = block + 1;
      else runs.push({ first: block, end: block + 1 });
    }
    return runs;
  }
}

/**
 * Merges ranges that are at most a gap apart.
 * @param {{ first: number, end: number }[]} runs
 * @param {number} gap
 */
function joinNear(runs, gap) {
  let count = 0;
  for (const run of runs) {
    const last = runs[count - 1];
    if (count > 0 && run.first - last.end <= gap) last.end = run.end;
    else runs[count++] = run;
  }
  runs.length = count;
}
