/**
 * The position of a split point: predicted from the surrounding polygon, and decoded as a residual.
 *
 * ```text
 *       a₂ ──── a₁             The polygon of the new point v consists of the kept point k and the
 *      ╱  ╲    ╱  ╲            points aₛ … aₑ around the corners that move. The prediction is mean
 *     a₃    v      a₀          q of its points plus weighted differences of other estimates from q.
 *      ╲  ╱    ╲  ╱
 *       k ──────
 * ```
 * 1. The estimates: the kept point; the midpoint of aₛ and aₑ; q plus the mean Laplacian of the
 *    polygon's points; the centroid of the polygon's area. They have separate weights along the
 *    normal of the polygon and perpendicular to it, per point count of the polygon and per batch
 *    regime (three).
 * 2. The axes: coordinates are decoded one at a time; the axis with the longest component of the
 *    normal comes last. The residuals of the first two predict the others, assuming that the new
 *    point is in the plane of the polygon.
 * 3. The levels: the expected magnitude of a residual. The features are the size of the polygon
 *    projected on the axis, the distance of the predicted point from q, the width of the polygon
 *    along the axis, and the residual of the previous coordinate.
 *
 * All numbers are integers below 2⁵³, exact as floats; divisions round down.
 *
 * Based on: Taubin, Guéziec, Horn, Lazarus, "Progressive Forest Split Compression", 1998; Alliez,
 * Desbrun, "Progressive Compression for Lossless Transmission of Triangle Meshes", 2001.
 * @module
 */
import { ALONG_LEVEL, BESIDE_LEVEL, ESTIMATES, MAX_CORNERS, MAX_LAPLACIAN, POLYGONS, WEIGHT_ONE } from './constants.js';
import { COUNT, FAN_CELLS } from './fans.js';
import { clamped, logarithm } from './math.js';
import { expectLevel, learnLevel, NumberModel } from './numbers.js';
import { around, split } from './surface.js';
import { integers } from './growth.js';

/**
 * @import { Fans } from './fans.js'
 * @import { RangeDecoder } from './range_coder.js'
 */

// Not imported from math.js: calls of imported functions would take 5 % more time overall.
const { floor, abs, max, min } = Math;

/** The sets of numbers: coordinates perpendicular to the normal, along it, and of the base mesh. */
const ALONG = 1;
const OF_BASE = 2;
/** Estimates are in 1/16 of a step, the predicted point in 1/1024. */
const ONE = 16 * WEIGHT_ONE;

/**
 * @param {number} a
 * @param {number} b
 */
function quotient(a, b) {
  return b > 0 ? floor(a / b) : 0;
}

/**
 * Returns 65536 / n.
 * @param {number} n
 */
function reciprocal(n) {
  return n > 0 ? floor(65536 / n) : 65536;
}

/** The points of the polygon relative to the kept point, without the kept point. */
const points = integers(3 * (MAX_CORNERS + 2));
/**
 * The mean of the polygon in 1/16, relative to the kept point; then the differences of the
 * estimates from it.
 */
const estimates = new Float64Array(3 + 3 * ESTIMATES);
/** The normal of the polygon, scaled to eight bits along its longest axis. */
const normal = new Float64Array(3);
/** The variance of the points along each axis, times their count squared. */
const spreads = new Float64Array(3);
/** The predicted point relative to the kept point. */
const expected = new Float64Array(3);
const features = Int32Array.of(32, 0, 0, 0, 0);

/** The models of the coordinates of new points. */
export class PlaceModel {
  #weights;
  #numbers = new NumberModel(3);
  #levels = [BESIDE_LEVEL, BESIDE_LEVEL, ALONG_LEVEL].map((weights) => Int32Array.from(weights));
  /**
   * @param {Int32Array} weights per polygon class and estimate, along the normal and perpendicular
   *   to it
   */
  constructor(weights) {
    this.#weights = weights;
    /** The last decoded point. */
    this.place = integers(3);
  }

  /**
   * Decodes the position of a new point to `place`.
   * @param {RangeDecoder} coder
   * @param {Fans} fans
   * @param {number} fan the kept fan
   * @param {number} regime
   * @param {number} most the maximum coordinate
   */
  decode(coder, fans, fan, regime, most) {
    const kept = FAN_CELLS * fan;
    const count = this.#estimate(fans, kept);
    this.#expect(count, regime);
    const numbers = this.#numbers;
    let last = 2;
    if (abs(normal[1]) >= abs(normal[last])) last = 1;
    if (abs(normal[0]) >= abs(normal[last])) last = 0;
    const n0 = normal[(last + 1) % 3];
    const n1 = normal[(last + 2) % 3];
    const n2 = normal[last];
    const rest = n1 * n1 + n2 * n2;
    const square = rest + n0 * n0;
    // 1. The features: those of the polygon, then those of an axis.
    const small = ((count * count) >> 3) + 1;
    const ofCount = 2 * logarithm(count);
    const whole = logarithm(spreads[0] + spreads[1] + spreads[2] + small) - ofCount;
    const ofSquare = logarithm(square);
    const ofRest = logarithm(rest);
    const ofLast = logarithm(n2 * n2);
    let far = ONE / 2;
    for (let j = 0; j < 3; j++) far += abs(expected[j] - WEIGHT_ONE * estimates[j]);
    const shift = 2 * logarithm(far) - 160 - whole;
    // 2. The coordinates perpendicular to the normal, then the one along it.
    let slope = 0;
    let ofNormal = 0;
    features[4] = 0;
    for (let turn = 0; turn < 3; turn++) {
      const j = (last + 1 + turn) % 3;
      const share = turn === 0 ? ofRest - ofSquare : turn === 1 ? ofLast - ofRest : ofSquare - ofLast;
      const size = whole + share;
      features[1] = size - 64;
      features[2] = shift - share;
      features[3] = logarithm(spreads[j] + small) - ofCount - size;
      const level = this.#levels[turn];
      const middle = (floor((expected[j] + slope + ONE / 2) / ONE) + fans.cells[kept + j]) | 0;
      const difference = numbers.decode(coder, turn === 2 ? ALONG : 0, expectLevel(level, features));
      learnLevel(level, features, numbers.error);
      features[4] = clamped(numbers.error, -48, 48);
      // Invalid bytes can lead beyond the grid.
      const found = clamped((middle + difference) | 0, 0, most);
      this.place[j] = found;
      // The deviation from the prediction along the normal.
      ofNormal += normal[j] * (ONE * (found - fans.cells[kept + j]) - expected[j]);
      slope = turn === 0 ? quotient(-n1 * ofNormal, rest) : floor((floor((-ofNormal * Math.sign(n2)) / 256) * reciprocal(abs(n2))) / 256);
    }
  }

  /**
   * Decodes the position of a base-mesh point to `place`, which contains a nearby point.
   * @param {RangeDecoder} coder
   * @param {number} square the squared side length of the surrounding triangles
   * @param {number} most the maximum coordinate
   */
  decodeBase(coder, square, most) {
    for (let axis = 0; axis < 3; axis++) {
      const difference = this.#numbers.decode(coder, OF_BASE, logarithm(square) - 16);
      this.place[axis] = clamped((this.place[axis] + difference) | 0, 0, most);
    }
  }

  /**
   * Computes the mean, estimates, normal and spreads of a polygon. Returns its point count.
   * @param {Fans} fans
   * @param {number} kept the first cell of the kept fan
   * @returns {number}
   */
  #estimate(fans, kept) {
    const { cells } = fans;
    const { start, count } = split;
    // 1. The points, their sum and sum of squares, and the sum of the Laplacians.
    let fanCount = cells[kept + COUNT];
    let laplacianX = fans.laplacian(kept, 0);
    let laplacianY = fans.laplacian(kept, 1);
    let laplacianZ = fans.laplacian(kept, 2);
    let end = 0;
    for (let i = start; i <= start + count; i++) {
      const at = FAN_CELLS * around[i];
      points[end++] = cells[at] - cells[kept];
      points[end++] = cells[at + 1] - cells[kept + 1];
      points[end++] = cells[at + 2] - cells[kept + 2];
      fanCount += cells[at + COUNT];
      laplacianX = (laplacianX + fans.laplacian(at, 0)) | 0;
      laplacianY = (laplacianY + fans.laplacian(at, 1)) | 0;
      laplacianZ = (laplacianZ + fans.laplacian(at, 2)) | 0;
    }
    // A triangle at the end of a border has no third point.
    for (; end < 6; end++) points[end] = points[end - 3];
    const number = end / 3 + 1;
    const share = reciprocal(number);
    const ofFans = reciprocal(fanCount);
    // Larger values come from fans with so many neighbours that the count has wrapped.
    const mean = (/** @type {number} */ laplacian) => clamped(floor((laplacian * ofFans) / 4096), -MAX_LAPLACIAN, MAX_LAPLACIAN);
    estimates[9] = mean(laplacianX);
    estimates[10] = mean(laplacianY);
    estimates[11] = mean(laplacianZ);
    let size = 1;
    for (let j = 0; j < 3; j++) {
      let sum = 0;
      let squares = 0;
      for (let i = j; i < end; i += 3) {
        sum += points[i];
        squares += points[i] * points[i];
      }
      const mean = floor((16 * sum * share) / 65536);
      estimates[j] = mean;
      estimates[3 + j] = -mean;
      estimates[6 + j] = 8 * (points[j] + points[end - 3 + j]) - mean;
      spreads[j] = number * squares - sum * sum;
      size += squares;
    }
    // 2. The triangles between the kept point and the others, reduced to eleven bits.
    const surplus = max((logarithm(size) >> 4) - 10, 0);
    let area = 0;
    let normalX = 0;
    let normalY = 0;
    let normalZ = 0;
    let centreX = 0;
    let centreY = 0;
    let centreZ = 0;
    let x = points[0] >> surplus;
    let y = points[1] >> surplus;
    let z = points[2] >> surplus;
    for (let i = 3; i < end; i += 3) {
      const nextX = points[i] >> surplus;
      const nextY = points[i + 1] >> surplus;
      const nextZ = points[i + 2] >> surplus;
      const crossX = y * nextZ - z * nextY;
      const crossY = z * nextX - x * nextZ;
      const crossZ = x * nextY - y * nextX;
      const size = max(abs(crossX), abs(crossY), abs(crossZ));
      area += size;
      normalX += crossX;
      normalY += crossY;
      normalZ += crossZ;
      centreX += size * (x + nextX);
      centreY += size * (y + nextY);
      centreZ += size * (z + nextZ);
      x = nextX;
      y = nextY;
      z = nextZ;
    }
    const ofArea = area > 0 ? floor(4294967296 / (3 * area)) / (1 << (28 - surplus)) : 0;
    estimates[12] = area > 0 ? floor(centreX * ofArea) - estimates[0] : 0;
    estimates[13] = area > 0 ? floor(centreY * ofArea) - estimates[1] : 0;
    estimates[14] = area > 0 ? floor(centreZ * ofArea) - estimates[2] : 0;
    const longest = max(abs(normalX), abs(normalY), abs(normalZ), 1);
    const unit = 1 << max((logarithm(longest) >> 3) - 7, 0);
    normal[0] = floor(normalX / unit);
    normal[1] = floor(normalY / unit);
    normal[2] = floor(normalZ / unit);
    return number;
  }

  /**
   * Computes the predicted point.
   * @param {number} count
   * @param {number} regime
   */
  #expect(count, regime) {
    const [normalX, normalY, normalZ] = normal;
    const weights = this.#weights;
    let of = 2 * ESTIMATES * (regime * POLYGONS + min(count - 3, POLYGONS - 1));
    let x = estimates[0] * WEIGHT_ONE;
    let y = estimates[1] * WEIGHT_ONE;
    let z = estimates[2] * WEIGHT_ONE;
    let along = 0;
    for (let i = 3; i < 3 + 3 * ESTIMATES; i += 3) {
      const beside = weights[of + 1];
      x += beside * estimates[i];
      y += beside * estimates[i + 1];
      z += beside * estimates[i + 2];
      along += (weights[of] - beside) * (estimates[i] * normalX + estimates[i + 1] * normalY + estimates[i + 2] * normalZ);
      of += 2;
    }
    const height = quotient(256 * along, normalX * normalX + normalY * normalY + normalZ * normalZ);
    expected[0] = x + floor((height * normalX) / 256);
    expected[1] = y + floor((height * normalY) / 256);
    expected[2] = z + floor((height * normalZ) / 256);
  }
}
