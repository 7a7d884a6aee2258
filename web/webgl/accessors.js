/**
 * The binary chunk of a GLB while it arrives, and its accessors.
 * @module
 */

/** @import { NumberArray } from './geometry.js' */

/** @type {Record<number, any>} */
const ARRAYS = { 5120: Int8Array, 5121: Uint8Array, 5122: Int16Array, 5123: Uint16Array, 5125: Uint32Array, 5126: Float32Array };
/** @type {Record<string, number>} */
const COMPONENTS = { SCALAR: 1, VEC2: 2, VEC3: 3, VEC4: 4, MAT2: 4, MAT3: 9, MAT4: 16 };
/** The maximum number of values in accessors without buffer views, which contain zeros. */
const MAX_ZEROS = 2 ** 24;
const FIRST_BYTES = 2 ** 16;

/** The value that represents 1 in normalized integers, by size in bytes and signedness. */
const ONE = { signed: [0, 127, 32767], unsigned: [0, 255, 65535] };

/**
 * Returns the number that represents 1 in values.
 * @param {{ array: NumberArray, normalized: boolean }} values
 */
export function unitOf({ array, normalized }) {
  if (!normalized) return 1;
  const isSigned = array instanceof Int8Array || array instanceof Int16Array;
  return ONE[isSigned ? 'signed' : 'unsigned'][array.BYTES_PER_ELEMENT] ?? 1;
}

/** A valid model that the renderer does not support. */
export class UnsupportedError extends Error {}

/** Bytes that arrive in order. */
export class Binary {
  #bytes = new Uint8Array(0);
  #length = 0;

  /**
   * @param {Uint8Array} bytes
   * @param {number} start
   */
  add(bytes, start) {
    const end = start + bytes.length;
    if (end > this.#bytes.length) {
      const old = this.#bytes;
      this.#bytes = new Uint8Array(Math.max(end, 2 * old.length, FIRST_BYTES));
      this.#bytes.set(old);
    }
    this.#bytes.set(bytes, start);
    this.#length = Math.max(this.#length, end);
  }

  /** The bytes received so far. */
  get bytes() {
    return this.#bytes.subarray(0, this.#length);
  }
}

/**
 * @typedef {object} Accessor
 * @property {NumberArray} array
 * @property {number} components
 * @property {boolean} normalized
 * @property {number} count
 */

/**
 * Returns the bytes of a buffer view.
 * @param {any} json
 * @param {number} index
 * @param {Uint8Array} bytes of the binary chunk
 */
export function viewBytes(json, index, bytes) {
  const { buffer, byteOffset = 0, byteLength, extensions } = json.bufferViews[index];
  const { uri } = json.buffers[buffer];
  if (uri !== undefined) throw new UnsupportedError(`Its geometry is in another file${uri.startsWith('data:') ? '' : `, ${uri.slice(0, 100)}`}. The viewer needs a single GLB file, as written by “tristrip pack”.`);
  if (buffer !== 0) throw new Error('A buffer is not in the file.');
  if (extensions) throw new UnsupportedError(`The model is compressed with ${Object.keys(extensions)[0]}.`);
  if (!(byteOffset >= 0 && byteLength >= 0 && byteOffset + byteLength <= bytes.length)) throw new Error('A buffer view is not in the file.');
  return bytes.subarray(byteOffset, byteOffset + byteLength);
}

/**
 * Returns the number of leading bytes of the binary chunk that an accessor needs.
 * @param {any} json
 * @param {number | undefined} index
 */
export function accessorEnd(json, index) {
  const { bufferView, sparse } = json.accessors?.[index ?? -1] ?? {};
  return Math.max(0, ...[bufferView, sparse?.indices.bufferView, sparse?.values.bufferView].filter((view) => view !== undefined).map((view) => viewEnd(json, view)));
}

/**
 * @param {any} json
 * @param {number} index
 */
export function viewEnd(json, index) {
  const { byteOffset = 0, byteLength = 0 } = json.bufferViews?.[index] ?? {};
  return byteOffset + byteLength;
}

/**
 * Returns the values of an accessor, tightly packed in a new array.
 * @param {any} json
 * @param {number} index
 * @param {Uint8Array} bytes of the binary chunk
 * @param {number} [mostZeros] the maximum number of values without a buffer view
 * @returns {Accessor}
 */
export function readAccessor(json, index, bytes, mostZeros = MAX_ZEROS) {
  const accessor = json.accessors[index];
  const { componentType, normalized = false, count, type, sparse } = accessor;
  const Type = ARRAYS[componentType];
  const components = COMPONENTS[type];
  if (!Type || !components || !(count >= 0)) throw new Error(`Accessor ${index} has an unknown type.`);
  /** @type {NumberArray} */
  let array;
  if (accessor.bufferView !== undefined) array = readItems(json, accessor, Type, components, count, bytes);
  else if (count * components <= mostZeros) array = new Type(count * components);
  else throw new Error(`Accessor ${index} is too large.`);
  if (sparse) {
    const places = readItems(json, sparse.indices, ARRAYS[sparse.indices.componentType], 1, sparse.count, bytes);
    const values = readItems(json, sparse.values, Type, components, sparse.count, bytes);
    for (let i = 0; i < values.length; i++) {
      const at = places[Math.floor(i / components)] * components + (i % components);
      if (at < array.length) array[at] = values[i];
    }
  }
  return { array, components, normalized, count };
}

/** The accessors of a document. Each is read once and shared. */
export class Accessors {
  #json;
  /** @type {Map<number, Accessor>} */
  #known = new Map();
  #zerosLeft = MAX_ZEROS;

  /** @param {any} json */
  constructor(json) {
    this.#json = json;
  }

  /**
   * Returns the values of an accessor. Do not modify them.
   * @param {number} index
   * @param {Uint8Array} bytes of the binary chunk
   */
  read(index, bytes) {
    const known = this.#known.get(index);
    if (known) return known;
    const accessor = readAccessor(this.#json, index, bytes, this.#zerosLeft);
    if (this.#json.accessors[index].bufferView === undefined) this.#zerosLeft -= accessor.array.length;
    this.#known.set(index, accessor);
    return accessor;
  }

  /** Drops the values; they are read again on demand. */
  clear() {
    this.#known.clear();
  }
}

/**
 * @param {any} json
 * @param {{ bufferView: number, byteOffset?: number }} where
 * @param {any} Type
 * @param {number} components
 * @param {number} count
 * @param {Uint8Array} bytes
 * @returns {NumberArray}
 */
function readItems(json, { bufferView, byteOffset = 0 }, Type, components, count, bytes) {
  const view = viewBytes(json, bufferView, bytes);
  const size = components * Type.BYTES_PER_ELEMENT;
  const stride = json.bufferViews[bufferView].byteStride ?? size;
  if (count > 0 && !(byteOffset >= 0 && stride >= size && byteOffset + (count - 1) * stride + size <= view.length)) throw new Error('An accessor is larger than its buffer view.');
  if (stride === size) return new Type(view.slice(byteOffset, byteOffset + count * size).buffer);
  const packed = new Uint8Array(count * size);
  for (let i = 0, from = byteOffset, to = 0; i < count; i++, from += stride) {
    for (let j = 0; j < size; j++) packed[to++] = view[from + j];
  }
  return new Type(packed.buffer);
}
