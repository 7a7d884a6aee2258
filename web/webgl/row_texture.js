/**
 * Textures that store arrays for vertex shaders, 2048 values per row. Changed rows are uploaded.
 * @module
 */
import { SLICE_BYTES } from './budget.js';

/** @import { Budget } from './budget.js' */

export const WIDTH = 2048;

/** The buffer in which rows are assembled, as integers and as floats. */
export const words = new Uint32Array(SLICE_BYTES / 4);
export const floats = new Float32Array(words.buffer);

/** A texture with incremental uploads per row. */
export class RowTexture {
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
   * Uploads changed rows within the budget. Returns whether everything is uploaded.
   * @param {WebGL2RenderingContext} gl
   * @param {Budget} budget
   * @param {number} count the number of texels
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

  /** @param {WebGL2RenderingContext} gl */
  release(gl) {
    gl.deleteTexture(this.texture);
    this.forget();
  }

  /** Drops the texture; `upload` creates a new one. */
  forget() {
    this.texture = null;
    this.#rows = 0;
  }
}
