/**
 * The fans that a batch splits, and the corners that move.
 *
 * Triangles that a split has moved or added are used: no other split of the same batch moves them.
 * For each fan, in batch order:
 *
 * 1. Is there a (further) split? Features: valence and free corners, age of the fan, and its
 *    distance from the mean of its neighbours.
 * 2. For an open fan: is only a triangle added at an end, and at which one?
 * 3. The number of corners that move, given the valence and the lengths of runs of free corners.
 * 4. The first of these corners, as one choice among all corners that start such a run. Each edge
 *    of the fan is the first edge of the run, its last edge, inside it, or outside. The features of
 *    an edge are its relative length and the valence at its other end.
 * 5. For corners at the end of an open fan: is there a triangle beyond it?
 *
 * Based on: Pajarola, Rossignac, "Compressed Progressive Meshes", 2000.
 * @module
 */
import {
  AGE_FEATURES, DISTANCE_FEATURES, LENGTHS, MARK_FEATURES, MAX_CHOICES, MAX_CORNERS, ROLES, SCORE_RATE, VALENCES, WHOLE,
} from './constants.js';
import { BORN, COUNT, FAN_CELLS, IS_OPEN } from './fans.js';
import { clamped, logarithm } from './math.js';
import { Scores, WEIGHTS } from './scores.js';
import { Simple } from './slots.js';
import { around, corners, ring, split } from './surface.js';
import { integers } from './growth.js';

/**
 * @import { RangeDecoder } from './range_coder.js'
 * @import { Fans } from './fans.js'
 * @import { Surface } from './surface.js'
 */

/** The role of an edge in a run of corners: first, inside, or last. */
const [FIRST, WITHIN, LAST] = [0, 1, 2];

/** The maximum number of edges of a fan with scored choices. */
const EDGES = MAX_CHOICES + 1;

// Scratch arrays for decoding a run: the start corners of runs by length, as bits; per edge, the
// rows of its features and its scores; per choice, its start corner and probability; the errors of
// all corners, repeated once before the first.
const starts = integers(EDGES);
const ofLengths = integers(EDGES);
const ofValences = integers(EDGES);
const firsts = integers(EDGES);
const ends = integers(2 * EDGES);
const choices = integers(EDGES);
const shares = integers(EDGES);
const errors = integers(2 * EDGES + 1);

/** The models for splits. */
export class SplitModel {
  #surface;
  #fans;
  #marks = new Scores(MARK_FEATURES);
  #sides = new Simple(4);
  #counts = new Simple(16 * 16 * 16);
  /** The scores of lengths and valences, one row of roles each. */
  #scores = integers(ROLES * (LENGTHS + VALENCES));

  /**
   * @param {Surface} surface
   * @param {Fans} fans
   */
  constructor(surface, fans) {
    this.#surface = surface;
    this.#fans = fans;
    /** The index of the batch. */
    this.batch = 0;
  }

  /**
   * Decodes whether a fan is split.
   * @param {RangeDecoder} coder
   * @param {number} fan
   * @param {number} done the number of splits in this batch; 1 means one or more
   * @returns {number} 1 or 0
   */
  decodeMark(coder, fan, done) {
    const fans = this.#fans;
    const { cells } = fans;
    const at = FAN_CELLS * fan;
    const open = cells[at + IS_OPEN];
    const count = cells[at + COUNT];
    const free = count - open - fans.used(at, this.batch);
    if (count < 2 || count > MAX_CORNERS || (free <= 0 && open === 0)) return 0;
    const sum = Math.abs(fans.laplacian(at, 0)) + Math.abs(fans.laplacian(at, 1)) + Math.abs(fans.laplacian(at, 2));
    const distance = ((logarithm(sum + 1) - logarithm(count)) >> 2) + 4;
    const age = (this.batch - cells[at + BORN]) & 255;
    return this.#marks.decode(
      coder,
      ((count < 15 ? count : 15) * 8 + clamped(free, 0, 7)) * 4 + done * 2 + open,
      AGE_FEATURES + (age < 7 ? age : 7),
      DISTANCE_FEATURES + clamped(distance, 0, 31),
    );
  }

  /**
   * Decodes which corners of a fan move, to `split`.
   * @param {RangeDecoder} coder
   * @param {number} fan whose corners were collected
   */
  decodeSplit(coder, fan) {
    const sides = this.#sides;
    const { length: n, isOpen } = ring;
    const canMove = n > MAX_CHOICES ? corners.subarray(0, n).some((corner) => this.#isFree(corner)) : ring.free !== 0;
    split.start = 0;
    split.count = 1;
    split.addsStart = split.addsEnd = true;
    if (isOpen && (!canMove || sides.decode(coder, 0))) {
      split.count = 0;
      split.addsEnd = sides.decode(coder, 1) === 1;
      split.addsStart = !split.addsEnd;
      if (split.addsStart) split.start = n;
      return;
    }
    if (canMove) this.#decodeRun(coder, fan);
    const end = split.start + split.count;
    if (isOpen && split.start === 0) split.addsStart = sides.decode(coder, 2) === 1;
    if (isOpen && end === n && split.addsStart) split.addsEnd = sides.decode(coder, 3) === 1;
    for (let i = n; i < end; i++) {
      corners[i] = corners[i - n];
      around[i + 1] = around[i + 1 - n];
    }
  }

  /** @param {number} corner */
  #isFree(corner) {
    return this.#surface.mark(corner) !== this.batch;
  }

  /**
   * Decodes a run of free corners in a fan with many corners.
   * @param {RangeDecoder} coder
   */
  #decodePlain(coder) {
    const { length: n, isOpen } = ring;
    const choose = (/** @type {number} */ number) => coder.bits(32 - Math.clz32(number - 1)) % number;
    const free = [];
    for (let i = 0; i < n; i++) if (this.#isFree(corners[i])) free.push(i);
    const start = free[choose(free.length)];
    const most = isOpen ? n - start : n - 1;
    let run = 1;
    while (run < most && this.#isFree(corners[(start + run) % n])) run++;
    split.start = start;
    split.count = 1 + choose(run);
  }

  /**
   * Decodes a run of free corners: its length and its first corner.
   * @param {RangeDecoder} coder
   * @param {number} fan
   */
  #decodeRun(coder, fan) {
    const { length: n, isOpen, free } = ring;
    if (n > MAX_CHOICES) {
      this.#decodePlain(coder);
      return;
    }
    // 1. The starts of runs of this length. A run never covers a whole closed fan.
    const twice = isOpen ? free : free | (free << n);
    const largest = isOpen ? n : n - 1;
    let longest = 1;
    starts[1] = free;
    while (longest < largest) {
      const rest = starts[longest] & (twice >> longest);
      if (rest === 0) break;
      starts[++longest] = rest;
    }
    // 2. The number of corners.
    let count = 1;
    if (longest > 1) count = Math.min(1 + this.#counts.decodeNumber(coder, 16 * n + longest, n > 8 ? 4 : 3), longest);
    split.count = count;
    let rest = starts[count];
    split.start = 31 - Math.clz32(rest);
    if ((rest & (rest - 1)) === 0) return;
    // 3. The scores of the start: of the first edge, the edges inside, and the last edge. Around a
    //    closed fan, edges are repeated.
    const scores = this.#scores;
    const edgeCount = isOpen ? n + 1 : n;
    this.#lookAround(fan, edgeCount);
    let within = 0;
    for (let i = 0; i < edgeCount; i++) {
      const a = ofLengths[i];
      const b = ofValences[i];
      ends[i] = within + scores[a + LAST] + scores[b + LAST];
      within = (within + scores[a + WITHIN] + scores[b + WITHIN]) | 0;
      firsts[i] = scores[a + FIRST] + scores[b + FIRST] - within;
    }
    if (!isOpen) for (let i = 0; i < count; i++) ends[n + i] = ends[i] + within;
    let number = 0;
    let most = 1 << 31;
    for (; rest !== 0; rest &= rest - 1) {
      const i = 31 - Math.clz32(rest & -rest);
      const score = (firsts[i] + ends[i + count]) | 0;
      choices[number] = i;
      shares[number++] = score;
      if (score > most) most = score;
    }
    // 4. The probabilities.
    let all = 0;
    for (let c = 0; c < number; c++) {
      const place = (most - shares[c]) >>> 11;
      all += shares[c] = WEIGHTS[place < 255 ? place : 255];
    }
    const unit = Math.floor(0xffffffff / all);
    // 5. The choice. The last one gets the rounding remainder.
    const part = coder.seek(16);
    let choice = 0;
    let passed = 0;
    let sum = 0;
    errors.fill(0);
    for (let c = 0; c < number; c++) {
      if (part >= sum) {
        choice = c;
        passed = sum;
      }
      const share = (shares[c] * unit) >>> 16;
      sum += shares[c] = share;
      errors[EDGES + choices[c]] = -share >> SCORE_RATE;
    }
    coder.take(passed, choice < number - 1 ? shares[choice] : WHOLE - passed);
    const start = choices[choice];
    split.start = start;
    // 6. Learn. An edge is inside the runs that started before it and have not ended.
    errors[EDGES + start] = (WHOLE - shares[choice]) >> SCORE_RATE;
    let open = 0;
    for (let by = 1; by <= count && !isOpen; by++) {
      errors[EDGES - by] = errors[EDGES + n - by];
      if (by < count) open += errors[EDGES - by];
    }
    for (let i = 0; i < edgeCount; i++) {
      const a = ofLengths[i];
      const b = ofValences[i];
      const first = errors[EDGES + i];
      const last = errors[EDGES + i - count];
      scores[a + FIRST] += first;
      scores[a + WITHIN] += open;
      scores[a + LAST] += last;
      scores[b + FIRST] += first;
      scores[b + WITHIN] += open;
      scores[b + LAST] += last;
      open += first - errors[EDGES + i - count + 1];
    }
  }

  /**
   * Computes the features of the edges of a fan.
   * @param {number} fan
   * @param {number} edgeCount
   */
  #lookAround(fan, edgeCount) {
    const { cells } = this.#fans;
    const x = cells[FAN_CELLS * fan];
    const y = cells[FAN_CELLS * fan + 1];
    const z = cells[FAN_CELLS * fan + 2];
    let sum = 1;
    for (let i = 0; i < edgeCount; i++) {
      const at = FAN_CELLS * around[i];
      const dx = cells[at] - x;
      const dy = cells[at + 1] - y;
      const dz = cells[at + 2] - z;
      const square = dx * dx + dy * dy + dz * dz + 1;
      sum += square;
      ofLengths[i] = logarithm(square);
      ofValences[i] = ROLES * (LENGTHS + Math.min(cells[at + COUNT], 15));
    }
    const mean = logarithm(sum) - logarithm(edgeCount);
    for (let i = 0; i < edgeCount; i++) ofLengths[i] = ROLES * clamped(((5 * (ofLengths[i] - mean)) >> 4) + 8, 0, 15);
    if (ring.isOpen) ofValences[0] = ofValences[edgeCount - 1] = ROLES * LENGTHS;
  }
}
