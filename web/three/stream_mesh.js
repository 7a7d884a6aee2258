/**
 * The buffers of one mesh of the stream, updated in place. All geometries that draw parts of the
 * mesh share its vertices.
 *
 * ```text
 *                     ┌ geometry of part 0: index ┐
 * update ─▶ vertices ─┤                           ├─ the same attributes
 *                     └ geometry of part 1: index ┘
 * ```
 *
 * three.js cannot resize the buffer of an attribute. When the capacity is exceeded, all buffers of
 * the mesh are replaced by larger ones, and the old ones are freed on the GPU. The capacity
 * doubles, so the cost per vertex is constant. It depends on the received data, not on the declared
 * size.
 * @module
 */
import { Box3, BufferAttribute, DynamicDrawUsage, Vector4 } from 'three';
import { boundSphere, growBox, growMeshBounds } from './bounds.js';
import { threeName } from './names.js';

/**
 * @import { InstancedMesh, SkinnedMesh } from 'three'
 * @import { Attribute, IndexUpdate, MeshUpdate } from '../src/client/client.js'
 * @import { Refined } from './plugin.js'
 */

const SKIN_WEIGHT = 'skinWeight';

/**
 * If a buffer has more changed ranges, they are uploaded as one. Objects out of view accumulate
 * ranges.
 */
const MAX_RANGES = 128;

/**
 * A geometry, and whether it has the buffers of the stream.
 * @typedef {Refined & { isAttached: boolean }} User
 */

/** One mesh of the stream and the geometries that draw it. */
export class StreamMesh {
  /**
   * Attributes by three.js name.
   * @type {Map<string, BufferAttribute>}
   */
  #attributes = new Map();
  /** The index of each part. @type {(BufferAttribute | undefined)[]} */
  #indices = [];
  #vertexCount = 0;
  #vertexRoom = 0;
  /**
   * The error of the last update.
   * @type {number | undefined}
   */
  #error;
  /** @type {User[]} */
  #users = [];
  /**
   * The meshes with their own bounds.
   * @type {(SkinnedMesh | InstancedMesh)[]}
   */
  #bounded = [];
  #isSkinned = false;

  /**
   * Adds a geometry that draws a part.
   * @param {Refined} refined
   * @param {(SkinnedMesh | InstancedMesh)[]} bounded the skinned and instanced meshes with this geometry
   */
  add(refined, bounded) {
    const user = { ...refined, isAttached: false };
    this.#users.push(user);
    if (!this.#isSkinned && bounded.some((mesh) => 'isSkinnedMesh' in mesh)) {
      this.#isSkinned = true;
      this.#normalizeWeights(0);
    }
    this.#bounded.push(...bounded);
    user.geometry.boundingBox ??= new Box3();
    this.#attach(user);
    if (user.isAttached) this.#growBounds(user, 0, [{ start: 0, count: Infinity }]);
  }

  /**
   * The name of an attribute that a geometry needs and the stream lacks.
   * @returns {string | undefined}
   */
  get missing() {
    if (this.#vertexCount === 0) return undefined;
    return this.#users.flatMap(({ names }) => names).find((name) => !this.#attributes.has(name));
  }

  /**
   * Applies an update.
   * @param {MeshUpdate} update
   */
  take({ firstVertex, positions, attributes, parts, error, fullVertices }) {
    const count = firstVertex + positions.length / 3;
    const needsRoom = count > this.#vertexRoom || parts.some((part) => this.#needsRoom(part));
    if (needsRoom) {
      for (const { geometry, isAttached } of this.#users) if (isAttached) geometry.dispose();
    }
    if (count > this.#vertexRoom) {
      // The declared size is used only to avoid spare capacity at the end.
      this.#vertexRoom = fullVertices < count ? 2 * count : Math.min(2 * count, fullVertices);
    }
    if (positions.length > 0) {
      this.#vertexCount = count;
      this.#write({ name: 'POSITION', components: 3, normalized: false, array: positions }, firstVertex);
      for (const attribute of attributes) this.#write(attribute, firstVertex);
      if (this.#isSkinned) this.#normalizeWeights(firstVertex);
    }
    // three.js may have computed the bounds before this update.
    for (const mesh of this.#bounded) growMeshBounds(mesh, this.#error ?? error);
    this.#error = error;
    for (const part of parts) this.#writeIndices(part);
    for (const user of this.#users) {
      this.#attach(user);
      const ranges = parts.find(({ part }) => part === user.part)?.ranges ?? [];
      const changed = ranges.map(({ start, array }) => ({ start, count: array.length }));
      this.#growBounds(user, firstVertex, firstVertex === 0 ? [{ start: 0, count: Infinity }] : changed);
    }
  }

  /** @param {IndexUpdate} update */
  #needsRoom({ part, capacity, bytesPerIndex }) {
    const array = this.#indices[part]?.array;
    return !array || array.length < capacity || array.BYTES_PER_ELEMENT !== bytesPerIndex;
  }

  /**
   * Writes the values of an attribute, starting at a vertex.
   * @param {Attribute} attribute
   * @param {number} firstVertex
   */
  #write({ name, components, normalized, array: values }, firstVertex) {
    let attribute = this.#attributes.get(threeName(name));
    if (!attribute || attribute.array.length < components * this.#vertexRoom) {
      // GPUs do not support 64-bit attributes.
      const ArrayType = values instanceof Float64Array ? Float32Array : /** @type {any} */ (values.constructor);
      const array = new ArrayType(components * this.#vertexRoom);
      if (attribute) array.set(attribute.array.subarray(0, components * firstVertex));
      attribute = new BufferAttribute(array, components, normalized).setUsage(DynamicDrawUsage);
      this.#attributes.set(threeName(name), attribute);
    }
    attribute.array.set(values, components * firstVertex);
    setCount(attribute, this.#vertexCount);
    // Every changed range ends at the last vertex, so one range covers the changes of several
    // updates.
    const start = Math.min(components * firstVertex, ...attribute.updateRanges.map((range) => range.start));
    attribute.clearUpdateRanges();
    attribute.addUpdateRange(start, components * this.#vertexCount - start);
    attribute.needsUpdate = true;
  }

  /** @param {IndexUpdate} update */
  #writeIndices(update) {
    const { part, length, capacity, bytesPerIndex, ranges } = update;
    let index = this.#indices[part];
    if (!index || this.#needsRoom(update)) {
      const array = bytesPerIndex === 2 ? new Uint16Array(capacity) : new Uint32Array(capacity);
      if (index) array.set(index.array);
      index = new BufferAttribute(array, 1).setUsage(DynamicDrawUsage);
      this.#indices[part] = index;
    }
    for (const { start, array } of ranges) {
      index.array.set(array, start);
      index.addUpdateRange(start, array.length);
    }
    if (index.updateRanges.length > MAX_RANGES) {
      const start = index.updateRanges.reduce((least, range) => Math.min(least, range.start), length);
      index.clearUpdateRanges();
      index.addUpdateRange(start, length - start);
    }
    setCount(index, length);
    if (ranges.length > 0) index.needsUpdate = true;
  }

  /**
   * Attaches the current buffers to a geometry. A part without triangles keeps its base mesh.
   * @param {User} user
   */
  #attach(user) {
    const { geometry, part, names } = user;
    const index = this.#indices[part];
    if (!index || index.count === 0) return;
    if (!user.isAttached) {
      geometry.dispose();
      user.isAttached = true;
    }
    if (geometry.index !== index) geometry.setIndex(index);
    for (const name of names) {
      const attribute = this.#attributes.get(name);
      if (attribute && geometry.attributes[name] !== attribute) geometry.setAttribute(name, attribute);
    }
    geometry.setDrawRange(0, index.count);
  }

  /**
   * Extends the bounds of a geometry. If it draws the whole mesh, by the vertices from
   * `firstVertex`; otherwise by the vertices of its changed indices.
   * @param {User} user
   * @param {number} firstVertex
   * @param {{ start: number, count: number }[]} changed ranges of the index
   */
  #growBounds({ geometry, part, isAttached }, firstVertex, changed) {
    const positions = this.#attributes.get('position')?.array.subarray(0, 3 * this.#vertexCount);
    const index = this.#indices[part];
    if (!isAttached || !positions || !index || !geometry.boundingBox) return;
    if (this.#users.length === 1) growBox(geometry.boundingBox, positions.subarray(3 * firstVertex));
    else {
      for (const { start, count } of changed) {
        growBox(geometry.boundingBox, positions, index.array.subarray(start, Math.min(start + count, index.count)));
      }
    }
    boundSphere(geometry);
  }

  /**
   * Normalizes the weights of each vertex to a sum of 1, as GLTFLoader does for skinned meshes.
   * @param {number} firstVertex
   */
  #normalizeWeights(firstVertex) {
    const weights = this.#attributes.get(SKIN_WEIGHT);
    if (!weights) return;
    const vector = new Vector4();
    for (let vertex = firstVertex; vertex < this.#vertexCount; vertex++) {
      vector.fromBufferAttribute(weights, vertex);
      const sum = vector.manhattanLength();
      if (sum > 0) vector.divideScalar(sum);
      else vector.set(1, 0, 0, 0);
      weights.setXYZW(vertex, vector.x, vector.y, vector.z, vector.w);
    }
  }
}

/**
 * Sets the number of used entries of an attribute. three.js computes bounds and exports by this
 * number; the array can be longer.
 * @param {BufferAttribute} attribute
 * @param {number} count
 */
function setCount(attribute, count) {
  /** @type {{ count: number }} */ (attribute).count = count;
}
