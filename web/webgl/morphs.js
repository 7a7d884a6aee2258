/**
 * The morph targets of a primitive, as a texture from which the vertex shader fetches the offsets
 * of each vertex.
 *
 * ```text
 * target 0: offsets of positions, of normals │ target 1: positions, normals │ …
 * ```
 *
 * Each vertex and attribute takes one texel.
 *
 * Weights belong to nodes. A frame of an animation uploads only the weights, no vertices. Targets
 * of weight 0 cost nothing.
 * @module
 */
import { unitOf } from './accessors.js';
import { floats, RowTexture } from './row_texture.js';

/**
 * @import { Accessor } from './accessors.js'
 * @import { Budget } from './budget.js'
 * @import { Program } from './programs.js'
 */

/** The attributes that targets can change, in the order of the shader's `slots`. */
export const MORPHED = ['POSITION', 'NORMAL', 'TEXCOORD_0', 'COLOR_0'];
/**
 * The maximum number of targets applied at once; the largest weights win. The shader has the same
 * constant.
 */
export const MAX_ADDED = 64;

/** The morph targets of a primitive. */
export class Morphs {
  #texture = new RowTexture('RGBA32F');
  #targets;
  /** The attributes that any target changes. */
  #names;
  #vertexCount;
  #isUploaded = false;

  /**
   * @param {Map<string, Accessor>[]} targets the offsets of each target by attribute name
   * @param {number} vertexCount
   */
  constructor(targets, vertexCount) {
    this.#targets = targets;
    this.#names = MORPHED.filter((name) => targets.some((target) => target.has(name)));
    this.#vertexCount = vertexCount;
  }

  /**
   * Uploads what the budget allows. Returns whether everything is uploaded.
   * @param {WebGL2RenderingContext} gl
   * @param {Budget} budget
   */
  upload(gl, budget) {
    const count = this.#targets.length * this.#names.length * this.#vertexCount;
    return (this.#isUploaded ||= this.#texture.upload(gl, budget, count, (from, to) => this.#fill(from, to)));
  }

  /**
   * @param {number} from
   * @param {number} to
   */
  #fill(from, to) {
    floats.fill(0, 0, 4 * (to - from));
    const names = this.#names;
    const count = this.#vertexCount;
    for (let texel = from; texel < to; ) {
      const row = Math.floor(texel / count);
      const end = Math.min((row + 1) * count, to);
      const values = this.#targets[Math.floor(row / names.length)].get(names[row % names.length]);
      if (values) {
        const { array, components } = values;
        const unit = unitOf(values);
        for (let vertex = texel - row * count, at = 4 * (texel - from), last = end - row * count; vertex < last; vertex++, at += 4) {
          for (let j = 0; j < components; j++) floats[at + j] = (array[vertex * components + j] ?? 0) / unit;
        }
      }
      texel = end;
    }
  }

  /**
   * Sets the targets and weights of a program.
   * @param {WebGL2RenderingContext} gl
   * @param {Program} program in use
   * @param {number[]} weights
   * @param {(name: string, texture: WebGLTexture | null) => void} bind binds a texture to a sampler
   */
  bind(gl, { at }, weights, bind) {
    bind('deltas', this.#texture.texture);
    const added = addedTargets(weights.slice(0, this.#targets.length));
    gl.uniform4iv(at('slots'), MORPHED.map((name) => this.#names.indexOf(name)));
    gl.uniform2i(at('targetSize'), this.#names.length, this.#vertexCount);
    gl.uniform1i(at('addedCount'), added.length);
    if (added.length > 0) gl.uniform2fv(at('added'), added.flat());
  }

  /** @param {WebGL2RenderingContext} gl */
  release(gl) {
    this.#texture.release(gl);
  }

  /** Drops the texture after a context loss. */
  forget() {
    this.#texture.forget();
    this.#isUploaded = false;
  }
}

/**
 * Returns the indices and weights of the targets to apply.
 * @param {number[]} weights
 * @returns {[number, number][]}
 */
export function addedTargets(weights) {
  const added = weights.map((weight, target) => /** @type {[number, number]} */ ([target, weight])).filter(([, weight]) => weight !== 0);
  return added.length > MAX_ADDED ? added.sort((a, b) => Math.abs(b[1]) - Math.abs(a[1])).slice(0, MAX_ADDED) : added;
}
