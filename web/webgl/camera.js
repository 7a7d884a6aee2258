/**
 * A camera that orbits a target point.
 * @module
 */
import { multiply, perspective, view } from './matrix.js';

/** @import { Matrix, Vector } from './matrix.js' */

/**
 * @typedef {object} Box
 * @property {Vector} min
 * @property {Vector} max
 */

/** The height of the view at distance 1, for a field of view of 40 degrees. */
const VIEW_HEIGHT = 2 * Math.tan((20 * Math.PI) / 180);
/** The maximum number in a view. Products of two such numbers must be finite on the GPU. */
const MAX_NUMBER = 1e15;
const MAX_PITCH = Math.PI / 2 - 0.001;
/** The initial direction of view. */
const FIRST_YAW = 0.5;
const FIRST_PITCH = 0.25;

/** @type {(x: number, least: number, most: number) => number} */
const clamp = (x, least, most) => Math.min(Math.max(x, least), most);

/** The camera. Its owner redraws after a change. */
export class Camera {
  /** The angles around the vertical axis and above the horizon, in radians. */
  yaw = FIRST_YAW;
  pitch = FIRST_PITCH;
  distance = 3;
  /** @type {Vector} */
  target = [0, 0, 0];
  /** The aspect ratio of the view, width by height. */
  aspect = 1;
  /** The centre and radius of the bounding sphere. */
  #middle = [0, 0, 0];
  #radius = 1;
  /** Whether the camera has not been moved; it then follows the bounds. */
  isAutomatic = true;

  /**
   * Sets the bounds of what is viewed.
   * @param {Box} box
   */
  set bounds({ min, max }) {
    this.#middle = min.map((least, i) => (least + max[i]) / 2);
    this.#radius = Math.hypot(...min.map((least, i) => max[i] - least)) / 2 || 1;
    if (this.isAutomatic) this.reset();
  }

  /** @param {number} aspect width by height */
  resize(aspect) {
    this.aspect = aspect;
    if (this.isAutomatic) this.reset();
  }

  /** Moves the camera so that everything is in view. */
  reset() {
    const least = Math.min(VIEW_HEIGHT, VIEW_HEIGHT * this.aspect) / 2;
    this.yaw = FIRST_YAW;
    this.pitch = FIRST_PITCH;
    this.target = [...this.#middle];
    this.isAutomatic = true;
    this.distance = (1.08 * this.#radius) / Math.sin(Math.atan(least));
  }

  /**
   * Orbits around the target.
   * @param {number} right in radians
   * @param {number} up in radians
   */
  orbit(right, up) {
    this.isAutomatic = false;
    this.yaw = (this.yaw + right) % (2 * Math.PI);
    this.pitch = clamp(this.pitch + up, -MAX_PITCH, MAX_PITCH);
  }

  /**
   * Scales the distance.
   * @param {number} factor
   */
  zoom(factor) {
    this.isAutomatic = false;
    this.distance = clamp(this.distance * factor, this.#radius / 1000, this.#radius * 100);
  }

  /**
   * Moves the target.
   * @param {number} right as a fraction of the view height
   * @param {number} up as a fraction of the view height
   */
  pan(right, up) {
    this.isAutomatic = false;
    const [x, y] = this.axes;
    const scale = this.distance * VIEW_HEIGHT;
    this.target = this.target.map((at, i) => at + scale * (x[i] * right + y[i] * up));
  }

  /**
   * The right, up and back directions.
   * @returns {Vector[]}
   */
  get axes() {
    const [sy, cy, sp, cp] = [Math.sin(this.yaw), Math.cos(this.yaw), Math.sin(this.pitch), Math.cos(this.pitch)];
    return [[cy, 0, -sy], [-sy * sp, cp, -cy * sp], [sy * cp, sp, cy * cp]];
  }

  /** @returns {Vector} */
  get eye() {
    const back = this.axes[2];
    return this.target.map((at, i) => at + this.distance * back[i]);
  }

  /** @returns {Matrix} */
  get viewProjection() {
    const { axes, eye } = this;
    const depth = this.#middle.reduce((sum, at, i) => sum + (eye[i] - at) * axes[2][i], 0);
    // Coarse models can grow a little, and animations move them.
    const reach = 2 * this.#radius;
    const far = Math.max(depth + reach, reach / 100);
    const near = Math.max(depth - reach, far / 5000);
    return multiply(perspective(VIEW_HEIGHT, this.aspect, near, far), view(axes, eye));
  }

  /** The view as text, for links. */
  toString() {
    const { yaw, pitch, distance, target } = this;
    return [yaw.toFixed(3), pitch.toFixed(3), ...[distance, ...target].map((x) => Number(x.toPrecision(5)))].join(',');
  }

  /**
   * Parses a view. Returns whether the text is valid.
   * @param {string} text
   */
  parse(text) {
    const numbers = text.split(',').map(Number);
    if (numbers.length !== 6 || !numbers.every((x) => Math.abs(x) <= MAX_NUMBER) || !(numbers[2] >= 1 / MAX_NUMBER)) return false;
    this.isAutomatic = false;
    this.yaw = numbers[0];
    this.pitch = clamp(numbers[1], -MAX_PITCH, MAX_PITCH);
    this.distance = numbers[2];
    this.target = numbers.slice(3);
    return true;
  }
}
