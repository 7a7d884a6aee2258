/**
 * Decodes a mesh of random bytes, so that the browser compiles the decoder before the first model
 * arrives. Compilation takes as long as decoding the bunny.
 *
 * Random bytes decode to some mesh. These are a base mesh and one chunk that declares more than it
 * contains; the decoder rejects it after using all of it.
 * @module
 */
import { Checksum } from '../chunk.js';
import { Decoder } from '../decoder.js';
import { StreamError } from '../error.js';
import { Random } from '../paths.js';
import { Strips } from '../strips.js';
import { MeshBuffers } from './mesh_buffers.js';

/**
 * The sizes in bytes of both chunks, random except for the header of the base mesh, and the
 * triangles of the base mesh. 5000 bytes save a third of the time for the first model; 20,000 save
 * no more.
 */
const BASE_BYTES = 400;
const BYTES = 5000;
const BASE_TRIANGLES = 12;
/** The number of random values to skip; the first ones would not yield a valid base mesh. */
const SKIPPED = 1;
/** The counts declared by the header of the refinement. */
const MOST = 2 ** 20;
/**
 * The header of the base mesh: bits per coordinate and unknown bits; grid origin and step as
 * floats; triangles, levels, triangles, vertices and attributes.
 */
const BASE_HEAD = [14, 4, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 128, 63, BASE_TRIANGLES, 0, 0, 0, 0];

/**
 * Encodes a number as in the header of a chunk.
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
 * Decodes the mesh and builds its buffers.
 * @returns {number} the triangle count
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
