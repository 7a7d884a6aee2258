/**
 * Triangle strips of the parts of a mesh, in index buffers with few changed ranges per update.
 *
 * ```text
 * buffer   │ strip · R R R │ strip · R │ R R R R R R R │ strip · R R │ …       R: primitive restart
 *            └ segment with spare capacity └ segment of a removed strip
 * ```
 * # Algorithm
 * 1. A strip has changed if one of its triangles has different vertices or links than when it was
 *    sent. Unchanged strips are not visited.
 * 2. The segments of all triangles of a changed strip are freed. The strip is written to the old
 *    segment of its first triangle if it fits, otherwise to a new segment at the end of the buffer.
 * 3. When more than a third of a buffer is unused restarts, its segments are compacted.
 *
 * Borders between parts are seams, which no strip crosses. A strip is in the buffer of its first
 * vertex.
 * @module
 */
import { grown, integers } from '../growth.js';
import { IndexBuffer } from './index_buffer.js';

/**
 * @import { StreamPart } from '../decoder.js'
 * @import { IndexUpdate } from './client.js'
 * @import { SentTriangles } from './mesh_buffers.js'
 */

/** No segment. */
const NONE = -1;
/**
 * The cells of a segment: buffer, start, capacity, length of the strip including its restart,
 * triangle count, and the update that wrote it.
 */
const CELLS = 6;
const START = 1;
const ROOM = 2;
const LENGTH = 3;
const TRIANGLES = 4;
const WRITTEN_IN = 5;
/**
 * The maximum share of unused restarts in a buffer, the same for the last update, and the number of
 * unused restarts that is always allowed.
 */
const MAX_WASTE = 1 / 3;
const MAX_WASTE_AT_END = 1 / 32;
const FREE_WASTE = 1024;
/** A link mask that no triangle has. */
const UNKNOWN = 255;

/**
 * Returns the capacity for a strip: its length plus an eighth.
 * @param {number} length including the restart
 */
const roomFor = (length) => (length + (length >> 3) + 3) & ~3;

/** The strips of one part and their metrics. */
class StripBuffer {
  indices = new IndexBuffer();
  end = 0;
  /** Free segments by the binary logarithm of their capacity. */
  free = Array.from({ length: 32 }, () => /** @type {number[]} */ ([]));
  /** The total length of all strips including restarts. */
  live = 0;
  triangles = 0;
  strips = 0;
}

/** The strips of all parts of a mesh. */
export class StripSegments {
  #parts;
  /** @type {StripBuffer[]} */
  #buffers;
  #segments = integers(0);
  #segmentCount = 0;
  /** The segments freed by this update, with the lengths of their strips. */
  #freed = /** @type {{ segment: number, length: number }[]} */ ([]);
  /** Per triangle: its segment, its links when sent, and the last update that sent it. */
  #segmentOf = integers(0);
  #links = new Uint8Array(0);
  #sentIn = integers(0);
  #update = 0;
  #count = 0;
  /** A strip and its triangles. */
  #strip = new Uint32Array(0);
  #path = integers(0);

  /**
   * @param {number[]} parts the indices of the parts that are drawn; a single one draws all
   *   triangles
   */
  constructor(parts) {
    this.#parts = new Map(parts.map((part, i) => [part, i]));
    this.#buffers = parts.map(() => new StripBuffer());
  }

  /**
   * Returns the changes of the strips.
   * @param {StreamPart} part with strips
   * @param {SentTriangles} triangles
   * @param {Float64Array} partOf the part of each vertex; empty for a single part
   * @param {boolean} isLast whether this is the last update
   * @returns {IndexUpdate[]}
   */
  update(part, { changed, changedCount, count }, partOf, isLast) {
    const strips = /** @type {import('../strips.js').Strips} */ (part.strips);
    strips.improve();
    this.#grow(count, strips.verticesSent);
    this.#update++;
    if (part.vertexCount > 0xffff) for (const { indices } of this.#buffers) indices.widen();
    for (let i = 0; i < changedCount; i++) this.#send(changed[i], strips, partOf);
    for (let t = 0; t < count; t++) if (strips.links(t) !== this.#links[t]) this.#send(t, strips, partOf);
    this.#clearFreed();
    for (const [i, { end, live }] of this.#buffers.entries()) {
      const most = isLast ? MAX_WASTE_AT_END * end : Math.max(MAX_WASTE * end, FREE_WASTE);
      if (end - live > most) this.#compact(i, isLast);
    }
    return [...this.#parts.keys()].map((part, i) => {
      const { indices, end, live, triangles, strips } = this.#buffers[i];
      indices.length = end;
      const { length, capacity, bytesPerIndex } = indices;
      const ranges = indices.takeChanges();
      return { part, length, capacity, bytesPerIndex, triangles, strips, verticesSent: live - strips, ranges };
    });
  }

  /**
   * @param {number} count the triangles
   * @param {number} verticesSent an upper bound for the vertices of a strip
   */
  #grow(count, verticesSent) {
    this.#segmentOf = grown(this.#segmentOf, count).fill(NONE, this.#count);
    this.#links = grown(this.#links, count).fill(UNKNOWN, this.#count);
    this.#sentIn = grown(this.#sentIn, count);
    this.#path = grown(this.#path, count);
    if (this.#strip.length < verticesSent) this.#strip = new Uint32Array(2 * verticesSent);
    this.#count = count;
  }

  /**
   * Writes the strip of a triangle, unless this update has written it already.
   * @param {number} t
   * @param {import('../strips.js').Strips} strips
   * @param {Float64Array} partOf
   */
  #send(t, strips, partOf) {
    if (this.#sentIn[t] === this.#update) return;
    const path = this.#path;
    const length = strips.send(t, this.#strip, 0, path);
    const count = strips.sentTriangles;
    const old = this.#segmentOf[path[0]];
    for (let i = 0; i < count; i++) {
      this.#free(this.#segmentOf[path[i]]);
      this.#links[path[i]] = strips.links(path[i]);
      this.#sentIn[path[i]] = this.#update;
    }
    const number = partOf.length === 0 ? 0 : this.#parts.get(partOf[this.#strip[0]]);
    const segment = number === undefined ? NONE : this.#place(number, old, length + 1);
    for (let i = 0; i < count; i++) this.#segmentOf[path[i]] = segment;
    if (number === undefined) return;
    const { indices } = this.#buffers[number];
    const start = this.#segments[CELLS * segment + START];
    indices.write(start, this.#strip, 0, length);
    indices.clear(start + length, start + this.#segments[CELLS * segment + ROOM]);
    this.#occupy(segment, length + 1, count);
  }

  /**
   * Frees the segment of a triangle, unless this update has written or freed it.
   * @param {number} segment
   */
  #free(segment) {
    if (segment === NONE) return;
    const { at, buffer } = this.#cellsOf(segment);
    const segments = this.#segments;
    const length = segments[at + LENGTH];
    if (length === 0 || segments[at + WRITTEN_IN] === this.#update) return;
    buffer.live -= length;
    buffer.strips--;
    buffer.triangles -= segments[at + TRIANGLES];
    segments[at + LENGTH] = 0;
    this.#freed.push({ segment, length });
  }

  /**
   * @param {number} segment a free one
   * @param {number} length of its strip, including the restart
   * @param {number} triangles
   */
  #occupy(segment, length, triangles) {
    const { at, buffer } = this.#cellsOf(segment);
    this.#segments[at + LENGTH] = length;
    this.#segments[at + TRIANGLES] = triangles;
    this.#segments[at + WRITTEN_IN] = this.#update;
    buffer.live += length;
    buffer.strips++;
    buffer.triangles += triangles;
  }

  /** @param {number} segment */
  #cellsOf(segment) {
    const at = CELLS * segment;
    return { at, buffer: this.#buffers[this.#segments[at]] };
  }

  /**
   * Returns a segment for a strip: the old one of its first triangle, a free one, or a new one.
   * @param {number} number the index of the buffer
   * @param {number} old
   * @param {number} length including the restart
   */
  #place(number, old, length) {
    const segments = this.#segments;
    const isFit = (/** @type {number} */ at) => segments[at] === number && segments[at + LENGTH] === 0 && segments[at + ROOM] >= length;
    if (old !== NONE && isFit(CELLS * old)) return old;
    const buffer = this.#buffers[number];
    const least = 32 - Math.clz32(length - 1);
    for (let size = least; size < least + 2; size++) {
      const free = buffer.free[size].pop();
      if (free !== undefined) return free;
    }
    const room = roomFor(length);
    const start = buffer.end;
    buffer.end += room;
    buffer.indices.reserve(buffer.end);
    buffer.indices.touch(start, buffer.end);
    const segment = this.#segmentCount++;
    this.#segments = grown(segments, CELLS * this.#segmentCount);
    this.#segments.set([number, start, room], CELLS * segment);
    return segment;
  }

  /** Clears the freed segments that were not reused. */
  #clearFreed() {
    for (const { segment, length } of this.#freed) {
      const { at, buffer } = this.#cellsOf(segment);
      if (this.#segments[at + LENGTH] > 0) continue;
      const start = this.#segments[at + START];
      buffer.indices.clear(start, start + length);
      buffer.free[31 - Math.clz32(this.#segments[at + ROOM])].push(segment);
    }
    this.#freed.length = 0;
  }

  /**
   * Compacts the segments of a buffer, and drops the free ones.
   * @param {number} number
   * @param {boolean} isTight whether segments get no spare capacity
   */
  #compact(number, isTight) {
    const segments = this.#segments;
    const buffer = this.#buffers[number];
    const { indices } = buffer;
    const old = Uint32Array.from(indices.slice(0, buffer.end));
    const order = [];
    for (let segment = 0; segment < this.#segmentCount; segment++) {
      const at = CELLS * segment;
      if (segments[at] === number && segments[at + LENGTH] > 0) order.push(at);
    }
    order.sort((a, b) => segments[a + START] - segments[b + START]);
    buffer.free.forEach((free) => (free.length = 0));
    buffer.end = 0;
    for (const at of order) {
      const from = segments[at + START];
      const length = segments[at + LENGTH];
      const room = isTight ? length : Math.min(roomFor(length), segments[at + ROOM]);
      segments[at + START] = buffer.end;
      segments[at + ROOM] = room;
      indices.write(buffer.end, old, from, from + length - 1);
      indices.clear(buffer.end + length - 1, buffer.end + room);
      buffer.end += room;
    }
  }
}
