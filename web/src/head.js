import { ChannelModel, LINEAR, NAMES, OCTAHEDRAL, TANGENT } from './channels.js';
import {
  ESTIMATES,
  MAX_BITS,
  MAX_CHANNEL_BITS,
  MAX_CHANNELS,
  MAX_NAME_BYTES,
  POLYGONS,
  REGIMES,
  SMALL_CONTEXTS,
  USUAL_WEIGHTS,
} from './constants.js';
import { fail } from './error.js';
import { ARRAY_TYPES } from './grid.js';
import { Simple } from './slots.js';
import { abs } from './math.js';
import { decodeSmall } from './numbers.js';

/**
 * @import { Reader } from './chunk.js'
 * @import { Channel } from './grid.js'
 * @import { RangeDecoder } from './range_coder.js'
 */

/**
 * The header in the first chunk of a mesh.
 * @typedef {object} Head
 * @property {number} positionBits bits per coordinate
 * @property {number} unknownBits bits per coordinate that the base mesh does not contain
 * @property {number[]} origin origin of the position grid
 * @property {number} step
 * @property {number} baseTriangles
 * @property {number} levels number of collapses of the full mesh
 * @property {number} triangles triangles of the full mesh
 * @property {number} vertices
 * @property {Channel[]} channels
 */

/**
 * @param {Reader} reader
 * @returns {Head}
 */
export function readHead(reader) {
  const number = () => reader.number('a count');
  const positionBits = reader.byte();
  const unknownBits = reader.byte();
  if (positionBits === 0 || positionBits > MAX_BITS || unknownBits >= positionBits) {
    fail(`${positionBits} bits, ${unknownBits} of them unknown`, '1 to 16 bits per coordinate, and fewer unknown ones');
  }
  const origin = [reader.float(), reader.float(), reader.float()];
  const step = reader.float();
  const far = step * 2 ** positionBits;
  const isFinite = origin.every((x) => abs(x + far) <= 3.4028234663852886e38);
  if (!(step >= 0 && isFinite)) {
    fail(`origin ${origin.join(' ')}, step ${step}`, 'finite positions and a step of at least 0');
  }
  const baseTriangles = number();
  const levels = number();
  const triangles = number();
  const vertices = number();
  const channelCount = number();
  if (channelCount > MAX_CHANNELS) fail(`${channelCount} attributes`, `at most ${MAX_CHANNELS}`);
  const channels = [];
  for (let i = 0; i < channelCount; i++) channels.push(readChannel(reader));
  return { positionBits, unknownBits, origin, step, baseTriangles, levels, triangles, vertices, channels };
}

/**
 * @param {Reader} reader
 * @returns {Channel}
 */
function readChannel(reader) {
  const name = readName(reader);
  const valueType = reader.byte();
  const components = reader.byte();
  const normalized = reader.byte();
  const kind = reader.byte();
  const bits = reader.byte();
  if (valueType >= ARRAY_TYPES.length || kind > NAMES) {
    fail(`values of type ${valueType} and kind ${kind}`, 'types 0 to 7, kinds 0 to 3');
  }
  const isShaped = kind === OCTAHEDRAL ? components === 3 : kind === TANGENT ? components === 4 : components > 0;
  const isLinear = kind === LINEAR || kind === NAMES;
  // Types 0 and 1 are floats.
  if (!isShaped || bits > MAX_CHANNEL_BITS || normalized > 1 || (!isLinear && (bits === 0 || valueType > 1))) {
    fail(`${components} components of ${bits} bits`, 'components and a type that fit the kind, and at most 24 bits');
  }
  const origins = [];
  for (let i = 0; isLinear && i < components; i++) origins.push(reader.double());
  const step = isLinear ? reader.double() : 0;
  const far = step * 2 ** bits;
  if (!(step >= 0 && origins.every((origin) => Number.isFinite(origin + far)))) {
    fail(`a step of ${step}`, 'finite values and a step of at least 0');
  }
  const width = kind === OCTAHEDRAL ? 2 : kind === TANGENT ? 3 : components;
  const model = new ChannelModel(kind, width, bits);
  return { name, valueType, components, normalized: normalized === 1, origins, step, model };
}

/** @param {Reader} reader */
function readName(reader) {
  const length = reader.number('a count');
  if (length > MAX_NAME_BYTES) fail(`a name of ${length} bytes`, 'at most 256 bytes');
  const start = reader.take(length);
  try {
    return new TextDecoder('utf-8', { fatal: true, ignoreBOM: true }).decode(reader.bytes.subarray(start, start + length));
  } catch {
    fail('a name that is not UTF-8', 'UTF-8');
  }
}

/**
 * Decodes the weights of the estimates, as differences from the defaults: 0, −1, 1, −2, 2, …
 * @param {RangeDecoder} coder
 * @returns {Int32Array}
 */
export function decodeWeights(coder) {
  const model = new Simple(SMALL_CONTEXTS);
  return Int32Array.from({ length: 2 * ESTIMATES * POLYGONS * REGIMES }, (_, i) => {
    const folded = decodeSmall(coder, model) & 0x3ff;
    return USUAL_WEIGHTS[i % USUAL_WEIGHTS.length] + ((folded >> 1) ^ -(folded & 1));
  });
}
