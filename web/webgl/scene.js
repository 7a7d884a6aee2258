/**
 * The nodes of a glTF scene: where meshes stand, and how skins are bent.
 * @module
 */
import { compose, identity, multiply, transformBox } from './matrix.js';

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
  /** The boxes around meshes, as they are asked for.
   * @type {Map<number, Box | undefined>} */
  #boxes = new Map();

  /** @param {any} json */
  constructor(json) {
    this.#json = json;
    const { scene = 0, scenes, nodes = [] } = json;
    const roots = scenes?.[scene]?.nodes ?? [];
    /** @type {[number, Node | undefined][]} */
    const waiting = roots.map((/** @type {number} */ index) => [index, undefined]);
    // The list grows meanwhile.
    for (const [index, parent] of waiting) {
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
    for (const [i, joint] of joints.entries()) matrices.set(this.#joint(joint, bindings, i), 16 * i);
    return matrices;
  }

  /**
   * @param {number} node
   * @param {ArrayLike<number>} bindings
   * @param {number} i the number of the joint in its skin
   */
  #joint(node, bindings, i) {
    const inverse = Array.from({ length: 16 }, (_, j) => bindings[16 * i + j]);
    return multiply(this.nodes.get(node)?.world ?? identity(), inverse);
  }

  /**
   * Returns the box around a mesh, from the bounds of its positions; `undefined` if there are none.
   * @param {number} mesh
   * @returns {Box | undefined}
   */
  #boxOf(mesh) {
    if (this.#boxes.has(mesh)) return this.#boxes.get(mesh);
    const box = emptyBox();
    for (const primitive of this.#json.meshes?.[mesh]?.primitives ?? []) {
      const { min, max, normalized, componentType } = this.#json.accessors?.[primitive.attributes.POSITION] ?? {};
      const unit = normalized ? (MOST[componentType] ?? 1) : 1;
      const isKnown = [min, max].every((corner) => Array.isArray(corner) && [0, 1, 2].every((i) => Number.isFinite(corner[i])));
      if (isKnown) for (const corner of [min, max]) include(box, corner.map((/** @type {number} */ x) => x / unit));
    }
    const known = isEmpty(box) ? undefined : box;
    this.#boxes.set(mesh, known);
    return known;
  }

  /** The box around all meshes, from the bounds of their positions; `undefined` if there are none.
   * @returns {Box | undefined} */
  get bounds() {
    const bounds = emptyBox();
    for (const { mesh, world, skin, instances } of this.nodes.values()) {
      const box = mesh === undefined ? undefined : this.#boxOf(mesh);
      if (!box) continue;
      // A skin at rest moves all of a mesh about as its first joint.
      const bindings = skin === undefined ? undefined : this.bindings.get(skin);
      const matrices = bindings ? [this.#joint(this.#json.skins[skin ?? 0].joints[0], bindings, 0)] : instances.map((instance) => multiply(world, instance));
      for (const matrix of matrices) {
        const { min, max } = transformBox(matrix, box);
        include(bounds, min);
        include(bounds, max);
      }
    }
    return isEmpty(bounds) ? undefined : bounds;
  }
}

/** @returns {Box} */
const emptyBox = () => ({ min: [Infinity, Infinity, Infinity], max: [-Infinity, -Infinity, -Infinity] });

/** @param {Box} box */
const isEmpty = ({ min, max }) => !(min[0] <= max[0]);

/**
 * Grows a box by a point.
 * @param {Box} box
 * @param {number[]} point
 */
function include({ min, max }, point) {
  for (let i = 0; i < 3; i++) {
    min[i] = Math.min(min[i], point[i]);
    max[i] = Math.max(max[i], point[i]);
  }
}
