/**
 * The part of a progressive GLB before its stream, as a complete GLB that GLTFLoader can read while
 * the stream arrives.
 *
 * ```text
 * header │ JSON │ BIN: base meshes, textures, … │ (chunks omitted)
 * ```
 * @module
 */
import { BIN_CHUNK, CHUNK_HEADER_BYTES, EXTENSION, HEADER_BYTES, JSON_CHUNK, MAGIC } from '../src/container.js';

const VERSION = 2;
const SPACE = 0x20;

/** @param {number} byteCount */
const padded = (byteCount) => (byteCount + 3) & ~3;

/**
 * Returns a GLB with the document and the binary chunk before the stream. The buffer in the
 * document is truncated there, and the buffer view of the stream becomes empty.
 * @param {any} json the document, which is modified
 * @param {Uint8Array[]} pieces the bytes of the binary chunk before the stream, in order
 * @returns {ArrayBuffer}
 */
export function baseGlb(json, pieces) {
  const binaryBytes = pieces.reduce((sum, piece) => sum + piece.length, 0);
  const stream = json.extensions?.[EXTENSION];
  if (stream) {
    const view = json.bufferViews?.[stream.bufferView];
    if (view) Object.assign(view, { byteOffset: 0, byteLength: 0 });
    if (json.buffers?.[0]) json.buffers[0].byteLength = binaryBytes;
  }
  const text = new TextEncoder().encode(JSON.stringify(json));
  const binaryStart = HEADER_BYTES + CHUNK_HEADER_BYTES + padded(text.length);
  const hasBinary = binaryBytes > 0;
  const length = binaryStart + (hasBinary ? CHUNK_HEADER_BYTES + padded(binaryBytes) : 0);
  const bytes = new Uint8Array(length);
  const view = new DataView(bytes.buffer);
  /** @type {(at: number, ...numbers: number[]) => void} */
  const write = (at, ...numbers) => numbers.forEach((number, i) => view.setUint32(at + 4 * i, number, true));
  write(0, MAGIC, VERSION, length, padded(text.length), JSON_CHUNK);
  bytes.fill(SPACE, HEADER_BYTES + CHUNK_HEADER_BYTES, binaryStart);
  bytes.set(text, HEADER_BYTES + CHUNK_HEADER_BYTES);
  if (hasBinary) write(binaryStart, padded(binaryBytes), BIN_CHUNK);
  let at = binaryStart + CHUNK_HEADER_BYTES;
  for (const piece of pieces) {
    bytes.set(piece, at);
    at += piece.length;
  }
  return bytes.buffer;
}
