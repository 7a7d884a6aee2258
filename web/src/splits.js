/**
 * Which fans a batch splits, and which of their corners move.
 *
 * In each batch, triangles that a split has moved or added are used: no other split of the batch moves them. For each fan, in the order of the batch:
 *
 * 1. Is there a (further) split? Features: the valence and the used corners, the age of the fan, and how far it is from the mean of its neighbours.
 * 2. An open fan: is a triangle only added at its end, and at which one?
 * 3. The corners that move, as one choice among all runs of free corners. An edge of the fan is the first of a run, the last, within, or not of it. Its
 *    features are its length, compared with the other edges and with the line between its neighbours, and the valence at its other end.
 * 4. Corners at the end of an open fan: is there a triangle beyond?
 *
 * Based on: Pajarola, Rossignac, "Compressed Progressive Meshes", 2000.
 * @module
 */
import {
  AGE_FEATURES, COUNT_SCORES, DISTANCE_FEATURES, LEARNED_RUNS, MARK_FEATURES, MOST_CHOICES, MOST_CORNERS, ROLES, RUN_RATE, SHAPES, VALENCES,
} from './constants.js';
import { BORN, COUNT, FAN_CELLS, IS_OPEN, LAST_SPLIT, USED } from './fans.js';
import { clamped, logarithm } from './numbers.js';
import { FALLS, learn, placeOf, Scores } from './scores.js';
import { Simple } from './slots.js';
import { Split } from './surface.js';

/**
 * @import { RangeDecoder } from './range_coder.js'
 * @import { Fans } from './fans.js'
 * @import { Ring, Surface } from './surface.js'
 */

/** What an edge is to a run of corners: its first edge, one within, or its last one. */
const [FIRST, WITHIN, LAST] = [0, 1, 2];

/**
 * Returns the error of a probability.
 * @param {boolean} is what it is of
 * @param {number} weight
 * @param {number} unit
 */
function errorOf(is, weight, unit) {
  return (is ? 65536 : 0) - ((weight * unit) >>> 16);
}

const newArray = () => new Int32Array(2 * MOST_CHOICES + 2);

/** The models of splits. */
export class SplitModel {
  #surface;
  #fans;
  #marks = new Scores(MARK_FEATURES);
  #sides = new Simple(4);
  /** The scores of shapes and valences, a row of roles each, and those of the numbers of corners. */
  #edgeScores = new Int32Array(ROLES * (SHAPES + VALENCES));
  #countScores = new Int32Array(COUNT_SCORES);
  /** The runs that were decoded. */
  #runCount = 0;
  /** The mean of the logarithm of the distances of fans from the mean of those around, in 1/256 of 1/8. */
  #usual = 0;
  /** The rows of the features of each edge. */
  #shapes = newArray();
  #valences = newArray();
  #firsts = newArray();
  #ends = newArray();
  #lengths = newArray();
  #ofFirsts = newArray();
  #ofEnds = newArray();
  #ofCounts = newArray();
  /** The scores of all runs, then their weights. */
  #weights = new Int32Array(MOST_CHOICES * MOST_CHOICES);
  #split = new Split();

  /**
   * @param {Surface} surface
   * @param {Fans} fans
   */
  constructor(surface, fans) {
    this.#surface = surface;
    this.#fans = fans;
    /** The number of the batch. */
    this.batch = 0;
  }

  /**
   * Decodes whether a fan is split.
   * @param {RangeDecoder} coder
   * @param {number} fan
   * @param {number} done the splits of this batch: 1 stands for more
   * @returns {number} 1 or 0
   */
  decodeMark(coder, fan, done) {
    const fans = this.#fans;
    const { cells } = fans;
    const at = FAN_CELLS * fan;
    const open = cells[at + IS_OPEN];
    const count = cells[at + COUNT];
    const n = count > open ? count - open : 0;
    const used = cells[at + USED];
    if (n + open < 2 || n > MOST_CORNERS || (used >= n && open === 0)) return 0;
    const sum = Math.abs(fans.laplacian(fan, 0)) + Math.abs(fans.laplacian(fan, 1)) + Math.abs(fans.laplacian(fan, 2));
    const distance = logarithm(sum + 1) - logarithm(count);
    const relative = ((distance - (this.#usual >> 8)) >> 1) + 16;
    this.#usual += (distance * 256 - this.#usual) >> 7;
    const age = (this.batch - cells[at + BORN]) & 255;
    const quiet = (this.batch - cells[at + LAST_SPLIT]) & 255;
    return this.#marks.decode(
      coder,
      (clamped(n, 0, 15) * 8 + clamped(used, 0, 7)) * 4 + done * 2 + open,
      AGE_FEATURES + clamped(age, 0, 7) * 8 + clamped(quiet, 0, 7),
      DISTANCE_FEATURES + clamped(relative, 0, 31),
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
    const split = this.#split;
    const { corners, length: n, isOpen } = ring;
    const lengths = this.#lengths;
    let canMove = false;
    for (let i = 0; i < n && !canMove; i++) canMove = this.#isFree(corners[i]);
    if (isOpen && (!canMove || sides.decode(coder, 0))) {
      split.addsEnd = sides.decode(coder, 1) === 1;
      split.addsStart = !split.addsEnd;
      split.start = split.addsEnd ? 0 : n;
      split.count = 0;
      return split;
    }
    split.start = 0;
    split.count = 1;
    if (canMove && n > MOST_CHOICES) {
      this.#decodePlain(coder, ring);
    } else if (canMove) {
      // How many free corners follow one another, around a closed fan not all.
      const most = isOpen ? n : n > 1 ? n - 1 : 1;
      for (let i = isOpen ? n - 1 : 2 * n - 1, run = 0; i >= 0; i--) {
        run = this.#isFree(corners[i < n ? i : i - n]) ? run + 1 : 0;
        if (i < n) lengths[i] = run < most ? run : most;
      }
      this.#lookAround(fan, ring);
      this.#decodeRun(coder, n, isOpen);
    }
    split.addsStart = !(isOpen && split.start === 0) || sides.decode(coder, 2) === 1;
    const isAtEnd = isOpen && split.start + split.count === n && split.addsStart;
    split.addsEnd = !isAtEnd || sides.decode(coder, 3) === 1;
    return split;
  }

  /** @param {number} corner */
  #isFree(corner) {
    return this.#surface.mark(corner) !== this.batch;
  }

  /**
   * Decodes a run of free corners where there are many.
   * @param {RangeDecoder} coder
   * @param {Ring} ring
   */
  #decodePlain(coder, { corners, length: n, isOpen }) {
    const choose = (/** @type {number} */ number) => coder.decodeBits(32 - Math.clz32(number - 1)) % number;
    const free = [];
    for (let i = 0; i < n; i++) if (this.#isFree(corners[i])) free.push(i);
    const start = free[choose(free.length)];
    const most = isOpen ? n - start : n - 1;
    let run = 1;
    while (run < most && this.#isFree(corners[(start + run) % n])) run++;
    this.#split.start = start;
    this.#split.count = 1 + choose(run);
  }

  /**
   * Finds the features of the edges of a fan.
   * @param {number} fan
   * @param {Ring} ring
   */
  #lookAround(fan, { around, length: n, isOpen }) {
    const { cells } = this.#fans;
    const shapes = this.#shapes;
    const valences = this.#valences;
    const firsts = this.#firsts;
    const edgeCount = isOpen ? n + 1 : n;
    const ofRing = clamped(n, 4, 11) - 4;
    const center = FAN_CELLS * fan;
    let before = FAN_CELLS * around[n - 1];
    let at = FAN_CELLS * around[0];
    let sum = 0;
    for (let i = 0; i < edgeCount; i++) {
      const after = FAN_CELLS * around[i < n ? i + 1 : n];
      const square = this.#square(at, center);
      const length = logarithm(square);
      const isBorder = isOpen && (i === 0 || i === n);
      const chord = isBorder ? 8 : clamped((length - logarithm(this.#square(before, after)) + 16) >> 2, 0, 7);
      sum += square;
      // The lengths, until all are known.
      firsts[i] = length;
      shapes[i] = ROLES * 16 * chord;
      valences[i] = ROLES * (SHAPES + (clamped(cells[at + COUNT], 3, 10) - 3) * 8 + ofRing);
      before = at;
      at = after;
    }
    const mean = logarithm(sum) - logarithm(edgeCount);
    for (let i = 0; i < edgeCount; i++) shapes[i] += ROLES * clamped(((5 * (firsts[i] - mean)) >> 4) + 8, 0, 15);
  }

  /**
   * Returns the square of the distance of two fans, which are given by their cells.
   * @param {number} a
   * @param {number} b
   */
  #square(a, b) {
    const { cells } = this.#fans;
    const x = cells[a] - cells[b];
    const y = cells[a + 1] - cells[b + 1];
    const z = cells[a + 2] - cells[b + 2];
    return x * x + y * y + z * z;
  }

  /**
   * Decodes a run of free corners: the first one, and their number.
   * @param {RangeDecoder} coder
   * @param {number} n
   * @param {boolean} isOpen
   */
  #decodeRun(coder, n, isOpen) {
    const scores = this.#edgeScores;
    const counts = this.#countScores;
    const shapes = this.#shapes;
    const valences = this.#valences;
    const firsts = this.#firsts;
    const ends = this.#ends;
    const lengths = this.#lengths;
    const ofFirsts = this.#ofFirsts;
    const ofEnds = this.#ofEnds;
    const ofCounts = this.#ofCounts;
    const weights = this.#weights;
    const edgeCount = isOpen ? n + 1 : n;
    const ofCount = 32 * (clamped(n, 4, 11) - 4);
    // 1. The scores of a run are those of its first edge, of the edges within, of the last edge, and of its length. Around a closed fan, edges are
    //    counted twice.
    let within = 0;
    for (let i = 0; i < edgeCount; i++) {
      const shape = shapes[i];
      const valence = valences[i];
      ends[i] = within + scores[shape + LAST] + scores[valence + LAST];
      within += scores[shape + WITHIN] + scores[valence + WITHIN];
      firsts[i] = scores[shape + FIRST] + scores[valence + FIRST] - within;
    }
    if (!isOpen) for (let i = 0; i < n; i++) ends[n + i] = ends[i] + within;
    let number = 0;
    let most = -(2 ** 31);
    for (let i = 0; i < n; i++) {
      for (let c = 1; c <= lengths[i]; c++) {
        const score = firsts[i] + ends[i + c] + counts[ofCount + c];
        if (score > most) most = score;
        weights[number++] = score;
      }
    }
    // 2. Their weights, and the sums of those with a first edge, with a last one, and with a number of corners.
    ofEnds.fill(0);
    ofCounts.fill(0);
    let all = 0;
    number = 0;
    for (let i = 0; i < n; i++) {
      const before = all;
      for (let c = 1; c <= lengths[i]; c++) {
        const weight = FALLS[placeOf(most - weights[number])] >> 12;
        weights[number++] = weight;
        ofEnds[i + c] += weight;
        ofCounts[c] += weight;
        all += weight;
      }
      ofFirsts[i] = all - before;
    }
    // 3. The choice.
    const part = coder.seek(all);
    let start = 0;
    let passed = 0;
    number = 0;
    for (; part >= passed + ofFirsts[start]; start++) {
      passed += ofFirsts[start];
      number += lengths[start];
    }
    let count = 1;
    for (; part >= passed + weights[number]; count++) passed += weights[number++];
    coder.take(passed, weights[number]);
    this.#split.start = start;
    this.#split.count = count;
    if (++this.#runCount > LEARNED_RUNS && this.#runCount % 4 !== 0) return;
    // 4. Learn. An edge is within the runs that have begun before it and not ended.
    const unit = Math.floor(0xffffffff / all);
    let open = 0;
    if (!isOpen) for (let i = 0; i < n; i++) open += ofEnds[n + i];
    for (let i = 0; i < edgeCount; i++) {
      const ending = isOpen ? ofEnds[i] : ofEnds[i] + ofEnds[n + i];
      const beginning = i < n ? ofFirsts[i] : 0;
      open -= ending;
      const steps = i >= start ? i - start : isOpen ? n + 1 : i + n - start;
      for (let role = 0; role < ROLES; role++) {
        const isIt = role === FIRST ? steps === 0 : role === LAST ? steps === count : steps > 0 && steps < count;
        const error = errorOf(isIt, role === FIRST ? beginning : role === LAST ? ending : open, unit);
        learn(scores, shapes[i] + role, error, RUN_RATE);
        learn(scores, valences[i] + role, error, RUN_RATE);
      }
      open += beginning;
    }
    for (let c = 1; c <= n; c++) learn(counts, ofCount + c, errorOf(c === count, ofCounts[c], unit), RUN_RATE);
  }
}
