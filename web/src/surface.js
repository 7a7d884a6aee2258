/**
 * The triangles of a stream as decoded so far, as a corner table whose vertices are fans.
 *
 * A fan is a sequence of triangles around a point, each sharing an edge with the next. It is closed
 * around an interior point and open at a border. A point has several fans where the surface touches
 * itself or where attributes differ.
 *
 * ```text
 *        a₂ ───── a₁          The corners around k, counterclockwise: (k a₀ a₁), (k a₁ a₂), …
 *       ╱  ╲     ╱  ╲
 *      ╱    ╲   ╱    ╲        A split moves the triangles of consecutive corners to a new fan v,
 *    a₃ ───── k ───── a₀      and adds triangles S = (k aₛ v) before and E = (k v aₑ) after them.
 * ```
 * A split takes time proportional to the number of corners that move. A triangle takes 32 bytes and
 * a fan 4.
 * @module
 */
import { MAX_CORNERS } from './constants.js';
import { grown, integers } from './growth.js';

/** No corner: the edge has one triangle. */
export const NONE = -1;

/**
 * The offsets from the cell of a corner's fan to that of its opposite corner, and from a triangle
 * to its mark.
 */
const OPPOSITE = 4;
const MARK = 3;

/**
 * Returns the next corner of the same triangle. The result is unpredictable, so a branch would be
 * expensive.
 * @param {number} corner
 */
export function next(corner) {
  return corner + 1 - 3 * ((corner >> 1) & 1);
}

/**
 * Returns the previous corner of the same triangle.
 * @param {number} corner
 */
export function previous(corner) {
  return corner + 2 - 3 * ((corner | (corner >> 1)) & 1);
}

/**
 * The corners of the last collected fan, counterclockwise, at most `MAX_CORNERS` and one more; and
 * the fans at the other ends of its edges, one more. Both are repeated, so that runs can wrap
 * around.
 */
export const corners = integers(2 * MAX_CORNERS + 2);
export const around = integers(2 * MAX_CORNERS + 2);

/**
 * The state of that fan: `free` has the free corners among the first 32 as bits, if there are no
 * more.
 */
export const ring = { length: 0, isOpen: false, free: 0 };

/**
 * A split of that fan: the first corner that moves, the number of corners, and whether a triangle
 * is added before and after them.
 */
export const split = { start: 0, count: 0, addsStart: false, addsEnd: false };

/** Triangles with adjacency. */
export class Surface {
  /**
   * Builds the table from the corner opposite to each corner, with three corner indices per
   * triangle. Fans are ordered by their lowest corners.
   * @param {Int32Array} opposite
   * @param {number} triangleCount
   */
  constructor(opposite, triangleCount) {
    /**
     * Eight cells per triangle: the fans of its three corners, a mark, the opposite corners, and
     * one unused cell. A corner is the index of the cell of its fan.
     */
    this.cells = integers(8 * triangleCount);
    this.triangleCount = triangleCount;
    /** A corner of each fan; the first one counterclockwise if the fan is open. */
    this.first = integers(triangleCount);
    this.fanCount = 0;
    const cornerOf = (/** @type {number} */ i) => i + 5 * Math.floor(i / 3);
    for (let i = 0; i < 3 * triangleCount; i++) {
      this.cells[cornerOf(i)] = NONE;
      this.cells[cornerOf(i) + OPPOSITE] = opposite[i] === NONE ? NONE : cornerOf(opposite[i]);
    }
    for (let i = 0; i < 3 * triangleCount; i++) {
      if (this.cells[cornerOf(i)] === NONE) this.#addFan(this.#firstAround(cornerOf(i)));
    }
  }

  /** @param {number} first */
  #addFan(first) {
    for (let at = first; at !== NONE && this.cells[at] === NONE; at = this.after(at)) this.cells[at] = this.fanCount;
    this.#pushFan(first);
  }

  /** @param {number} first */
  #pushFan(first) {
    this.first = grown(this.first, this.fanCount + 1);
    this.first[this.fanCount++] = first;
  }

  /**
   * Returns the first corner of the fan of a corner: the corner itself if the fan is closed.
   * @param {number} corner
   */
  #firstAround(corner) {
    let first = corner;
    for (;;) {
      const before = this.cells[previous(first) + OPPOSITE];
      if (before === NONE) return first;
      first = previous(before);
      if (first === corner) return first;
    }
  }

  /**
   * Returns the fan of a corner.
   * @param {number} corner
   */
  fan(corner) {
    return this.cells[corner];
  }

  /**
   * Returns the corner across the edge opposite to a corner, or `NONE`.
   * @param {number} corner
   */
  opposite(corner) {
    return this.cells[corner + OPPOSITE];
  }

  /**
   * Returns the mark of the triangle of a corner, initially 0.
   * @param {number} corner
   */
  mark(corner) {
    return this.cells[corner | MARK];
  }

  /**
   * @param {number} corner
   * @param {number} mark
   */
  setMark(corner, mark) {
    this.cells[corner | MARK] = mark;
  }

  /**
   * Returns the next corner counterclockwise around the fan of a corner, or `NONE`.
   * @param {number} corner
   */
  after(corner) {
    const opposite = this.cells[next(corner) + OPPOSITE];
    return opposite === NONE ? NONE : next(opposite);
  }

  /** Returns whether the three corners of every triangle are in different fans. */
  hasDistinctFans() {
    const { cells } = this;
    for (let first = 0; first < 8 * this.triangleCount; first += 8) {
      if (cells[first] === cells[first + 1] || cells[first + 1] === cells[first + 2] || cells[first] === cells[first + 2]) return false;
    }
    return true;
  }

  /**
   * Collects the corners of a fan.
   * @param {number} fan
   * @param {number} used the mark of triangles that are not free
   */
  collect(fan, used) {
    const { cells } = this;
    const first = this.first[fan];
    let length = 0;
    let free = 0;
    let last = NONE;
    ring.isOpen = true;
    for (let at = first; at !== NONE; ) {
      const after = next(at);
      const opposite = cells[after + OPPOSITE];
      if (cells[at | MARK] !== used) free |= 1 << length;
      corners[length] = at;
      around[length++] = cells[after];
      last = cells[previous(at)];
      at = opposite === NONE ? NONE : next(opposite);
      if (at === first || length > MAX_CORNERS) {
        ring.isOpen = false;
        break;
      }
    }
    around[length] = last;
    ring.free = free;
    ring.length = length;
  }

  /**
   * Sets the opposite of a corner, possibly `NONE`.
   * @param {number} corner
   * @param {number} opposite
   */
  #join(corner, opposite) {
    if (corner !== NONE) this.cells[corner + OPPOSITE] = opposite;
  }

  /**
   * Appends a triangle, and returns its first corner.
   * @param {number} a @param {number} b @param {number} c its fans
   * @param {number} mark
   * @param {number} ofA @param {number} ofB @param {number} ofC the corners opposite to its corners
   */
  #push(a, b, c, mark, ofA, ofB, ofC) {
    const corner = 8 * this.triangleCount++;
    const cells = (this.cells = grown(this.cells, corner + 8));
    cells[corner] = a;
    cells[corner + 1] = b;
    cells[corner + 2] = c;
    cells[corner + MARK] = mark;
    cells[corner + OPPOSITE] = ofA;
    cells[corner + OPPOSITE + 1] = ofB;
    cells[corner + OPPOSITE + 2] = ofC;
    this.#join(ofA, corner);
    this.#join(ofB, corner + 1);
    this.#join(ofC, corner + 2);
    return corner;
  }

  /**
   * Moves consecutive corners of a fan to a new fan, and adds and marks the triangles before and
   * after them.
   * @param {number} fan whose corners were collected
   * @param {number} mark
   */
  split(fan, mark) {
    const { start, count, addsStart, addsEnd } = split;
    const { length: n, isOpen } = ring;
    const made = this.fanCount;
    const end = start + count;
    // 1. The edges on both sides of the corners that move. Each is identified by its opposite
    //    corner.
    const before = start > 0 ? next(corners[start - 1]) : isOpen ? NONE : next(corners[n - 1]);
    const after = isOpen && end === n ? NONE : previous(corners[end < n ? end : end - n]);
    const first = count > 0 ? previous(corners[start]) : NONE;
    const last = count > 0 ? next(corners[end - 1]) : NONE;
    // 2. Move.
    for (let i = start; i < end; i++) this.cells[corners[i]] = made;
    // 3. Add. In S = (k aₛ v), the edge to v is opposite to corner 0, the edge from v to k to
    //    corner 1, and the edge from k to corner 2. In E = (k v aₑ), the edge from v to aₑ is
    //    opposite to corner 0, the edge from aₑ to k to corner 1, and the edge from k to v to
    //    corner 2.
    let addedStart = NONE;
    let addedEnd = NONE;
    if (addsStart) addedStart = this.#push(fan, around[start], made, mark, first, NONE, before);
    if (addsEnd) addedEnd = this.#push(fan, made, around[end], mark, last, after, addsStart ? addedStart + 1 : NONE);
    // 4. The first corners. An open fan starts where no corner is clockwise.
    this.#pushFan(addsStart ? addedStart + 2 : count > 0 ? corners[start] : addedEnd + 1);
    const firsts = this.first;
    if (addsEnd && after === NONE) firsts[around[end]] = addedEnd + 2;
    if (addsStart && count === 0) firsts[around[start]] = addedStart + 1;
    firsts[fan] = !isOpen && addsEnd ? addedEnd : start > 0 ? corners[0] : addsStart ? addedStart : addedEnd;
  }
}
