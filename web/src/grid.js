import { OCTAHEDRAL, TANGENT } from './channels.js';
import { abs, clamped, floor, max } from './math.js';

/** @import { ChannelModel } from './channels.js' */

/** @typedef {Float32Array | Float64Array | Uint8Array | Int8Array | Uint16Array | Int16Array | Uint32Array | Int32Array} ValueArray */

/** The value types of attributes: their arrays and, for integers, the bounds. */
export const ARRAY_TYPES = [
  Float32Array,
  Float64Array,
  Uint8Array,
  Int8Array,
  Uint16Array,
  Int16Array,
  Uint32Array,
  Int32Array,
];

/** The first integer type. */
const FIRST_INTEGER = 2;

/**
 * An attribute and the grid on which its values are decoded.
 * @typedef {object} Channel
 * @property {string} name
 * @property {number} valueType
 * @property {number} components
 * @property {boolean} normalized
 * @property {number[]} origins the minimum of each component
 * @property {number} step
 * @property {ChannelModel} model with the integers
 */

/**
 * A vertex attribute.
 * @typedef {object} Attribute
 * @property {string} name the glTF name if there is one (`NORMAL`, `TEXCOORD_0`, `COLOR_0`)
 * @property {number} components values per vertex
 * @property {boolean} normalized whether integers represent fractions of their range
 * @property {ValueArray} array the values, vertex by vertex
 */

/**
 * Returns an attribute with the values of a vertex range.
 * @param {Channel} channel
 * @param {number} first
 * @param {number} end the vertex after the last one
 * @returns {Attribute}
 */
export function attributeOf({ name, valueType, components, normalized, origins, step, model }, first, end) {
  const array = new ARRAY_TYPES[valueType](components * (end - first));
  const { values, width } = model;
  const isUnit = model.kind === OCTAHEDRAL || model.kind === TANGENT;
  const most = 2 ** model.bits - 1;
  const bits = 8 * array.BYTES_PER_ELEMENT;
  const isSigned = valueType % 2 === 1;
  const lowest = isSigned ? -(2 ** (bits - 1)) : 0;
  const highest = lowest + 2 ** bits - 1;
  const unit = [0, 0, 0, 0];
  for (let vertex = first; vertex < end; vertex++) {
    const from = width * vertex;
    const to = components * (vertex - first);
    if (isUnit) {
      unfold(values[from] / most, values[from + 1] / most, unit);
      unit[3] = values[from + 2] === 0 ? 1 : -1;
    }
    for (let j = 0; j < components; j++) {
      const value = isUnit ? unit[j] : origins[j] + values[from + j] * step;
      array[to + j] = valueType < FIRST_INTEGER ? value : clamped(floor(value + 0.5), lowest, highest);
    }
  }
  return { name, components, normalized, array };
}

/**
 * Computes the unit vector at a point of an octahedron that is unfolded to a square.
 * @param {number} s from 0 to 1
 * @param {number} t from 0 to 1
 * @param {number[]} unit receives the vector
 */
function unfold(s, t, unit) {
  const u = s * 2 - 1;
  const v = t * 2 - 1;
  const z = 1 - abs(u) - abs(v);
  const below = max(-z, 0);
  const x = u < 0 ? u + below : u - below;
  const y = v < 0 ? v + below : v - below;
  const length = Math.sqrt(x * x + y * y + z * z);
  unit[0] = x / length;
  unit[1] = y / length;
  unit[2] = z / length;
}
