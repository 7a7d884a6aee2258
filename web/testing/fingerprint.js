import { Checksum } from '../src/chunk.js';
import { FAN_CELLS, VERTEX } from '../src/fans.js';

/**
 * Returns a checksum of the current mesh: the CRC-32 of the vertices of the triangles, then of the
 * grid positions of the vertices, then of the integers of each attribute, all as 32-bit
 * little-endian numbers. Conforming decoders return the same value after each chunk.
 * @param {import('../src/decoder.js').StreamPart} part
 * @returns {number}
 */
export function fingerprint(part) {
  const { fans } = part.internals.refiner;
  const checksum = new Checksum();
  const places = new Int32Array(3 * fans.vertexCount);
  for (let at = 0; at < FAN_CELLS * fans.count; at += FAN_CELLS) {
    for (let j = 0; j < 3; j++) places[3 * fans.cells[at + VERTEX] + j] = fans.cells[at + j];
  }
  for (const vertex of part.triangles()) checksum.addNumber(vertex);
  for (const step of places) checksum.addNumber(step);
  for (const { model } of part.internals.head.channels) {
    for (const value of model.values.subarray(0, model.width * fans.vertexCount)) checksum.addNumber(value);
  }
  return checksum.value;
}
