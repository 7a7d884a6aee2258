/**
 * Small GLB files for tests, built from a document and arrays.
 * @module
 */

/** @param {number} byteCount */
const padded = (byteCount) => (byteCount + 3) & ~3;

/**
 * Returns the bytes of a GLB. Each array becomes the buffer view with the same index.
 * @param {any} json without buffers and buffer views
 * @param {ArrayBufferView[]} arrays
 */
export function sceneGlb(json, arrays) {
  let end = 0;
  const bufferViews = arrays.map(({ byteLength }) => {
    const byteOffset = end;
    end += padded(byteLength);
    return { buffer: 0, byteOffset, byteLength };
  });
  const binary = new Uint8Array(end);
  for (const [i, { buffer, byteOffset, byteLength }] of arrays.entries()) {
    binary.set(new Uint8Array(buffer, byteOffset, byteLength), bufferViews[i].byteOffset);
  }
  return writeGlb({ asset: { version: '2.0' }, buffers: [{ byteLength: end }], bufferViews, ...json }, binary);
}

/**
 * Returns the bytes of a GLB.
 * @param {any} json
 * @param {Uint8Array} binary
 */
export function writeGlb(json, binary) {
  const text = new TextEncoder().encode(JSON.stringify(json));
  const start = 20 + padded(text.length);
  const length = padded(binary.length);
  const bytes = new Uint8Array(start + 8 + length).fill(0x20, 0, start);
  const view = new DataView(bytes.buffer);
  [0x46546c67, 2, bytes.length, padded(text.length), 0x4e4f534a].forEach((word, i) => view.setUint32(4 * i, word, true));
  bytes.set(text, 20);
  view.setUint32(start, length, true);
  view.setUint32(start + 4, 0x004e4942, true);
  bytes.set(binary, start + 8);
  return bytes;
}

/**
 * Returns the document and the binary chunk of a GLB.
 * @param {Uint8Array} file
 * @returns {{ json: any, binary: Uint8Array }}
 */
export function readGlb(file) {
  const start = 20 + new DataView(file.buffer, file.byteOffset).getUint32(12, true);
  return { json: JSON.parse(new TextDecoder().decode(file.subarray(20, start))), binary: file.slice(start + 8) };
}

/**
 * Returns a square with two morph targets, which double its height and its width, and two
 * animations, which change the weight of the first target and move the node.
 * @param {{ mesh?: number[], node?: number[] }} [weights] of the mesh and the node
 */
export function morphingSquare({ mesh, node } = {}) {
  const arrays = [
    Float32Array.of(0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0),
    Float32Array.of(0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 1, 0),
    Float32Array.of(0, 0, 0, 1, 0, 0, 0, 0, 0, 1, 0, 0),
    Uint16Array.of(0, 1, 2, 2, 1, 3),
    Float32Array.of(0, 100),
    Float32Array.of(1, 0, 1, 0),
    Float32Array.of(0, 0, 0, 0, 0, 0),
  ];
  const points = { componentType: 5126, count: 4, type: 'VEC3', min: [0, 0, 0], max: [1, 1, 0] };
  const json = {
    scenes: [{ nodes: [0] }],
    nodes: [{ mesh: 0, ...(node && { weights: node }) }],
    meshes: [{ primitives: [{ attributes: { POSITION: 0 }, indices: 3, targets: [{ POSITION: 1 }, { POSITION: 2 }] }], ...(mesh && { weights: mesh }) }],
    accessors: [
      { bufferView: 0, ...points },
      { bufferView: 1, ...points, max: [0, 1, 0] },
      { bufferView: 2, ...points, max: [1, 0, 0] },
      { bufferView: 3, componentType: 5123, count: 6, type: 'SCALAR' },
      { bufferView: 4, componentType: 5126, count: 2, type: 'SCALAR' },
      { bufferView: 5, componentType: 5126, count: 4, type: 'SCALAR' },
      { bufferView: 6, componentType: 5126, count: 2, type: 'VEC3' },
    ],
    animations: [
      { name: 'Stretch', samplers: [{ input: 4, output: 5 }], channels: [{ sampler: 0, target: { node: 0, path: 'weights' } }] },
      { samplers: [{ input: 4, output: 6 }], channels: [{ sampler: 0, target: { node: 0, path: 'translation' } }] },
    ],
  };
  return { json, arrays, bytes: sceneGlb(json, arrays) };
}
