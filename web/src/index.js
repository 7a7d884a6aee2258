/**
 * Decodes meshes that are drawn after their first bytes and refined by the others.
 * @module
 */
export { Decoder, StreamPart } from './decoder.js';
export { StreamError } from './error.js';
export { GlbDecoder } from './glb.js';
