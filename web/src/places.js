/**
 * Where the point of a split is: expected from the polygon around it, and decoded as the difference.
 *
 * ```text
 *       a₂ ──── a₁             The polygon of the new point v is the kept point k and the points aₛ … aₑ around the corners that move. What is
 *      ╱  ╲    ╱  ╲            expected is the mean q of its points, and a weighted sum of how other estimates differ from q.
 *     a₃    v      a₀
 *      ╲  ╱    ╲  ╱
 *       k ──────
 * ```
 * 1. The estimates: the kept point; the middle of aₛ and aₑ; q and the mean of the Laplacians of the polygon's points; the centre of the polygon's
 *    area. They have weights along the normal of the polygon and others beside it: for each number of points in the polygon, and for each of three
 *    regimes of batches.
 * 2. The axes: the coordinates are decoded one after the other, that along which the normal is longest last. A difference in the first two says what
 *    to expect in the others, if the new point is in the plane of the polygon.
 * 3. The levels: how large a difference is expected to be. Features are the size of the polygon, projected to the axis; how far the expected point is
 *    from q; how wide the polygon is along the axis; how much the coordinate before has differed.
 *
 * All numbers are whole and below 2⁵³, and exact as floats; divisions round down.
 *
 * Based on: Taubin, Guéziec, Horn, Lazarus, "Progressive Forest Split Compression", 1998; Alliez, Desbrun, "Progressive Compression for Lossless
 * Transmission of Triangle Meshes", 2001.
 * @module
 */
import { ALONG_LEVEL, BESIDE_LEVEL, ESTIMATES, MOST_CORNERS, POLYGONS, WEIGHT_ONE } from './constants.js';
import { clamped, Level, logarithm, NumberModel } from './numbers.js';

/** @import { RangeDecoder } from './range_coder.js' */

/** What is known around a new point. */
export class Polygon {
  constructor() {
    /** The kept point, then aₛ … aₑ. */
    this.points = new Int32Array(3 * (MOST_CORNERS + 3));
    this.count = 0;
    /** The sum of the Laplacians of its points, in 1/16. */
    this.laplacians = new Float64Array(3);
  }
}

const { floor, abs, max } = Math;

/** The sets of numbers: coordinates beside the normal, those along it, and those of the base mesh. */
const ALONG = 1;
const OF_BASE = 2;
/** Estimates are in 1/16 of a step, the expected point in 1/1024. */
const ONE = 16 * WEIGHT_ONE;

/**
 * @param {number} a
 * @param {number} b
 */
function quotient(a, b) {
  return b > 0 ? floor(a / b) : 0;
}

/**
 * Returns the power of two by which a number has more bits than some.
 * @param {number} x below 2³²
 * @param {number} bits
 */
function surplus(x, bits) {
  return 1 << max(32 - Math.clz32(x) - bits, 0);
}

/**
 * Returns 65536 / n.
 * @param {number} n
 */
export function reciprocal(n) {
  return n > 0 ? floor(65536 / n) : 65536;
}

/** The models of the coordinates of new points. */
export class PlaceModel {
  #weights;
  #numbers = new NumberModel(3);
  #levels = [BESIDE_LEVEL, BESIDE_LEVEL, ALONG_LEVEL].map((weights) => new Level(weights));
  #features = Int32Array.of(32, 0, 0, 0, 0);
  /** The mean of the polygon, in 1/16, relative to the kept point; then how the estimates differ from it. */
  #estimates = new Float64Array(3 + 3 * ESTIMATES);
  /** The normal of the polygon, with eight bits along its longest axis. */
  #normal = new Float64Array(3);
  /** The variance of its points along each axis, times the square of their number. */
  #spreads = new Float64Array(3);
  /** The expected point relative to the kept one. */
  #expected = new Float64Array(3);

  /** @param {Int32Array} weights for each polygon and estimate, along the normal and beside it */
  constructor(weights) {
    this.#weights = weights;
    /** The last point. */
    this.place = new Int32Array(3);
  }

  /**
   * Decodes the position of a new point, to `place`.
   * @param {RangeDecoder} coder
   * @param {Polygon} polygon
   * @param {number} regime
   * @param {number} most the largest coordinate
   */
  decode(coder, polygon, regime, most) {
    this.#estimate(polygon);
    this.#expect(polygon.count, regime);
    const { points, count } = polygon;
    const expected = this.#expected;
    const numbers = this.#numbers;
    const features = this.#features;
    const spreads = this.#spreads;
    const estimates = this.#estimates;
    const normal = this.#normal;
    let last = 2;
    if (abs(normal[1]) >= abs(normal[last])) last = 1;
    if (abs(normal[0]) >= abs(normal[last])) last = 0;
    const axis0 = last === 2 ? 0 : last + 1;
    const axis1 = last === 0 ? 2 : last - 1;
    const n0 = normal[axis0];
    const n1 = normal[axis1];
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
    // 2. The coordinates beside the normal, then that along it.
    let slope = 0;
    let ofNormal = 0;
    features[4] = 0;
    for (let turn = 0; turn < 3; turn++) {
      const j = turn === 0 ? axis0 : turn === 1 ? axis1 : last;
      const share = turn === 0 ? ofRest - ofSquare : turn === 1 ? ofLast - ofRest : ofSquare - ofLast;
      const size = whole + share;
      features[1] = size - 64;
      features[2] = shift - share;
      features[3] = logarithm(spreads[j] + small) - ofCount - size;
      const level = this.#levels[turn];
      const middle = (floor((expected[j] + slope + ONE / 2) / ONE) + points[j]) | 0;
      const difference = numbers.decode(coder, turn === 2 ? ALONG : 0, level.expect(features));
      level.learn(features, numbers.error);
      features[4] = clamped(numbers.error, -48, 48);
      // Bytes that no encoder has written may lead beyond the grid.
      const found = clamped((middle + difference) | 0, 0, most);
      this.place[j] = found;
      // How far from what is expected of the polygon.
      ofNormal += normal[j] * (ONE * (found - points[j]) - expected[j]);
      slope = turn === 0 ? quotient(-n1 * ofNormal, rest) : quotient(-ofNormal * Math.sign(n2), abs(n2));
    }
  }

  /**
   * Decodes the position of a point of the base mesh, to `place`, which holds one near to it.
   * @param {RangeDecoder} coder
   * @param {number} square the square of the length of the sides of the triangles around
   * @param {number} most the largest coordinate
   */
  decodeBase(coder, square, most) {
    for (let axis = 0; axis < 3; axis++) {
      const difference = this.#numbers.decode(coder, OF_BASE, logarithm(square) - 16);
      this.place[axis] = clamped((this.place[axis] + difference) | 0, 0, most);
    }
  }

  /**
   * Sets the mean, the estimates, the normal and the spreads of a polygon.
   * @param {Polygon} polygon
   */
  #estimate({ points, count, laplacians }) {
    const estimates = this.#estimates;
    const normal = this.#normal;
    const share = reciprocal(count);
    const end = 3 * count;
    // 1. The sums of the points relative to the kept one, and of their squares.
    let most = 0;
    for (let j = 0; j < 3; j++) {
      let sum = 0;
      let squares = 0;
      for (let i = j + 3; i < end; i += 3) {
        const x = points[i] - points[j];
        sum += x;
        squares += x * x;
        most = max(most, abs(x));
      }
      const mean = floor((16 * sum * share) / 65536);
      estimates[j] = mean;
      estimates[3 + j] = -mean;
      estimates[6 + j] = 8 * (points[3 + j] + points[end - 3 + j] - 2 * points[j]) - mean;
      estimates[9 + j] = floor((laplacians[j] * share) / 65536);
      this.#spreads[j] = count * squares - sum * sum;
      normal[j] = 0;
    }
    // 2. The triangles between the kept point and the others, with ten bits along the longest axis.
    const unit = surplus(most, 10);
    let area = 0;
    let centreX = 0;
    let centreY = 0;
    let centreZ = 0;
    let x = 0;
    let y = 0;
    let z = 0;
    for (let i = 3; i < end; i += 3) {
      const nextX = floor((points[i] - points[0]) / unit);
      const nextY = floor((points[i + 1] - points[1]) / unit);
      const nextZ = floor((points[i + 2] - points[2]) / unit);
      const crossX = y * nextZ - z * nextY;
      const crossY = z * nextX - x * nextZ;
      const crossZ = x * nextY - y * nextX;
      const size = max(abs(crossX), abs(crossY), abs(crossZ));
      area += size;
      normal[0] += crossX;
      normal[1] += crossY;
      normal[2] += crossZ;
      centreX += size * (x + nextX);
      centreY += size * (y + nextY);
      centreZ += size * (z + nextZ);
      x = nextX;
      y = nextY;
      z = nextZ;
    }
    estimates[12] = centreX;
    estimates[13] = centreY;
    estimates[14] = centreZ;
    const longest = surplus(max(abs(normal[0]), abs(normal[1]), abs(normal[2])), 8);
    for (let j = 0; j < 3; j++) {
      estimates[12 + j] = area > 0 ? floor((estimates[12 + j] * 16 * unit) / (3 * area)) - estimates[j] : 0;
      normal[j] = floor(normal[j] / longest);
    }
  }

  /**
   * Sets the expected point.
   * @param {number} count
   * @param {number} regime
   */
  #expect(count, regime) {
    const estimates = this.#estimates;
    const expected = this.#expected;
    const [normalX, normalY, normalZ] = this.#normal;
    const weights = this.#weights;
    let of = 2 * ESTIMATES * (regime * POLYGONS + Math.min(count - 3, POLYGONS - 1));
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
