/**
 * Textures of the vertices and indices of a mesh, from which a vertex shader fetches the corners of each triangle: for wireframe, and for a colour per strip.
 *
 * ```text
 * index texture: index, start of its strip │ index, start │ …        position k of the buffer is texel (k mod 2048, k / 2048)
 * vertex texture: x, y, z │ x, y, z │ …                              so is vertex k
 * ```
 *
 * There are two sets of them. While one is drawn, rows of the other one that have changed are uploaded, over several frames if they are many.
 * @module
 */
import { unitOf } from './accessors.js';
import { floats, RowTexture, words } from './row_texture.js';

/**
 * @import { Budget } from './budget.js'
 * @import { Geometry, IndexArray, IndexData, VertexData } from './geometry.js'
 */

const STRIP = 5;
const RESTART = 0xffffffff;
/** How far back the start of a strip is searched for. */
const MOST_STEPS_BACK = 2 ** 16;

/** @param {IndexArray} array */
const restartOf = (array) => 2 ** (8 * array.BYTES_PER_ELEMENT) - 1;

/** A set of textures that belong together. */
class Snapshot {
  isDirty = true;
  positions = new RowTexture('RGB32F');
  joints = new RowTexture('RGBA32F');
  weights = new RowTexture('RGBA32F');
  /** @type {Map<number, { texture: RowTexture, count: number, mode: number }>} */
  parts = new Map();

  /** @param {number} number */
  part(number) {
    let part = this.parts.get(number);
    if (!part) this.parts.set(number, (part = { texture: new RowTexture('RG32UI'), count: 0, mode: 0 }));
    return part;
  }

  /**
   * @param {WebGL2RenderingContext} gl
   * @param {Geometry} geometry
   * @param {Budget} budget
   */
  upload(gl, { attributes, parts }, budget) {
    for (const [name, texture] of /** @type {[string, RowTexture][]} */ ([['POSITION', this.positions], ['JOINTS_0', this.joints], ['WEIGHTS_0', this.weights]])) {
      const data = attributes.get(name);
      if (data && !texture.upload(gl, budget, data.array.length / data.components, (from, to) => fillVertices(data, from, to))) return false;
    }
    for (const [number, data] of parts) {
      const part = this.part(number);
      if (!part.texture.upload(gl, budget, data.length, (from, to) => fillIndices(data, from, to))) return false;
      part.count = data.length;
      part.mode = data.mode;
    }
    this.isDirty = false;
    return true;
  }

  /** @param {WebGL2RenderingContext} gl */
  release(gl) {
    for (const { texture } of [this.positions, this.joints, this.weights, ...[...this.parts.values()].map((part) => part.texture)]) gl.deleteTexture(texture);
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
    const least = Math.max(from - MOST_STEPS_BACK, 0);
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
  #shown = new Snapshot();
  #next = new Snapshot();
  /** Whether there is something to draw. */
  isReady = false;

  /** @param {Geometry} geometry */
  constructor(geometry) {
    this.#geometry = geometry;
  }

  /**
   * Notes vertices that change.
   * @param {number} from
   * @param {number} to
   */
  markVertices(from, to) {
    for (const snapshot of [this.#shown, this.#next]) {
      for (const texture of [snapshot.positions, snapshot.joints, snapshot.weights]) texture.mark(from, to);
      snapshot.isDirty = true;
    }
  }

  /**
   * Notes indices that have changed, with those behind them in the same strip.
   * @param {number} number of the part
   * @param {IndexData} data
   * @param {number} from
   * @param {number} to
   */
  markIndices(number, { array, length }, from, to) {
    const restart = array && restartOf(array);
    let end = to;
    while (array && end < length && array[end] !== restart) end++;
    for (const snapshot of [this.#shown, this.#next]) {
      snapshot.part(number).texture.mark(from, end);
      snapshot.isDirty = true;
    }
  }

  /**
   * Uploads what the budget allows. Returns whether all is drawn from now on.
   * @param {WebGL2RenderingContext} gl
   * @param {Budget} budget
   */
  upload(gl, budget) {
    if (!this.#shown.isDirty) return true;
    if (!this.#next.upload(gl, this.#geometry, budget)) return false;
    [this.#shown, this.#next] = [this.#next, this.#shown];
    this.isReady = true;
    return true;
  }

  /**
   * Binds the textures of a part.
   * @param {number} number
   * @param {(name: string, texture: WebGLTexture | null) => void} bind binds a texture to a sampler
   */
  bind(number, bind) {
    const { positions, joints, weights, parts } = this.#shown;
    bind('indices', parts.get(number)?.texture.texture ?? null);
    bind('positions', positions.texture);
    bind('jointNumbers', joints.texture);
    bind('jointWeights', weights.texture);
  }

  /**
   * Draws a part with the program in use.
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

  /** @param {WebGL2RenderingContext} gl */
  release(gl) {
    this.#shown.release(gl);
    this.#next.release(gl);
  }
}
