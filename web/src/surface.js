/**
 * The triangles that a stream has built so far, with their neighbours: a corner table whose vertices are fans.
 *
 * A fan is a run of triangles around a point in which each shares an edge with the next: closed around an inner point, open on a border. A point where
 * a surface touches itself, or at which attributes differ, has several fans.
 *
 * ```text
 *        a₂ ───── a₁              The corners around k, counterclockwise: (k a₀ a₁), (k a₁ a₂), …
 *       ╱  ╲     ╱  ╲
 *      ╱    ╲   ╱    ╲            A split moves the triangles of some successive corners to a new fan v, and adds the triangles
 *    a₃ ───── k ───── a₀          S = (k aₛ v) before them and E = (k v aₑ) after them.
 * ```
 * A split takes time in proportion to the corners that move; a triangle takes 32 bytes, and a fan 4.
 * @module
 */
import { MOST_CORNERS } from './constants.js';
import { grown } from './growth.js';

/** No corner: an edge of one triangle. */
export const NONE = -1;

/** From the cell of a corner's fan to that of what is opposite, and from a triangle to its mark. */
const OPPOSITE = 4;
const MARK = 3;

/**
 * Returns the next corner of the same triangle. Which one it is cannot be predicted, so that a branch would be expensive.
 * @param {number} corner
 */
export function next(corner) {
  return corner + 1 - 3 * ((corner >> 1) & 1);
}

/**
 * Returns the corner before in the same triangle.
 * @param {number} corner
 */
export function previous(corner) {
  return corner + 2 - 3 * ((corner | (corner >> 1)) & 1);
}

/** The corners of a fan, counterclockwise: at most `MOST_CORNERS` and one more. */
export class Ring {
  constructor() {
    this.corners = new Int32Array(MOST_CORNERS + 1);
    /** The fans at the other ends of its edges, one more than the corners. */
    this.around = new Int32Array(MOST_CORNERS + 2);
    this.length = 0;
    /** Whether the fan is open, if it has no more corners. */
    this.isOpen = false;
  }
}

/** What a split of a fan does. */
export class Split {
  constructor() {
    /** The first of the corners that move, and their number. */
    this.start = 0;
    this.count = 0;
    /** Whether a triangle is added before and after these corners. */
    this.addsStart = false;
    this.addsEnd = false;
  }
}

/** Triangles with neighbours. */
export class Surface {
  /**
   * Builds the table of triangles from what is opposite to each corner, where corners are counted three to a triangle. The fans get numbers in the order
   * of their lowest corners.
   * @param {Int32Array} opposite
   * @param {number} triangleCount
   */
  constructor(opposite, triangleCount) {
    /**
     * Eight cells for each triangle: the fans of its three corners, a mark, what is opposite to its corners, and one that is not used. A corner is the
     * place of its fan.
     */
    this.cells = new Int32Array(8 * triangleCount);
    this.triangleCount = triangleCount;
    /** A corner of each fan, the first one counterclockwise if the fan is open. */
    this.first = new Int32Array(triangleCount);
    this.fanCount = 0;
    for (let i = 0; i < 3 * triangleCount; i++) {
      const corner = Math.floor(i / 3) * 8 + (i % 3);
      const other = opposite[i];
      this.cells[corner] = NONE;
      this.cells[corner + OPPOSITE] = other === NONE ? NONE : Math.floor(other / 3) * 8 + (other % 3);
    }
    for (let triangle = 0; triangle < triangleCount; triangle++) {
      for (let corner = triangle * 8; corner < triangle * 8 + 3; corner++) {
        if (this.cells[corner] === NONE) this.#addFan(this.#firstAround(corner));
      }
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
   * Returns the corner with which the fan of a corner starts: this one if the fan is closed.
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
   * Returns the corner on the other side of the edge opposite to a corner, or `NONE`.
   * @param {number} corner
   */
  opposite(corner) {
    return this.cells[corner + OPPOSITE];
  }

  /**
   * Returns the mark of the triangle of a corner: 0 unless it was set.
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

  /** Returns whether the three corners of each triangle are in different fans. */
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
   * @param {Ring} ring
   */
  collect(fan, ring) {
    const { cells } = this;
    const { corners, around } = ring;
    const first = this.first[fan];
    let length = 0;
    let at = first;
    ring.isOpen = true;
    while (at !== NONE) {
      const after = next(at);
      corners[length] = at;
      around[length++] = cells[after];
      const opposite = cells[after + OPPOSITE];
      at = opposite === NONE ? NONE : next(opposite);
      if (at === first || length > MOST_CORNERS) {
        ring.isOpen = false;
        break;
      }
    }
    ring.length = length;
    if (length > 0) around[length] = cells[previous(corners[length - 1])];
  }

  /**
   * Makes two corners opposite to each other; one of them may be `NONE`.
   * @param {number} a
   * @param {number} b
   */
  #join(a, b) {
    if (a !== NONE) this.cells[a + OPPOSITE] = b;
    if (b !== NONE) this.cells[b + OPPOSITE] = a;
  }

  /**
   * Appends a triangle without neighbours; returns its first corner.
   * @param {number} a @param {number} b @param {number} c its fans
   * @param {number} mark
   */
  #push(a, b, c, mark) {
    const corner = 8 * this.triangleCount++;
    const cells = (this.cells = grown(this.cells, corner + 8));
    cells[corner] = a;
    cells[corner + 1] = b;
    cells[corner + 2] = c;
    cells[corner + MARK] = mark;
    cells[corner + OPPOSITE] = NONE;
    cells[corner + OPPOSITE + 1] = NONE;
    cells[corner + OPPOSITE + 2] = NONE;
    return corner;
  }

  /**
   * Moves successive corners of a fan to a new fan, and adds the triangles before and after them. Marks all these triangles.
   * @param {number} fan
   * @param {Ring} ring all its corners
   * @param {Split} split
   * @param {number} mark
   */
  split(fan, ring, split, mark) {
    const { start, count, addsStart, addsEnd } = split;
    const { corners, length: n, isOpen } = ring;
    const made = this.fanCount;
    const end = start + count;
    const first = corners[start < n ? start : start - n];
    const last = count === 0 ? NONE : corners[end - 1 < n ? end - 1 : end - 1 - n];
    // 1. The edges on both sides of the corners that move. Each is named by the corner opposite to it.
    const before = start > 0 ? next(corners[start - 1]) : isOpen ? NONE : next(corners[n - 1]);
    const after = isOpen && end === n ? NONE : previous(corners[end < n ? end : end - n]);
    const startFan = count > 0 ? this.cells[next(first)] : before === NONE ? NONE : this.cells[next(before)];
    const endFan = count > 0 ? this.cells[previous(last)] : after === NONE ? NONE : this.cells[previous(after)];
    // 2. Move.
    for (let i = start; i < end; i++) {
      const corner = corners[i < n ? i : i - n];
      this.cells[corner] = made;
      this.setMark(corner, mark);
    }
    // 3. Add. In S = (k aₛ v), the edge to v is opposite to corner 0, that from v to k to corner 1, that from k to corner 2.
    let addedStart = NONE;
    let addedEnd = NONE;
    if (addsStart) {
      addedStart = this.#push(fan, startFan, made, mark);
      this.#join(addedStart + 2, before);
      this.#join(addedStart, count === 0 ? NONE : previous(first));
    }
    // In E = (k v aₑ), the edge from v to aₑ is opposite to corner 0, that from aₑ to k to corner 1, that from k to v to corner 2.
    if (addsEnd) {
      addedEnd = this.#push(fan, made, endFan, mark);
      this.#join(addedEnd + 1, after);
      this.#join(addedEnd, count === 0 ? NONE : next(last));
    }
    if (addsStart && addsEnd) this.#join(addedStart + 1, addedEnd + 2);
    // 4. The first corners. An open fan starts where there is nothing clockwise.
    if (addsEnd && after === NONE) this.first[endFan] = addedEnd + 2;
    if (addsStart && count === 0) this.first[startFan] = addedStart + 1;
    this.#pushFan(addsStart ? addedStart + 2 : count > 0 ? first : addedEnd + 1);
    if (!isOpen && addsEnd) this.first[fan] = addedEnd;
    else if (start > 0) this.first[fan] = corners[0];
    else if (addsStart) this.first[fan] = addedStart;
    else this.first[fan] = addedEnd;
  }
}
