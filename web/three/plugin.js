/**
 * The GLTFLoader plugin for the extension `TRISTRIP_progressive`. It records which geometries draw
 * which mesh of the stream.
 *
 * `parser.associations` is not sufficient: for a file with several scenes it contains only the
 * objects of the last one.
 * @module
 */
import { EXTENSION } from '../src/container.js';
import { threeName } from './names.js';

/**
 * @import { BufferGeometry, Mesh } from 'three'
 * @import { GLTFParser } from 'three/addons/loaders/GLTFLoader.js'
 */

/**
 * A geometry that is refined by a part of a mesh of the stream.
 * @typedef {object} Refined
 * @property {BufferGeometry} geometry
 * @property {number} stream
 * @property {number} part
 * @property {string[]} names the attributes that the stream must have, by their three.js names
 */

/** @type {WeakMap<GLTFParser, ProgressivePlugin>} */
const plugins = new WeakMap();

/** Records the geometries of primitives with the extension. */
export class ProgressivePlugin {
  name = EXTENSION;
  /** @type {Map<BufferGeometry, Refined>} */
  #refined = new Map();
  #parser;

  /** @param {GLTFParser} parser */
  constructor(parser) {
    this.#parser = parser;
    plugins.set(parser, this);
  }

  /**
   * Loads a mesh as GLTFLoader does.
   * @param {number} meshIndex
   * @returns {ReturnType<GLTFParser['loadMesh']> | null}
   */
  loadMesh(meshIndex) {
    const { primitives } = this.#parser.json.meshes[meshIndex];
    if (!primitives.some((/** @type {any} */ primitive) => primitive.extensions?.[EXTENSION])) return null;
    return this.#parser.loadMesh(meshIndex).then((object) => {
      // A single primitive becomes a mesh; several become the children of a group.
      const meshes = /** @type {Mesh[]} */ (primitives.length === 1 ? [object] : object.children);
      primitives.forEach((/** @type {any} */ primitive, /** @type {number} */ i) => this.#note(primitive, meshes[i]));
      return object;
    });
  }

  /**
   * @param {any} primitive
   * @param {Mesh | undefined} mesh
   */
  #note(primitive, mesh) {
    const { stream, part = 0 } = primitive.extensions?.[EXTENSION] ?? {};
    if (!mesh?.isMesh || !Number.isSafeInteger(stream) || !Number.isSafeInteger(part) || primitive.targets) return;
    const known = this.#refined.get(mesh.geometry);
    // GLTFLoader shares the geometry of primitives with equal accessors, but each part needs its
    // own.
    if (known && (known.stream !== stream || known.part !== part)) mesh.geometry = mesh.geometry.clone();
    const names = Object.keys(primitive.attributes).map(threeName);
    this.#refined.set(mesh.geometry, { geometry: mesh.geometry, stream, part, names });
  }

  /** The geometries refined by the stream. */
  get refined() {
    return [...this.#refined.values()];
  }
}

/**
 * Returns the geometries of a parsed document that its stream refines.
 * @param {GLTFParser} parser
 * @returns {Refined[]}
 */
export function refinedGeometries(parser) {
  return plugins.get(parser)?.refined ?? [];
}

/**
 * Creates the plugin for `GLTFLoader.register`.
 * @param {GLTFParser} parser
 */
export const createPlugin = (parser) => new ProgressivePlugin(parser);
