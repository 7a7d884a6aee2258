/**
 * Triangle lists of the parts of a mesh. Each triangle keeps its position in its list.
 * @module
 */
import { grown, integers } from '../growth.js';
import { IndexBuffer } from './index_buffer.js';

/**
 * @import { StreamPart } from '../decoder.js'
 * @import { IndexUpdate } from './client.js'
 * @import { SentTriangles } from './mesh_buffers.js'
 */

/** No list: the part of the triangle is not drawn. */
const NOT_DRAWN = -1;

/** One triangle list per part of a mesh. */
export class Lists {
  #parts;
  /** @type {IndexBuffer[]} */
  #buffers;
  /** The list of each triangle, and its position in the list. */
  #lists = integers(0);
  #places = integers(0);
  #count = 0;

  /**
   * @param {number[]} parts the indices of the parts that are drawn; a single one draws all
   *   triangles
   */
  constructor(parts) {
    this.#parts = new Map(parts.map((part, i) => [part, i]));
    this.#buffers = parts.map(() => new IndexBuffer());
  }

  /**
   * Returns the changes of the lists.
   * @param {StreamPart} part
   * @param {SentTriangles} triangles
   * @param {Float64Array} partOf the part of each vertex; empty for a single part
   * @returns {IndexUpdate[]}
   */
  update(part, { vertices, changed, changedCount, count }, partOf) {
    this.#lists = grown(this.#lists, count);
    this.#places = grown(this.#places, count);
    const known = this.#buffers.map(({ length }) => length);
    for (let t = this.#count; t < count; t++) {
      const list = partOf.length === 0 ? 0 : (this.#parts.get(partOf[vertices[3 * t]]) ?? NOT_DRAWN);
      this.#lists[t] = list;
      if (list === NOT_DRAWN) continue;
      this.#places[t] = this.#buffers[list].length;
      this.#buffers[list].length += 3;
    }
    this.#count = count;
    for (const [i, buffer] of this.#buffers.entries()) {
      buffer.reserve(buffer.length);
      if (part.vertexCount > 0xffff) buffer.widen();
      buffer.touch(known[i], buffer.length);
    }
    for (let i = 0; i < changedCount; i++) {
      const t = changed[i];
      if (this.#lists[t] === NOT_DRAWN) continue;
      for (let j = 0; j < 3; j++) this.#buffers[this.#lists[t]].set(this.#places[t] + j, vertices[3 * t + j]);
    }
    return [...this.#parts.keys()].map((part, i) => {
      const buffer = this.#buffers[i];
      const { length, capacity, bytesPerIndex } = buffer;
      const ranges = buffer.takeChanges();
      return { part, length, capacity, bytesPerIndex, triangles: length / 3, strips: 0, verticesSent: length, ranges };
    });
  }
}
