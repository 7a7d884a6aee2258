/**
 * Decodes a mesh of random bytes, so that the browser has compiled the decoder before the first model comes: that takes as long as decoding the bunny.
 *
 * Any bytes build some mesh. These are a base mesh and one chunk, which claims more than it has: the decoder refuses it when it has used all of it.
 * @module
 */
import { Checksum } from '../chunk.js';
import { Decoder } from '../decoder.js';
import { StreamError } from '../error.js';
import { Random } from '../paths.js';
import { Strips } from '../strips.js';
import { MeshBuffers } from './mesh_buffers.js';

/** The bytes of the two chunks, random but for the head of the base mesh, and its triangles. 5000 bytes save a third of the time of the first model, and 20,000 no more. */
const BASE_BYTES = 400;
const BYTES = 5000;
const BASE_TRIANGLES = 12;
/** The first random numbers, with which the base mesh would not be one. */
const SKIPPED = 1;
/** What the head of the refinement claims. */
const MOST = 2 ** 20;
/** Bits of a coordinate, and those that are unknown at first; origin and step of the grid as floats; triangles, levels, triangles, vertices and attributes. */
const BASE_HEAD = [14, 4, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 128, 63, BASE_TRIANGLES, 0, 0, 0, 0];

/**
 * Writes a number as the head of a chunk has it.
 * @param {number} number
 */
function* digits(number) {
  for (; number > 127; number >>>= 7) yield (number & 127) | 128;
  yield number;
}

/**
 * Returns a chunk of the only mesh.
 * @param {Uint8Array} payload
 * @param {number} visits
 * @param {number} level
 * @param {number} triangles
 */
function chunkOf(payload, visits, level, triangles) {
  const head = [0, payload.length, visits, level, triangles].flatMap((number) => [...digits(number)]);
  const chunk = Uint8Array.from([...head, 0, 0, 0, 0, 0, 0, 0, 0, ...payload]);
  const checksum = new Checksum();
  checksum.addBytes(chunk.subarray(0, head.length + 4));
  checksum.addBytes(payload);
  new DataView(chunk.buffer).setUint32(head.length + 4, checksum.value, true);
  return chunk;
}

/**
 * Decodes the mesh, and builds its buffers.
 * @returns {number} its triangles
 */
export function warmUp() {
  const random = new Random();
  const bytes = (/** @type {number} */ count) => Uint8Array.from({ length: count }, () => random.below(256));
  const decoder = new Decoder({ strips: Strips, isLazy: true });
  for (let i = 0; i < SKIPPED; i++) random.next();
  const base = bytes(BASE_BYTES);
  base.set(BASE_HEAD);
  decoder.update(chunkOf(base, 0, 0, BASE_TRIANGLES));
  const part = decoder.parts[0];
  const buffers = new MeshBuffers(0, undefined, 'strips');
  buffers.update(part, false);
  try {
    decoder.update(chunkOf(bytes(BYTES), MOST, MOST, MOST));
  } catch (error) {
    if (!(error instanceof StreamError)) throw error;
  }
  buffers.update(part, true);
  return part.triangleCount;
}
