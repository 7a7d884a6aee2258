import assert from 'node:assert/strict';
import { existsSync } from 'node:fs';
import { register } from 'node:module';
import { test } from 'node:test';

// three.js is a dependency of the browser tests.
const BROWSER = new URL('../browser/package.json', import.meta.url).href;
const skip = !existsSync(new URL('node_modules/three', BROWSER)) && 'SKIPPED: three.js is not installed: npm ci --prefix browser';
const HOOK = `export const resolve = (name, context, next) => next(name, /^three($|\\/)/.test(name) ? { ...context, parentURL: '${BROWSER}' } : context);`;
if (!skip) register(`data:text/javascript,${encodeURIComponent(HOOK)}`);
const load = async () => ({ THREE: await import('three'), ...(await import('../three/index.js')) });

/** A client controlled by the test. */
class FakeClient {
  calls = [];
  load(source, events) {
    this.events = events;
    return { close: () => this.calls.push('close'), retry: () => this.calls.push('retry'), set priority(number) {} };
  }
}

/** A GLTFLoader that parses when the test allows it. */
class FakeGLTFLoader {
  register() {}
  parseAsync() {
    return new Promise((resolve, reject) => Object.assign(this, { resolve, reject }));
  }
}

const isComplete = { meshes: [], progress: { isComplete: true } };
const json = { extensions: { TRISTRIP_progressive: {} } };

/** Starts loading a model. */
async function begin(options = {}) {
  const { THREE, ProgressiveLoader } = await load();
  const [client, gltfLoader] = [new FakeClient(), new FakeGLTFLoader()];
  const manager = new THREE.LoadingManager();
  const loader = new ProgressiveLoader(manager, { client, gltfLoader });
  const loading = loader.loadAsync('a.glb', options);
  const settled = loading.then((gltf) => gltf, (error) => error);
  const scene = new THREE.Group();
  const gltf = { scene, scenes: [scene], animations: [], parser: { json, associations: new Map() } };
  return { THREE, loader, manager, settled, events: client.events, calls: client.calls, parser: gltfLoader, gltf };
}

const nextTask = () => new Promise((resolve) => setTimeout(resolve));

test('an error of the parser is reported, also after everything has arrived', { skip }, async () => {
  const { manager, settled, events, parser } = await begin();
  const ended = new Promise((resolve) => (manager.onLoad = resolve));
  events.document(json, 0);
  events.update(isComplete);
  parser.reject(new Error('no texture'));
  assert.equal((await settled).message, 'no texture');
  await ended;
});

test('an invalid document rejects', { skip }, async () => {
  const { settled, events } = await begin();
  events.document(null, 0);
  assert.ok((await settled) instanceof TypeError);
});

test('a model is complete when its scene is available', { skip }, async () => {
  const { settled, events, parser, gltf, calls } = await begin();
  events.document(json, 0);
  events.update(isComplete);
  parser.resolve(gltf);
  const { progressive } = await settled;
  const told = [];
  progressive.addEventListener('complete', () => told.push('complete'));
  await progressive.done;
  await nextTask();
  assert.ok(progressive.isComplete && progressive.isClosed);
  assert.deepEqual([told, calls], [['complete'], ['close']]);
});

test('loading stops by a signal between the last byte and the scene', { skip }, async () => {
  const end = new AbortController();
  const { settled, events, parser, gltf, THREE } = await begin({ signal: end.signal });
  const geometry = new THREE.BufferGeometry();
  let isFreed = false;
  geometry.addEventListener('dispose', () => (isFreed = true));
  gltf.scene.add(new THREE.Mesh(geometry));
  events.document(json, 0);
  events.update(isComplete);
  end.abort();
  parser.resolve(gltf);
  assert.equal((await settled).name, 'AbortError');
  await nextTask();
  assert.ok(isFreed);
});

test('only a lost connection is retried, or one that is being retried', { skip }, async () => {
  const { settled, events, parser, gltf, calls } = await begin();
  events.document(json, 0);
  parser.resolve(gltf);
  const { progressive } = await settled;
  progressive.retry();
  assert.deepEqual(calls, ['retry']);
  events.error({ kind: 'connection', message: '' });
  const { done } = progressive;
  await assert.rejects(done);
  progressive.retry();
  assert.deepEqual([calls, progressive.error], [['retry', 'retry'], undefined]);
  events.error({ kind: 'damaged', message: '' });
  progressive.retry();
  assert.deepEqual([calls.length, progressive.error.kind], [2, 'damaged']);
  await assert.rejects(progressive.done);
});

test('a loader drops complete models', { skip }, async () => {
  const { loader, settled, events, parser, gltf, THREE } = await begin();
  events.document(json, 0);
  parser.resolve(gltf);
  const { progressive } = await settled;
  const asked = [];
  progressive.setView = () => asked.push(progressive);
  loader.updatePriorities(new THREE.Camera());
  events.update(isComplete);
  loader.updatePriorities(new THREE.Camera());
  assert.equal(asked.length, 1);
});

test('the bounds of instances grow with the mesh', { skip }, async () => {
  const { THREE } = await load();
  const { StreamMesh } = await import('../three/stream_mesh.js');
  const { sizeOnScreen } = await import('../three/view.js');
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute('position', new THREE.BufferAttribute(Float32Array.of(0, 0, 0, 1, 0, 0, 0, 1, 0), 3));
  geometry.computeBoundingBox();
  const instances = new THREE.InstancedMesh(geometry, new THREE.MeshBasicMaterial(), 2);
  instances.setMatrixAt(0, new THREE.Matrix4());
  instances.setMatrixAt(1, new THREE.Matrix4().makeTranslation(10, 0, 0));
  instances.computeBoundingSphere();
  const mesh = new StreamMesh();
  mesh.add({ geometry, stream: 0, part: 0, names: ['position'] }, [instances]);
  const positions = Float32Array.of(0, 0, 0, 1, 0, 0, 0, 5, 0);
  const parts = [{ part: 0, length: 3, capacity: 3, bytesPerIndex: 2, ranges: [{ start: 0, array: Uint16Array.of(0, 1, 2) }] }];
  mesh.take({ firstVertex: 0, positions, attributes: [], parts, error: 0, fullVertices: 3 });
  const camera = new THREE.PerspectiveCamera(40, 1, 0.1, 1000);
  camera.position.set(5, 0, 100);
  assert.ok(sizeOnScreen([instances], camera) > 0);
  for (const x of [0, 10]) assert.ok(instances.boundingSphere.containsPoint(new THREE.Vector3(x, 5, 0)));
});
