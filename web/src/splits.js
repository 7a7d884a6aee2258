/**
 * Which fans a batch splits, and which of their corners move.
 *
 * In each batch, triangles that a split has moved or added are used: no other split of the batch moves them. For each fan, in the order of their numbers:
 *
 * 1. Is there a (further) split? Contexts: the valence and the free corners, the age of the fan and of those around it, its size relative to the
 *    others, and how many of its edges are chords: longer than the line between their neighbours, as collapses leave them.
 * 2. An open fan: is a triangle only added at its end, and at which one?
 * 3. The first corner that moves: for each free corner but the last, is it this one?
 * 4. Do more corners move: for each next one, as long as it is free.
 * 5. Corners at the end of an open fan: is there a triangle beyond?
 *
 * Contexts of 3 and 4 are how long the edges on both sides are, compared with the others and with the lines across.
 *
 * Based on: Pajarola, Rossignac, "Compressed Progressive Meshes", 2000.
 * @module
 */
import { MOST_CORNERS, SPLIT_SETS, SPLIT_SLOTS } from './constants.js';
import { BORN, FAN_CELLS, LAST_SPLIT } from './fans.js';
import { Mixed, Simple } from './mixing.js';
import { halves } from './numbers.js';
import { next, previous, Split } from './surface.js';

/**
 * @import { RangeDecoder } from './range_coder.js'
 * @import { Fans } from './fans.js'
 * @import { Ring, Surface } from './surface.js'
 */

/**
 * @param {number} a
 * @param {number} b
 */
function least(a, b) {
  return a < b ? a : b;
}

const newMixed = () => new Mixed(SPLIT_SLOTS, SPLIT_SLOTS, SPLIT_SETS);

/** The models of splits. */
export class SplitModel {
  #surface;
  #fans;
  #marks;
  #starts;
  #runs;
  #sides;
  #usualSize;
  #rim;
  #spokes;
  #meanSpoke;
  #last;
  #chords = 0;
  #lengths = 0;
  #ages = 0;
  #firsts = 0;

  /**
   * @param {Surface} surface
   * @param {Fans} fans
   */
  constructor(surface, fans) {
    this.#surface = surface;
    this.#fans = fans;
    /** The number of the batch. */
    this.batch = 0;
    this.#marks = newMixed();
    this.#starts = newMixed();
    this.#runs = newMixed();
    this.#sides = new Simple(4);
    /** The mean of twice the logarithm of the squares of the sides around fans, in 1/256. */
    this.#usualSize = 0;
    /** The points around the fan, the squares of their distances from it, and their mean. */
    this.#rim = new Float64Array(3 * (MOST_CORNERS + 1));
    this.#spokes = new Float64Array(MOST_CORNERS + 1);
    this.#meanSpoke = 0;
    /** The last split. */
    this.#last = new Split();
  }

  /**
   * Collects the points around a fan.
   * @param {number} fan
   * @param {Ring} ring
   */
  #lookAround(fan, ring) {
    const { cells } = this.#fans;
    const ofCorner = this.#surface.cells;
    const rim = this.#rim;
    const spokes = this.#spokes;
    const { corners, length } = ring;
    const x = cells[FAN_CELLS * fan];
    const y = cells[FAN_CELLS * fan + 1];
    const z = cells[FAN_CELLS * fan + 2];
    let sum = 0;
    for (let i = 0; i <= length; i++) {
      const corner = i < length ? next(corners[i]) : previous(corners[i - 1]);
      const at = FAN_CELLS * ofCorner[corner];
      const px = cells[at];
      const py = cells[at + 1];
      const pz = cells[at + 2];
      rim[3 * i] = px;
      rim[3 * i + 1] = py;
      rim[3 * i + 2] = pz;
      const square = (px - x) * (px - x) + (py - y) * (py - y) + (pz - z) * (pz - z);
      spokes[i] = square;
      if (i < length) sum += square;
    }
    this.#meanSpoke = Math.floor(sum / length);
  }

  /**
   * Returns the square of the line between the neighbours of a point around the fan, which has some before it.
   * @param {number} i
   * @param {number} n the corners of the fan
   */
  #across(i, n) {
    const rim = this.#rim;
    const before = 3 * (i === 0 ? n - 1 : i - 1);
    const after = 3 * (i + 1);
    const x = rim[after] - rim[before];
    const y = rim[after + 1] - rim[before + 1];
    const z = rim[after + 2] - rim[before + 2];
    return x * x + y * y + z * z;
  }

  /**
   * Decodes whether a fan is split, after `done` splits in this batch.
   * @param {RangeDecoder} coder
   * @param {number} fan
   * @param {Ring} ring
   * @param {number} done
   * @returns {number} 1 or 0
   */
  decodeMark(coder, fan, ring, done) {
    const { corners, length: n } = ring;
    const { batch } = this;
    const ofCorner = this.#surface.cells;
    const { cells } = this.#fans;
    const open = ring.isOpen ? 1 : 0;
    if (n < 2 - open || n > MOST_CORNERS) return 0;
    // 1. The fans around. What cannot be predicted is counted without branches: x − 1 >>> 31 is 1 if x is 0, for x ≥ 0.
    let free = 0;
    let split = 0;
    let born = 0;
    let earlier = 0;
    let run = 0;
    let longestRun = 0;
    for (let i = 0; i < n; i++) {
      const corner = corners[i];
      const other = ofCorner[next(corner)];
      const isUsed = ((ofCorner[corner | 3] ^ batch) - 1) >>> 31;
      split += ((cells[FAN_CELLS * other + LAST_SPLIT] ^ batch) - 1) >>> 31;
      born += ((cells[FAN_CELLS * other + BORN] ^ batch) - 1) >>> 31;
      earlier += (other - fan) >>> 31;
      free += 1 - isUsed;
      run = (run + 1) & (isUsed - 1);
      if (run > longestRun) longestRun = run;
    }
    if (free === 0 && open === 0) return 0;
    // 2. Its size and its chords.
    this.#lookAround(fan, ring);
    let chords = 0;
    for (let i = open; i < n && chords < 7; i++) if (this.#spokes[i] > this.#across(i, n)) chords++;
    const size = halves(this.#meanSpoke);
    const difference = size - (this.#usualSize >> 8) + 8;
    const relative = difference < 0 ? 0 : least(difference, 15);
    this.#usualSize += (size * 256 - this.#usualSize) >> 7;

    const age = least(batch - cells[FAN_CELLS * fan + BORN], 7);
    const quiet = least(batch - cells[FAN_CELLS * fan + LAST_SPLIT], 7);
    const valence = least(n, 15);
    const few = least(free, 15);
    const set = least(done, 3) * 2 + open;
    return this.#marks.decode(
      coder,
      (valence * 16 + few) * 8 + set,
      (relative * 16 + few) * 8 + set,
      (chords * 16 + few) * 16 + valence,
      (age * 8 + quiet) * 16 + few,
      (least(split, 7) * 8 + least(born, 7)) * 16 + few,
      (least(earlier, 15) * 8 + least(longestRun, 7)) * 8 + chords,
      set,
    );
  }

  /**
   * Decodes which corners of a fan move.
   * @param {RangeDecoder} coder
   * @param {number} fan
   * @param {Ring} ring
   * @returns {Split} valid until the next call
   */
  decodeSplit(coder, fan, ring) {
    const sides = this.#sides;
    const last = this.#last;
    const n = ring.length;
    let free = 0;
    for (let i = 0; i < n; i++) if (this.#isFree(ring.corners[i])) free++;
    if (ring.isOpen && (free === 0 || sides.decode(coder, 0))) {
      last.addsEnd = sides.decode(coder, 1) === 1;
      last.addsStart = !last.addsEnd;
      last.start = last.addsEnd ? 0 : n;
      last.count = 0;
      return last;
    }
    this.#lookAround(fan, ring);
    last.start = this.#decodeStart(coder, ring, free);
    last.count = this.#decodeCount(coder, ring, last.start);
    last.addsStart = !(ring.isOpen && last.start === 0) || sides.decode(coder, 2) === 1;
    const isAtEnd = ring.isOpen && last.start + last.count === n && last.addsStart;
    last.addsEnd = !isAtEnd || sides.decode(coder, 3) === 1;
    return last;
  }

  /** @param {number} corner */
  #isFree(corner) {
    return this.#surface.cells[corner | 3] !== this.batch;
  }

  /**
   * Decodes the first corner that moves.
   * @param {RangeDecoder} coder
   * @param {Ring} ring
   * @param {number} left the free corners
   * @returns {number}
   */
  #decodeStart(coder, ring, left) {
    const { corners, length: n, isOpen } = ring;
    for (let i = 0; i < n; i++) {
      if (!this.#isFree(corners[i])) continue;
      left--;
      if (left === 0) return i;
      const before = i > 0 ? this.#isFree(corners[i - 1]) : !isOpen && this.#isFree(corners[n - 1]);
      const after = i + 1 < n ? this.#isFree(corners[i + 1]) : !isOpen && this.#isFree(corners[0]);
      const free = (before ? 2 : 0) + (after ? 1 : 0);
      this.#compare(ring, i);
      const isFirst = this.#starts.decode(
        coder,
        this.#chords * 4 + free,
        this.#lengths * 4 + free,
        (least(i, 15) * 16 + least(left, 15)) * 4 + free,
        this.#ages * 4 + free,
        this.#firsts * 4 + free,
        (least(n, 15) * 16 + (this.#chords >> 4)) * 4 + free,
        isOpen ? free + 4 : free,
      );
      if (isFirst) return i;
    }
    return 0;
  }

  /**
   * Decodes how many corners move.
   * @param {RangeDecoder} coder
   * @param {Ring} ring
   * @param {number} start
   * @returns {number}
   */
  #decodeCount(coder, ring, start) {
    const { corners, length: n, isOpen } = ring;
    // One corner of a closed fan stays.
    const most = isOpen ? n - start : Math.max(n - 1, 1);
    const ofStart = this.#ofChord(start, n, isOpen);
    for (let count = 1; count < most; count++) {
      const i = start + count < n ? start + count : start + count - n;
      if (!this.#isFree(corners[i])) return count;
      this.#compare(ring, i);
      const few = least(count, 7);
      const isMore = this.#runs.decode(
        coder,
        this.#chords * 8 + few,
        this.#lengths * 8 + few,
        least(n, 15) * 16 + least(count, 15),
        this.#ages * 8 + few,
        this.#firsts * 8 + least(n - count, 7),
        ((this.#chords & 0xf0) + ofStart) * 8 + few,
        few,
      );
      if (!isMore) return count;
    }
    return most;
  }

  /**
   * Compares the edges on both sides of a corner, in pairs of numbers from 0 to 15: with the lines between their neighbours, with the other edges of
   * the fan, and how long ago their fans arose and were split. Also the first one with that line and with the others.
   * @param {Ring} ring
   * @param {number} i
   */
  #compare({ corners, length: n, isOpen }, i) {
    const a = this.#ofOthers(i);
    const across = this.#ofChord(i, n, isOpen) * 16;
    this.#chords = across + this.#ofChord(i + 1, n, isOpen);
    this.#lengths = a * 16 + this.#ofOthers(i + 1);
    this.#ages = this.#age(next(corners[i])) * 16 + this.#age(previous(corners[i]));
    this.#firsts = across + a;
  }

  /**
   * Returns how long ago a fan at a corner arose and was split: 0 to 15.
   * @param {number} corner
   */
  #age(corner) {
    const { cells } = this.#fans;
    const at = FAN_CELLS * this.#surface.cells[corner];
    return least(this.batch - cells[at + BORN], 3) * 4 + least(this.batch - cells[at + LAST_SPLIT], 3);
  }

  /**
   * Compares an edge with all edges of the fan: 0 to 15.
   * @param {number} i
   */
  #ofOthers(i) {
    return least(halves(Math.floor((16 * this.#spokes[i]) / (this.#meanSpoke + 1))), 15);
  }

  /**
   * Compares an edge with the line between its neighbours: 0 to 15.
   * @param {number} i
   * @param {number} n the corners of the fan
   * @param {boolean} isOpen
   */
  #ofChord(i, n, isOpen) {
    if (isOpen && (i === 0 || i === n)) return 15;
    if (i === n) i = 0;
    return least(halves(Math.floor((64 * this.#spokes[i]) / (this.#across(i, n) + 1))) >> 1, 15);
  }
}
