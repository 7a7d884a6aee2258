/**
 * glTF animations of nodes and of morph-target weights.
 * @module
 */

/**
 * @import { Scene } from './scene.js'
 * @import { NumberArray } from './geometry.js'
 */

/**
 * The properties that tracks animate.
 * @type {['translation', 'rotation', 'scale', 'weights']}
 */
export const PATHS = ['translation', 'rotation', 'scale', 'weights'];
/** @typedef {typeof PATHS[number]} Path */

/**
 * @typedef {object} Track
 * @property {number} node
 * @property {Path} path
 * @property {string} interpolation
 * @property {NumberArray} times
 * @property {NumberArray} values
 */

/** The keyframes of one animation. */
export class Animation {
  /** @type {Track[]} */
  tracks = [];

  /** @param {string} [name] */
  constructor(name = '') {
    this.name = name;
  }

  /** The duration in seconds; the animation then repeats. */
  get duration() {
    return this.tracks.reduce((most, { times }) => Math.max(most, times.at(-1) ?? 0), 0);
  }

  /**
   * Applies the animation to the nodes at a time.
   * @param {Scene} scene
   * @param {number} seconds
   */
  apply(scene, seconds) {
    const time = seconds % (this.duration || 1);
    for (const track of this.tracks) {
      const node = scene.nodes.get(track.node);
      if (!node || track.times.length === 0) continue;
      node[track.path] = sample(track, time, sizeOf(track));
    }
  }
}

/**
 * Returns the number of components of a value of a track.
 * @param {Track} track
 */
function sizeOf({ path, interpolation, times, values }) {
  if (path !== 'weights') return path === 'rotation' ? 4 : 3;
  return Math.floor(values.length / times.length / (interpolation === 'CUBICSPLINE' ? 3 : 1));
}

/**
 * Returns the value of a track at a time.
 * @param {Track} track
 * @param {number} time
 * @param {number} size its number of components
 * @returns {number[]}
 */
function sample({ path, interpolation, times, values }, time, size) {
  const finish = path === 'rotation' ? unit : (/** @type {number[]} */ value) => value;
  const isSpline = interpolation === 'CUBICSPLINE';
  const last = times.length - 1;
  let [low, high] = [0, last];
  while (low < high) {
    const middle = (low + high + 1) >> 1;
    if (times[middle] <= time) low = middle;
    else high = middle - 1;
  }
  // A cubic spline stores an in-tangent, a value and an out-tangent per key.
  const at = (/** @type {number} */ key, shift = isSpline ? size : 0) => Array.from({ length: size }, (_, j) => values[key * size * (isSpline ? 3 : 1) + shift + j] ?? 0);
  const a = at(low);
  if (low === last || time <= times[0] || interpolation === 'STEP') return a;
  const length = times[low + 1] - times[low];
  const t = (time - times[low]) / length;
  const b = at(low + 1);
  if (isSpline) {
    const [p, q] = [at(low, 2 * size), at(low + 1, 0)];
    const [t2, t3] = [t * t, t * t * t];
    return finish(a.map((x, j) => (2 * t3 - 3 * t2 + 1) * x + length * (t3 - 2 * t2 + t) * p[j] + (3 * t2 - 2 * t3) * b[j] + length * (t3 - t2) * q[j]));
  }
  // Interpolates along the shorter path. Keyframes are close enough for linear interpolation.
  const sign = path === 'rotation' && a.reduce((sum, x, j) => sum + x * b[j], 0) < 0 ? -1 : 1;
  return finish(a.map((x, j) => x + t * (sign * b[j] - x)));
}

/** @param {number[]} value */
function unit(value) {
  const length = Math.hypot(...value) || 1;
  return value.map((x) => x / length);
}
