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
import { SLICE_BYTES } from './budget.js';

/**
 * @import { Budget } from './budget.js'
 * @import { Geometry, IndexArray, IndexData, VertexData } from './geometry.js'
 */

const WIDTH = 2048;
const STRIP = 5;
const RESTART = 0xffffffff;
/** How far back the start of a strip is searched for. */
const MOST_STEPS_BACK = 2 ** 16;

/** Where a row is put together. */
const words = new Uint32Array(SLICE_BYTES / 4);
const floats = new Float32Array(words.buffer);

/** @param {IndexArray} array */
const restartOf = (array) => 2 ** (8 * array.BYTES_PER_ELEMENT) - 1;

/** A texture whose rows are uploaded as they change. */
class RowTexture {
  /** @type {WebGLTexture | null} */
  texture = null;
  #rows = 0;
  #dirty = new Uint8Array(0);
  #format;

  /** @param {'RG32UI' | 'RGB32F' | 'RGBA32F'} format */
  constructor(format) {
    this.#format = format;
  }

  /**
   * @param {number} from
   * @param {number} to
   */
  mark(from, to) {
    this.#dirty.fill(1, Math.floor(from / WIDTH), Math.ceil(to / WIDTH));
  }

  /**
   * Uploads rows that have changed, as the budget allows. Returns whether none are left.
   * @param {WebGL2RenderingContext} gl
   * @param {Budget} budget
   * @param {number} count of texels
   * @param {(from: number, to: number) => void} fill writes texels to the start of `words`
   */
  upload(gl, budget, count, fill) {
    const name = this.#format;
    const [format, type, components] = {
      RG32UI: [gl.RG_INTEGER, gl.UNSIGNED_INT, 2],
      RGB32F: [gl.RGB, gl.FLOAT, 3],
      RGBA32F: [gl.RGBA, gl.FLOAT, 4],
    }[name];
    const need = Math.max(Math.ceil(count / WIDTH), 1);
    if (need > this.#rows) {
      this.#rows = Math.min(Math.max(need, 2 * this.#rows), gl.getParameter(gl.MAX_TEXTURE_SIZE));
      gl.deleteTexture(this.texture);
      this.texture = gl.createTexture();
      gl.bindTexture(gl.TEXTURE_2D, this.texture);
      gl.texStorage2D(gl.TEXTURE_2D, 1, gl[name], WIDTH, this.#rows);
      gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.NEAREST);
      gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MAG_FILTER, gl.NEAREST);
      this.#dirty = new Uint8Array(this.#rows).fill(1);
    }
    const most = Math.floor(words.length / WIDTH / components);
    const last = Math.min(need, this.#rows);
    gl.bindTexture(gl.TEXTURE_2D, this.texture);
    for (let row = this.#dirty.indexOf(1); row >= 0 && row < last; row = this.#dirty.indexOf(1, row)) {
      if (budget.bytes === 0) return false;
      let end = row + 1;
      while (end < last && end - row < most && this.#dirty[end]) end++;
      fill(row * WIDTH, Math.min(end * WIDTH, count));
      gl.texSubImage2D(gl.TEXTURE_2D, 0, 0, row, WIDTH, end - row, format, type, name === 'RG32UI' ? words : floats, 0);
      budget.spend((end - row) * WIDTH * components * 4);
      this.#dirty.fill(0, row, end);
    }
    return true;
  }
}

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
  if (!normalized || array instanceof Float32Array) return;
  const isSigned = array instanceof Int8Array || array instanceof Int16Array;
  const most = 2 ** (8 * array.BYTES_PER_ELEMENT - (isSigned ? 1 : 0)) - 1;
  for (let i = 0; i < values.length; i++) floats[i] /= most;
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
