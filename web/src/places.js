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
 * 1. The estimates: the kept point; the middle of aₛ and aₑ; the mean of the parallelograms over the edges of the polygon; q and the mean of the
 *    Laplacians of the polygon's points; the centre of its perimeter. They have weights along the normal of the polygon and others beside it: for each
 *    number of points in the polygon, and for each of three regimes of batches.
 * 2. The axes: the coordinates are decoded one after the other, that along which the normal is longest last. A difference in the first two says what
 *    to expect in the others, if the new point is in the plane of the polygon.
 * 3. The scales: the size of the polygon, projected to each axis. Other contexts: how large the differences were at the points around, how much the
 *    estimates differ along the normal, how wide the polygon is along the axis, how much the coordinates before have differed.
 *
 * All numbers are whole and below 2⁵³, and exact as floats; divisions round down.
 *
 * Based on: Touma, Gotsman, "Triangle Mesh Compression", 1998; Taubin, Guéziec, Horn, Lazarus, "Progressive Forest Split Compression", 1998; Alliez,
 * Desbrun, "Progressive Compression for Lossless Transmission of Triangle Meshes", 2001.
 * @module
 */
import { ESTIMATES, MOST_CORNERS, MOST_SURPRISE, PLACE_CONTEXTS, POLYGONS, WEIGHT_ONE } from './constants.js';
import { halves, NumberModel } from './numbers.js';

/** @import { RangeDecoder } from './range_coder.js' */

/** What is known around a new point. */
export class Polygon {
  constructor() {
    /** The kept point, then aₛ … aₑ. */
    this.points = new Float64Array(3 * (MOST_CORNERS + 3));
    this.count = 0;
    /** The sum of the parallelograms over its edges, and their number. */
    this.parallelograms = new Float64Array(3);
    this.parallelogramCount = 0;
    /** The sum of the Laplacians of its points, in 1/16. */
    this.laplacians = new Float64Array(3);
    /** The sums of the surprises of the kept point, aₛ and aₑ. */
    this.along = 0;
    this.beside = 0;
  }
}

/** The powers of two. */
const POWERS = Float64Array.from({ length: 64 }, (_, i) => 2 ** i);

/**
 * @param {number} a
 * @param {number} b
 */
function quotient(a, b) {
  return b > 0 ? Math.floor(a / b) : 0;
}

/**
 * @param {number} x
 * @param {number} most
 */
function clamped(x, most) {
  return x < 0 ? 0 : x > most ? most : x;
}

/**
 * Returns the bits of a whole number of less than 2⁶⁴.
 * @param {number} x
 */
function bitLength(x) {
  return x < 4294967296 ? 32 - Math.clz32(x) : 64 - Math.clz32(x / 4294967296);
}

/** The models of the coordinates of new points. */
export class PlaceModel {
  #weights;
  #numbers;
  #most;
  #mean;
  #others;
  #normal;
  #square;
  #expected;

  /** @param {Int32Array} weights for each polygon and estimate, along the normal and beside it */
  constructor(weights) {
    this.#weights = weights;
    this.#numbers = new NumberModel(3, PLACE_CONTEXTS);
    /** The largest coordinate. */
    this.#most = 0;
    /** The last point. */
    this.place = new Int32Array(3);
    this.along = 0;
    this.beside = 0;
    /** The mean of the polygon, in 1/16, and how the estimates differ from it. */
    this.#mean = new Float64Array(3);
    this.#others = new Float64Array(3 * ESTIMATES);
    /** The normal of the polygon, with eight bits along its longest axis. */
    this.#normal = new Float64Array(3);
    /** The square of the mean distance of its points from the mean. */
    this.#square = 0;
    /** The expected point, in 1/512. */
    this.#expected = new Float64Array(3);
  }

  /**
   * Decodes the position of a new point, to `place`, `along` and `beside`.
   * @param {RangeDecoder} coder
   * @param {Polygon} polygon
   * @param {number} regime
   * @param {number} knownBits those of a coordinate
   */
  decode(coder, polygon, regime, knownBits) {
    this.#most = 2 ** knownBits - 1;
    this.#estimate(polygon);
    this.#expect(polygon, regime);
    const normal = this.#normal;
    const expected = this.#expected;
    const size = this.#square;
    let last = 2;
    if (Math.abs(normal[1]) >= Math.abs(normal[last])) last = 1;
    if (Math.abs(normal[0]) >= Math.abs(normal[last])) last = 0;
    const axis0 = last === 2 ? 0 : last + 1;
    const axis1 = last === 0 ? 2 : last - 1;
    const n0 = normal[axis0];
    const n1 = normal[axis1];
    const n2 = normal[last];
    const square = n0 * n0 + n1 * n1 + n2 * n2;
    const rest = square - n0 * n0;
    let scale0 = halves(16 * size);
    let scale1 = scale0;
    let scale2 = scale0;
    if (square > 0) {
      scale0 = halves(Math.floor((size * quotient(1024 * rest, square)) / 64));
      scale1 = halves(Math.floor((size * quotient(1024 * n2 * n2, rest)) / 64));
      scale2 = halves(Math.floor((size * quotient(1024 * square, n2 * n2)) / 64));
    }
    // The contexts.
    const along = polygon.along < 31 ? polygon.along : 31;
    const beside = polygon.beside < 31 ? polygon.beside : 31;
    const kind = (polygon.count < 8 ? polygon.count : 8) - 3;
    const below = halves(square) + halves(size);
    const ofSides = this.#height(2, below);
    const ofLaplacians = this.#height(3, below);
    const ofKept = this.#height(0, below);
    const heightsA = ofLaplacians * 32 + ofSides;
    const heightsB = ofKept * 32 + ofLaplacians;

    // 1. The coordinates beside the normal.
    const numbers = this.#numbers;
    const a0 = beside * 32 + ((scale0 >> 1) & 31);
    const b0 = this.#width(polygon, axis0, scale0) * 8 + kind;
    const difference0 = this.#code(coder, 0, axis0, scale0, expected[axis0], a0, b0, kind, heightsA, heightsB);
    const above0 = numbers.above;
    const level0 = clamped(above0 + 4, 7);
    const shift = quotient(-n0 * n1 * difference0, rest);
    const a1 = beside * 32 + level0 * 4;
    const b1 = this.#width(polygon, axis1, scale1) * 8 + level0;
    const difference1 = this.#code(coder, 1, axis1, scale1, expected[axis1] + shift, a1, b1, kind, heightsA, heightsB) + shift;
    const above1 = numbers.above;
    // 2. That along the normal.
    const fall = quotient(-(n0 * difference0 + n1 * difference1) * Math.sign(n2), Math.abs(n2));
    const a2 = along * 32 + level0;
    const b2 = level0 * 8 + clamped(above1 + 4, 7);
    this.#code(coder, 2, last, scale2, expected[last] + fall, a2, b2, kind, heightsA, heightsB);
    this.along = clamped(numbers.above + 5, MOST_SURPRISE);
    this.beside = clamped(above0 + above1 + 7, MOST_SURPRISE);
  }

  /**
   * Decodes a coordinate. Returns how far it is from what is expected of the polygon, in 1/512.
   * @param {RangeDecoder} coder
   * @param {number} turn 0, 1 or 2
   * @param {number} axis
   * @param {number} scale
   * @param {number} expected
   * @param {number} a @param {number} b @param {number} kind @param {number} d @param {number} e
   */
  #code(coder, turn, axis, scale, expected, a, b, kind, d, e) {
    const middle = Math.floor((expected + 256) / 512) | 0;
    const difference = this.#numbers.decode(coder, turn, scale, a, b, kind * 128 + (scale < 127 ? scale : 127), d, e);
    // Bytes that no encoder has written may lead beyond the grid.
    const found = clamped((middle + difference) | 0, this.#most);
    this.place[axis] = found;
    return found * 512 - expected;
  }

  /**
   * Decodes the position of a point of the base mesh, to `place`, which holds one near to it.
   * @param {RangeDecoder} coder
   * @param {number} square the square of the length of the sides of the triangles around
   * @param {number} knownBits those of a coordinate
   */
  decodeBase(coder, square, knownBits) {
    const scale = halves(square);
    const most = 2 ** knownBits - 1;
    for (let axis = 0; axis < 3; axis++) {
      const difference = this.#numbers.decode(coder, axis, scale, 0, 0, 0, 0, 0);
      this.place[axis] = clamped((this.place[axis] + difference) | 0, most);
    }
  }

  /**
   * Sets the mean, the estimates, the normal and the size of a polygon.
   * @param {Polygon} polygon
   */
  #estimate(polygon) {
    const { points, count, parallelograms, parallelogramCount, laplacians } = polygon;
    const mean = this.#mean;
    const others = this.#others;
    const end = 3 * count;
    let sumX = 0;
    let sumY = 0;
    let sumZ = 0;
    let perimeterX = 0;
    let perimeterY = 0;
    let perimeterZ = 0;
    let length = 0;
    let beforeX = points[end - 3];
    let beforeY = points[end - 2];
    let beforeZ = points[end - 1];
    for (let i = 0; i < end; i += 3) {
      const x = points[i];
      const y = points[i + 1];
      const z = points[i + 2];
      const side = Math.abs(x - beforeX) + Math.abs(y - beforeY) + Math.abs(z - beforeZ);
      length += side;
      sumX += x;
      sumY += y;
      sumZ += z;
      perimeterX += side * (x + beforeX);
      perimeterY += side * (y + beforeY);
      perimeterZ += side * (z + beforeZ);
      beforeX = x;
      beforeY = y;
      beforeZ = z;
    }
    mean[0] = Math.floor((16 * sumX) / count);
    mean[1] = Math.floor((16 * sumY) / count);
    mean[2] = Math.floor((16 * sumZ) / count);
    others[12] = length > 0 ? Math.floor((8 * perimeterX) / length) - mean[0] : 0;
    others[13] = length > 0 ? Math.floor((8 * perimeterY) / length) - mean[1] : 0;
    others[14] = length > 0 ? Math.floor((8 * perimeterZ) / length) - mean[2] : 0;
    for (let j = 0; j < 3; j++) {
      others[j] = 16 * points[j] - mean[j];
      others[3 + j] = 8 * (points[3 + j] + points[end - 3 + j]) - mean[j];
      others[6 + j] = parallelogramCount > 0 ? Math.floor((16 * parallelograms[j]) / parallelogramCount) - mean[j] : 0;
      others[9 + j] = Math.floor(laplacians[j] / count);
    }
    const middleX = Math.floor(mean[0] / 16);
    const middleY = Math.floor(mean[1] / 16);
    const middleZ = Math.floor(mean[2] / 16);
    // The squares of the distances, and the normals of the triangles between the first point and the others.
    const firstX = points[0];
    const firstY = points[1];
    const firstZ = points[2];
    let squares = 0;
    let normalX = 0;
    let normalY = 0;
    let normalZ = 0;
    let sideX = 0;
    let sideY = 0;
    let sideZ = 0;
    for (let i = 0; i < end; i += 3) {
      const x = points[i];
      const y = points[i + 1];
      const z = points[i + 2];
      squares += (x - middleX) * (x - middleX) + (y - middleY) * (y - middleY) + (z - middleZ) * (z - middleZ);
      const nextX = x - firstX;
      const nextY = y - firstY;
      const nextZ = z - firstZ;
      normalX += sideY * nextZ - sideZ * nextY;
      normalY += sideZ * nextX - sideX * nextZ;
      normalZ += sideX * nextY - sideY * nextX;
      sideX = nextX;
      sideY = nextY;
      sideZ = nextZ;
    }
    this.#square = Math.floor(squares / count) + 1;
    const surplus = bitLength(Math.max(Math.abs(normalX), Math.abs(normalY), Math.abs(normalZ))) - 8;
    const divisor = surplus > 0 ? POWERS[surplus] : 1;
    this.#normal[0] = Math.floor(normalX / divisor);
    this.#normal[1] = Math.floor(normalY / divisor);
    this.#normal[2] = Math.floor(normalZ / divisor);
  }

  /**
   * Sets the expected point.
   * @param {Polygon} polygon
   * @param {number} regime
   */
  #expect({ count }, regime) {
    const mean = this.#mean;
    const others = this.#others;
    const normal = this.#normal;
    const expected = this.#expected;
    const weights = this.#weights;
    const [normalX, normalY, normalZ] = [normal[0], normal[1], normal[2]];
    let of = 2 * ESTIMATES * (regime * POLYGONS + Math.min(count - 3, POLYGONS - 1));
    let x = mean[0] * WEIGHT_ONE;
    let y = mean[1] * WEIGHT_ONE;
    let z = mean[2] * WEIGHT_ONE;
    let along = 0;
    for (let i = 0; i < 3 * ESTIMATES; i += 3) {
      const weight = weights[of];
      const beside = weights[of + 1];
      of += 2;
      x += beside * others[i];
      y += beside * others[i + 1];
      z += beside * others[i + 2];
      along += (weight - beside) * (others[i] * normalX + others[i + 1] * normalY + others[i + 2] * normalZ);
    }
    const square = normalX * normalX + normalY * normalY + normalZ * normalZ;
    expected[0] = x + quotient(along * normalX, square);
    expected[1] = y + quotient(along * normalY, square);
    expected[2] = z + quotient(along * normalZ, square);
  }

  /**
   * Returns how much an estimate differs from the mean along the normal, relative to the size of the polygon: 0 to 15.
   * @param {number} estimate
   * @param {number} below
   */
  #height(estimate, below) {
    const others = this.#others;
    const normal = this.#normal;
    const i = 3 * estimate;
    const along = Math.floor((others[i] * normal[0] + others[i + 1] * normal[1] + others[i + 2] * normal[2]) / 64);
    return clamped(halves(along * along) + 20 - below, 15);
  }

  /**
   * Returns how wide the polygon is along an axis: 0 to 31.
   * @param {Polygon} polygon
   * @param {number} axis
   * @param {number} scale
   */
  #width({ points, count }, axis, scale) {
    const middle = Math.floor(this.#mean[axis] / 16);
    let squares = 0;
    for (let i = axis; i < 3 * count; i += 3) squares += (points[i] - middle) * (points[i] - middle);
    return clamped(halves(16 * (Math.floor(squares / count) + 1)) + 16 - scale, 31);
  }
}
