/**
 * A mesh that batches of splits refine. Every decision is valid, so that any bytes build some mesh.
 * @module
 */
import { MOST_CORNERS, MOST_TWINS } from './constants.js';
import { COUNT, FAN_CELLS, IS_OPEN, LAST_SPLIT, LEADER, NEXT, SUM, TWIN, USED, VERTEX } from './fans.js';
import { Polygon, reciprocal } from './places.js';
import { Simple } from './slots.js';
import { SplitModel } from './splits.js';
import { next, NONE, previous, Ring } from './surface.js';

/**
 * @import { ChannelModel } from './channels.js'
 * @import { Fans } from './fans.js'
 * @import { PlaceModel } from './places.js'
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
    /** The next fan to visit, or none at the end of a batch. */
    this.next = NONE;
    this.#ring = new Ring();
    /** The fans around the new point: the kept one, then those around the corners that move. Also their vertices. */
    this.#rim = new Int32Array(MOST_CORNERS + 2);
    this.#rimLength = 0;
    this.#rimVertices = new Int32Array(MOST_CORNERS + 2);
    this.#polygon = new Polygon();
    for (let fan = 0; fan < fans.count; fan++) {
      const first = surface.first[fan];
      fans.cells[FAN_CELLS * fan + NEXT] = fan + 1 < fans.count ? fan + 1 : NONE;
      fans.cells[FAN_CELLS * fan + IS_OPEN] = surface.opposite(previous(first)) === NONE ? 1 : 0;
    }
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
    const { cells, count } = this.fans;
    for (let at = USED; at < FAN_CELLS * count; at += FAN_CELLS) cells[at] = 0;
    this.next = count > 0 ? 0 : NONE;
  }

  /**
   * Decodes another bit of all positions.
   * @param {RangeDecoder} coder
   */
  #refinePlaces(coder) {
    const { cells, count } = this.fans;
    this.unknownBits--;
    for (let at = 0; at < FAN_CELLS * count; at += FAN_CELLS) {
      const leader = FAN_CELLS * cells[at + LEADER];
      const bits = leader === at ? coder.decodeBits(3) : 0;
      for (let j = 0; j < 3; j++) cells[at + j] = leader === at ? (cells[at + j] << 1) | ((bits >> (2 - j)) & 1) : cells[leader + j];
    }
    this.#sumAround();
  }

  /**
   * Visits the next fan of the batch: decodes all its splits.
   * @param {RangeDecoder} coder
   */
  visit(coder) {
    const fan = this.next;
    const ring = this.#ring;
    // The fans of this batch come before it.
    this.next = this.fans.cells[FAN_CELLS * fan + NEXT];
    for (let done = 0; ; done = 1) {
      this.cornerCount++;
      if (!this.#splits.decodeMark(coder, fan, done)) break;
      this.surface.collect(fan, ring);
      if (ring.length === 0 || ring.length > MOST_CORNERS) break;
      this.#decodeGroup(coder, fan);
      if (this.#isTooLarge(coder)) break;
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
      const hasTwins = fans.cells[FAN_CELLS * fan + TWIN] !== fan ? 1 : 0;
      // Only where a surface has borders a point has several fans.
      if (!ring.isOpen || !this.#flags.decode(coder, MORE_IN_GROUP + hasTwins)) break;
      of = this.#decodeTwin(coder, fan);
      surface.collect(of, ring);
    } while (ring.length > 0 && ring.length <= MOST_CORNERS && !this.#isTooLarge(coder));
    // New fans are visited after this one, from the next batch on, so that fans near each other are visited one after the other.
    const { cells } = fans;
    let after = cells[FAN_CELLS * fan + NEXT];
    for (let made = fans.count - 1; made >= firstNew; after = made--) cells[FAN_CELLS * made + NEXT] = after;
    cells[FAN_CELLS * fan + NEXT] = firstNew;
    this.groupCount++;
  }

  /**
   * Decodes a fan of the point of another one, whose number is counted from it.
   * @param {RangeDecoder} coder
   * @param {number} fan
   */
  #decodeTwin(coder, fan) {
    const twinOf = (/** @type {number} */ fan) => this.fans.cells[FAN_CELLS * fan + TWIN];
    let count = 1;
    for (let twin = twinOf(fan); twin !== fan && count < MOST_TWINS; twin = twinOf(twin)) count++;
    let twin = fan;
    for (let steps = coder.decodeBits(32 - Math.clz32(count - 1)) % count; steps > 0; steps--) twin = twinOf(twin);
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
    this.cornerCount += ring.length;
    // 1. The corners that move.
    const split = this.#splits.decodeSplit(coder, fan, ring);
    // 2. The point.
    this.#collectRim(fan, split);
    if (isFirst) {
      this.#collectPolygon();
      placeModel.decode(coder, this.#polygon, this.#regime, (1 << (this.#positionBits - this.unknownBits)) - 1);
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
    this.#useCorners(split);
    const made = fans.push(isFirst ? NONE : firstNew, vertex, this.#batch, split.addsStart && split.addsEnd ? 0 : 1);
    for (let j = 0; j < 3; j++) fans.cells[FAN_CELLS * made + j] = placeModel.place[j];
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
    const rim = this.#rim;
    const { around, length: n } = this.#ring;
    rim[0] = fan;
    this.#rimLength = count > 0 ? count + 2 : 2;
    rim[1] = around[addsStart ? n : 0];
    for (let i = 0; i <= count && count > 0; i++) rim[i + 1] = around[start + i <= n ? start + i : start + i - n];
  }

  /** Collects what is known around a new point. */
  #collectPolygon() {
    const rim = this.#rim;
    const rimLength = this.#rimLength;
    const { fans } = this;
    const { points, laplacians } = this.#polygon;
    laplacians.fill(0);
    for (let i = 0; i < rimLength; i++) {
      const at = FAN_CELLS * rim[i];
      const share = 16 * reciprocal(fans.cells[at + COUNT]);
      for (let j = 0; j < 3; j++) {
        points[3 * i + j] = fans.cells[at + j];
        laplacians[j] += Math.floor((fans.laplacian(rim[i], j) * share) / 65536);
      }
    }
    this.#polygon.count = rimLength;
    if (rimLength > 2) return;
    // A triangle at the end of a border has no third point.
    this.#polygon.count = 3;
    for (let j = 0; j < 3; j++) points[6 + j] = points[3 + j];
  }

  /**
   * Marks the corners of a split as used, before it is done.
   * @param {Split} split
   */
  #useCorners({ start, count, addsStart, addsEnd }) {
    const { surface } = this;
    const { corners, length: n } = this.#ring;
    const rim = this.#rim;
    const use = (/** @type {number} */ i, sign = 1) => {
      const { cells } = this.fans;
      const at = FAN_CELLS * rim[i] + USED;
      const used = cells[at] + sign;
      cells[at] = used < 0 ? 0 : used > 255 ? 255 : used;
    };
    let moved = 0;
    for (let i = 0; i < count; i++) {
      // It may be used already where a group has several splits.
      if (surface.mark(corners[start + i < n ? start + i : start + i - n]) === this.#batch) {
        moved++;
      } else {
        use(i + 1);
        use(i + 2);
      }
    }
    if (addsStart) {
      use(0);
      use(1);
    }
    if (addsEnd) {
      use(0);
      use(this.#rimLength - 1);
    }
    for (; moved > 0; moved--) use(0, -1);
  }

  /** Sums up the positions around all fans. */
  #sumAround() {
    const { surface, fans } = this;
    const { cells } = fans;
    for (let at = 0; at < FAN_CELLS * fans.count; at += FAN_CELLS) {
      for (let i = SUM; i <= COUNT; i++) cells[at + i] = 0;
    }
    for (let triangle = 0; triangle < surface.triangleCount; triangle++) {
      for (let corner = 8 * triangle; corner < 8 * triangle + 3; corner++) {
        const fan = surface.fan(corner);
        fans.around(fan, surface.fan(next(corner)), 1);
        if (surface.after(corner) === NONE) fans.around(fan, surface.fan(previous(corner)), 1);
      }
    }
  }

  /**
   * Does the same for a split, before it is done.
   * @param {Split} split
   * @param {number} made the new fan
   */
  #updateAround({ count, addsStart, addsEnd }, made) {
    const { fans } = this;
    const rim = this.#rim;
    const rimLength = this.#rimLength;
    const kept = rim[0];
    // The first and the last one stay neighbours of the kept fan if a triangle is added there.
    const firstLost = addsStart ? 2 : 1;
    const lostEnd = count === 0 ? 0 : addsEnd ? rimLength - 1 : rimLength;
    fans.around(made, kept, 1);
    for (let i = 1; i < rimLength; i++) {
      const fan = rim[i];
      fans.around(made, fan, 1);
      if (i >= firstLost && i < lostEnd) {
        fans.around(fan, kept, -1);
        fans.around(kept, fan, -1);
      }
      fans.around(fan, made, 1);
    }
    fans.around(kept, made, 1);
  }
}
