import assert from 'node:assert/strict';
import { test } from 'node:test';
import { Accessors, Binary, accessorEnd, readAccessor, UnsupportedError } from '../webgl/accessors.js';
import { Animation } from '../webgl/animation.js';
import { Budget } from '../webgl/budget.js';
import { Camera } from '../webgl/camera.js';
import { Geometry } from '../webgl/geometry.js';
import { countTriangles } from '../webgl/indices.js';
import { readMaterial } from '../webgl/materials.js';
import { cofactors, compose, determinant, multiply, transformBox, transformPoint } from '../webgl/matrix.js';
import { ShownModel } from '../webgl/model.js';
import { addedTargets, MAX_ADDED } from '../webgl/morphs.js';
import { Scene } from '../webgl/scene.js';
import { FRAGMENT, VERTEX } from '../webgl/shaders.js';
import { morphingSquare, readGlb, sceneGlb } from '../testing/scene_glb.js';

/** A document with one accessor over one buffer view. */
const documentOf = (accessor, view = {}, buffer = {}) => ({
  buffers: [buffer],
  bufferViews: [{ buffer: 0, byteLength: 64, ...view }],
  accessors: [{ bufferView: 0, componentType: 5123, count: 3, type: 'VEC2', ...accessor }],
});
const numbers = new Uint8Array(Uint16Array.from({ length: 32 }, (_, i) => i).buffer);

test('accessors are read with offset and stride', () => {
  assert.deepEqual([...readAccessor(documentOf({}), 0, numbers).array], [0, 1, 2, 3, 4, 5]);
  assert.deepEqual([...readAccessor(documentOf({ byteOffset: 2 }), 0, numbers).array], [1, 2, 3, 4, 5, 6]);
  assert.deepEqual([...readAccessor(documentOf({ byteOffset: 4 }, { byteStride: 8 }), 0, numbers).array], [2, 3, 6, 7, 10, 11]);
});

test('sparse accessors replace values, also of zeros', () => {
  const json = documentOf({ bufferView: undefined, sparse: { count: 2, indices: { bufferView: 1, componentType: 5121 }, values: { bufferView: 0, byteOffset: 8 } } });
  json.bufferViews.push({ buffer: 0, byteOffset: 64, byteLength: 2 });
  const bytes = new Uint8Array([...numbers, 0, 2]);
  assert.equal(accessorEnd(json, 0), 66);
  assert.deepEqual([...readAccessor(json, 0, bytes).array], [4, 5, 0, 0, 6, 7]);
});

test('accessors beyond their view, in other files and of unknown types are rejected', () => {
  for (const json of [documentOf({ count: 17 }), documentOf({ byteOffset: -4 }), documentOf({}, { byteLength: 65 }), documentOf({}, {}, { uri: 'a.bin' }), documentOf({ componentType: 5 }), documentOf({ bufferView: undefined, count: 2 ** 40 }), documentOf({}, { byteStride: 2 })]) {
    assert.throws(() => readAccessor(json, 0, numbers), Error);
  }
});

test('accessors of zeros share a limit, and each is read once', () => {
  const zeros = { componentType: 5121, count: 2 ** 21, type: 'VEC4' };
  const accessors = new Accessors({ accessors: [zeros, zeros, zeros] });
  assert.equal(accessors.read(0, numbers), accessors.read(0, numbers));
  accessors.read(1, numbers);
  assert.throws(() => accessors.read(2, numbers), /too large/);
});

test('a binary chunk arrives in pieces', () => {
  const binary = new Binary();
  for (let start = 0; start < numbers.length; start += 7) binary.add(numbers.subarray(start, start + 7), start);
  assert.deepEqual(binary.bytes, numbers);
});

test('matrices are applied from right to left', () => {
  const turn = compose([1, 2, 3], [0, 0, Math.SQRT1_2, Math.SQRT1_2], [2, 2, 2]);
  const near = (a, b) => a.forEach((x, i) => assert.ok(Math.abs(x - b[i]) < 1e-12, `${a} is not ${b}`));
  near(transformPoint(turn, [1, 0, 0]), [1, 4, 3]);
  near(transformPoint(multiply(turn, turn), [1, 0, 0]), transformPoint(turn, transformPoint(turn, [1, 0, 0])));
  assert.ok(Math.abs(determinant(turn) - 8) < 1e-12);
  // Normals are transformed by the cofactor matrix: here the rotation times 4.
  near(cofactors(turn).slice(0, 3), [0, 4, 0]);
});

test('a box is transformed like its corners', () => {
  const turn = compose([1, -2, 3], [0.1, -0.5, 0.3, 0.8], [2, -1, 0.5]);
  const [min, max] = [[-1, 0, 2], [3, 5, 4]];
  const corners = Array.from({ length: 8 }, (_, corner) => transformPoint(turn, [0, 1, 2].map((i) => (corner & (1 << i) ? max : min)[i])));
  const box = transformBox(turn, { min, max });
  for (let i = 0; i < 3; i++) {
    const values = corners.map((corner) => corner[i]);
    assert.ok(Math.abs(box.min[i] - Math.min(...values)) < 1e-12);
    assert.ok(Math.abs(box.max[i] - Math.max(...values)) < 1e-12);
  }
});

test('a camera sees what it looks at, and its view is text', () => {
  const camera = new Camera();
  camera.resize(0.5);
  camera.bounds = { min: [-1, 0, 2], max: [3, 2, 4] };
  for (const corner of [[-1, 0, 2], [3, 2, 4], [3, 0, 2]]) {
    const m = camera.viewProjection;
    const w = m[3] * corner[0] + m[7] * corner[1] + m[11] * corner[2] + m[15];
    assert.ok(transformPoint(m, corner).every((x) => Math.abs(x / w) <= 1), `${corner} is not seen`);
  }
  camera.orbit(1, 0.2);
  camera.pan(0.1, 0.1);
  const other = new Camera();
  assert.ok(other.parse(String(camera)));
  assert.equal(String(other), String(camera));
  for (const text of ['', '1,2,3', '0,0,-1,0,0,0', '0,0,x,0,0,0', '0,0,Infinity,0,0,0', '0,0,1e300,0,0,0', '0,0,1e-300,0,0,0', '0,0,1,0,-1e38,0', '1e16,0,1,0,0,0']) assert.ok(!other.parse(text), text);
});

/**
 * Returns an object that calls a function on every read of a property, also of nested ones.
 * @template {object} T
 * @param {T} object
 * @param {() => void} onread
 * @returns {T}
 */
function counting(object, onread) {
  const proxies = new Map();
  const wrap = (value) => {
    if (typeof value !== 'object' || value === null) return value;
    if (!proxies.has(value)) {
      const get = (target, key) => {
        onread();
        return wrap(target[key]);
      };
      proxies.set(value, new Proxy(value, { get }));
    }
    return proxies.get(value);
  };
  return wrap(object);
}

test('a scene ignores cycles, and its bounds include the node transforms', () => {
  const scene = new Scene({
    scenes: [{ nodes: [0] }],
    nodes: [{ children: [1, 0, 7], translation: [10, 0, 0] }, { mesh: 0, scale: [2, 2, 2], children: [0] }],
    meshes: [{ primitives: [{ attributes: { POSITION: 0 } }] }],
    accessors: [{ min: [0, 0, 0], max: [1, 2, 3] }],
  });
  assert.equal(scene.nodes.size, 2);
  assert.deepEqual(scene.bounds, { min: [10, 0, 0], max: [12, 4, 6] });
});

test('a scene with many nodes is read in linear time, and invalid bounds are ignored', () => {
  const count = 200_000;
  let reads = 0;
  const bounds = (accessor) => new Scene(counting({
    scenes: [{ nodes: Array.from({ length: count }, (_, i) => i) }],
    nodes: Array.from({ length: count }, (_, i) => (i > 1 ? {} : { mesh: i })),
    meshes: [0, 1].map((POSITION) => ({ primitives: [{ attributes: { POSITION } }] })),
    accessors: [accessor, { min: [0, 0, 0], max: [1, 1, 1] }],
  }, () => reads++)).bounds;
  for (const accessor of [{ min: 5, max: 5 }, { min: ['a', 0, 0], max: [1, 1, 1] }]) assert.deepEqual(bounds(accessor), { min: [0, 0, 0], max: [1, 1, 1] });
  assert.ok(reads < 50 * count, `${reads} reads`);
});

test('animations may have many tracks', () => {
  const animation = new Animation();
  animation.tracks = Array.from({ length: 200_000 }, (_, i) => ({ times: Float32Array.of(0, i) }));
  assert.equal(animation.duration, 199_999);
});

test('animations interpolate', () => {
  const scene = new Scene({ scenes: [{ nodes: [0] }], nodes: [{}] });
  const animation = new Animation();
  const times = Float32Array.of(0, 1, 2);
  animation.tracks.push({ node: 0, path: 'translation', interpolation: 'LINEAR', times, values: Float32Array.of(0, 0, 0, 4, 0, 0, 8, 2, 0) });
  animation.tracks.push({ node: 0, path: 'scale', interpolation: 'STEP', times, values: Float32Array.of(1, 1, 1, 2, 2, 2, 3, 3, 3) });
  animation.apply(scene, 1.5);
  assert.deepEqual(scene.nodes.get(0).translation, [6, 1, 0]);
  assert.deepEqual(scene.nodes.get(0).scale, [2, 2, 2]);
});

test('animations move the weights of morph targets, of any number', () => {
  const mesh = { weights: [0.25, 0, 0, 0, 9], primitives: [{ attributes: {}, targets: [{}, {}, {}, {}, {}] }] };
  const scene = new Scene({ scenes: [{ nodes: [0, 1, 2] }], nodes: [{ mesh: 0 }, { mesh: 0, weights: [0, 1] }, {}], meshes: [mesh] });
  const weights = (node) => scene.nodes.get(node).weights;
  assert.deepEqual([0, 1, 2].map(weights), [[0.25, 0, 0, 0, 9], [0, 1], []], 'those of a node come before those of its mesh');
  const animation = new Animation('Smile');
  const times = Float32Array.of(0, 2);
  for (const node of [0, 7]) animation.tracks.push({ node, path: 'weights', interpolation: 'LINEAR', times, values: Float32Array.of(0, 1, 2, 3, 4, 4, 3, 2, 1, 0) });
  // A cubic spline with an in-tangent, a value and an out-tangent per key.
  const zeros = [0, 0, 0, 0, 0];
  animation.tracks.push({ node: 1, path: 'weights', interpolation: 'CUBICSPLINE', times, values: Float32Array.of(...zeros, 0, 0, 0, 0, 4, ...zeros, ...zeros, 8, 0, 0, 0, 0, ...zeros) });
  animation.apply(scene, 1);
  assert.deepEqual([0, 1, 2].map(weights), [[2, 2, 2, 2, 2], [4, 0, 0, 0, 2], []]);
  scene.rest();
  assert.deepEqual([0, 1].map(weights), [[0.25, 0, 0, 0, 9], [0, 1]]);
});

test('weights of many nodes and targets take no more than the document', () => {
  const [targets, nodes] = [20_000, 20_000];
  const mesh = { primitives: [{ attributes: { POSITION: 0 }, targets: Array.from({ length: targets }, () => ({ POSITION: 0 })) }], weights: new Array(targets).fill(0.5) };
  const json = {
    scenes: [{ nodes: Array.from({ length: nodes }, (_, i) => i) }],
    nodes: Array.from({ length: nodes }, (_, i) => ({ mesh: 0, ...(i % 2 && { weights: [1] }) })),
    meshes: [mesh],
    accessors: [{ min: [0, 0, 0], max: [1, 1, 1] }],
    animations: [{ channels: Array.from({ length: nodes }, (_, node) => ({ target: { node, path: 'weights' } })) }],
  };
  let reads = 0;
  const scene = new Scene(counting(json, () => reads++));
  assert.deepEqual(scene.bounds.max, [1 + targets / 2, 1 + targets / 2, 1 + targets / 2]);
  assert.ok(new Set([...scene.nodes.values()].map(({ weights }) => weights)).size === 1 + nodes / 2);
  assert.ok(reads < 200 * (targets + nodes), `${reads} reads`);
});

test('unused morph targets are not read', () => {
  const { json, arrays } = morphingSquare();
  delete json.animations;
  for (const weights of [undefined, [0, 0], [0, 0.5]]) {
    json.nodes[0].weights = weights;
    const { json: views, bytes } = binaryOf(sceneGlb(json, arrays));
    const { gl, model } = openModel({ ...json, ...views }, bytes);
    while (model.isBusy) model.step(new Budget());
    assert.equal(gl.textures.length, weights?.[1] ? 1 : 0);
  }
});

test('another animation starts from the rest pose', () => {
  const { json, bytes } = morphingSquare();
  json.nodes.push({ translation: [0, 5, 0] });
  json.scenes[0].nodes.push(1);
  json.animations[1].channels[0].target.node = 1;
  const { model } = openModel({ ...json, ...binaryOf(bytes).json }, binaryOf(bytes).bytes);
  while (model.isBusy) model.step(new Budget());
  assert.deepEqual(model.animations.map(({ name }) => name), ['Stretch', '']);
  const pose = () => [model.scene.nodes.get(0).weights, model.scene.nodes.get(1).world.slice(12, 15)];
  model.animate(0, 50);
  assert.deepEqual(pose(), [[1, 0], [0, 5, 0]]);
  model.animate(1, 50);
  assert.deepEqual(pose(), [[], [0, 0, 0]]);
  model.animate(-1, 0);
  assert.deepEqual(pose(), [[], [0, 5, 0]]);
});

test('keyframes may be normalized integers', () => {
  const { json, arrays } = morphingSquare();
  arrays[5] = Int8Array.of(127, -128, 0, 64);
  json.accessors[5] = { ...json.accessors[5], componentType: 5120, normalized: true };
  const { json: views, bytes } = binaryOf(sceneGlb(json, arrays));
  const { model } = openModel({ ...json, ...views }, bytes);
  while (model.isBusy) model.step(new Budget());
  assert.deepEqual([...model.animations[0].tracks[0].values], [1, -1, 0, 64 / 127].map(Math.fround));
});

test('the bounds of a mesh include its morph targets', () => {
  const boundsOf = (weights, change = () => {}) => {
    const { json } = morphingSquare(weights);
    change(json);
    return new Scene(json).bounds.max;
  };
  const isStill = (json) => delete json.animations;
  assert.deepEqual(boundsOf({}, isStill), [1, 1, 0]);
  assert.deepEqual(boundsOf({ mesh: [0, 1] }, isStill), [2, 1, 0]);
  assert.deepEqual(boundsOf({ mesh: [0, 1], node: [0.5] }, isStill), [1, 1.5, 0]);
  assert.deepEqual(boundsOf({}), [2, 2, 0], 'an animation may move all weights to 1');
  assert.deepEqual(boundsOf({ mesh: 'ab' }, isStill), [1, 1, 0]);
});

test('the largest weights are applied, up to the limit of the shader', () => {
  assert.deepEqual(addedTargets([0, 0.5, 0, -2]), [[1, 0.5], [3, -2]]);
  const many = addedTargets(Array.from({ length: 100 }, (_, i) => i - 50));
  assert.equal(many.length, MAX_ADDED);
  assert.deepEqual(Math.min(...many.map(([, weight]) => Math.abs(weight))), 18);
  assert.match(VERTEX, new RegExp(`vec2 added\\[${MAX_ADDED}\\]`));
});

test('shaders compute powers of non-negative numbers only: others give black pixels on some drivers', () => {
  const powers = [...FRAGMENT.matchAll(/\bpow\((.*)/g)].map(([, rest]) => rest);
  assert.ok(powers.length >= 3);
  for (const rest of powers) assert.match(rest, /^max\(.*, 0\.0\)/);
});

test('triangles of strips are counted without restarts and degenerate ones', () => {
  const count = (mode, ...indices) => countTriangles({ mode, array: Uint8Array.from(indices), length: indices.length });
  assert.equal(count(4, 0, 1, 2, 2, 1, 3, 0), 2);
  assert.equal(count(5, 0, 1, 2, 3), 2);
  assert.equal(count(5, 0, 1, 2, 255, 3, 4, 5, 6, 255, 7, 8), 3);
  assert.equal(count(5, 0, 1, 2, 2, 3, 3, 4, 5), 2, 'strips that are joined');
  assert.equal(count(6, 0, 1, 2, 3, 255, 4, 5, 6), 3);
  assert.equal(count(1, 0, 1, 2, 3), 0);
  assert.equal(countTriangles({ mode: 5, array: null, length: 1 }), 0);
  assert.equal(countTriangles({ mode: 5, array: null, length: 5 }), 3);
});

test('morph targets are uploaded as one texture, which is freed', () => {
  const { json, arrays } = morphingSquare({ mesh: [0.5] });
  // The second target also changes normals, as integers.
  json.meshes[0].primitives[0].targets[1].NORMAL = 7;
  json.accessors.push({ componentType: 5122, normalized: true, count: 4, type: 'VEC3', sparse: { count: 1, indices: { bufferView: 7, componentType: 5121 }, values: { bufferView: 8 } } });
  const { json: views, bytes: binary } = binaryOf(sceneGlb(json, [...arrays, Uint8Array.of(3), Int16Array.of(32767, 0, -32767)]));
  const { gl, model, told } = openModel({ ...json, ...views }, binary);
  while (model.isBusy) model.step(new Budget());
  assert.deepEqual(told.errors, []);
  const [texture] = gl.textures;
  const texels = (target, slot) => [...texture.texels.subarray(16 * (2 * target + slot), 16 * (2 * target + slot + 1))];
  assert.deepEqual(texels(0, 0), [0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0]);
  assert.deepEqual(texels(0, 1), new Array(16).fill(0));
  assert.deepEqual(texels(1, 1), [...new Array(12).fill(0), 1, 0, -1, 0]);
  model.restore();
  while (model.isBusy) model.step(new Budget());
  assert.equal(gl.textures.length, 2, 'it is made again after the context was lost');
  model.close();
  assert.ok(gl.textures[1].isDeleted);
});

/** Regression: the page reported an empty scene. */
test('a model that arrives after the context was restored is shown', () => {
  const { json, arrays } = morphingSquare();
  const { json: views, bytes } = binaryOf(sceneGlb(json, arrays));
  for (const isRestored of [false, true]) {
    const { model, told } = openModel({ ...json, ...views }, new Uint8Array(0), bytes.length);
    if (isRestored) model.restore();
    while (model.isBusy) model.step(new Budget());
    assert.equal(model.items.length, 0);
    model.events.binary(bytes, 0);
    while (model.isBusy) model.step(new Budget());
    assert.deepEqual(told.errors, []);
    assert.equal(model.items.length, 1, isRestored ? 'after the context was restored' : 'without a loss');
  }
});

test('morph targets beyond the limit are dropped', () => {
  const { json } = morphingSquare({ node: [1] });
  const count = 2 ** 20;
  json.accessors = [{ componentType: 5126, count, type: 'VEC3' }, { componentType: 5126, count, type: 'VEC3' }];
  delete json.animations;
  const primitive = { attributes: { POSITION: 0 }, targets: Array.from({ length: 100 }, () => ({ POSITION: 1 })) };
  json.meshes = [{ primitives: [primitive, primitive] }];
  const { gl, model, told } = openModel(json, new Uint8Array(0));
  while (model.isBusy) model.step(new Budget());
  assert.deepEqual(told.errors, []);
  assert.equal(model.items.length, 2);
  assert.deepEqual(gl.textures.map(({ width, height }) => width * height), [8 * count]);
});

test('a material without surface properties is not a metal', () => {
  assert.equal(readMaterial({ name: 'plain' }).factors[0], 0);
  assert.equal(readMaterial({ pbrMetallicRoughness: {} }).factors[0], 1);
});

/** The buffer operations of a context, emulated in memory. */
class FakeContext {
  bound = new Map();
  COPY_READ_BUFFER = 1;
  createBuffer = () => ({ bytes: new Uint8Array(0) });
  bindBuffer = (target, buffer) => this.bound.set(target, buffer);
  bufferData = (target, size) => (this.bound.get(target).bytes = new Uint8Array(size));
  bufferSubData(target, offset, array, from, count) {
    const part = array.subarray(from, from + count);
    this.bound.get(target).bytes.set(new Uint8Array(part.buffer, part.byteOffset, part.byteLength), offset);
  }
  copyBufferSubData = (from, to, a, b, size) => this.bound.get(to).bytes.set(this.bound.get(from).bytes.subarray(a, a + size), b);
  deleteBuffer = (buffer) => buffer && (buffer.bytes = undefined);
  bindVertexArray() {}
  deleteVertexArray() {}

  textures = [];
  createTexture() {
    this.textures.push({});
    return this.textures.at(-1);
  }
  bindTexture = (target, texture) => this.bound.set('texture', texture);
  texStorage2D = (target, levels, format, width, height) => Object.assign(this.bound.get('texture'), { format, width, height, texels: new Float32Array(4 * width) });
  texParameteri() {}
  texSubImage2D(target, level, x, y, width, height, format, type, array) {
    // The first row suffices for the tests.
    if (y === 0) this.bound.get('texture').texels.set(array.subarray(0, this.bound.get('texture').texels.length));
  }
  getParameter = () => 8192;
  deleteTexture = (texture) => texture && (texture.isDeleted = true);
}

/** The binary chunk of a small GLB, and the accessors and buffer views of its document. */
function binaryOf(file) {
  const { json: { buffers, bufferViews }, binary } = readGlb(file);
  return { json: { buffers, bufferViews }, bytes: binary };
}

/** Whether two arrays have equal bytes. */
const isSame = (a, b) => Buffer.from(a.buffer, a.byteOffset, a.byteLength).equals(Buffer.from(b.buffer, b.byteOffset, b.byteLength));

test('buffers follow updates, and indices are shown when all of an update is uploaded', () => {
  const gl = new FakeContext();
  const geometry = new Geometry();
  const vertices = [];
  let indices = [];
  let seed = 1;
  const random = (n) => (seed = (seed * 48271) % 2147483647) % n;
  for (let round = 0; round < 24; round++) {
    const bytesPerIndex = round < 12 ? 2 : 4;
    const firstVertex = round % 7 === 3 ? 0 : random(vertices.length + 1);
    const count = random(40_000) + 1;
    const positions = Float32Array.from({ length: 3 * count }, () => random(1000));
    vertices.length = firstVertex;
    for (let v = 0; v < count; v++) vertices.push(positions.slice(3 * v, 3 * v + 3));
    const length = indices.length + random(60_000);
    const isNew = round === 0 || round === 12;
    const start = isNew ? 0 : random(indices.length + 1);
    const Type = bytesPerIndex === 2 ? Uint16Array : Uint32Array;
    const array = Type.from({ length: length - start }, () => random(65535));
    indices = [...indices.slice(0, start), ...array];
    const before = geometry.parts.get(0)?.shownLength;
    const wasShown = before && geometry.parts.get(0).buffer.bytes.slice(0, before * (round <= 12 ? 2 : 4));
    geometry.patch({ stream: 0, firstVertex, positions, attributes: [], parts: [{ part: 0, length, capacity: 2 * length, bytesPerIndex, strips: 1, ranges: [{ start, array }] }] });
    let steps = 0;
    while (!geometry.upload(gl, new Budget())) {
      assert.ok(++steps < 1000);
      const part = geometry.parts.get(0);
      if (before) assert.ok(isSame(part.buffer.bytes.subarray(0, wasShown.length), wasShown), 'what is drawn has changed before the update was complete');
    }
    const part = geometry.parts.get(0);
    assert.equal(part.shownLength, length);
    assert.ok(isSame(new Type(part.buffer.bytes.buffer, 0, length), Type.from(indices)), `indices of round ${round}`);
    const shown = new Float32Array(geometry.attributes.get('POSITION').buffer.bytes.buffer, 0, 3 * vertices.length);
    assert.ok(isSame(shown, Float32Array.from(vertices.flatMap((v) => [...v]))), `vertices of round ${round}`);
  }
});

/** Opens a model, and records its notifications. */
function openModel(json, bytes, binaryBytes = bytes.length) {
  const gl = new FakeContext();
  const told = { errors: [], bounds: [] };
  const model = new ShownModel(gl, { change() {}, draw() {}, bounds: (box) => told.bounds.push(box), error: (error) => told.errors.push(error), shown() {} });
  const { document, binary } = model.events;
  document(json, binaryBytes);
  binary(bytes, 0);
  return { gl, model, told };
}

test('primitives share buffers of equal accessors', () => {
  const count = 30;
  const json = {
    scenes: [{ nodes: [0] }],
    nodes: [{ mesh: 0 }],
    meshes: [{ primitives: Array.from({ length: count }, () => ({ attributes: { POSITION: 0 }, indices: 1 })) }],
    buffers: [{}],
    bufferViews: [{ buffer: 0, byteLength: 64 }],
    accessors: [{ componentType: 5126, count: 2 ** 20, type: 'VEC3' }, { bufferView: 0, componentType: 5123, count: 30, type: 'SCALAR' }],
  };
  const { gl, model, told } = openModel(json, numbers);
  const buffers = [];
  const create = gl.createBuffer;
  gl.createBuffer = () => {
    const buffer = create();
    buffers.push(buffer);
    return buffer;
  };
  for (let i = 0; i < 1000 && (model.isBusy || i === 0); i++) {
    model.step(new Budget());
    for (const { geometry } of model.items) assert.ok(geometry.attributes.get('POSITION').buffer, 'no primitive is drawn before its buffers are there');
  }
  assert.deepEqual(told.errors, []);
  assert.equal(model.items.length, count);
  assert.equal(buffers.length, 2);
  assert.equal(buffers[0].bytes.length, 12 * 2 ** 20);
  model.close();
  assert.ok(buffers.every(({ bytes }) => bytes === undefined));
});

test('primitives share wireframe textures, which are freed', () => {
  const count = 30;
  const json = {
    scenes: [{ nodes: [0] }],
    nodes: [{ mesh: 0 }],
    // Two sets of vertices, and separate indices for each primitive.
    meshes: [{ primitives: Array.from({ length: count }, (_, i) => ({ attributes: { POSITION: i % 2 }, indices: 2 + i })) }],
    buffers: [{}],
    bufferViews: [{ buffer: 0, byteLength: 64 }],
    accessors: [...[0, 1].map(() => ({ componentType: 5126, count: 5000, type: 'VEC3' })), ...Array.from({ length: count }, () => ({ bufferView: 0, componentType: 5123, count: 30, type: 'SCALAR' }))],
  };
  const { gl, model } = openModel(json, numbers);
  const settle = () => {
    for (let i = 0; i < 1000 && (model.isBusy || i === 0); i++) model.step(new Budget());
  };
  const live = () => gl.textures.filter(({ isDeleted }) => !isDeleted);
  settle();
  for (const end of ['unpull', 'close']) {
    assert.equal(live().length, 0);
    for (const { geometry } of model.items) model.pull(geometry);
    settle();
    assert.deepEqual(model.items.map(({ geometry }) => geometry.pulled.isReady), new Array(count).fill(true));
    assert.equal(live().length, 2 + count);
    const bound = new Set();
    for (const { geometry } of model.items) geometry.pulled.bind(0, (name, texture) => name === 'positions' && bound.add(texture));
    assert.equal(bound.size, 2);
    model[end]();
  }
  assert.equal(live().length, 0);
});

test('a refining mesh has two sets of wireframe textures, a full mesh has one', () => {
  const json = {
    scenes: [{ nodes: [0] }],
    nodes: [{ mesh: 0 }],
    meshes: [{ primitives: [{ attributes: { POSITION: 0 }, extensions: { TRISTRIP_progressive: { stream: 0 } } }] }],
    accessors: [{ componentType: 5126, count: 3, type: 'VEC3' }],
  };
  const { gl, model } = openModel(json, new Uint8Array(0));
  const updates = [];
  const update = (level) => {
    const mesh = { stream: 0, level, fullLevel: 9, firstVertex: 0, positions: new Float32Array(9).fill(level), attributes: [], parts: [{ part: 0, length: 3, capacity: 3, bytesPerIndex: 2, strips: 1, ranges: [{ start: 0, array: Uint16Array.of(0, 1, 2) }] }] };
    updates.push(model.events.update({ meshes: [mesh] }));
    while (model.isBusy) model.step(new Budget());
  };
  const live = () => gl.textures.filter(({ isDeleted }) => !isDeleted).length;
  const shown = () => {
    let value;
    model.items[0].geometry.pulled.bind(0, (name, texture) => name === 'positions' && (value = texture.texels[0]));
    return value;
  };
  update(1);
  model.pull(model.items[0].geometry);
  while (model.isBusy) model.step(new Budget());
  const found = [[live(), shown()]];
  for (const level of [2, 9, 9, 3, 4, 9]) {
    update(level);
    found.push([live(), shown()]);
  }
  assert.deepEqual(found, [[2, 1], [4, 2], [2, 9], [2, 9], [4, 3], [4, 4], [2, 9]]);
  const before = gl.textures.length;
  model.restore();
  while (model.isBusy) model.step(new Budget());
  assert.equal(live(), 2, 'what a context has lost cannot be deleted');
  model.pull(model.items[0].geometry);
  while (model.isBusy) model.step(new Budget());
  assert.deepEqual([gl.textures.length, shown()], [before + 2, 9]);
  model.close();
});

test('a model with missing bytes reports an error at once', () => {
  const json = (view, buffer = {}) => ({ ...documentOf({ type: 'VEC3' }, view, buffer), scenes: [{ nodes: [0] }], nodes: [{ mesh: 0 }], meshes: [{ primitives: [{ attributes: { POSITION: 0 } }] }] });
  for (const view of [{ byteOffset: 1 }, { byteLength: 1e9 }, { byteLength: 'x' }]) assert.match(openModel(json(view), numbers).told.errors[0].message, /not in the file/);
  assert.ok(openModel(json({}, { uri: 'a.bin' }), new Uint8Array(0)).told.errors[0] instanceof UnsupportedError);
  assert.deepEqual(openModel(json({}), numbers).told.errors, []);
});

test('the bounds of instances are computed once per step, and instances are limited together', () => {
  const nodes = 5;
  const instanced = { extensions: { EXT_mesh_gpu_instancing: { attributes: { TRANSLATION: 1 } } } };
  const json = {
    scenes: [{ nodes: Array.from({ length: nodes }, (_, i) => i) }],
    nodes: Array.from({ length: nodes }, () => ({ mesh: 0, ...instanced })),
    meshes: [{ primitives: [{ attributes: { POSITION: 0 } }] }],
    accessors: [{ componentType: 5126, count: 3, type: 'VEC3', min: [0, 0, 0], max: [1, 1, 1] }, { componentType: 5126, count: 4000, type: 'VEC3' }],
  };
  const { model, told } = openModel(json, new Uint8Array(0));
  let steps = 0;
  for (; model.isBusy; steps++) model.step(new Budget());
  assert.ok(told.bounds.length <= steps);
  assert.deepEqual(told.bounds.at(-1), { min: [0, 0, 0], max: [1, 1, 1] });
  const instances = [...model.scene.nodes.values()].map((node) => node.instances.length);
  assert.deepEqual(instances, [4000, 4000, 2000, 0, 0]);
});
