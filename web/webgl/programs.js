/**
 * Shader programs, compiled asynchronously if the browser supports it.
 * @module
 */
import { TEXTURES } from './materials.js';
import { FRAGMENT, shaderSource, VERTEX } from './shaders.js';

/**
 * @typedef {object} Program
 * @property {WebGLProgram} program
 * @property {(name: string) => WebGLUniformLocation | null} at the location of a uniform
 */

/** The samplers in the order of their texture units. */
const SAMPLERS = [...TEXTURES, 'joints', 'indices', 'positions', 'jointNumbers', 'jointWeights', 'deltas'];
export const UNITS = new Map(SAMPLERS.map((name, unit) => [name, unit]));

/** The variants that most models need. Others are compiled on demand. */
const VARIANTS = ['', 'NORMALS', 'NORMALS SKIN', 'SKIN', 'PULL', 'PULL SKIN'];

/** All program variants. */
export class Programs {
  #gl;
  #parallel;
  /** @type {Map<string, { program: WebGLProgram, shaders: WebGLShader[], isNew: boolean, ready?: Program }>} */
  #programs = new Map();

  /** @param {WebGL2RenderingContext} gl */
  constructor(gl) {
    this.#gl = gl;
    this.#parallel = gl.getExtension('KHR_parallel_shader_compile');
  }

  /**
   * Returns a variant, or `undefined` while it is being compiled.
   * @param {string} name
   * @returns {Program | undefined}
   */
  get(name) {
    const known = this.#programs.get(name) ?? this.#compile(name);
    // Compilation has just started; a query would block.
    if (known.isNew && this.#parallel) {
      known.isNew = false;
      return undefined;
    }
    if (known.ready) return known.ready;
    const gl = this.#gl;
    const { program, shaders } = known;
    if (this.#parallel && !gl.isContextLost() && !gl.getProgramParameter(program, this.#parallel.COMPLETION_STATUS_KHR)) return undefined;
    if (!gl.getProgramParameter(program, gl.LINK_STATUS)) {
      if (gl.isContextLost()) return undefined;
      throw new Error(`The shader ${name} does not compile: ${shaders.map((shader) => gl.getShaderInfoLog(shader)).join('')}${gl.getProgramInfoLog(program)}`);
    }
    for (const shader of shaders) gl.deleteShader(shader);
    /** @type {Map<string, WebGLUniformLocation | null>} */
    const locations = new Map();
    const at = (/** @type {string} */ uniform) => {
      let location = locations.get(uniform);
      if (location === undefined) locations.set(uniform, (location = gl.getUniformLocation(program, uniform)));
      return location;
    };
    gl.useProgram(program);
    for (const [unit, sampler] of SAMPLERS.entries()) gl.uniform1i(gl.getUniformLocation(program, sampler), unit);
    return (known.ready = { program, at });
  }

  /**
   * Continues to prepare the common variants, one at a time if compilation blocks. Returns whether
   * all are ready.
   */
  prepare() {
    if (this.#gl.isContextLost()) return true;
    const names = VARIANTS.filter((name) => !this.#programs.get(name)?.ready);
    for (const name of this.#parallel ? names : names.slice(0, 1)) this.get(name);
    return names.length === 0;
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
    /** @type {{ program: WebGLProgram, shaders: WebGLShader[], isNew: boolean, ready?: Program }} */
    const made = { program, shaders, isNew: true };
    this.#programs.set(name, made);
    return made;
  }
}
