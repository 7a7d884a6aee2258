/**
 * Shader programs, which are compiled beside the main thread where the browser can.
 * @module
 */
import { FRAGMENT, shaderSource, VERTEX } from './shaders.js';

/**
 * @typedef {object} Program
 * @property {WebGLProgram} program
 * @property {(name: string) => WebGLUniformLocation | null} at the location of a uniform
 */

const VARIANTS = ['', 'NORMALS', 'NORMALS SKIN', 'SKIN', 'PULL', 'PULL SKIN'];

/** All variants of the program. */
export class Programs {
  #gl;
  #parallel;
  /** @type {Map<string, { program: WebGLProgram, shaders: WebGLShader[], ready?: Program }>} */
  #programs = new Map();

  /** @param {WebGL2RenderingContext} gl */
  constructor(gl) {
    this.#gl = gl;
    this.#parallel = gl.getExtension('KHR_parallel_shader_compile');
  }

  /**
   * Returns a variant, or `undefined` while it is compiled.
   * @param {string} name
   * @returns {Program | undefined}
   */
  get(name) {
    const known = this.#programs.get(name) ?? this.#compile(name);
    if (known.ready) return known.ready;
    const gl = this.#gl;
    const { program, shaders } = known;
    if (this.#parallel && !gl.isContextLost() && !gl.getProgramParameter(program, this.#parallel.COMPLETION_STATUS_KHR)) return undefined;
    if (!gl.getProgramParameter(program, gl.LINK_STATUS)) {
      if (gl.isContextLost()) return undefined;
      throw new Error(`The shader ${name} is refused: ${shaders.map((shader) => gl.getShaderInfoLog(shader)).join('')}${gl.getProgramInfoLog(program)}`);
    }
    for (const shader of shaders) gl.deleteShader(shader);
    /** @type {Map<string, WebGLUniformLocation | null>} */
    const locations = new Map();
    const at = (/** @type {string} */ uniform) => {
      let location = locations.get(uniform);
      if (location === undefined) locations.set(uniform, (location = gl.getUniformLocation(program, uniform)));
      return location;
    };
    return (known.ready = { program, at });
  }

  /** Begins to compile what will be needed. */
  prepare() {
    for (const name of VARIANTS) this.#programs.get(name) ?? this.#compile(name);
  }

  /** @param {string} name */
  #compile(name) {
    const gl = this.#gl;
    const program = gl.createProgram();
    const defines = name.split(' ').filter(Boolean);
    const sources = /** @type {[number, string][]} */ ([[gl.VERTEX_SHADER, VERTEX], [gl.FRAGMENT_SHADER, FRAGMENT]]);
    const shaders = sources.map(([type, source]) => {
      const shader = /** @type {WebGLShader} */ (gl.createShader(type));
      gl.shaderSource(shader, shaderSource(source, defines));
      gl.compileShader(shader);
      gl.attachShader(program, shader);
      return shader;
    });
    gl.linkProgram(program);
    /** @type {{ program: WebGLProgram, shaders: WebGLShader[], ready?: Program }} */
    const made = { program, shaders };
    this.#programs.set(name, made);
    return made;
  }
}
