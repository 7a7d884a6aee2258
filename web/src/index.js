/**
 * Decoder for progressive meshes, which render from the first bytes and refine as the rest arrives.
 * @module
 */
export { Decoder, StreamPart } from './decoder.js';
export { StreamError } from './error.js';
export { GlbDecoder } from './glb.js';
