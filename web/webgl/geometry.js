/**
 * Vertex and index buffers of a mesh, patched while it is drawn.
 *
 * ```text
 * patch ─▶ arrays in memory ─ upload, in slices ─▶ buffers ─ complete ─▶ draw
 * ```
 *
 * Vertices are replaced in place. A vertex keeps its index, so the indices in use remain valid.
 * Small index changes are uploaded in one frame. Larger ones are applied to a copy of the buffer
 * over several frames, which then replaces it.
 * @module
 */
import { SLICE_BYTES } from './budget.js';
import { Pulled } from './pulled.js';

/**
 * @import { MeshUpdate, IndexUpdate } from '../src/client/client.js'
 * @import { Budget } from './budget.js'
 * @import { Morphs } from './morphs.js'
 * @import { PulledTextures } from './pulled.js'
 */

/** @typedef {Float32Array | Uint8Array | Int8Array | Uint16Array | Int16Array | Uint32Array | Int32Array} NumberArray */
/** @typedef {Uint8Array | Uint16Array | Uint32Array} IndexArray */

/**
 * The attributes that shaders read, and their locations.
 * @type {Record<string, number>}
 */
export const LOCATIONS = { POSITION: 0, NORMAL: 1, TEXCOORD_0: 2, TEXCOORD_1: 3, COLOR_0: 4, JOINTS_0: 5, WEIGHTS_0: 6 };

/** Ranges with a smaller gap, in indices, are uploaded as one. */
const NEAR = 512;
const ELEMENT_ARRAY_BUFFER = 0x8893;
const ARRAY_BUFFER = 0x8892;

/** @type {Map<Function, number>} */
const GL_TYPES = new Map(
  /** @type {[Function, number][]} */ ([
    [Int8Array, 0x1400], [Uint8Array, 0x1401], [Int16Array, 0x1402], [Uint16Array, 0x1403], [Int32Array, 0x1404], [Uint32Array, 0x1405], [Float32Array, 0x1406],
  ]),
);
const glType = (/** @type {NumberArray} */ array) => GL_TYPES.get(array.constructor) ?? 0;

/**
 * Returns a buffer of a given size that starts with the contents of another one.
 * @param {WebGL2RenderingContext} gl
 * @param {number} target
 * @param {number} size
 * @param {WebGLBuffer | null} old
 * @param {number} oldSize the bytes to copy
 */
function copyOf(gl, target, size, old, oldSize) {
  const buffer = gl.createBuffer();
  gl.bindBuffer(target, buffer);
  gl.bufferData(target, size, gl.DYNAMIC_DRAW);
  if (old && oldSize > 0) {
    gl.bindBuffer(gl.COPY_READ_BUFFER, old);
    gl.copyBufferSubData(gl.COPY_READ_BUFFER, target, 0, 0, oldSize);
    gl.bindBuffer(gl.COPY_READ_BUFFER, null);
  }
  return buffer;
}

/** A vertex attribute. */
export class VertexData {
  /** @type {WebGLBuffer | null} */
  buffer = null;
  #capacity = 0;
  /** The range of values that still need to be uploaded. */
  #from = 0;
  #to;

  /**
   * @param {NumberArray} array
   * @param {number} components
   * @param {boolean} normalized
   */
  constructor(array, components, normalized) {
    this.array = array;
    this.components = components;
    this.normalized = normalized;
    this.#to = array.length;
  }

  /**
   * @param {number} start the first changed value
   * @param {NumberArray} values
   */
  patch(start, values) {
    const end = start + values.length;
    if (start === 0 && end >= this.array.length) this.array = values;
    else if (end > this.array.length) {
      const old = this.array;
      this.array = new /** @type {any} */ (old.constructor)(Math.max(end, 2 * old.length));
      this.array.set(old);
    }
    if (this.array !== values) this.array.set(values, start);
    this.#from = this.#from < this.#to ? Math.min(this.#from, start) : start;
    this.#to = Math.max(this.#to, end);
  }

  /**
   * Uploads what the budget allows. Returns whether everything is uploaded.
   * @param {WebGL2RenderingContext} gl
   * @param {Budget} budget
   */
  upload(gl, budget) {
    const { array } = this;
    const size = array.BYTES_PER_ELEMENT;
    if (this.#from >= this.#to) return true;
    if (this.#capacity < array.length) {
      const capacity = Math.max(array.length, 2 * this.#capacity);
      const buffer = copyOf(gl, ARRAY_BUFFER, capacity * size, this.buffer, this.#capacity * size);
      gl.deleteBuffer(this.buffer);
      this.buffer = buffer;
      this.#capacity = capacity;
    }
    gl.bindBuffer(ARRAY_BUFFER, this.buffer);
    while (this.#from < this.#to) {
      if (budget.bytes === 0) return false;
      const count = Math.min(this.#to - this.#from, SLICE_BYTES / size);
      gl.bufferSubData(ARRAY_BUFFER, this.#from * size, array, this.#from, count);
      budget.spend(count * size);
      this.#from += count;
    }
    this.#from = this.#to = 0;
    return true;
  }

  /** Drops the buffer after a context loss. */
  forget() {
    this.buffer = null;
    this.#capacity = 0;
    this.#from = 0;
    this.#to = this.array.length;
  }
}

/** The indices of a part. */
export class IndexData {
  length = 0;
  /**
   * The buffer in use; its index count and type follow.
   * @type {WebGLBuffer | null}
   */
  buffer = null;
  shownLength = 0;
  shownType = 0;
  #capacity = 0;
  /** The size of a new buffer, in bytes. */
  #room = 0;
  #nextCapacity = 0;
  /**
   * The buffer that will be drawn once it is complete.
   * @type {WebGLBuffer | null}
   */
  #next = null;
  #isPrepared = false;
  /**
   * The ranges that still need to be uploaded, as start and end indices.
   * @type {number[][]}
   */
  #ranges = [];

  /**
   * @param {IndexArray | null} array `null` to draw vertices in order
   * @param {number} length
   * @param {number} mode see `drawElements`
   */
  constructor(array, length, mode) {
    this.array = array;
    this.length = length;
    this.mode = mode;
    if (array) this.#ranges.push([0, length]);
  }

  /** @param {IndexUpdate} update */
  patch({ length, capacity, bytesPerIndex, ranges }) {
    const Type = bytesPerIndex === 2 ? Uint16Array : Uint32Array;
    const last = ranges.at(-1);
    const need = Math.max(length, last ? last.start + last.array.length : 0);
    this.#room = Math.min(capacity, 2 * need) * bytesPerIndex;
    let array = this.array;
    if (last && ranges.length === 1 && last.start === 0 && need === last.array.length) this.array = array = last.array;
    else if (!(array instanceof Type) || array.length < need) {
      array = new Type(Math.max(need, Math.min(capacity, 2 * need)));
      if (this.array instanceof Type) array.set(this.array);
      this.array = array;
    }
    for (const range of ranges) {
      if (array !== range.array) array.set(range.array, range.start);
      this.#ranges.push([range.start, range.start + range.array.length]);
    }
    this.length = length;
  }

  /** Sorts the ranges, and merges those with small gaps. */
  #join() {
    /** @type {number[][]} */
    const joined = [];
    for (const [from, to] of this.#ranges.sort((a, b) => a[0] - b[0])) {
      const last = joined.at(-1);
      if (last && from - last[1] < NEAR) last[1] = Math.max(last[1], to);
      else joined.push([from, to]);
    }
    this.#ranges = joined;
  }

  /**
   * Uploads what the budget allows and what is not in use. Returns whether `show` can be called.
   * @param {WebGL2RenderingContext} gl
   * @param {Budget} budget
   */
  upload(gl, budget) {
    const { array } = this;
    if (!array || this.#ranges.length === 0) return true;
    if (!this.#isPrepared) {
      if (budget.bytes === 0) return false;
      this.#join();
      const bytes = this.#ranges.reduce((sum, [from, to]) => sum + to - from, 0) * array.BYTES_PER_ELEMENT;
      const isOther = glType(array) !== this.shownType;
      if (isOther || this.#capacity < array.byteLength || bytes > Math.min(SLICE_BYTES, budget.bytes)) {
        this.#nextCapacity = Math.max(array.byteLength, this.#room);
        this.#next = copyOf(gl, ELEMENT_ARRAY_BUFFER, this.#nextCapacity, this.buffer, isOther ? 0 : Math.min(this.#capacity, this.#nextCapacity));
      } else budget.spend(bytes);
      this.#isPrepared = true;
    }
    if (!this.#next) return true;
    gl.bindBuffer(ELEMENT_ARRAY_BUFFER, this.#next);
    return this.#send(gl, array, budget);
  }

  /**
   * @param {WebGL2RenderingContext} gl
   * @param {IndexArray} array
   * @param {Budget} [budget]
   */
  #send(gl, array, budget) {
    const size = array.BYTES_PER_ELEMENT;
    for (let range; (range = this.#ranges[0]); this.#ranges.shift()) {
      for (let count; range[0] < range[1]; range[0] += count) {
        if (budget?.bytes === 0) return false;
        count = Math.min(range[1] - range[0], SLICE_BYTES / size);
        gl.bufferSubData(ELEMENT_ARRAY_BUFFER, range[0] * size, array, range[0], count);
        budget?.spend(count * size);
      }
    }
    return true;
  }

  /**
   * Starts drawing the new indices.
   * @param {WebGL2RenderingContext} gl
   */
  show(gl) {
    const { array } = this;
    if (array && this.#next) {
      gl.deleteBuffer(this.buffer);
      this.buffer = this.#next;
      this.#capacity = this.#nextCapacity;
      this.#next = null;
    } else if (array && this.#ranges.length > 0) {
      gl.bindBuffer(ELEMENT_ARRAY_BUFFER, this.buffer);
      this.#send(gl, array);
    }
    if (array) this.shownType = glType(array);
    this.shownLength = this.length;
    this.#isPrepared = false;
  }

  /** @param {WebGL2RenderingContext} gl */
  release(gl) {
    gl.deleteBuffer(this.buffer);
    gl.deleteBuffer(this.#next);
  }

  /** Drops the buffers after a context loss. */
  forget() {
    this.buffer = this.#next = null;
    this.#capacity = this.shownLength = this.shownType = 0;
    this.#isPrepared = false;
    this.#ranges = this.array ? [[0, this.length]] : [];
  }
}

/** A mesh: vertex attributes and the indices of its parts. */
export class Geometry {
  /** @type {Map<string, VertexData>} */
  attributes = new Map();
  /** @type {Map<number, IndexData>} */
  parts = new Map();
  /** @type {Morphs | undefined} */
  morphs;
  /** @type {Pulled | undefined} */
  pulled;
  /** Whether no more updates are expected. */
  isFull = true;
  /** @type {Map<number, WebGLVertexArrayObject>} */
  #layouts = new Map();
  #isChanged = true;
  /** Whether it has been uploaded. Shared arrays may be uploaded earlier. */
  #isUploaded = false;

  /**
   * Sets the arrays of a part. They are uploaded even if the context was restored before they
   * arrived.
   * @param {Map<string, VertexData>} attributes
   * @param {number} number
   * @param {IndexData} indices
   * @param {Morphs} [morphs]
   */
  fill(attributes, number, indices, morphs) {
    this.attributes = attributes;
    this.morphs = morphs;
    this.parts.set(number, indices);
    this.#isChanged = true;
  }

  /**
   * Applies an update of the client.
   * @param {MeshUpdate} update
   */
  patch({ firstVertex, positions, attributes, parts, level, fullLevel }) {
    this.isFull = level === fullLevel;
    const all = [...attributes, { name: 'POSITION', components: 3, normalized: false, array: positions }];
    for (const { name, components, normalized, array } of all) {
      if (!Object.hasOwn(LOCATIONS, name) || array.length === 0) continue;
      const values = array instanceof Float64Array ? Float32Array.from(array) : array;
      const known = this.attributes.get(name);
      if (known) known.patch(firstVertex * components, values);
      else this.attributes.set(name, new VertexData(values, components, normalized));
    }
    this.pulled?.markVertices(firstVertex, firstVertex + positions.length / 3);
    for (const update of parts) {
      let part = this.parts.get(update.part);
      if (!part) this.parts.set(update.part, (part = new IndexData(null, 0, update.strips > 0 ? 5 : 4)));
      if (part.length === 0) part.mode = update.strips > 0 ? 5 : 4;
      part.patch(update);
      for (const { start, array } of update.ranges) this.pulled?.markIndices(part, start, start + array.length);
    }
    this.#isChanged = true;
  }

  /**
   * Uploads what the budget allows. Returns whether the new state is drawn from now on.
   * @param {WebGL2RenderingContext} gl
   * @param {Budget} budget
   */
  upload(gl, budget) {
    if (this.#isChanged) {
      gl.bindVertexArray(null);
      for (const data of this.attributes.values()) if (!data.upload(gl, budget)) return this.#dropLayouts(gl);
      for (const part of this.parts.values()) if (!part.upload(gl, budget)) return this.#dropLayouts(gl);
      if (this.morphs?.upload(gl, budget) === false) return this.#dropLayouts(gl);
      for (const part of this.parts.values()) part.show(gl);
      this.#dropLayouts(gl);
      this.#isChanged = false;
      this.#isUploaded = true;
    }
    return !this.pulled || this.pulled.upload(gl, budget);
  }

  /**
   * Deletes the vertex array objects, because buffers may have been replaced.
   * @param {WebGL2RenderingContext} gl
   */
  #dropLayouts(gl) {
    for (const layout of this.#layouts.values()) gl.deleteVertexArray(layout);
    this.#layouts.clear();
    return false;
  }

  /**
   * Returns whether a part has anything to draw.
   * @param {number} number
   */
  isShown(number) {
    return this.#isUploaded && Boolean(this.parts.get(number)?.shownLength);
  }

  /**
   * Draws a part with the current program.
   * @param {WebGL2RenderingContext} gl
   * @param {number} number
   */
  draw(gl, number) {
    const part = this.parts.get(number);
    if (!part || part.shownLength === 0) return;
    let layout = this.#layouts.get(number);
    if (!layout) {
      layout = gl.createVertexArray();
      this.#layouts.set(number, layout);
      gl.bindVertexArray(layout);
      for (const [name, { buffer, array, components, normalized }] of this.attributes) {
        gl.bindBuffer(ARRAY_BUFFER, buffer);
        gl.enableVertexAttribArray(LOCATIONS[name]);
        gl.vertexAttribPointer(LOCATIONS[name], components, glType(array), normalized, 0, 0);
      }
      gl.bindBuffer(ELEMENT_ARRAY_BUFFER, part.buffer);
    } else gl.bindVertexArray(layout);
    if (part.array) gl.drawElements(part.mode, part.shownLength, part.shownType, 0);
    else gl.drawArrays(part.mode, 0, part.shownLength);
  }

  /**
   * Creates textures of vertices and indices, for modes that need the corners of each triangle.
   * @param {PulledTextures} textures of the model
   */
  pull(textures) {
    this.pulled ??= new Pulled(this, textures);
  }

  /** Drops these textures. */
  unpull() {
    this.pulled = undefined;
  }

  /** @param {WebGL2RenderingContext} gl */
  release(gl) {
    this.#dropLayouts(gl);
    this.morphs?.release(gl);
    for (const { buffer } of this.attributes.values()) gl.deleteBuffer(buffer);
    for (const part of this.parts.values()) part.release(gl);
  }

  /** Drops the objects of a lost context; `upload` creates them again. */
  forget() {
    this.#layouts.clear();
    this.morphs?.forget();
    for (const data of this.attributes.values()) data.forget();
    for (const part of this.parts.values()) part.forget();
    this.#isChanged = true;
    this.#isUploaded = false;
  }
}
