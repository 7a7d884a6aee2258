/**
 * A mesh refined by batches of splits. Every decision is valid, so any bytes decode to some mesh.
 * @module
 */
import { MAX_CORNERS, MAX_TWINS } from './constants.js';
import { COUNT, FAN_CELLS, IS_OPEN, LEADER, NEXT, SUM, TWIN, VERTEX } from './fans.js';
import { grown, integers } from './growth.js';
import { Simple } from './slots.js';
import { SplitModel } from './splits.js';
import { around, corners, next, NONE, previous, ring, split } from './surface.js';

/**
 * @import { ChannelModel } from './channels.js'
 * @import { Fans } from './fans.js'
 * @import { PlaceModel } from './places.js'
 * @import { RangeDecoder } from './range_coder.js'
 * @import { Strips } from './strips.js'
 * @import { Surface } from './surface.js'
 */

/** Contexts of flags. */
const MORE_REFINING = 0;
const REGIME = 1;
const MORE_IN_GROUP = 3;
const SAME_VERTEX = 5;
const FLAGS = 6;

/** The vertices around a new point, starting with that of the kept fan. */
const vertices = integers(MAX_CORNERS + 2);

/** A mesh and the state for the next split. */
export class Refiner {
  #channels;
  #placeModel;
  #positionBits;
  #splits;
  #flags = new Simple(FLAGS);
  /** The number of batches started. */
  batch = 0;
  #regime = 0;
  /**
   * The strips of the mesh, if they are maintained.
   * @type {Strips | undefined}
   */
  strips;
  /** The number of collapses undone. */
  level = 0;
  /** The number of corners around the visited fans. */
  corners = 0;
  /** The triangle count of the level being decoded. */
  mostTriangles = 0;
  /** The next fan to visit, or none at the end of a batch. */
  next = NONE;

  /**
   * @param {Surface} surface
   * @param {Fans} fans
   * @param {ChannelModel[]} channels
   * @param {PlaceModel} placeModel
   * @param {number} positionBits bits per coordinate
   * @param {number} unknownBits bits per coordinate that are still unknown
   */
  constructor(surface, fans, channels, placeModel, positionBits, unknownBits) {
    this.surface = surface;
    this.fans = fans;
    this.#channels = channels;
    this.#placeModel = placeModel;
    this.#positionBits = positionBits;
    this.unknownBits = unknownBits;
    this.#splits = new SplitModel(surface, fans);
    for (let fan = 0; fan < fans.count; fan++) {
      const first = surface.first[fan];
      fans.cells[FAN_CELLS * fan + NEXT] = fan + 1 < fans.count ? fan + 1 : NONE;
      fans.cells[FAN_CELLS * fan + IS_OPEN] = surface.opposite(previous(first)) === NONE ? 1 : 0;
    }
    this.#sumAround();
  }

  /**
   * Reserves memory for a number of triangles, and for as many fans as a closed surface with a few
   * borders has.
   * @param {number} triangles
   */
  reserve(triangles) {
    const { surface, fans } = this;
    if (8 * triangles <= surface.cells.length) return;
    const fanCount = Math.ceil(triangles * 0.53) + 64;
    surface.cells = grown(surface.cells, 8 * triangles);
    surface.first = grown(surface.first, fanCount);
    fans.cells = grown(fans.cells, FAN_CELLS * fanCount);
  }

  /**
   * Starts a batch: decodes whether positions get another bit, and the regime.
   * @param {RangeDecoder} coder
   */
  beginBatch(coder) {
    this.batch++;
    this.#splits.batch = this.batch;
    while (this.unknownBits > 0 && this.#flags.decode(coder, MORE_REFINING)) this.#refinePlaces(coder);
    this.#regime = this.#flags.decode(coder, REGIME) ? 2 : this.#flags.decode(coder, REGIME + 1);
    this.next = this.fans.count > 0 ? 0 : NONE;
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
      const bits = leader === at ? coder.bits(3) : 0;
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
    // The new fans of this batch precede it.
    this.next = this.fans.cells[FAN_CELLS * fan + NEXT];
    for (let done = 0; ; done = 1) {
      this.corners++;
      if (!this.#splits.decodeMark(coder, fan, done)) break;
      this.surface.collect(fan, this.batch);
      if (ring.length === 0 || ring.length > MAX_CORNERS) break;
      this.#decodeGroup(coder, fan);
      if (this.#isTooLarge(coder)) break;
    }
  }

  /**
   * Returns whether the mesh exceeds the limits of the chunk.
   * @param {RangeDecoder} coder
   */
  #isTooLarge(coder) {
    return coder.isPastEnd || this.surface.triangleCount > this.mostTriangles;
  }

  /**
   * Decodes the splits of one collapse: one split, or on a seam one per fan of the new point.
   * @param {RangeDecoder} coder
   * @param {number} fan
   */
  #decodeGroup(coder, fan) {
    const { fans, surface } = this;
    const firstNew = fans.count;
    let of = fan;
    do {
      this.#decodeSplit(coder, of, firstNew);
      const hasTwins = fans.cells[FAN_CELLS * fan + TWIN] !== fan ? 1 : 0;
      // A point has several fans only at borders.
      if (!ring.isOpen || !this.#flags.decode(coder, MORE_IN_GROUP + hasTwins)) break;
      of = this.#decodeTwin(coder, fan);
      surface.collect(of, this.batch);
    } while (ring.length > 0 && ring.length <= MAX_CORNERS && !this.#isTooLarge(coder));
    // New fans are visited after this one, from the next batch on. This keeps neighbouring fans
    // close in the order.
    const { cells } = fans;
    let after = cells[FAN_CELLS * fan + NEXT];
    for (let made = fans.count - 1; made >= firstNew; after = made--) cells[FAN_CELLS * made + NEXT] = after;
    cells[FAN_CELLS * fan + NEXT] = firstNew;
    this.level++;
  }

  /**
   * Decodes another fan of the same point, as an offset in the cycle of its fans.
   * @param {RangeDecoder} coder
   * @param {number} fan
   */
  #decodeTwin(coder, fan) {
    const twinOf = (/** @type {number} */ fan) => this.fans.cells[FAN_CELLS * fan + TWIN];
    let count = 1;
    for (let twin = twinOf(fan); twin !== fan && count < MAX_TWINS; twin = twinOf(twin)) count++;
    let twin = fan;
    for (let steps = coder.bits(32 - Math.clz32(count - 1)) % count; steps > 0; steps--) twin = twinOf(twin);
    return twin;
  }

  /**
   * @param {RangeDecoder} coder
   * @param {number} fan
   * @param {number} firstNew the first new fan of the group
   */
  #decodeSplit(coder, fan, firstNew) {
    const { fans, surface } = this;
    const { place } = this.#placeModel;
    const isFirst = fans.count === firstNew;
    this.corners += ring.length;
    // 1. The corners that move.
    this.#splits.decodeSplit(coder, fan);
    // 2. The point. All fans of a group have the position of the first one.
    if (isFirst) this.#placeModel.decode(coder, fans, fan, this.#regime, (1 << (this.#positionBits - this.unknownBits)) - 1);
    // 3. The vertex.
    let vertex = fans.vertexCount;
    if (!isFirst && this.#flags.decode(coder, SAME_VERTEX)) {
      const count = fans.count - firstNew;
      const number = coder.bits(32 - Math.clz32(count - 1)) % count;
      vertex = fans.cells[FAN_CELLS * (firstNew + number) + VERTEX];
    } else if (this.#channels.length > 0) {
      const { start, count } = split;
      vertices[0] = fans.cells[FAN_CELLS * fan + VERTEX];
      for (let i = 0; i <= count; i++) vertices[i + 1] = fans.cells[FAN_CELLS * around[start + i] + VERTEX];
      for (const channel of this.#channels) channel.decode(coder, vertex, vertices, count + 2);
    }
    // 4. Apply the split.
    const made = fans.push(isFirst ? NONE : firstNew, vertex, this.batch, split.addsStart && split.addsEnd ? 0 : 1);
    fans.cells.set(place, FAN_CELLS * made);
    this.#updateAround(FAN_CELLS * fan, FAN_CELLS * made);
    surface.split(fan, this.batch);
    this.strips?.followSplit(split.addsStart, split.addsEnd);
  }

  /** Counts the neighbours of all fans, and sums their positions. */
  #sumAround() {
    const { surface, fans } = this;
    const { cells } = fans;
    for (let at = 0; at < FAN_CELLS * fans.count; at += FAN_CELLS) cells.fill(0, at + SUM, at + COUNT + 1);
    for (let corner = 0; corner < 8 * surface.triangleCount; corner += (corner & 7) === 2 ? 6 : 1) {
      const at = FAN_CELLS * surface.fan(corner);
      let from = FAN_CELLS * surface.fan(next(corner));
      fans.add(at, cells[from], cells[from + 1], cells[from + 2], 1);
      if (surface.after(corner) !== NONE) continue;
      from = FAN_CELLS * surface.fan(previous(corner));
      fans.add(at, cells[from], cells[from + 1], cells[from + 2], 1);
    }
  }

  /**
   * Updates the neighbours of a new fan before it is split off: used corners, neighbour counts and
   * position sums.
   * @param {number} kept @param {number} made the first cells of the kept and the new fan
   */
  #updateAround(kept, made) {
    const { fans, surface } = this;
    const { cells } = fans;
    const batch = this.batch;
    const { start, count, addsStart, addsEnd } = split;
    const x = cells[made];
    const y = cells[made + 1];
    const z = cells[made + 2];
    const movedX = x - cells[kept];
    const movedY = y - cells[kept + 1];
    const movedZ = z - cells[kept + 2];
    let lost = 0;
    let notFree = 0;
    let before = 0;
    for (let i = 0; i <= count; i++) {
      // The corner between this fan and the next one moves.
      let used = 0;
      if (i < count) {
        const corner = corners[start + i];
        // It may already be used if a group has several splits.
        if (surface.mark(corner) === batch) notFree++;
        else used = 1;
        surface.setMark(corner, batch);
      }
      const at = FAN_CELLS * around[start + i];
      // The first and last fan remain neighbours of the kept fan if a triangle is added there.
      const stays = count === 0 || (i === 0 && addsStart) || (i === count && addsEnd);
      fans.use(at, batch, before + used + (stays ? 1 : 0), 0);
      before = used;
      fans.add(made, cells[at], cells[at + 1], cells[at + 2], 1);
      if (stays) {
        fans.add(at, x, y, z, 1);
      } else {
        lost++;
        fans.add(at, movedX, movedY, movedZ, 0);
        fans.add(kept, -cells[at], -cells[at + 1], -cells[at + 2], 0);
      }
    }
    fans.add(made, cells[kept], cells[kept + 1], cells[kept + 2], 1);
    fans.add(kept, x, y, z, 1 - lost);
    fans.use(kept, batch, (addsStart ? 1 : 0) + (addsEnd ? 1 : 0), notFree);
  }
}
