/**
 * The nodes of a glTF scene: transforms, skins and bounds.
 * @module
 */
import { compose, identity, multiply, transformBox } from './matrix.js';

/**
 * @import { Matrix, Vector } from './matrix.js'
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
 * @property {number[]} weights weights of the morph targets of the mesh; missing ones are 0
 * @property {number | undefined} mesh
 * @property {number | undefined} skin
 * @property {Matrix} world
 * @property {Matrix[]} instances instances of the mesh, relative to the node
 */

/**
 * The value that represents 1 in normalized integers, by component type.
 * @type {Record<number, number>}
 */
const MOST = { 5120: 127, 5121: 255, 5122: 32767, 5123: 65535 };

/** The nodes of the displayed scene. */
export class Scene {
  #json;
  /**
   * The nodes without animation.
   * @type {Map<Node, Pick<Node, 'translation' | 'rotation' | 'scale' | 'weights'>>}
   */
  #rest = new Map();
  /**
   * Parents come before their children.
   * @type {Map<number, Node>}
   */
  nodes = new Map();
  /**
   * The inverse bind matrices of skins, as they arrive.
   * @type {Map<number, ArrayLike<number>>}
   */
  bindings = new Map();
  /**
   * The boxes around meshes, cached.
   * @type {Map<string, Box | undefined>}
   */
  #boxes = new Map();
  /**
   * The nodes with animated weights.
   * @type {Set<number>}
   */
  #morphing = new Set();
  /**
   * The meshes with nonzero weights at any node.
   * @type {Set<number>}
   */
  #morphed = new Set();
  /**
   * The weights of meshes, shared by nodes.
   * @type {Map<number, number[]>}
   */
  #weights = new Map();

  /** @param {any} json */
  constructor(json) {
    this.#json = json;
    const { scene = 0, scenes, nodes = [], animations = [] } = json;
    for (const { channels = [] } of animations) {
      for (const { target } of channels) if (target?.path === 'weights') this.#morphing.add(target.node);
    }
    const roots = scenes?.[scene]?.nodes ?? [];
    /** @type {[number, Node | undefined][]} */
    const waiting = roots.map((/** @type {number} */ index) => [index, undefined]);
    // The list grows during the loop.
    for (const [index, parent] of waiting) {
      const node = nodes[index];
      // In a tree, each node occurs once.
      if (!node || this.nodes.has(index)) continue;
      const { matrix, translation = [0, 0, 0], rotation = [0, 0, 0, 1], scale = [1, 1, 1], mesh, skin, children = [] } = node;
      const weights = Array.isArray(node.weights) ? readWeights(json.meshes?.[mesh], node.weights) : this.#weightsOf(mesh);
      if (this.#morphing.has(index) || weights.some((weight) => weight !== 0)) this.#morphed.add(mesh);
      const rest = { translation, rotation, scale, weights };
      const made = { index, parent, matrix, ...rest, mesh, skin, world: identity(), instances: [identity()] };
      this.nodes.set(index, made);
      this.#rest.set(made, rest);
      for (const child of children) waiting.push([child, made]);
    }
    this.update();
  }

  /** Resets all nodes to their state without animation. Call `update` afterwards. */
  rest() {
    for (const [node, rest] of this.#rest) Object.assign(node, rest);
  }

  /** Updates the world transforms of all nodes. */
  update() {
    for (const node of this.nodes.values()) {
      const local = node.matrix ?? compose(node.translation, node.rotation, node.scale);
      node.world = node.parent ? multiply(node.parent.world, local) : local;
    }
  }

  /**
   * Returns the joint matrices of a skin, or `undefined` if it has not arrived.
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
   * @param {number} i the index of the joint in its skin
   */
  #joint(node, bindings, i) {
    const inverse = Array.from({ length: 16 }, (_, j) => bindings[16 * i + j]);
    return multiply(this.nodes.get(node)?.world ?? identity(), inverse);
  }

  /**
   * Returns the box around the mesh of a node, from the bounds of its positions and morph targets,
   * or `undefined` if they are unknown.
   * @param {Node} node
   * @returns {Box | undefined}
   */
  #boxOf(node) {
    const { index, mesh = -1 } = node;
    // Most nodes have no weights of their own and share the box of their mesh.
    const weights = this.#rest.get(node)?.weights ?? [];
    const rest = this.#known(weights === this.#weightsOf(mesh) ? `${mesh}` : `${mesh} ${index}`, () => this.#boxAt(mesh, weights));
    if (!this.#morphing.has(index)) return rest;
    // Animations usually move the weight of each target up to 1.
    const moving = this.#known(`${mesh} moving`, () => this.#boxOfTargets(mesh));
    return rest && moving && union(rest, moving);
  }

  /**
   * @param {string} key
   * @param {() => Box | undefined} compute
   */
  #known(key, compute) {
    if (!this.#boxes.has(key)) this.#boxes.set(key, compute());
    return this.#boxes.get(key);
  }

  /**
   * Returns the box around a mesh for some weights.
   * @param {number} mesh
   * @param {number[]} weights
   */
  #boxAt(mesh, weights) {
    const box = emptyBox();
    for (const { attributes, targets = [] } of this.#json.meshes?.[mesh]?.primitives ?? []) {
      const corners = this.#cornersOf(attributes.POSITION);
      if (!corners) continue;
      for (const [i, weight] of weights.entries()) add(corners, weight, this.#cornersOf(targets[i]?.POSITION));
      for (const corner of corners) include(box, corner);
    }
    return isEmpty(box) ? undefined : box;
  }

  /**
   * Returns the box around a mesh with each morph target applied separately.
   * @param {number} mesh
   */
  #boxOfTargets(mesh) {
    const box = emptyBox();
    for (const { attributes, targets = [] } of this.#json.meshes?.[mesh]?.primitives ?? []) {
      for (const { POSITION } of [{}, ...targets]) {
        const corners = this.#cornersOf(attributes.POSITION);
        if (!corners) continue;
        add(corners, 1, this.#cornersOf(POSITION));
        for (const corner of corners) include(box, corner);
      }
    }
    return isEmpty(box) ? undefined : box;
  }

  /**
   * Returns the morph-target weights of a mesh.
   * @param {number} mesh
   */
  #weightsOf(mesh) {
    let weights = this.#weights.get(mesh);
    if (!weights) this.#weights.set(mesh, (weights = readWeights(this.#json.meshes?.[mesh], this.#json.meshes?.[mesh]?.weights)));
    return weights;
  }

  /**
   * Returns whether a mesh ever has nonzero weights.
   * @param {number} mesh
   */
  isMorphed(mesh) {
    return this.#morphed.has(mesh);
  }

  /**
   * Returns the minimum and maximum of a position accessor, if declared.
   * @param {number | undefined} accessor
   * @returns {Vector[] | undefined}
   */
  #cornersOf(accessor) {
    const { min, max, normalized, componentType } = this.#json.accessors?.[accessor ?? -1] ?? {};
    const unit = normalized ? (MOST[componentType] ?? 1) : 1;
    const isKnown = [min, max].every((corner) => Array.isArray(corner) && [0, 1, 2].every((i) => Number.isFinite(corner[i])));
    return isKnown ? [min, max].map((corner) => corner.slice(0, 3).map((/** @type {number} */ x) => x / unit)) : undefined;
  }

  /**
   * The box around all meshes, from the declared bounds of their positions, or `undefined` if there
   * are none.
   * @returns {Box | undefined}
   */
  get bounds() {
    const bounds = emptyBox();
    for (const node of this.nodes.values()) {
      const { mesh, world, skin, instances } = node;
      const box = mesh === undefined ? undefined : this.#boxOf(node);
      if (!box) continue;
      // At rest, a skin moves the whole mesh approximately like its first joint.
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

/**
 * Returns morph-target weights, at most one per target. Missing ones are 0.
 * @param {any} mesh
 * @param {unknown} given
 * @returns {number[]}
 */
function readWeights(mesh, given) {
  const most = (mesh?.primitives ?? []).reduce((/** @type {number} */ count, /** @type {any} */ { targets }) => Math.max(count, targets?.length ?? 0), 0);
  return Array.isArray(given) ? given.slice(0, most).map((weight) => (Number.isFinite(weight) ? weight : 0)) : [];
}

/**
 * Adds a morph target to the corners of a box.
 * @param {Vector[]} corners the minimum and maximum
 * @param {number} weight
 * @param {Vector[] | undefined} added the minimum and maximum of the target
 */
function add(corners, weight, added) {
  if (!added) return;
  for (let j = 0; j < 3; j++) {
    const ends = added.map((corner) => weight * corner[j]);
    corners[0][j] += Math.min(...ends);
    corners[1][j] += Math.max(...ends);
  }
}

/**
 * @param {Box} a
 * @param {Box} b
 * @returns {Box}
 */
const union = (a, b) => ({ min: a.min.map((x, i) => Math.min(x, b.min[i])), max: a.max.map((x, i) => Math.max(x, b.max[i])) });

/** @returns {Box} */
const emptyBox = () => ({ min: [Infinity, Infinity, Infinity], max: [-Infinity, -Infinity, -Infinity] });

/** @param {Box} box */
const isEmpty = ({ min, max }) => !(min[0] <= max[0]);

/**
 * Extends a box by a point.
 * @param {Box} box
 * @param {number[]} point
 */
function include({ min, max }, point) {
  for (let i = 0; i < 3; i++) {
    min[i] = Math.min(min[i], point[i]);
    max[i] = Math.max(max[i], point[i]);
  }
}
