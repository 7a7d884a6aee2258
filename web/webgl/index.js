/**
 * WebGL 2 renderer for progressive models.
 * @module
 */
export { UnsupportedError } from './accessors.js';
export { Camera } from './camera.js';
export { moveByKey, orbitByPointer } from './orbit.js';
export { MODES, Renderer } from './renderer.js';
