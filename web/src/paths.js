/**
 * Paths over triangles, one per strip, with the vertices that they cost, and a local search that makes them cheaper.
 *
 * Half-edges are numbered by fours: edge e of triangle t, which begins at its corner e, is 4 t + e. A link joins two triangles over the half-edges of their edge, its two sides.
 * A swap repeats a vertex, so that a strip can turn to the same side twice.
 *
 * The same steps with the same random numbers as `PricedPaths` and `LocalSearch` in Rust.
 * @module
 */
import { grown } from './growth.js';

/** No half-edge: an edge of one triangle. */
export const NONE = -1;

/** By the edges over which a triangle is linked, one bit per edge: their number, and the lowest of them, or 3. */
const DEGREES = Uint8Array.of(0, 1, 1, 2, 1, 2, 2, 3);
export const LOWEST = Uint8Array.of(3, 0, 1, 0, 2, 0, 1, 0);

/** What a strip costs beside one vertex per triangle. */
const STRIP = 2;
/** Steps of a walk that are always allowed. */
const SHORT_WALK = 16;
/** Moves of a search after its first cut. */
const DEPTH = 4;
/** From a triangle's first half-edge to the cell of its links and, at an end, the other end of its path. */
const STATE = 3;

/**
 * Returns the high 32 bits of a product.
 * @param {number} a
 * @param {number} b
 */
function highProduct(a, b) {
  const low = (a & 65535) * (b & 65535);
  const middle = (a >>> 16) * (b & 65535) + (low >>> 16);
  const other = (a & 65535) * (b >>> 16) + (middle & 65535);
  return (a >>> 16) * (b >>> 16) + (middle >>> 16) + (other >>> 16);
}

/** Random numbers of 64 bits (SplitMix64). */
export class Random {
  #high = 0;
  #low = 0;
  /** The halves of the last number: the high one, and the low one. */
  high = 0;
  low = 0;

  /** Draws the next number. */
  next() {
    const sum = this.#low + 0x7f4a7c15;
    this.#low = sum >>> 0;
    this.#high = (this.#high + 0x9e3779b9 + (sum > 0xffffffff ? 1 : 0)) >>> 0;
    this.high = this.#high;
    this.low = this.#low;
    this.#mix(30, 0xbf58476d, 0x1ce4e5b9);
    this.#mix(27, 0x94d049bb, 0x133111eb);
    this.#shift(31);
  }

  /** @param {number} shift */
  #shift(shift) {
    const { high, low } = this;
    this.low = (low ^ ((low >>> shift) | (high << (32 - shift)))) >>> 0;
    this.high = (high ^ (high >>> shift)) >>> 0;
  }

  /**
   * @param {number} shift
   * @param {number} high
   * @param {number} low
   */
  #mix(shift, high, low) {
    this.#shift(shift);
    this.high = (highProduct(this.low, low) + Math.imul(this.high, low) + Math.imul(this.low, high)) >>> 0;
    this.low = Math.imul(this.low, low) >>> 0;
  }

  /**
   * Draws a number below n.
   * @param {number} n
   */
  below(n) {
    this.next();
    return Math.floor((this.high * n) / 4294967296);
  }
}

/**
 * The side to which a path turns in a triangle, at 4 mask + edge, where the mask has the edges over which it is linked, and the path enters over one of them: 1 if it leaves over the next
 * edge, 2 over the one before, 0 if it ends.
 */
const TURNS = new Uint8Array(32);
for (let edge = 0; edge < 3; edge++) {
  const next = (edge + 1) % 3;
  TURNS[4 * ((1 << edge) | (1 << next)) + edge] = 1;
  TURNS[4 * ((1 << edge) | (1 << next)) + next] = 2;
}

/** Paths, and the search that improves them. */
export class Paths {
  #random = new Random();
  /** The walks that searches may still take, in steps. */
  walkSteps = 0;
  /** The moves of a search, to be undone: a half-edge, and of a join the outer ends of the two paths, of a cut `NONE`. */
  #moves = new Int32Array(6 * DEPTH + 3);
  #moveCount = 0;
  /** The end after a rotation. */
  #end = 0;
  /** The ends of the path of a link. */
  #here = 0;
  #there = 0;

  constructor() {
    /** Four cells per triangle: the twins of its half-edges, and its state. */
    this.cells = new Int32Array(0);
    this.triangleCount = 0;
    this.stripCount = 0;
    /** The vertices of all strips beside one per triangle. */
    this.cost = 0;
  }

  /** Appends a triangle, as a strip by itself without neighbours. */
  push() {
    const t = this.triangleCount++;
    const cells = (this.cells = grown(this.cells, 4 * t + 4));
    cells.fill(NONE, 4 * t, 4 * t + STATE);
    cells[4 * t + STATE] = t << 3;
    this.stripCount++;
    this.cost += STRIP;
  }

  /**
   * Makes two half-edges without links twins.
   * @param {number} a
   * @param {number} b
   */
  pair(a, b) {
    this.cells[a] = b;
    this.cells[b] = a;
  }

  /** @param {number} t a triangle @returns {number} the edges over which it is linked, one bit per edge */
  mask(t) {
    return this.cells[4 * t + STATE] & 7;
  }

  /** @param {number} t */
  degree(t) {
    return DEGREES[this.mask(t)];
  }

  /** @param {number} h a half-edge */
  isLinked(h) {
    return (this.mask(h >> 2) >> (h & 3)) & 1;
  }

  /** @param {number} end @returns {number} the other end of its path */
  partner(end) {
    return this.cells[4 * end + STATE] >>> 3;
  }

  /**
   * @param {number} e
   * @param {number} f the two ends of a path
   */
  #setPartners(e, f) {
    const { cells } = this;
    cells[4 * e + STATE] = (cells[4 * e + STATE] & 7) | (f << 3);
    cells[4 * f + STATE] = (cells[4 * f + STATE] & 7) | (e << 3);
  }

  /** @param {number} h @returns {number} the turn in its triangle of a path that enters over it */
  #turn(h) {
    return TURNS[((this.cells[h | STATE] & 7) << 2) | (h & 3)];
  }

  /** @param {number} link @returns {number} the swaps on it */
  #swapAt(link) {
    return (this.#turn(link) ^ this.#turn(this.cells[link])) === 3 ? 1 : 0;
  }

  /** @param {number} link @returns {number} the swaps on the other link of its triangle */
  #swapBehind(link) {
    const behind = LOWEST[this.mask(link >> 2) & ~(1 << (link & 3))];
    return behind < 3 ? this.#swapAt((link & ~3) | behind) : 0;
  }

  /** @param {number} link @returns {number} the swaps on a link and on those next to it */
  #swapsAround(link) {
    return this.#swapAt(link) + this.#swapBehind(link) + this.#swapBehind(this.cells[link]);
  }

  /** @param {number} end @returns {boolean} whether a strip from there begins with the turn that requires a swap */
  beginsWithSwap(end) {
    const edge = LOWEST[this.mask(end)];
    return edge < 3 && this.#turn(this.cells[4 * end + edge]) === 1;
  }

  /**
   * @param {number} e
   * @param {number} f the two ends of a path
   */
  #startSwap(e, f) {
    return this.beginsWithSwap(e) && this.beginsWithSwap(f) ? 1 : 0;
  }

  /**
   * Links two triangles, or removes their link.
   * @param {number} link
   */
  #toggle(link) {
    const { cells } = this;
    const twin = cells[link];
    cells[link | STATE] ^= 1 << (link & 3);
    cells[twin | STATE] ^= 1 << (twin & 3);
  }

  /**
   * Links two ends of different paths. Returns the rise of the cost, or `undefined` if the link would close a path.
   * @param {number} link
   */
  join(link) {
    const t = link >> 2;
    const u = this.cells[link] >> 2;
    const e = this.partner(t);
    const f = this.partner(u);
    if (e === u) return undefined;
    const before = this.#startSwap(e, t) + this.#startSwap(u, f);
    this.#toggle(link);
    this.#setPartners(e, f);
    const rise = this.#swapsAround(link) + this.#startSwap(e, f) - before - STRIP;
    this.stripCount--;
    this.cost += rise;
    return rise;
  }

  /**
   * Removes a link between the ends e, on its side, and f. Returns the rise of the cost.
   * @param {number} link
   * @param {number} e
   * @param {number} f
   */
  #cutBetween(link, e, f) {
    const t = link >> 2;
    const u = this.cells[link] >> 2;
    const before = this.#swapsAround(link) + this.#startSwap(e, f);
    this.#toggle(link);
    this.#setPartners(e, t);
    this.#setPartners(f, u);
    const rise = this.#startSwap(e, t) + this.#startSwap(u, f) - before + STRIP;
    this.stripCount++;
    this.cost += rise;
    return rise;
  }

  /**
   * Walks from a link both ways to the nearer end. Returns whether the steps that are left suffice.
   * @param {number} link
   */
  #findEnds(link) {
    const { cells } = this;
    const allowed = Math.max(this.walkSteps, SHORT_WALK);
    let here = link;
    let there = cells[link];
    for (let steps = 0; ; steps++) {
      const t = here >> 2;
      const u = there >> 2;
      const onHere = this.mask(t) & ~(1 << (here & 3));
      const onThere = this.mask(u) & ~(1 << (there & 3));
      const isFound = onHere === 0 || onThere === 0;
      if (isFound || steps === allowed) {
        this.walkSteps = Math.max(this.walkSteps - steps, 0);
        this.#here = onHere === 0 ? t : this.partner(u);
        this.#there = onHere === 0 ? this.partner(t) : u;
        return isFound;
      }
      here = cells[4 * t + LOWEST[onHere]];
      there = cells[4 * u + LOWEST[onThere]];
    }
  }

  /**
   * Removes a link. Returns the rise of the cost, or `undefined` if both ends are too far.
   * @param {number} link
   */
  #tryCut(link) {
    return this.#findEnds(link) ? this.#cutBetween(link, this.#here, this.#there) : undefined;
  }

  /**
   * Returns by how much a rotation raises the cost, without the repeats at the starts of paths.
   * @param {number} link from an end, and of the triangle across the link that is cut
   * @param {number} cut
   */
  #rotationRise(link, cut) {
    const { cells } = this;
    const twin = cells[link];
    const cutTwin = cells[cut];
    const w = link >> 2;
    const v = cut >> 2;
    const maskV = this.mask(v);
    const kept = LOWEST[maskV & ~(1 << (cut & 3))];
    const beyond = this.#turn(cells[4 * v + kept]);
    const newV = (1 << (twin & 3)) | (1 << kept);
    const maskW = this.mask(w);
    const newW = maskW | (1 << (link & 3));
    const isSwap = (/** @type {number} */ a, /** @type {number} */ b) => ((a ^ b) === 3 ? 1 : 0);
    const before = isSwap(TURNS[(maskV << 2) | kept], beyond) + this.#swapAt(cut) + this.#swapBehind(cutTwin);
    let after = isSwap(TURNS[(newV << 2) | kept], beyond) + isSwap(TURNS[(newW << 2) | (link & 3)], TURNS[(newV << 2) | (twin & 3)]);
    const inner = LOWEST[maskW];
    if (inner < 3) {
      const other = cells[4 * w + inner];
      // There is no turn at the new end.
      if (other >> 2 !== cutTwin >> 2) after += isSwap(TURNS[(newW << 2) | inner], this.#turn(other));
    }
    return after - before;
  }

  /**
   * Puts the last triangle, which has no links, into a link: its half-edges a and b become the twins of the link's two sides.
   * @param {number} link
   * @param {number} a
   * @param {number} b
   */
  insertIntoLink(link, a, b) {
    const twin = this.cells[link];
    const t = link >> 2;
    const u = twin >> 2;
    // Only the turn in the triangle itself is new. The start of the path changes only if the link is next to an end.
    const isFirst = this.degree(t) < 2;
    const hasEnd = isFirst || this.degree(u) < 2;
    const e = isFirst ? t : u;
    const f = hasEnd ? this.partner(e) : e;
    const start = () => (hasEnd ? this.#startSwap(e, f) : 0);
    const before = this.#swapAt(link) + start();
    this.pair(link, a);
    this.pair(twin, b);
    this.cells[a | STATE] |= (1 << (a & 3)) | (1 << (b & 3));
    this.stripCount--;
    this.cost += this.#swapAt(link) + this.#swapAt(twin) + start() - before - STRIP;
  }

  /**
   * Joins a triangle to the ends beside it, over the edge that lowers the cost the most, until none does not raise it.
   * @param {number} t
   */
  joinEnds(t) {
    while (this.degree(t) < 2) {
      let best = NONE;
      let least = 1;
      for (let h = 4 * t; h < 4 * t + 3; h++) {
        const twin = this.cells[h];
        if (twin === NONE || this.isLinked(h) || this.degree(twin >> 2) === 2) continue;
        const e = this.partner(t);
        const f = this.partner(twin >> 2);
        const rise = this.join(h);
        if (rise === undefined) continue;
        this.#cutBetween(h, e, f);
        if (rise < least) {
          least = rise;
          best = h;
        }
      }
      if (best === NONE) break;
      this.join(best);
    }
  }

  /**
   * @param {number} link
   * @param {number} e
   * @param {number} f
   */
  #record(link, e, f) {
    const moves = this.#moves;
    moves[this.#moveCount++] = link;
    moves[this.#moveCount++] = e;
    moves[this.#moveCount++] = f;
  }

  /**
   * Joins two ends unless that raises the cost by more than a limit. Returns whether it did.
   * @param {number} link
   * @param {number} highest
   */
  #tryJoin(link, highest) {
    const e = this.partner(link >> 2);
    const f = this.partner(this.cells[link] >> 2);
    const rise = this.join(link);
    if (rise === undefined) return false;
    if (rise <= highest) {
      this.#record(link, e, f);
      return true;
    }
    this.#cutBetween(link, e, f);
    return false;
  }

  /**
   * Tries a join or a rotation at an end, chosen by the random number drawn. Returns 0 if it is refused, 1 if the end was linked to another one, 2 if another end replaces it.
   * @param {number} w
   * @param {number} highest the most by which the cost may rise
   */
  #moveEnd(w, highest) {
    const { high } = this.#random;
    const inner = LOWEST[this.mask(w)];
    const link = 4 * w + (inner > 2 ? ((high & 65535) * 3) >>> 16 : (inner + 1 + (high & 1)) % 3);
    const twin = this.cells[link];
    if (twin === NONE) return 0;
    const mask = this.mask(twin >> 2);
    if (DEGREES[mask] < 2) return this.#tryJoin(link, highest) ? 1 : 0;
    // Another link of the triangle is cut.
    const cut = (twin & ~3) | (high >>> 31 ? LOWEST[mask] : 31 - Math.clz32(mask));
    const released = this.cells[cut] >> 2;
    if (released === w || this.#rotationRise(link, cut) > highest) return 0;
    const rise = this.#tryCut(cut);
    if (rise === undefined) return 0;
    this.#record(cut, NONE, NONE);
    if (this.#tryJoin(link, highest - rise)) {
      this.#end = released;
      return 2;
    }
    this.#moveCount -= 3;
    this.join(cut);
    return 0;
  }

  /**
   * Tries a chain of moves from a triangle. Within the chain the cost may rise by less than a strip; after it the cost has not risen.
   * @param {number} t
   */
  improveAt(t) {
    const random = this.#random;
    const start = this.cost;
    const highest = start + STRIP - 1;
    this.#moveCount = 0;
    let first = t;
    let second = t;
    let count = 1;
    if (this.degree(t) === 2) {
      const link = 4 * t + random.below(3);
      if (!this.isLinked(link) || start + STRIP - this.#swapsAround(link) > highest || this.#tryCut(link) === undefined) return;
      this.#record(link, NONE, NONE);
      second = this.cells[link] >> 2;
      count = 2;
    }
    for (let depth = 0; depth < DEPTH && count > 0 && this.cost >= start; depth++) {
      random.next();
      const isSecond = (random.low & (count - 1)) === 1;
      const end = isSecond ? second : first;
      // A move of the other end may have linked this one.
      const move = this.degree(end) === 2 ? 1 : this.#moveEnd(end, highest - this.cost);
      if (move === 0) continue;
      const next = move === 2 ? this.#end : count === 2 ? second : first;
      if (isSecond) second = next;
      else first = next;
      if (move === 1) count--;
    }
    if (this.cost > start) this.#undo();
  }

  #undo() {
    const moves = this.#moves;
    for (let i = this.#moveCount - 3; i >= 0; i -= 3) {
      if (moves[i + 1] === NONE) this.join(moves[i]);
      else this.#cutBetween(moves[i], moves[i + 1], moves[i + 2]);
    }
  }
}
