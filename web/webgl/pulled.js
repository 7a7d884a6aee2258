/**
 * Textures of the vertices and indices of a mesh, from which the vertex shader fetches the corners
 * of each triangle. They are used for wireframe, and for a colour per strip.
 *
 * ```text
 * index texture: index, start of its strip │ index, start │ …
 * vertex texture: x, y, z │ x, y, z │ …
 * ```
 *
 * Index k of the buffer and vertex k are at texel (k mod 2048, k / 2048).
 *
 * There are two sets. While one is drawn, changed rows of the other are uploaded, over several
 * frames if there are many. A complete mesh keeps only one set.
 * @module
 */
import { unitOf } from './accessors.js';
import { restartOf } from './indices.js';
import { floats, RowTexture, words } from './row_texture.js';

/**
 * @import { Budget } from './budget.js'
 * @import { Geometry, IndexData, VertexData } from './geometry.js'
 */

const STRIP = 5;
const RESTART = 0xffffffff;
/** The maximum distance of a backward search for the start of a strip. */
const MAX_STEPS_BACK = 2 ** 16;

/**
 * The attributes with textures, their samplers and formats.
 * @type {[string, string, 'RGB32F' | 'RGBA32F'][]}
 */
const ATTRIBUTES = [
  ['POSITION', 'positions', 'RGB32F'],
  ['JOINTS_0', 'jointNumbers', 'RGBA32F'],
  ['WEIGHTS_0', 'jointWeights', 'RGBA32F'],
];

/**
 * One set of textures of a model, by their content. Primitives that share vertices share their
 * texture.
 */
class TextureSet {
  /** @type {Map<VertexData | IndexData, RowTexture>} */
  #textures = new Map();

  /**
   * Returns the texture of some data, if it exists.
   * @param {VertexData | IndexData | undefined} data
   */
  get(data) {
    return data && this.#textures.get(data);
  }

  /**
   * Returns the texture of some data; creates it if needed.
   * @param {VertexData | IndexData} data
   * @param {'RG32UI' | 'RGB32F' | 'RGBA32F'} format
   */
  make(data, format) {
    let texture = this.#textures.get(data);
    if (!texture) this.#textures.set(data, (texture = new RowTexture(format)));
    return texture;
  }

  /** @param {WebGL2RenderingContext} gl */
  release(gl) {
    for (const texture of this.#textures.values()) texture.release(gl);
    this.#textures.clear();
  }
}

/** The textures of a model. */
export class PulledTextures {
  sets = [new TextureSet(), new TextureSet()];

  /**
   * Deletes all textures. Geometries that use them must drop them.
   * @param {WebGL2RenderingContext} gl
   */
  release(gl) {
    for (const set of this.sets) set.release(gl);
  }
}

/** A consistent set of textures of a mesh. */
class Snapshot {
  isDirty = true;
  /**
   * The draw call of each part.
   * @type {Map<number, { count: number, mode: number }>}
   */
  parts = new Map();

  /** @param {TextureSet} textures */
  constructor(textures) {
    this.textures = textures;
  }

  /**
   * @param {WebGL2RenderingContext} gl
   * @param {Geometry} geometry
   * @param {Budget} budget
   */
  upload(gl, { attributes, parts }, budget) {
    for (const [name, , format] of ATTRIBUTES) {
      const data = attributes.get(name);
      if (data && !this.textures.make(data, format).upload(gl, budget, data.array.length / data.components, (from, to) => fillVertices(data, from, to))) return false;
    }
    for (const [number, data] of parts) {
      if (!this.textures.make(data, 'RG32UI').upload(gl, budget, data.length, (from, to) => fillIndices(data, from, to))) return false;
      this.parts.set(number, { count: data.length, mode: data.mode });
    }
    this.isDirty = false;
    return true;
  }

  /**
   * Deletes the textures of a mesh, unless they are shared. They are created again after a change.
   * @param {WebGL2RenderingContext} gl
   * @param {Geometry} geometry
   */
  release(gl, { attributes, parts }) {
    for (const data of [...attributes.values(), ...parts.values()]) this.textures.get(data)?.release(gl);
    this.isDirty = true;
  }
}

/**
 * @param {VertexData} data
 * @param {number} from
 * @param {number} to
 */
function fillVertices({ array, components, normalized }, from, to) {
  const values = array.subarray(from * components, to * components);
  floats.set(values);
  const unit = unitOf({ array, normalized });
  if (unit !== 1) for (let i = 0; i < values.length; i++) floats[i] /= unit;
}

/**
 * @param {IndexData} data
 * @param {number} from
 * @param {number} to
 */
function fillIndices({ array, mode }, from, to) {
  const restart = array && restartOf(array);
  let start = from;
  if (array && mode === STRIP) {
    const least = Math.max(from - MAX_STEPS_BACK, 0);
    while (start > least && array[start - 1] !== restart) start--;
  } else start = 0;
  for (let position = from, at = 0; position < to; position++) {
    const index = array ? array[position] : position;
    if (index === restart) start = position + 1;
    words[at++] = index === restart ? RESTART : index;
    words[at++] = start;
  }
}

/** The textures of a mesh. */
export class Pulled {
  #geometry;
  /** @type {Snapshot} */
  #shown;
  /** @type {Snapshot} */
  #next;
  /** Whether there is anything to draw. */
  isReady = false;

  /**
   * @param {Geometry} geometry
   * @param {PulledTextures} textures of the model
   */
  constructor(geometry, { sets }) {
    this.#geometry = geometry;
    this.#shown = new Snapshot(sets[0]);
    this.#next = new Snapshot(sets[1]);
  }

  /**
   * Marks vertices as changed.
   * @param {number} from
   * @param {number} to
   */
  markVertices(from, to) {
    for (const snapshot of [this.#shown, this.#next]) {
      for (const [name] of ATTRIBUTES) snapshot.textures.get(this.#geometry.attributes.get(name))?.mark(from, to);
      snapshot.isDirty = true;
    }
  }

  /**
   * Marks indices as changed, including those after them in the same strip.
   * @param {IndexData} data
   * @param {number} from
   * @param {number} to
   */
  markIndices(data, from, to) {
    const { array, length } = data;
    const restart = array && restartOf(array);
    let end = to;
    while (array && end < length && array[end] !== restart) end++;
    for (const snapshot of [this.#shown, this.#next]) {
      snapshot.textures.get(data)?.mark(from, end);
      snapshot.isDirty = true;
    }
  }

  /**
   * Uploads what the budget allows. Returns whether the new state is drawn from now on.
   * @param {WebGL2RenderingContext} gl
   * @param {Budget} budget
   */
  upload(gl, budget) {
    if (!this.#shown.isDirty) return true;
    if (!this.#next.upload(gl, this.#geometry, budget)) return false;
    [this.#shown, this.#next] = [this.#next, this.#shown];
    // A complete mesh does not need the second set.
    if (this.#geometry.isFull) this.#next.release(gl, this.#geometry);
    this.isReady = true;
    return true;
  }

  /**
   * Binds the textures of a part.
   * @param {number} number
   * @param {(name: string, texture: WebGLTexture | null) => void} bind binds a texture to a sampler
   */
  bind(number, bind) {
    const { attributes, parts } = this.#geometry;
    const textureOf = (/** @type {VertexData | IndexData | undefined} */ data) => this.#shown.textures.get(data)?.texture ?? null;
    bind('indices', textureOf(parts.get(number)));
    for (const [name, sampler] of ATTRIBUTES) bind(sampler, textureOf(attributes.get(name)));
  }

  /**
   * Draws a part with the current program.
   * @param {WebGL2RenderingContext} gl
   * @param {number} number
   * @param {WebGLUniformLocation | null} topology the uniform of the mode
   */
  draw(gl, number, topology) {
    const { count = 0, mode = 0 } = this.#shown.parts.get(number) ?? {};
    const triangles = mode === 4 ? Math.floor(count / 3) : count - 2;
    if (triangles < 1) return;
    gl.uniform1i(topology, mode);
    gl.bindVertexArray(null);
    gl.drawArrays(gl.TRIANGLES, 0, 3 * triangles);
  }
}
