/**
 * A mesh that batches of splits refine. Every decision is valid, so that any bytes build some mesh.
 * @module
 */
import { MOST_CORNERS, MOST_TWINS } from './constants.js';
import { ALONG, AROUND_CELLS, BESIDE, FAN_CELLS, LAST_SPLIT, VERTEX } from './fans.js';
import { Simple } from './mixing.js';
import { PlaceModel, Polygon } from './places.js';
import { SplitModel } from './splits.js';
import { next, NONE, previous, Ring } from './surface.js';

/**
 * @import { ChannelModel } from './channels.js'
 * @import { Fans } from './fans.js'
 * @import { RangeDecoder } from './range_coder.js'
 * @import { Strips } from './strips.js'
 * @import { Split, Surface } from './surface.js'
 */

/** Contexts of single flags. */
const MORE_REFINING = 0;
const REGIME = 1;
const MORE_IN_GROUP = 3;
const SAME_VERTEX = 5;
const FLAGS = 6;

/** A mesh with what is known for the next split. */
export class Refiner {
  #channels;
  #placeModel;
  #positionBits;
  #splits;
  #flags;
  #precision;
  #batch;
  #regime;
  #ring;
  #rim;
  #rimLength;
  #rimVertices;
  #polygon;

  /**
   * @param {Surface} surface
   * @param {Fans} fans
   * @param {ChannelModel[]} channels
   * @param {PlaceModel} placeModel
   * @param {number} positionBits the bits of a coordinate
   * @param {number} unknownBits those that are still unknown
   */
  constructor(surface, fans, channels, placeModel, positionBits, unknownBits) {
    this.surface = surface;
    this.fans = fans;
    this.#channels = channels;
    this.#placeModel = placeModel;
    this.#positionBits = positionBits;
    this.unknownBits = unknownBits;
    this.#splits = new SplitModel(surface, fans);
    this.#flags = new Simple(FLAGS);
    this.#precision = new Simple(3);
    /** @type {Strips | undefined} the strips of the mesh, if they are kept */
    this.strips = undefined;
    /** The collapses that have been undone. */
    this.groupCount = 0;
    /** The corners around the fans that were visited. */
    this.cornerCount = 0;
    /** The most triangles of the level to decode. */
    this.mostTriangles = 0;
    this.#batch = 0;
    this.#regime = 0;
    /** The next fan to visit, and the end of the batch. */
    this.next = 0;
    this.end = 0;
    this.#ring = new Ring();
    /** The fans around the new point: the kept one, then those around the corners that move. Also their vertices. */
    this.#rim = new Int32Array(MOST_CORNERS + 2);
    this.#rimLength = 0;
    this.#rimVertices = new Int32Array(MOST_CORNERS + 2);
    this.#polygon = new Polygon();
    this.#sumAround();
  }

  /**
   * Begins a batch: decodes whether the positions get another bit, and the regime.
   * @param {RangeDecoder} coder
   */
  beginBatch(coder) {
    this.#batch++;
    this.#splits.batch = this.#batch;
    while (this.unknownBits > 0 && this.#flags.decode(coder, MORE_REFINING)) this.#refinePlaces(coder);
    this.#regime = this.#flags.decode(coder, REGIME) ? 2 : this.#flags.decode(coder, REGIME + 1);
    this.next = 0;
    this.end = this.fans.count;
  }

  /**
   * Decodes another bit of all positions.
   * @param {RangeDecoder} coder
   */
  #refinePlaces(coder) {
    const { fans } = this;
    this.unknownBits--;
    for (let fan = 0; fan < fans.count; fan++) {
      const leader = fans.leaders[fan];
      if (leader !== fan) {
        fans.copyPlace(fan, leader);
        continue;
      }
      for (let j = 0; j < 3; j++) {
        const at = FAN_CELLS * fan + j;
        fans.cells[at] = (fans.cells[at] << 1) | this.#precision.decode(coder, j);
      }
    }
    this.#sumAround();
  }

  /**
   * Visits the next fan of the batch: decodes all its splits.
   * @param {RangeDecoder} coder
   */
  visit(coder) {
    const fan = this.next++;
    const { surface } = this;
    const ring = this.#ring;
    const splits = this.#splits;
    surface.collect(fan, ring);
    this.cornerCount += 1 + ring.length;
    for (let done = 0; splits.decodeMark(coder, fan, ring, done); done++) {
      this.#decodeGroup(coder, fan);
      if (this.#isTooLarge(coder)) break;
      surface.collect(fan, ring);
      this.cornerCount += 1 + ring.length;
    }
  }

  /**
   * Returns whether more has been built than the bytes may build.
   * @param {RangeDecoder} coder
   */
  #isTooLarge(coder) {
    return coder.isPastEnd || this.surface.triangleCount > this.mostTriangles;
  }

  /**
   * Decodes the splits of one collapse: one, or on a seam one for each fan of the new point.
   * @param {RangeDecoder} coder
   * @param {number} fan
   */
  #decodeGroup(coder, fan) {
    const { fans, surface } = this;
    const ring = this.#ring;
    const firstNew = fans.count;
    let of = fan;
    do {
      this.#decodeSplit(coder, of, firstNew);
      const hasTwins = fans.twins[fan] !== fan ? 1 : 0;
      // Only where a surface has borders a point has several fans.
      if (!ring.isOpen || !this.#flags.decode(coder, MORE_IN_GROUP + hasTwins)) break;
      of = this.#decodeTwin(coder, fan);
      surface.collect(of, ring);
    } while (ring.length > 0 && ring.length <= MOST_CORNERS && !this.#isTooLarge(coder));
    this.groupCount++;
  }

  /**
   * Decodes a fan of the point of another one, whose number is counted from it.
   * @param {RangeDecoder} coder
   * @param {number} fan
   */
  #decodeTwin(coder, fan) {
    const { twins } = this.fans;
    let count = 1;
    for (let twin = twins[fan]; twin !== fan && count < MOST_TWINS; twin = twins[twin]) count++;
    let twin = fan;
    for (let steps = coder.decodeBits(32 - Math.clz32(count - 1)) % count; steps > 0; steps--) twin = twins[twin];
    return twin;
  }

  /**
   * @param {RangeDecoder} coder
   * @param {number} fan
   * @param {number} firstNew the first new fan of the group
   */
  #decodeSplit(coder, fan, firstNew) {
    const { fans, surface } = this;
    const ring = this.#ring;
    const placeModel = this.#placeModel;
    const isFirst = fans.count === firstNew;
    // 1. The corners that move.
    const split = this.#splits.decodeSplit(coder, fan, ring);
    // 2. The point.
    this.#collectRim(fan, split);
    if (isFirst) {
      this.#collectPolygon(split);
      placeModel.decode(coder, this.#polygon, this.#regime, this.#positionBits - this.unknownBits);
    }
    // 3. The vertex.
    let vertex = fans.vertexCount;
    if (!isFirst && this.#flags.decode(coder, SAME_VERTEX)) {
      const count = fans.count - firstNew;
      const number = coder.decodeBits(32 - Math.clz32(count - 1)) % count;
      vertex = fans.cells[FAN_CELLS * (firstNew + number) + VERTEX];
    } else if (this.#channels.length > 0) {
      const rim = this.#rim;
      const rimVertices = this.#rimVertices;
      const rimLength = this.#rimLength;
      for (let i = 0; i < rimLength; i++) rimVertices[i] = fans.cells[FAN_CELLS * rim[i] + VERTEX];
      for (const channel of this.#channels) channel.decode(coder, vertex, rimVertices, rimLength);
    }
    // 4. Do it. The fans of a group have the position of the first one.
    const made = fans.push(isFirst ? NONE : firstNew, vertex, this.#batch);
    const at = FAN_CELLS * made;
    for (let j = 0; j < 3; j++) fans.cells[at + j] = placeModel.place[j];
    fans.cells[at + ALONG] = placeModel.along;
    fans.cells[at + BESIDE] = placeModel.beside;
    this.#updateAround(split, made);
    surface.split(fan, ring, split, this.#batch);
    this.strips?.followSplit(split.addsStart, split.addsEnd);
    fans.cells[FAN_CELLS * fan + LAST_SPLIT] = this.#batch;
  }

  /**
   * Collects the fans around the new point.
   * @param {number} fan
   * @param {Split} split
   */
  #collectRim(fan, { start, count, addsStart }) {
    const { cells } = this.surface;
    const rim = this.#rim;
    const { corners, length: n } = this.#ring;
    rim[0] = fan;
    if (count === 0) {
      rim[1] = cells[addsStart ? previous(corners[n - 1]) : next(corners[0])];
      this.#rimLength = 2;
      return;
    }
    let last = 0;
    for (let i = 0; i < count; i++) {
      last = corners[start + i < n ? start + i : start + i - n];
      rim[i + 1] = cells[next(last)];
    }
    rim[count + 1] = cells[previous(last)];
    this.#rimLength = count + 2;
  }

  /**
   * Collects what is known around a new point.
   * @param {Split} split
   */
  #collectPolygon({ start, count }) {
    const { surface } = this;
    const rim = this.#rim;
    const rimLength = this.#rimLength;
    const polygon = this.#polygon;
    const { cells, around } = this.fans;
    const { points, laplacians, parallelograms } = polygon;
    const { corners, length: n, isOpen } = this.#ring;
    let laplacianX = 0;
    let laplacianY = 0;
    let laplacianZ = 0;
    for (let i = 0; i < rimLength; i++) {
      const at = FAN_CELLS * rim[i];
      const sum = AROUND_CELLS * rim[i];
      const valence = around[sum + 3] > 1 ? around[sum + 3] : 1;
      const x = cells[at];
      const y = cells[at + 1];
      const z = cells[at + 2];
      points[3 * i] = x;
      points[3 * i + 1] = y;
      points[3 * i + 2] = z;
      laplacianX += 16 * x - Math.floor((16 * around[sum]) / valence);
      laplacianY += 16 * y - Math.floor((16 * around[sum + 1]) / valence);
      laplacianZ += 16 * z - Math.floor((16 * around[sum + 2]) / valence);
    }
    laplacians[0] = laplacianX;
    laplacians[1] = laplacianY;
    laplacians[2] = laplacianZ;
    parallelograms[0] = 0;
    parallelograms[1] = 0;
    parallelograms[2] = 0;
    polygon.parallelogramCount = 0;
    polygon.count = rimLength;
    const kept = FAN_CELLS * rim[0];
    const first = FAN_CELLS * rim[1];
    const last = FAN_CELLS * rim[rimLength - 1];
    polygon.along = cells[kept + ALONG] + cells[first + ALONG] + cells[last + ALONG];
    polygon.beside = cells[kept + BESIDE] + cells[first + BESIDE] + cells[last + BESIDE];
    if (count === 0) {
      // A triangle at the end of a border has no third point.
      polygon.count = 3;
      for (let j = 0; j < 3; j++) points[6 + j] = points[3 + j];
      return;
    }
    for (let i = 0; i < count; i++) {
      const opposite = surface.opposite(corners[start + i < n ? start + i : start + i - n]);
      if (opposite !== NONE) this.#addParallelogram(i + 1, i + 2, opposite);
    }
    if (start > 0 || !isOpen) this.#addParallelogram(0, 1, next(corners[start > 0 ? start - 1 : n - 1]));
    const end = start + count;
    if (end < n || !isOpen) this.#addParallelogram(0, count + 1, previous(corners[end < n ? end : end - n]));
  }

  /**
   * Adds the parallelogram over an edge of the polygon whose triangle has a third point on the other side.
   * @param {number} a
   * @param {number} b
   * @param {number} third its corner
   */
  #addParallelogram(a, b, third) {
    const { points, parallelograms } = this.#polygon;
    const { cells } = this.fans;
    const at = FAN_CELLS * this.surface.cells[third];
    a *= 3;
    b *= 3;
    parallelograms[0] += points[a] + points[b] - cells[at];
    parallelograms[1] += points[a + 1] + points[b + 1] - cells[at + 1];
    parallelograms[2] += points[a + 2] + points[b + 2] - cells[at + 2];
    this.#polygon.parallelogramCount++;
  }

  /** Sums up the positions around all fans. */
  #sumAround() {
    const { surface, fans } = this;
    fans.around.fill(0);
    for (let triangle = 0; triangle < surface.triangleCount; triangle++) {
      for (let corner = 8 * triangle; corner < 8 * triangle + 3; corner++) {
        const fan = surface.fan(corner);
        this.#addAround(fan, surface.fan(next(corner)));
        if (surface.after(corner) === NONE) this.#addAround(fan, surface.fan(previous(corner)));
      }
    }
  }

  /**
   * Does the same for a split, before it is done.
   * @param {Split} split
   * @param {number} made the new fan
   */
  #updateAround({ count, addsStart, addsEnd }, made) {
    const rim = this.#rim;
    const rimLength = this.#rimLength;
    const kept = rim[0];
    // The first and the last one stay neighbours of the kept fan if a triangle is added there.
    const firstLost = addsStart ? 2 : 1;
    const lostEnd = count === 0 ? 0 : addsEnd ? rimLength - 1 : rimLength;
    this.#addAround(made, kept);
    for (let i = 1; i < rimLength; i++) {
      const fan = rim[i];
      this.#addAround(made, fan);
      if (i >= firstLost && i < lostEnd) {
        this.#removeAround(fan, kept);
        this.#removeAround(kept, fan);
      }
      this.#addAround(fan, made);
    }
    this.#addAround(kept, made);
  }

  /**
   * Adds the position of another fan to those around a fan.
   * @param {number} fan
   * @param {number} other
   */
  #addAround(fan, other) {
    const { around, cells } = this.fans;
    const sum = AROUND_CELLS * fan;
    const at = FAN_CELLS * other;
    around[sum] += cells[at];
    around[sum + 1] += cells[at + 1];
    around[sum + 2] += cells[at + 2];
    around[sum + 3]++;
  }

  /**
   * Removes the position of another fan from those around a fan.
   * @param {number} fan
   * @param {number} other
   */
  #removeAround(fan, other) {
    const { around, cells } = this.fans;
    const sum = AROUND_CELLS * fan;
    const at = FAN_CELLS * other;
    around[sum] -= cells[at];
    around[sum + 1] -= cells[at + 1];
    around[sum + 2] -= cells[at + 2];
    if (around[sum + 3] > 0) around[sum + 3]--;
  }
}
