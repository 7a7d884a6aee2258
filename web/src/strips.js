/**
 * Triangle strips of a mesh during refinement. They are maintained while splits add triangles, and
 * never rebuilt from scratch.
 *
 * A split inserts a triangle between the two sides of an edge. A strip that crosses the edge then
 * passes through the triangle; other links are unchanged. After a chunk, the other new triangles
 * are joined to adjacent strips, and a local search starts from the triangles nearest to the new
 * ones. The decoder in Rust produces the same strips.
 *
 * The class is passed to a decoder as an option, so that it is loaded only where needed:
 * `new Decoder({ strips: Strips })`.
 * @module
 */
import { FAN_CELLS, VERTEX } from './fans.js';
import { grown } from './growth.js';
import { LOWEST, NONE, Paths } from './paths.js';

/**
 * @import { Fans } from './fans.js'
 * @import { Surface } from './surface.js'
 */

/**
 * Search parameters: start triangles per new triangle; rounds from path ends; rounds from all start
 * triangles; the same for a base mesh.
 */
const NEAR = 4;
const ROUNDS_OF_ENDS = 4;
const ROUNDS = 1;
const BASE_ROUNDS = 10;
/**
 * The maximum number of walk steps of a search: a constant, and an amount per start triangle and
 * round.
 */
const WALK_STEPS = 2 ** 14;
const WALK_STEPS_PER_SEARCH = 128;

/**
 * Returns the half-edge opposite to a corner.
 * @param {number} corner
 */
function oppositeSide(corner) {
  const e = corner & 7;
  return 4 * (corner >> 3) + (e === 2 ? 0 : e + 1);
}

/** The strips of a mesh during refinement. */
export class Strips {
  #surface;
  #fans;
  #paths = new Paths();
  /** The number of triangles before the chunk. */
  #known = 0;
  /** The triangles near the new ones, and the last search that reached each triangle. */
  #near = new Int32Array(0);
  #marks = new Int32Array(0);
  #search = 0;
  /** The triangle count of the strip sent last. */
  sentTriangles = 0;

  /**
   * Builds the strips of a base mesh. Called by the decoder.
   * @param {Surface} surface
   * @param {Fans} fans
   */
  constructor(surface, fans) {
    this.#surface = surface;
    this.#fans = fans;
    const { triangleCount } = surface;
    for (let t = 0; t < triangleCount; t++) this.#paths.push();
    for (let first = 0; first < 8 * triangleCount; first += 8) {
      for (let corner = first; corner < first + 3; corner++) {
        const other = surface.opposite(corner);
        if (other !== NONE) this.#paths.pair(oppositeSide(corner), oppositeSide(other));
      }
    }
    this.#finishChunk(BASE_ROUNDS);
  }

  /**
   * Applies a split. Called by the decoder.
   * @param {boolean} addsStart whether a triangle was added before the corners that moved
   * @param {boolean} addsEnd whether a triangle was added after them
   */
  followSplit(addsStart, addsEnd) {
    const end = 8 * this.#surface.triangleCount - 8;
    const start = addsEnd ? end - 8 : end;
    if (addsStart) this.#insert(start + 2, start);
    if (addsEnd) this.#insert(end + 1, end);
    if (addsStart && addsEnd) this.#paths.pair(oppositeSide(start + 1), oppositeSide(end + 2));
  }

  /**
   * Inserts a triangle between the two sides of an edge.
   * @param {number} a
   * @param {number} b its corners opposite to its edges there
   */
  #insert(a, b) {
    const paths = this.#paths;
    const beyondA = this.#surface.opposite(a);
    const beyondB = this.#surface.opposite(b);
    paths.push();
    const outer = oppositeSide(beyondA);
    if (beyondA !== NONE && beyondB !== NONE && paths.isLinked(outer)) {
      paths.insertIntoLink(outer, oppositeSide(a), oppositeSide(b));
      return;
    }
    if (beyondA !== NONE) paths.pair(oppositeSide(a), outer);
    if (beyondB !== NONE) paths.pair(oppositeSide(b), oppositeSide(beyondB));
  }

  /**
   * Joins the triangles added since the last call to strips, and improves the strips around them.
   * The decoder calls it after each chunk, unless `isLazy` is set.
   */
  improve() {
    this.#finishChunk(ROUNDS);
  }

  /** @param {number} rounds */
  #finishChunk(rounds) {
    const paths = this.#paths;
    const { triangleCount } = paths;
    for (let t = this.#known; t < triangleCount; t++) paths.joinEnds(t);
    const count = this.#findNear();
    const near = this.#near;
    paths.walkSteps = WALK_STEPS + WALK_STEPS_PER_SEARCH * (ROUNDS_OF_ENDS + rounds) * count;
    for (let round = 0; round < ROUNDS_OF_ENDS; round++) {
      for (let i = 0; i < count; i++) if (paths.degree(near[i]) < 2) paths.improveAt(near[i]);
    }
    for (let round = 0; round < rounds; round++) {
      for (let i = 0; i < count; i++) paths.improveAt(near[i]);
    }
    this.#known = triangleCount;
  }

  /**
   * Finds the triangles nearest to the new ones, including them, in breadth-first order. Returns
   * their number.
   */
  #findNear() {
    const { cells, triangleCount } = this.#paths;
    const most = Math.min(NEAR * (triangleCount - this.#known), triangleCount);
    const near = (this.#near = grown(this.#near, most + 3));
    const marks = (this.#marks = grown(this.#marks, triangleCount));
    const search = ++this.#search;
    let count = 0;
    for (let t = this.#known; t < triangleCount; t++) {
      marks[t] = search;
      near[count++] = t;
    }
    for (let seen = 0; seen < count && count < most; seen++) {
      for (let h = 4 * near[seen]; h < 4 * near[seen] + 3; h++) {
        const t = cells[h] >> 2;
        if (cells[h] === NONE || marks[t] === search) continue;
        marks[t] = search;
        near[count++] = t;
      }
    }
    return Math.min(count, most);
  }

  /** The number of strips. */
  get count() {
    return this.#paths.stripCount;
  }

  /** The vertices of all strips, without restarts. */
  get verticesSent() {
    return this.#paths.triangleCount + this.#paths.cost;
  }

  /**
   * Returns the strips as an index buffer for `drawElements(TRIANGLE_STRIP, …)` with primitive
   * restart. The array has 16-bit indices with restart index 65535 if all vertices fit, otherwise
   * 32-bit indices with restart index 4294967295.
   * @returns {Uint16Array | Uint32Array}
   */
  indices() {
    const { triangleCount } = this.#paths;
    const Type = this.#fans.vertexCount < 65536 ? Uint16Array : Uint32Array;
    const indices = new Type(this.verticesSent + Math.max(this.count - 1, 0)).fill(-1);
    const path = new Int32Array(triangleCount);
    const seen = new Uint8Array(triangleCount);
    for (let lowest = 0, end = -1; lowest < triangleCount; lowest++) {
      if (seen[lowest]) continue;
      end = this.send(lowest, indices, end + 1, path);
      for (let i = 0; i < this.sentTriangles; i++) seen[path[i]] = 1;
    }
    return indices;
  }

  /**
   * Writes the vertices of the strip of a triangle to an array. Returns their end.
   * @param {number} t
   * @param {Uint16Array | Uint32Array} indices
   * @param {number} start
   * @param {Int32Array} path receives the triangles of the strip in order, `sentTriangles` of them
   */
  send(t, indices, start, path) {
    return this.#sendPath(this.#startOf(t), indices, start, path);
  }

  /**
   * Returns the edges across which a triangle is linked, one bit per edge.
   * @param {number} t
   */
  links(t) {
    return this.#paths.mask(t);
  }

  /**
   * Returns the end from which the path of a triangle is sent: the end in the direction of its
   * first link, unless only a strip from the other end starts without a swap.
   * @param {number} t
   */
  #startOf(t) {
    const paths = this.#paths;
    let start = t;
    for (let exit = LOWEST[paths.mask(t)]; exit < 3; ) {
      const twin = paths.cells[4 * start + exit];
      start = twin >> 2;
      exit = LOWEST[paths.mask(start) & ~(1 << (twin & 3))];
    }
    const other = paths.partner(start);
    return paths.beginsWithSwap(start) && !paths.beginsWithSwap(other) ? other : start;
  }

  /**
   * Writes the vertices of a path to an index buffer. Returns the new length.
   * @param {number} t the first triangle
   * @param {Uint16Array | Uint32Array} indices
   * @param {number} length
   * @param {Int32Array} path receives its triangles
   */
  #sendPath(t, indices, length, path) {
    const paths = this.#paths;
    const { cells } = this.#surface;
    const fans = this.#fans.cells;
    // Edge and corner indices continue beyond 2.
    const vertex = (/** @type {number} */ corner) => fans[FAN_CELLS * cells[8 * t + (corner > 2 ? corner - 3 : corner)] + VERTEX];
    let exit = LOWEST[paths.mask(t)];
    const first = exit < 3 ? exit : 1;
    for (const corner of [first + 2, first, first + 1]) indices[length++] = vertex(corner);
    path[0] = t;
    let count = 1;
    for (let isEven = false; exit < 3; ) {
      const twin = paths.cells[4 * t + exit];
      const entry = twin & 3;
      t = twin >> 2;
      path[count++] = t;
      exit = LOWEST[paths.mask(t) & ~(1 << entry)];
      if (exit < 3) {
        if ((exit === (entry < 2 ? entry + 1 : 0)) === isEven) isEven = !isEven;
        else indices[length] = indices[length++ - 2];
      }
      indices[length++] = vertex(entry + 2);
    }
    this.sentTriangles = count;
    return length;
  }
}
