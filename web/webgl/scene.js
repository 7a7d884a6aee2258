/**
 * The nodes of a glTF scene: where meshes stand, and how skins are bent.
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
 * @property {number[]} weights those of the morph targets of the mesh; those that are left out are 0
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
  /** How nodes are before an animation moves them. @type {Map<Node, Pick<Node, 'translation' | 'rotation' | 'scale' | 'weights'>>} */
  #rest = new Map();
  /** @type {Map<number, Node>} parents come before their children */
  nodes = new Map();
  /** The inverse bind matrices of skins, as they arrive.
   * @type {Map<number, ArrayLike<number>>} */
  bindings = new Map();
  /** The boxes around meshes, as they are asked for.
   * @type {Map<string, Box | undefined>} */
  #boxes = new Map();
  /** The nodes whose weights an animation moves. @type {Set<number>} */
  #morphing = new Set();
  /** The meshes of which targets are added by some node. @type {Set<number>} */
  #morphed = new Set();
  /** The weights of meshes, which nodes share. @type {Map<number, number[]>} */
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
    // The list grows meanwhile.
    for (const [index, parent] of waiting) {
      const node = nodes[index];
      // In a tree each node comes once.
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

  /** Moves all nodes to where they are without an animation; `update` follows. */
  rest() {
    for (const [node, rest] of this.#rest) Object.assign(node, rest);
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
   * Returns the box around the mesh of a node, from the bounds of its positions and morph targets; `undefined` if there are none.
   * @param {Node} node
   * @returns {Box | undefined}
   */
  #boxOf(node) {
    const { index, mesh = -1 } = node;
    // Most nodes have no weights of their own, and share the box of their mesh.
    const weights = this.#rest.get(node)?.weights ?? [];
    const rest = this.#known(weights === this.#weightsOf(mesh) ? `${mesh}` : `${mesh} ${index}`, () => this.#boxAt(mesh, weights));
    if (!this.#morphing.has(index)) return rest;
    // An animation of weights moves each target to 1, as a rule.
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
   * Returns the box around a mesh at some weights.
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
   * Returns the box around a mesh with each of its morph targets alone.
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
   * Returns the weights of the morph targets of a mesh.
   * @param {number} mesh
   */
  #weightsOf(mesh) {
    let weights = this.#weights.get(mesh);
    if (!weights) this.#weights.set(mesh, (weights = readWeights(this.#json.meshes?.[mesh], this.#json.meshes?.[mesh]?.weights)));
    return weights;
  }

  /**
   * Returns whether morph targets of a mesh are ever added.
   * @param {number} mesh
   */
  isMorphed(mesh) {
    return this.#morphed.has(mesh);
  }

  /**
   * Returns the least and the largest values of an accessor of points, if it tells them.
   * @param {number | undefined} accessor
   * @returns {Vector[] | undefined}
   */
  #cornersOf(accessor) {
    const { min, max, normalized, componentType } = this.#json.accessors?.[accessor ?? -1] ?? {};
    const unit = normalized ? (MOST[componentType] ?? 1) : 1;
    const isKnown = [min, max].every((corner) => Array.isArray(corner) && [0, 1, 2].every((i) => Number.isFinite(corner[i])));
    return isKnown ? [min, max].map((corner) => corner.slice(0, 3).map((/** @type {number} */ x) => x / unit)) : undefined;
  }

  /** The box around all meshes, from the bounds of their positions; `undefined` if there are none.
   * @returns {Box | undefined} */
  get bounds() {
    const bounds = emptyBox();
    for (const node of this.nodes.values()) {
      const { mesh, world, skin, instances } = node;
      const box = mesh === undefined ? undefined : this.#boxOf(node);
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

/**
 * Returns weights of morph targets, at most as many as there are targets; others are 0.
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
 * @param {Vector[]} corners the least and the largest one
 * @param {number} weight
 * @param {Vector[] | undefined} added those of the target
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
