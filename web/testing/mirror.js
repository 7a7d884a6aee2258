/**
 * The state of a model in a page: buffers filled by updates.
 * @module
 */

import { drawnByStrips, triples } from './triangles.js';

/** @import { MeshUpdate, Update } from '../src/client/client.js' */

/** The buffers of a mesh. */
class MirroredMesh {
  /** @type {number[]} */
  positions = [];
  /** @type {Map<string, number[]>} */
  attributes = new Map();
  /**
   * The indices of each part.
   * @type {Map<number, { indices: Float64Array, length: number, bytesPerIndex: number }>}
   */
  parts = new Map();
  /** The number of indices uploaded, and the total size of all buffers in indices. */
  uploaded = 0;
  whole = 0;

  /** @param {MeshUpdate} update */
  apply(update) {
    splice(this.positions, 3 * update.firstVertex, update.positions);
    if (this.positions.length !== 3 * update.vertices) throw new Error('positions are missing');
    for (const { name, components, array } of update.attributes) {
      const values = this.attributes.get(name) ?? [];
      splice(values, components * update.firstVertex, array);
      this.attributes.set(name, values);
    }
    for (const { part, length, capacity, bytesPerIndex, ranges } of update.parts) {
      if (length > capacity) throw new Error('more indices than room');
      const known = this.parts.get(part);
      let indices = known?.indices ?? new Float64Array(0);
      if (indices.length < capacity) {
        const longer = new Float64Array(capacity).fill(NaN);
        longer.set(indices);
        indices = longer;
      }
      if (known && known.bytesPerIndex !== bytesPerIndex) indices.fill(NaN);
      let end = -1;
      for (const { start, array } of ranges) {
        if (start <= end || array.BYTES_PER_ELEMENT !== bytesPerIndex) throw new Error('ranges out of order');
        indices.set(array, start);
        end = start + array.length;
        this.uploaded += array.length;
      }
      this.whole += length;
      if (end > length) throw new Error('a range behind the end');
      this.parts.set(part, { indices, length, bytesPerIndex });
    }
    this.update = update;
  }

  /**
   * Returns the triangles that a part draws.
   * @param {number} part
   * @param {'strips' | 'lists'} output
   */
  triangles(part, output) {
    const { indices, length, bytesPerIndex } = /** @type {any} */ (this.parts.get(part));
    const drawn = indices.subarray(0, length);
    if (drawn.includes(NaN)) throw new Error('an index that was never sent is drawn');
    return output === 'lists' ? triples(drawn) : drawnByStrips(bytesPerIndex === 2 ? Uint16Array.from(drawn) : Uint32Array.from(drawn));
  }
}

/**
 * Replaces the values from a position on.
 * @param {number[]} values
 * @param {number} start
 * @param {ArrayLike<number>} replaced
 */
function splice(values, start, replaced) {
  if (start > values.length) throw new Error('values are missing');
  values.length = start;
  for (let i = 0; i < replaced.length; i++) values.push(replaced[i]);
}

/** The buffers of a model. */
export class Mirror {
  /** @type {Map<number, MirroredMesh>} */
  meshes = new Map();

  /** @param {Update} update */
  apply({ meshes }) {
    for (const mesh of meshes) {
      if (!this.meshes.has(mesh.stream)) this.meshes.set(mesh.stream, new MirroredMesh());
      this.meshes.get(mesh.stream)?.apply(mesh);
    }
  }
}
