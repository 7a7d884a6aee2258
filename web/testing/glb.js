import { vectors } from './vectors.js';

/** A stream of two meshes. */
export const [MESHES] = vectors().filter(({ name }) => name === 'meshes');

const { bytes: stream } = MESHES;

/** The document of a file with this stream after some bytes of base meshes. */
export function document() {
  return {
    asset: { version: '2.0' },
    extensionsUsed: ['TRISTRIP_progressive'],
    extensions: { TRISTRIP_progressive: { version: 1, bufferView: 1 } },
    buffers: [{ byteLength: 40 + stream.length }],
    bufferViews: [
      { buffer: 0, byteLength: 40 },
      { buffer: 0, byteOffset: 40, byteLength: stream.length },
    ],
    meshes: [0, 1].map((number) => ({ primitives: [{ attributes: {}, extensions: { TRISTRIP_progressive: { stream: number } } }] })),
  };
}

/**
 * Returns a file with this stream.
 * @param {any} json
 */
export function glb(json, { magic = 0x46546c67, type = 0x004e4942, padding = 3 } = {}) {
  const text = new TextEncoder().encode(typeof json === 'string' ? json : JSON.stringify(json));
  const bin = 40 + stream.length + padding;
  const bytes = new Uint8Array(28 + text.length + bin);
  const view = new DataView(bytes.buffer);
  [magic, 2, bytes.length, text.length, 0x4e4f534a].forEach((word, i) => view.setUint32(4 * i, word, true));
  bytes.set(text, 20);
  view.setUint32(20 + text.length, bin, true);
  view.setUint32(24 + text.length, type, true);
  bytes.set(stream, 68 + text.length);
  return bytes;
}
