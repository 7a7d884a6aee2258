/**
 * Paths over triangles, one per strip, with their cost in vertices, and a local search that reduces
 * it.
 *
 * Half-edges have indices in groups of four: edge e of triangle t, which starts at its corner e, is
 * 4 t + e. A link joins two triangles across their common edge, through its two half-edges (sides).
 * A swap repeats a vertex, so that a strip can turn to the same side twice.
 *
 * The steps and random numbers are the same as in `PricedPaths` and `LocalSearch` in Rust.
 * @module
 */
import { grown } from './growth.js';

/** No half-edge: the edge has one triangle. */
export const NONE = -1;

/**
 * Indexed by the mask of linked edges, one bit per edge: the number of links, and the lowest linked
 * edge, or 3.
 */
const DEGREES = Uint8Array.of(0, 1, 1, 2, 1, 2, 2, 3);
export const LOWEST = Uint8Array.of(3, 0, 1, 0, 2, 0, 1, 0);

/** The cost of a strip in addition to one vertex per triangle. */
const STRIP = 2;
/** The number of walk steps that are always allowed. */
const SHORT_WALK = 16;
/** The maximum number of moves of a search after its first cut. */
const DEPTH = 4;
/**
 * The offset from a triangle's first half-edge to its state: the links and, at an end, the other
 * end of its path.
 */
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

/** A generator of 64-bit random numbers (SplitMix64). */
export class Random {
  #high = 0;
  #low = 0;
  /** The high and low halves of the last number. */
  high = 0;
  low = 0;

  /** Generates the next number. */
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
   * Returns a random number below n.
   * @param {number} n
   */
  below(n) {
    this.next();
    return Math.floor((this.high * n) / 4294967296);
  }
}

/**
 * The direction in which a path turns in a triangle, indexed by 4 mask + edge. The mask has the
 * linked edges, and the path enters across the edge. 1: it leaves across the next edge; 2: across
 * the previous edge; 0: it ends.
 */
const TURNS = new Uint8Array(32);
for (let edge = 0; edge < 3; edge++) {
  const next = (edge + 1) % 3;
  TURNS[4 * ((1 << edge) | (1 << next)) + edge] = 1;
  TURNS[4 * ((1 << edge) | (1 << next)) + next] = 2;
}

/** Paths and the search that improves them. */
export class Paths {
  #random = new Random();
  /** The remaining walk steps of searches. */
  walkSteps = 0;
  /**
   * The undo log of a search: a half-edge, then for a join the outer ends of both paths, for a cut
   * `NONE`.
   */
  #moves = new Int32Array(6 * DEPTH + 3);
  #moveCount = 0;
  /** The new end after a rotation. */
  #end = 0;
  /** The ends of the path of a link. */
  #here = 0;
  #there = 0;

  constructor() {
    /** Four cells per triangle: the twins of its half-edges, and its state. */
    this.cells = new Int32Array(0);
    this.triangleCount = 0;
    this.stripCount = 0;
    /** The vertices of all strips minus one per triangle. */
    this.cost = 0;
  }

  /** Appends a triangle as a separate strip without neighbours. */
  push() {
    const t = this.triangleCount++;
    const cells = (this.cells = grown(this.cells, 4 * t + 4));
    cells.fill(NONE, 4 * t, 4 * t + STATE);
    cells[4 * t + STATE] = t << 3;
    this.stripCount++;
    this.cost += STRIP;
  }

  /**
   * Makes two unlinked half-edges twins.
   * @param {number} a
   * @param {number} b
   */
  pair(a, b) {
    this.cells[a] = b;
    this.cells[b] = a;
  }

  /**
   * @param {number} t a triangle
   * @returns {number} the linked edges, one bit per edge
   */
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

  /**
   * @param {number} end
   * @returns {number} the other end of its path
   */
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

  /**
   * @param {number} h
   * @returns {number} the turn in its triangle of a path that enters across it
   */
  #turn(h) {
    return TURNS[((this.cells[h | STATE] & 7) << 2) | (h & 3)];
  }

  /**
   * @param {number} link
   * @returns {number} the swaps at the link
   */
  #swapAt(link) {
    return (this.#turn(link) ^ this.#turn(this.cells[link])) === 3 ? 1 : 0;
  }

  /**
   * @param {number} link
   * @returns {number} the swaps at the other link of its triangle
   */
  #swapBehind(link) {
    const behind = LOWEST[this.mask(link >> 2) & ~(1 << (link & 3))];
    return behind < 3 ? this.#swapAt((link & ~3) | behind) : 0;
  }

  /**
   * @param {number} link
   * @returns {number} the swaps at the link and at adjacent links
   */
  #swapsAround(link) {
    return this.#swapAt(link) + this.#swapBehind(link) + this.#swapBehind(this.cells[link]);
  }

  /**
   * @param {number} end
   * @returns {boolean} whether a strip from this end starts with a turn that requires a swap
   */
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
   * Links two ends of different paths. Returns the cost increase, or `undefined` if the link would
   * close a path.
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
   * Removes a link between the ends e (on its side) and f. Returns the cost increase.
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
   * Walks from a link in both directions until one end is reached. Returns whether the remaining
   * steps suffice.
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
   * Removes a link. Returns the cost increase, or `undefined` if both ends are too far away.
   * @param {number} link
   */
  #tryCut(link) {
    return this.#findEnds(link) ? this.#cutBetween(link, this.#here, this.#there) : undefined;
  }

  /**
   * Returns the cost increase of a rotation, without the repeats at the starts of paths.
   * @param {number} link from an end
   * @param {number} cut the link to cut, in the triangle across `link`
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
   * Inserts the last triangle, which has no links, into a link. Its half-edges a and b become the
   * twins of the two sides.
   * @param {number} link
   * @param {number} a
   * @param {number} b
   */
  insertIntoLink(link, a, b) {
    const twin = this.cells[link];
    const t = link >> 2;
    const u = twin >> 2;
    // Only the turn in the inserted triangle is new. The start of the path changes only if the link
    // is next to an end.
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
   * Joins a triangle to adjacent ends, each time across the edge that reduces the cost most, while
   * a join does not increase the cost.
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
   * Joins two ends unless the cost would rise by more than a limit. Returns whether they were
   * joined.
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
   * Tries a join or a rotation at an end, chosen by the current random number. Returns 0 if it is
   * rejected, 1 if the end was linked to another one, 2 if another end replaces it.
   * @param {number} w
   * @param {number} highest the maximum cost increase
   */
  #moveEnd(w, highest) {
    const { high } = this.#random;
    const inner = LOWEST[this.mask(w)];
    const link = 4 * w + (inner > 2 ? ((high & 65535) * 3) >>> 16 : (inner + 1 + (high & 1)) % 3);
    const twin = this.cells[link];
    if (twin === NONE) return 0;
    const mask = this.mask(twin >> 2);
    if (DEGREES[mask] < 2) return this.#tryJoin(link, highest) ? 1 : 0;
    // Cuts another link of the triangle.
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
   * Tries a chain of moves from a triangle. Within the chain, the cost may rise by less than one
   * strip; at its end it has not risen.
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
