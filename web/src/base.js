/**
 * Decoding of the base mesh.
 *
 * Triangles come in traversal order. Each open edge is visited once, in order of creation. It is a
 * border, an edge of a new triangle, or it is joined to another open edge. When no open edge is
 * left, a new component starts.
 *
 * Then each fan, ordered by its lowest corner, is a new vertex or a fan of an earlier vertex. Each
 * new vertex is a new point or has the position of an earlier fan. The values of new points and
 * vertices are predicted by the parallelogram over the edge at which their first triangle was
 * added.
 * @module
 */
import { SMALL_CONTEXTS, USUAL_SQUARE } from './constants.js';
import { fail } from './error.js';
import { FAN_CELLS, Fans, VERTEX } from './fans.js';
import { grown, integers } from './growth.js';
import { Simple } from './slots.js';
import { clz32, min } from './math.js';
import { decodeSmall } from './numbers.js';
import { next, NONE, previous, Surface } from './surface.js';

/**
 * @import { ChannelModel } from './channels.js'
 * @import { PlaceModel } from './places.js'
 * @import { RangeDecoder } from './range_coder.js'
 */

/** What is across an open edge. */
const IS_TRIANGLE = 0;
const IS_BORDER = 1;

/** Contexts of the flags of fans. */
const SAME_VERTEX = 0;
const SAME_POINT = 1;

/**
 * Decodes the triangles of a base mesh.
 * @param {RangeDecoder} coder
 * @param {number} triangleCount
 * @returns {Surface}
 */
export function decodeTriangles(coder, triangleCount) {
  const kinds = new Simple(2);
  const distances = new Simple(SMALL_CONTEXTS);
  let opposite = integers(3);
  let length = 0;
  const push = () => {
    if (coder.isPastEnd) fail('the end of the chunk', `${triangleCount} triangles`);
    opposite = grown(opposite, length + 3);
    opposite.fill(NONE, length, length + 3);
    length += 3;
  };
  for (let corner = 0; length < 3 * triangleCount; ) {
    // 1. A new component.
    push();
    // 2. The edges in order. Each is identified by its opposite corner, whose index is its position
    //    in the order.
    for (; corner < length; corner++) {
      if (opposite[corner] !== NONE) continue;
      let other = length;
      if (length < 3 * triangleCount && kinds.decode(coder, IS_TRIANGLE)) {
        push();
      } else if (corner + 1 === length || kinds.decode(coder, IS_BORDER)) {
        if (coder.isPastEnd) fail('the end of the chunk', `${triangleCount} triangles`);
        continue;
      } else {
        other = corner + decodeSmall(coder, distances) + 1;
        if (other >= length || opposite[other] !== NONE) fail('an edge of two triangles twice', 'edges of at most two triangles');
      }
      opposite[corner] = other;
      opposite[other] = corner;
    }
  }
  return new Surface(opposite, triangleCount);
}

/**
 * Decodes the fans, vertices and points of the base mesh.
 * @param {RangeDecoder} coder
 * @param {Surface} surface
 * @param {PlaceModel} placeModel
 * @param {ChannelModel[]} channels
 * @param {number} knownBits the known bits per coordinate
 * @returns {Fans}
 */
export function decodeFans(coder, surface, placeModel, channels, knownBits) {
  const fans = new Fans();
  const flags = new Simple(2);
  const around = integers(2);
  const { place } = placeModel;
  const most = 2 ** knownBits - 1;
  const earlier = (/** @type {number} */ context) => {
    const fan = fans.count;
    if (fan === 0 || !flags.decode(coder, context)) return NONE;
    return coder.bits(32 - clz32(fan)) % fan;
  };
  // Fans are ordered by their lowest corners.
  for (let lowest = 0; fans.count < surface.fanCount; lowest += (lowest & 7) === 2 ? 6 : 1) {
    const fan = fans.count;
    if (surface.fan(lowest) !== fan) continue;
    // 1. The vertex, then the point.
    const sameVertex = earlier(SAME_VERTEX);
    const twin = sameVertex === NONE ? earlier(SAME_POINT) : sameVertex;
    // 2. The fans across the edge at which the first triangle of the fan was added.
    const opposite = surface.opposite(lowest);
    const hasEdge = opposite !== NONE && opposite < lowest;
    const a = hasEdge ? surface.fan(next(lowest)) : fan;
    const b = hasEdge ? surface.fan(previous(lowest)) : fan;
    const c = hasEdge ? surface.fan(opposite) : fan;
    const isKnown = a < fan && b < fan && c < fan;
    // 3. The position.
    const { cells } = fans;
    if (twin !== NONE) {
      for (let j = 0; j < 3; j++) place[j] = cells[FAN_CELLS * twin + j];
    } else if (isKnown) {
      let square = 1;
      for (let j = 0; j < 3; j++) {
        const ofA = cells[FAN_CELLS * a + j];
        const ofB = cells[FAN_CELLS * b + j];
        place[j] = ofA + ofB - cells[FAN_CELLS * c + j];
        square += (ofA - ofB) * (ofA - ofB);
      }
      placeModel.decodeBase(coder, square, most);
    } else {
      for (let j = 0; j < 3; j++) place[j] = fan > 0 ? cells[FAN_CELLS * (fan - 1) + j] : 0;
      placeModel.decodeBase(coder, USUAL_SQUARE, most);
    }
    // 4. The attributes.
    let vertex = fans.vertexCount;
    if (sameVertex !== NONE) {
      vertex = cells[FAN_CELLS * sameVertex + VERTEX];
    } else {
      const length = isKnown ? 2 : min(fan, 1);
      if (length > 0) around[0] = cells[FAN_CELLS * (isKnown ? a : fan - 1) + VERTEX];
      if (length > 1) around[1] = cells[FAN_CELLS * b + VERTEX];
      for (const channel of channels) channel.decode(coder, vertex, around, length);
    }
    fans.push(twin, vertex, 0, 0);
    for (let j = 0; j < 3; j++) fans.cells[FAN_CELLS * fan + j] = place[j];
  }
  return fans;
}
