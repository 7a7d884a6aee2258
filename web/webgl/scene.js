/**
 * The nodes of a glTF scene: where meshes stand, and how skins are bent.
 * @module
 */
import { compose, identity, multiply, transformPoint } from './matrix.js';

/**
 * @import { Matrix } from './matrix.js'
 * @import { Box } from './camera.js'
 */

/**
 * @typedef {object} Node
 * @property {number} index
 * @property {Node | undefined} parent
 * @property {Matrix | undefined} matrix
 * @property {number[]} translation
 * @property {number[]} rotation
 * @property {number[]} scale
 * @property {number | undefined} mesh
 * @property {number | undefined} skin
 * @property {Matrix} world
 * @property {Matrix[]} instances those of the mesh, relative to the node
 */

/** What is 1 in normalized integers, by their type.
 * @type {Record<number, number>} */
const MOST = { 5120: 127, 5121: 255, 5122: 32767, 5123: 65535 };

/** The nodes of the scene that is shown. */
export class Scene {
  #json;
  /** @type {Map<number, Node>} parents come before their children */
  nodes = new Map();
  /** The inverse bind matrices of skins, as they arrive.
   * @type {Map<number, ArrayLike<number>>} */
  bindings = new Map();

  /** @param {any} json */
  constructor(json) {
    this.#json = json;
    const { scene = 0, scenes, nodes = [] } = json;
    const roots = scenes?.[scene]?.nodes ?? [];
    /** @type {[number, Node | undefined][]} */
    const waiting = roots.map((/** @type {number} */ index) => [index, undefined]);
    for (let next; (next = waiting.shift()); ) {
      const [index, parent] = next;
      const node = nodes[index];
      // In a tree each node comes once.
      if (!node || this.nodes.has(index)) continue;
      const { matrix, translation = [0, 0, 0], rotation = [0, 0, 0, 1], scale = [1, 1, 1], mesh, skin, children = [] } = node;
      const made = { index, parent, matrix, translation, rotation, scale, mesh, skin, world: identity(), instances: [identity()] };
      this.nodes.set(index, made);
      for (const child of children) waiting.push([child, made]);
    }
    this.update();
  }

  /** Computes where all nodes are. */
  update() {
    for (const node of this.nodes.values()) {
      const local = node.matrix ?? compose(node.translation, node.rotation, node.scale);
      node.world = node.parent ? multiply(node.parent.world, local) : local;
    }
  }

  /**
   * Returns the matrices of the joints of a skin, or `undefined` if it has not arrived.
   * @param {number | undefined} skin
   * @returns {Float32Array | undefined}
   */
  joints(skin) {
    const bindings = skin === undefined ? undefined : this.bindings.get(skin);
    if (!bindings) return undefined;
    /** @type {number[]} */
    const joints = this.#json.skins[skin ?? 0].joints;
    const matrices = new Float32Array(16 * joints.length);
    for (const [i, joint] of joints.entries()) {
      const inverse = Array.from({ length: 16 }, (_, j) => bindings[16 * i + j]);
      matrices.set(multiply(this.nodes.get(joint)?.world ?? identity(), inverse), 16 * i);
    }
    return matrices;
  }

  /** The box around all meshes, from the bounds of their positions; `undefined` if there are none.
   * @returns {Box | undefined} */
  get bounds() {
    const min = [Infinity, Infinity, Infinity];
    const max = [-Infinity, -Infinity, -Infinity];
    for (const { mesh, world, skin, instances } of this.nodes.values()) {
      if (mesh === undefined) continue;
      // A skin at rest moves all of a mesh about as its first joint.
      const first = this.joints(skin)?.slice(0, 16);
      for (const primitive of this.#json.meshes?.[mesh]?.primitives ?? []) {
        const bounds = this.#json.accessors?.[primitive.attributes.POSITION];
        if (!bounds?.min || !bounds.max) continue;
        const unit = bounds.normalized ? (MOST[bounds.componentType] ?? 1) : 1;
        for (const instance of instances) {
          const matrix = first ? Array.from(first) : multiply(world, instance);
          for (let corner = 0; corner < 8; corner++) {
            const at = transformPoint(matrix, [0, 1, 2].map((i) => (corner & (1 << i) ? bounds.max : bounds.min)[i] / unit));
            for (let i = 0; i < 3; i++) {
              min[i] = Math.min(min[i], at[i]);
              max[i] = Math.max(max[i], at[i]);
            }
          }
        }
      }
    }
    return min[0] <= max[0] ? { min, max } : undefined;
  }
}
