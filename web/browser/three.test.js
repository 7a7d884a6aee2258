/**
 * The three.js loader in a browser: images compared with those of GLTFLoader and of the source, and
 * resource cleanup.
 */
import assert from 'node:assert/strict';
import { readFileSync, statSync, writeFileSync } from 'node:fs';
import path from 'node:path';
import { skip, startHarness } from './harness.js';
import { largeModels, ownModel, texturedScenes } from './models.js';
import { morphingSquare, readGlb, writeGlb } from '../testing/scene_glb.js';

/**
 * The maximum fraction of pixels that may differ from the source, because positions and texture
 * coordinates are quantized.
 */
const MAX_DIFFERENCE = 0.001;

/**
 * The maximum fraction of pixels that may differ from the output of `tristrip unpack`, whose
 * triangles are in a different order.
 */
const ROUNDING = 0.00002;

const STAGE = '/browser/pages/stage.html';

const harness = await startHarness();
const { models, server, test } = harness;

/** @param {string} file */
function pack(file) {
  const packed = models.pack(file);
  const full = models.unpack(packed);
  const source = models.copy(file);
  const { size } = statSync(path.join(models.folder, packed));
  return { packed: `/models/${packed}`, full: `/models/${full}`, source: `/models/${source}`, bytes: size };
}

/**
 * Writes a model derived from another one, and packs it.
 * @param {string} name
 * @param {Uint8Array} bytes
 */
function packBytes(name, bytes) {
  const file = path.join(models.folder, name);
  writeFileSync(file, bytes);
  const packed = models.pack(file);
  return { packed: `/models/${packed}`, full: `/models/${models.unpack(packed)}`, bytes: statSync(path.join(models.folder, packed)).size };
}

/** Messages of the browser about connections that are lost. @param {string} problem */
const isLoss = (problem) => /ERR_(CONNECTION|INCOMPLETE|CONTENT)/.test(problem);

/** Opens the stage. */
async function openStage() {
  const tab = await harness.open(STAGE);
  await tab.page.waitForFunction('window.stage');
  return tab;
}

test('the full level looks like the source', { skip }, async (t) => {
  const { page, problems } = await openStage();
  // Scenes with several parts per mesh and with tangents are only compared with the unpacked model.
  const others = ['engine_2cylinder.glb', 'sheencloth.glb'].map((name) => largeModels && path.join(largeModels, name)).filter((name) => name !== undefined);
  for (const file of [ownModel('milktruck.glb'), ...texturedScenes, ...others]) {
    await t.test(path.basename(file), async () => {
      const found = await page.evaluate(
        async ({ packed, full, source }) => {
          const { ProgressiveLoader, GLTFLoader, picturesOf, difference, trianglesOf } = window.stage;
          const gltf = await new ProgressiveLoader().loadAsync(packed);
          const base = trianglesOf(gltf);
          await gltf.progressive.done;
          const expected = await new GLTFLoader().loadAsync(source);
          const unpacked = await new GLTFLoader().loadAsync(full);
          // Skinned models are compared in two poses.
          const times = gltf.animations.length > 0 ? [0, 0.4] : [undefined];
          const differences = times.map((time) => {
            const { pictures, box } = picturesOf(expected, { time });
            const shown = picturesOf(gltf, { time, box }).pictures;
            return { fromSource: difference(pictures, shown), fromUnpacked: difference(picturesOf(unpacked, { time, box }).pictures, shown) };
          });
          const triangles = trianglesOf(gltf);
          for (const shown of [gltf, expected, unpacked]) shown.scene.removeFromParent();
          gltf.progressive.dispose();
          return { base, triangles, expected: trianglesOf(unpacked), differences };
        },
        pack(file),
      );
      assert.equal(found.triangles, found.expected);
      const percent = (/** @type {number} */ share) => `${(100 * share).toFixed(4)} %`;
      for (const { fromSource, fromUnpacked } of found.differences) {
        t.diagnostic(`${path.basename(file)}: ${found.base} to ${found.triangles} triangles, ${percent(fromSource)} of the pixels differ from the source`);
        assert.ok(fromUnpacked <= ROUNDING, `${percent(fromUnpacked)} of the pixels differ from the unpacked model`);
        if (others.includes(file)) continue;
        assert.ok(fromSource <= MAX_DIFFERENCE, `${percent(fromSource)} of the pixels differ from the source`);
      }
      assert.deepEqual(problems, []);
    });
  }
});

test('the scene is available early, and refines as the rest arrives', { skip }, async () => {
  const { packed, bytes } = pack(ownModel('hand.ply'));
  server.shape(packed, { bytesPerSecond: bytes / 5 });
  const { page, problems } = await openStage();
  const found = await page.evaluate(async (packed) => {
    const { ProgressiveLoader, picturesOf, difference, trianglesOf, THREE } = window.stage;
    // Compile shaders in advance, so that frames are short.
    picturesOf({ scene: new THREE.Mesh(new THREE.BoxGeometry(), new THREE.MeshStandardMaterial()) }, { views: 1 });
    const gltf = await new ProgressiveLoader().loadAsync(packed);
    const box = new THREE.Box3().setFromObject(gltf.scene);
    const steps = [];
    const note = () => {
      const bytes = gltf.progressive.progress?.receivedBytes ?? 0;
      steps.push({ bytes, triangles: trianglesOf(gltf), pictures: picturesOf(gltf, { views: 1, box }).pictures });
    };
    note();
    gltf.progressive.onUpdate(note);
    await gltf.progressive.done;
    const { pictures } = steps.at(-1);
    return steps.map((step) => ({ bytes: step.bytes, triangles: step.triangles, difference: difference(pictures, step.pictures) }));
  }, packed);
  server.shape(packed);
  assert.ok(found.length >= 5, `${found.length} steps`);
  assert.ok(found[0].bytes < bytes / 2, `the scene came after ${found[0].bytes} of ${bytes} bytes`);
  assert.ok(found[0].difference > 5 * MAX_DIFFERENCE, 'the first picture is a coarse one');
  for (const [i, step] of found.entries()) if (i > 0) assert.ok(step.triangles >= found[i - 1].triangles);
  assert.ok(found.at(-2)?.difference < found[0].difference / 2, 'pictures come near the last one');
  assert.deepEqual(problems, []);
});

test('a signal stops loading, before and after the scene is available', { skip }, async () => {
  const { packed, bytes } = pack(ownModel('hand.ply'));
  server.shape(packed, { bytesPerSecond: bytes / 5 });
  const { page, problems } = await openStage();
  const found = await page.evaluate(async (packed) => {
    const { ProgressiveLoader, trianglesOf } = window.stage;
    const loader = new ProgressiveLoader();
    const early = new AbortController();
    const loading = loader.loadAsync(packed, { signal: early.signal }).catch((error) => error.name);
    early.abort();
    const late = new AbortController();
    const gltf = await loader.loadAsync(packed, { signal: late.signal });
    await new Promise((resolve) => gltf.progressive.addEventListener('update', resolve));
    late.abort();
    const before = trianglesOf(gltf);
    const done = await gltf.progressive.done.catch((error) => error.name);
    await new Promise((resolve) => setTimeout(resolve, 1000));
    const aborted = await loader.loadAsync(packed, { signal: AbortSignal.abort() }).catch((error) => error.name);
    return { early: await loading, done, aborted, before, after: trianglesOf(gltf) };
  }, packed);
  server.shape(packed);
  assert.deepEqual([found.early, found.done, found.aborted], ['AbortError', 'AbortError', 'AbortError']);
  assert.ok(found.before > 0 && found.before === found.after);
  assert.deepEqual(problems, []);
});

test('everything on the GPU is freed by dispose', { skip }, async () => {
  const scenes = [ownModel('milktruck.glb'), ...texturedScenes.slice(1, 2)].map((file) => pack(file).packed);
  const { page, problems } = await openStage();
  const found = await page.evaluate(async (scenes) => {
    const { ProgressiveLoader, renderer, live, THREE, cameraAt } = window.stage;
    const loader = new ProgressiveLoader();
    const scene = new THREE.Scene();
    const memory = [];
    const note = () => memory.push({ ...renderer.info.memory, ...live });
    // The renderer creates its own textures for materials of this kind.
    const cube = new THREE.Mesh(new THREE.BoxGeometry(), new THREE.MeshStandardMaterial());
    renderer.render(cube, cameraAt(new THREE.Box3().setFromObject(cube), 0));
    cube.geometry.dispose();
    note();
    for (const isComplete of [false, true]) {
      const models = await Promise.all(scenes.map((url) => loader.loadAsync(url)));
      scene.add(...models.map((gltf) => gltf.scene));
      const camera = cameraAt(new THREE.Box3().setFromObject(scene), 0.1);
      renderer.render(scene, camera);
      for (const gltf of models) if (isComplete) await gltf.progressive.done;
      renderer.render(scene, camera);
      note();
      for (const gltf of models) gltf.progressive.dispose();
      renderer.render(scene, camera);
      note();
    }
    return { memory, children: scene.children.length };
  }, scenes);
  assert.equal(found.children, 0);
  const [before, ...later] = found.memory;
  assert.equal(before.geometries, 0);
  for (const [i, memory] of later.entries()) {
    if (i % 2 === 1) assert.deepEqual(memory, before);
    else assert.ok(memory.geometries >= 4);
  }
  assert.deepEqual(problems, []);
});

test('errors are passed to onError before the scene is available, and are events afterwards', { skip }, async () => {
  const { packed, bytes } = pack(ownModel('hand.ply'));
  const { page, problems } = await openStage();
  const load = (/** @type {string} */ url) =>
    page.evaluate(async (url) => {
      const { ProgressiveLoader, trianglesOf } = window.stage;
      try {
        const gltf = await new ProgressiveLoader().loadAsync(url);
        const event = await new Promise((resolve) => {
          gltf.progressive.addEventListener('error', ({ error }) => resolve(error.kind));
          gltf.progressive.addEventListener('complete', () => resolve('complete'));
        });
        const done = await gltf.progressive.done.then(() => 'done', (error) => error.kind);
        return { event, done, triangles: trianglesOf(gltf) };
      } catch (error) {
        return { thrown: error.kind, message: error.message };
      }
    }, url);
  const full = await load(packed);
  assert.equal(full.event, 'complete');
  server.shape(packed, { flipAt: Math.floor(0.7 * bytes) });
  const damaged = await load(packed);
  assert.deepEqual([damaged.event, damaged.done], ['damaged', 'damaged']);
  assert.ok(damaged.triangles > 256 && damaged.triangles < full.triangles, `${damaged.triangles} triangles`);
  server.shape(packed, { flipAt: 1 });
  assert.equal((await load(packed)).thrown, 'not-glb');
  server.shape(packed, { status: 404 });
  assert.equal((await load(packed)).thrown, 'status');
  server.shape(packed);
  assert.deepEqual(problems.filter((problem) => !problem.includes('404')), []);
});

test('bounds, rays and buffers are right while a model refines', { skip }, async () => {
  const { packed, full, bytes } = pack(ownModel('hand.ply'));
  server.shape(packed, { bytesPerSecond: bytes / 2 });
  const { page, problems } = await openStage();
  const found = await page.evaluate(
    async ({ packed, full }) => {
      const { ProgressiveLoader, GLTFLoader, THREE } = window.stage;
      const gltf = await new ProgressiveLoader().loadAsync(packed);
      const mesh = gltf.scene.getObjectByProperty('isMesh', true);
      const arrays = new Set();
      const outside = [];
      const check = () => {
        const { position } = mesh.geometry.attributes;
        arrays.add(position.array);
        const { boundingBox, boundingSphere } = mesh.geometry;
        const point = new THREE.Vector3();
        let most = 0;
        for (let i = 0; i < position.count; i++) {
          point.fromBufferAttribute(position, i);
          most = Math.max(most, boundingBox.distanceToPoint(point), boundingSphere.distanceToPoint(point));
        }
        outside.push(most / boundingSphere.radius);
      };
      check();
      gltf.progressive.onUpdate(check);
      await gltf.progressive.done;
      const expected = (await new GLTFLoader().loadAsync(full)).scene;
      expected.updateMatrixWorld(true);
      gltf.scene.updateMatrixWorld(true);
      const center = mesh.geometry.boundingBox.getCenter(new THREE.Vector3());
      const hits = [];
      for (let i = 0; i < 50; i++) {
        const direction = new THREE.Vector3(Math.sin(i), Math.cos(2 * i), Math.sin(3 * i)).normalize();
        const ray = new THREE.Raycaster(center.clone().addScaledVector(direction, -1000), direction);
        const distance = (object) => ray.intersectObject(object)[0]?.distance ?? 0;
        hits.push(Math.abs(distance(expected) - distance(gltf.scene)));
      }
      const { position } = mesh.geometry.attributes;
      return { outside, arrays: arrays.size, worst: Math.max(...hits), count: position.count, room: position.array.length / 3 };
    },
    { packed, full },
  );
  server.shape(packed);
  assert.ok(Math.max(...found.outside) < 1e-6, `${found.outside}`);
  assert.ok(found.worst < 1e-3, `${found.worst}`);
  assert.ok(found.arrays <= 9, `${found.arrays} buffers`);
  assert.equal(found.room, found.count, 'no room is left over in the end');
  assert.deepEqual(problems, []);
});

test('a skinned mesh stays within its bounds', { skip: skip || (texturedScenes.length === 0 && 'SKIPPED: TRISTRIP_MODELS is not set') }, async () => {
  const { packed, bytes } = pack(/** @type {string} */ (texturedScenes.find((file) => file.endsWith('CesiumMan.glb'))));
  server.shape(packed, { bytesPerSecond: bytes / 2 });
  const { page, problems } = await openStage();
  const found = await page.evaluate(async (packed) => {
    const { ProgressiveLoader, renderer, THREE, cameraAt, trianglesOf } = window.stage;
    const gltf = await new ProgressiveLoader().loadAsync(packed);
    const mesh = gltf.scene.getObjectByProperty('isSkinnedMesh', true);
    renderer.render(gltf.scene, cameraAt(new THREE.Box3().setFromObject(gltf.scene), 0));
    const base = trianglesOf(gltf);
    await gltf.progressive.done;
    const { boundingSphere, geometry } = mesh;
    let outside = 0;
    for (let i = 0; i < geometry.attributes.position.count; i++) {
      outside = Math.max(outside, boundingSphere.distanceToPoint(mesh.getVertexPosition(i, new THREE.Vector3())));
    }
    return { base, triangles: trianglesOf(gltf), outside, radius: boundingSphere.radius };
  }, packed);
  server.shape(packed);
  assert.ok(found.base < found.triangles);
  assert.equal(found.outside, 0, `${found.outside} of ${found.radius}`);
  assert.deepEqual(problems, []);
});

test('a GLB without the extension, and one from memory', { skip }, async () => {
  const { packed, full } = pack(ownModel('milktruck.glb'));
  const { page, problems } = await openStage();
  const found = await page.evaluate(
    async ({ packed, full }) => {
      const { ProgressiveLoader, trianglesOf } = window.stage;
      const loader = new ProgressiveLoader();
      const plain = await loader.loadAsync(full);
      await plain.progressive.done;
      const data = await (await fetch(packed)).arrayBuffer();
      const sources = [data, new Uint8Array(data), new Blob([data])];
      const parsed = await Promise.all(sources.map((source) => loader.parseAsync(source)));
      await Promise.all(parsed.map((gltf) => gltf.progressive.done));
      return [plain, ...parsed].map(trianglesOf);
    },
    { packed, full },
  );
  assert.deepEqual(found, [found[0], found[0], found[0], found[0]]);
  assert.deepEqual(problems, []);
});

test('models in view load before those that are not', { skip }, async () => {
  const { packed, bytes } = pack(ownModel('hand.ply'));
  server.shape(packed, { bytesPerSecond: bytes / 2 });
  const { page, problems } = await openStage();
  const found = await page.evaluate(async (packed) => {
    const { ProgressiveLoader, THREE, cameraAt } = window.stage;
    const loader = new ProgressiveLoader();
    const names = ['behind', 'in view'];
    const models = await Promise.all(names.map((name) => loader.loadAsync(`${packed}?${name}`)));
    const box = new THREE.Box3().setFromObject(models[1].scene);
    const camera = cameraAt(box, 0);
    models[0].scene.position.copy(camera.position).sub(box.getCenter(new THREE.Vector3())).multiplyScalar(4);
    loader.updatePriorities(camera);
    const order = [];
    await Promise.all(models.map((gltf, i) => gltf.progressive.done.then(() => order.push(names[i]))));
    return order;
  }, packed);
  server.shape(packed);
  assert.deepEqual(found, ['in view', 'behind']);
  assert.deepEqual(problems, []);
});

test('buffers that are replaced are freed on the GPU', { skip }, async () => {
  const { packed, full, bytes } = pack(ownModel('milktruck.glb'));
  server.shape(packed, { bytesPerSecond: bytes / 2 });
  const { page, problems } = await openStage();
  const found = await page.evaluate(
    async ({ packed, full }) => {
      const { ProgressiveLoader, GLTFLoader, renderer, live, THREE, cameraAt } = window.stage;
      const scene = new THREE.Scene();
      const buffersOf = async (load) => {
        const before = live.buffers;
        await load();
        renderer.render(scene, cameraAt(new THREE.Box3().setFromObject(scene), 0.1));
        return live.buffers - before;
      };
      const refined = await buffersOf(async () => {
        const gltf = await new ProgressiveLoader().loadAsync(packed);
        scene.add(gltf.scene);
        const camera = cameraAt(new THREE.Box3().setFromObject(scene), 0.1);
        gltf.progressive.onUpdate(() => renderer.render(scene, camera));
        await gltf.progressive.done;
      });
      const plain = await buffersOf(async () => scene.add((await new GLTFLoader().loadAsync(full)).scene));
      return { refined, plain };
    },
    { packed, full },
  );
  server.shape(packed);
  assert.equal(found.refined, found.plain);
  assert.deepEqual(problems, []);
});

test('a lost connection resumes where it was lost, also after the last automatic retry', { skip }, async () => {
  const { packed, bytes } = pack(ownModel('hand.ply'));
  const { page, problems } = await openStage();
  const drop = Math.floor(0.6 * bytes);
  server.shape(packed, { dropAfter: drop, drops: Infinity });
  const known = server.requestsOf(packed).length;
  const lost = await page.evaluate(async (packed) => {
    const { ProgressiveLoader, trianglesOf } = window.stage;
    const gltf = await new ProgressiveLoader().loadAsync(packed);
    const { progressive } = gltf;
    const events = [];
    for (const type of ['error', 'complete']) progressive.addEventListener(type, () => events.push(type));
    // A retry skips the delay, which would otherwise add up to a minute.
    progressive.addEventListener('connection', ({ state }) => state === 'retrying' && setTimeout(() => progressive.retry(), 20));
    const kind = await progressive.done.catch((error) => error.kind);
    Object.assign(window, { gltf, events });
    return { kind, told: progressive.error?.kind, isClosed: progressive.isClosed, triangles: trianglesOf(gltf), received: progressive.progress.receivedBytes };
  }, packed);
  assert.deepEqual([lost.kind, lost.told, lost.isClosed], ['connection', 'connection', false]);
  // Data in flight are lost when a connection breaks.
  assert.ok(lost.received > 0 && lost.received <= drop, `${lost.received} of ${drop} bytes`);
  server.shape(packed);
  const found = await page.evaluate(async () => {
    const { gltf, events, stage } = window;
    gltf.progressive.retry();
    const error = gltf.progressive.error;
    await gltf.progressive.done;
    await new Promise((resolve) => setTimeout(resolve, 50));
    // The model is complete, so this has no effect.
    gltf.progressive.retry();
    return { error, events, triangles: stage.trianglesOf(gltf), isComplete: gltf.progressive.isComplete };
  });
  assert.deepEqual([found.error, found.events, found.isComplete], [undefined, ['error', 'complete'], true]);
  assert.ok(lost.triangles < found.triangles);
  // Received bytes are not requested again.
  const firsts = server.requestsOf(packed).slice(known + 1).map(({ range }) => Number(/^bytes=(\d+)-$/.exec(range ?? '')?.[1]));
  assert.ok(firsts.every((first, i) => first >= (firsts[i - 1] ?? 1)), `${firsts}`);
  assert.equal(firsts.at(-1), lost.received);
  assert.deepEqual(problems.filter((problem) => !isLoss(problem)), []);
});

test('nothing arrives while a model is paused', { skip }, async () => {
  const { packed, bytes } = pack(ownModel('hand.ply'));
  server.shape(packed, { bytesPerSecond: bytes / 3 });
  const { page, problems } = await openStage();
  const found = await page.evaluate(async (packed) => {
    const { ProgressiveLoader, trianglesOf } = window.stage;
    const gltf = await new ProgressiveLoader().loadAsync(packed);
    const { progressive } = gltf;
    const states = [];
    progressive.addEventListener('connection', ({ state }) => states.push(state));
    await new Promise((resolve) => progressive.addEventListener('update', resolve));
    const paused = new Promise((resolve) => progressive.addEventListener('connection', ({ state }) => state === 'paused' && resolve()));
    progressive.pause();
    await paused;
    // Data in flight may still arrive.
    await new Promise((resolve) => setTimeout(resolve, 500));
    const note = () => [trianglesOf(gltf), progressive.progress.receivedBytes];
    const before = note();
    await new Promise((resolve) => setTimeout(resolve, 1000));
    const after = note();
    progressive.resume();
    await progressive.done;
    return { before, after, end: note(), states };
  }, packed);
  server.shape(packed);
  assert.deepEqual(found.before, found.after);
  assert.ok(found.before[0] < found.end[0]);
  assert.equal(found.end[1], bytes);
  assert.ok(found.states.includes('paused'), String(found.states));
  assert.deepEqual(problems, []);
});

test('material variants work as in GLTFLoader, also while the mesh refines', { skip }, async () => {
  const { json, binary } = readGlb(readFileSync(ownModel('milktruck.glb')));
  const red = json.materials.length;
  json.materials.push({ name: 'red', pbrMetallicRoughness: { baseColorFactor: [1, 0, 0, 1] } });
  json.extensionsUsed = [...(json.extensionsUsed ?? []), 'KHR_materials_variants'];
  json.extensions = { ...json.extensions, KHR_materials_variants: { variants: [{ name: 'red' }] } };
  for (const { primitives } of json.meshes) {
    for (const primitive of primitives) primitive.extensions = { ...primitive.extensions, KHR_materials_variants: { mappings: [{ material: red, variants: [0] }] } };
  }
  const { packed, full, bytes } = packBytes('variants.glb', writeGlb(json, binary));
  server.shape(packed, { bytesPerSecond: bytes / 2 });
  const { page, problems } = await openStage();
  const found = await page.evaluate(
    async ({ packed, full }) => {
      const { ProgressiveLoader, GLTFLoader, picturesOf, difference } = window.stage;
      const extensionsOf = (gltf) => {
        const all = [gltf.userData.gltfExtensions?.KHR_materials_variants];
        gltf.scene.traverse(({ isMesh, userData }) => isMesh && all.push(userData.gltfExtensions));
        return all;
      };
      const choose = async (gltf) => {
        const meshes = [];
        gltf.scene.traverse((object) => object.isMesh && meshes.push(object));
        for (const mesh of meshes) {
          const [{ material }] = mesh.userData.gltfExtensions.KHR_materials_variants.mappings;
          mesh.material = await gltf.parser.getDependency('material', material);
          gltf.parser.assignFinalMaterial(mesh);
        }
        return meshes.map(({ material }) => material);
      };
      const gltf = await new ProgressiveLoader().loadAsync(packed);
      const isEarly = !gltf.progressive.isComplete;
      const extensions = extensionsOf(gltf);
      const chosen = await choose(gltf);
      await gltf.progressive.done;
      const expected = await new GLTFLoader().loadAsync(full);
      const expectedExtensions = extensionsOf(expected);
      await choose(expected);
      const { pictures, box } = picturesOf(expected);
      const shown = difference(pictures, picturesOf(gltf, { box }).pictures);
      let disposed = 0;
      for (const material of new Set(chosen)) material.addEventListener('dispose', () => disposed++);
      gltf.progressive.dispose();
      return { isEarly, extensions, expectedExtensions, shown, names: chosen.map(({ name }) => name), disposed, materials: new Set(chosen).size };
    },
    { packed, full },
  );
  server.shape(packed);
  assert.ok(found.isEarly);
  assert.ok(found.extensions[0] && found.extensions.every(Boolean));
  assert.deepEqual(found.extensions, found.expectedExtensions);
  assert.ok(found.names.every((name) => name === 'red'));
  assert.ok(found.shown <= ROUNDING, `${found.shown}`);
  assert.equal(found.disposed, found.materials, 'materials of variants are freed, too');
  assert.deepEqual(problems, []);
});

test('morph targets of other meshes are unchanged while a mesh refines', { skip }, async () => {
  const { json, binary } = readGlb(readFileSync(ownModel('milktruck.glb')));
  const square = morphingSquare({ mesh: [0.5, 0], node: [0.25, 1] });
  const own = readGlb(square.bytes);
  // Adds the square to the scene of the truck.
  const counts = { views: json.bufferViews.length, accessors: json.accessors.length, meshes: json.meshes.length, nodes: json.nodes.length };
  const start = (binary.length + 3) & ~3;
  const joined = new Uint8Array(start + own.binary.length);
  joined.set(binary);
  joined.set(own.binary, start);
  json.buffers[0].byteLength = joined.length;
  json.bufferViews.push(...own.json.bufferViews.map((view) => ({ ...view, byteOffset: view.byteOffset + start })));
  json.accessors.push(...own.json.accessors.map((accessor) => ({ ...accessor, bufferView: accessor.bufferView + counts.views })));
  const at = (/** @type {number} */ accessor) => accessor + counts.accessors;
  json.meshes.push({ weights: [0.5, 0], primitives: [{ attributes: { POSITION: at(0) }, indices: at(3), targets: [{ POSITION: at(1) }, { POSITION: at(2) }] }] });
  json.nodes.push({ mesh: counts.meshes, name: 'square', weights: [0.25, 1], translation: [0, 3, 0] });
  json.scenes[0].nodes.push(counts.nodes);
  json.animations = [{ name: 'Stretch', samplers: [{ input: at(4), output: at(5) }], channels: [{ sampler: 0, target: { node: counts.nodes, path: 'weights' } }] }];
  const { packed, full, bytes } = packBytes('morphs.glb', writeGlb(json, joined));
  server.shape(packed, { bytesPerSecond: bytes / 2 });
  const { page, problems } = await openStage();
  const found = await page.evaluate(
    async ({ packed, full }) => {
      const { ProgressiveLoader, GLTFLoader, picturesOf, difference, trianglesOf } = window.stage;
      const gltf = await new ProgressiveLoader().loadAsync(packed);
      const steps = [];
      const note = () => {
        const morphed = [];
        gltf.scene.traverse((object) => {
          if (!object.isMesh) return;
          const { attributes, morphAttributes } = object.geometry;
          const counts = (morphAttributes.position ?? []).map(({ count }) => count === attributes.position.count);
          if (counts.length > 0 || object.morphTargetInfluences) morphed.push([object.name, counts, [...(object.morphTargetInfluences ?? [])]]);
        });
        steps.push({ morphed, triangles: trianglesOf(gltf) });
      };
      note();
      gltf.progressive.onUpdate(note);
      await gltf.progressive.done;
      note();
      const expected = await new GLTFLoader().loadAsync(full);
      const differences = [undefined, 50].map((time) => {
        const { pictures, box } = picturesOf(expected, { time });
        return difference(pictures, picturesOf(gltf, { time, box }).pictures);
      });
      return { steps, differences };
    },
    { packed, full },
  );
  server.shape(packed);
  assert.ok(found.steps.length > 3 && found.steps[0].triangles < (found.steps.at(-1)?.triangles ?? 0));
  for (const { morphed } of found.steps) assert.deepEqual(morphed, [['square', [true, true], [0.25, 1]]]);
  assert.ok(Math.max(...found.differences) <= ROUNDING, String(found.differences));
  assert.deepEqual(problems, []);
});

test('a primitive with morph targets and a stream keeps its base mesh', { skip }, async () => {
  const { packed } = pack(ownModel('hand.ply'));
  const { json, binary } = readGlb(readFileSync(path.join(models.folder, path.basename(packed))));
  const [primitive] = json.meshes[0].primitives;
  const { POSITION } = primitive.attributes;
  primitive.targets = [{ POSITION }];
  json.meshes[0].weights = [0.5];
  writeFileSync(path.join(models.folder, 'both.glb'), writeGlb(json, binary));
  const { page, problems } = await openStage();
  const found = await page.evaluate(async () => {
    const { ProgressiveLoader, picturesOf } = window.stage;
    const gltf = await new ProgressiveLoader().loadAsync('/models/both.glb');
    await gltf.progressive.done;
    picturesOf(gltf, { views: 1 });
    const { geometry, morphTargetInfluences } = gltf.scene.getObjectByProperty('isMesh', true);
    return { count: geometry.attributes.position.count, morphs: geometry.morphAttributes.position[0].count, morphTargetInfluences };
  });
  assert.deepEqual(found, { count: json.accessors[POSITION].count, morphs: json.accessors[POSITION].count, morphTargetInfluences: [0.5] });
  assert.deepEqual(problems, []);
});

test('a model that is disposed of or aborted during the download gets no more events', { skip }, async () => {
  const { packed, bytes } = pack(ownModel('hand.ply'));
  server.shape(packed, { bytesPerSecond: bytes / 4 });
  const { page, problems } = await openStage();
  for (const how of ['dispose', 'abort', 'cancel']) {
    const found = await page.evaluate(
      async ({ packed, how }) => {
        const { ProgressiveLoader, renderer, live, THREE, cameraAt } = window.stage;
        const scene = new THREE.Scene();
        // The renderer creates its own texture for materials of this kind.
        const cube = new THREE.Mesh(new THREE.BoxGeometry(), new THREE.MeshStandardMaterial());
        renderer.render(cube, cameraAt(new THREE.Box3().setFromObject(cube), 0));
        cube.geometry.dispose();
        const before = { ...renderer.info.memory, ...live };
        const stop = new AbortController();
        const gltf = await new ProgressiveLoader().loadAsync(packed, { signal: stop.signal });
        const { progressive } = gltf;
        scene.add(gltf.scene);
        const camera = cameraAt(new THREE.Box3().setFromObject(scene), 0.1);
        const events = [];
        for (const type of ['update', 'progress', 'connection', 'error', 'complete']) progressive.addEventListener(type, () => events.push(type));
        // Stop in the middle of an update, right after a frame was drawn.
        await new Promise((resolve) => {
          progressive.onUpdate(() => {
            renderer.render(scene, camera);
            if (how === 'abort') stop.abort(new Error('enough'));
            else progressive[how]();
            resolve();
          });
        });
        const done = await progressive.done.catch((error) => [error.name, error.message]);
        // The event that stops loading is dispatched before loading ends.
        const known = events.length;
        await new Promise((resolve) => setTimeout(resolve, 1500));
        progressive.pause();
        progressive.resume();
        progressive.retry();
        progressive.cancel();
        progressive.dispose();
        progressive.dispose();
        renderer.render(scene, camera);
        const after = { ...renderer.info.memory, ...live };
        return { done, more: events.slice(known), isClosed: progressive.isClosed, isComplete: progressive.isComplete, children: scene.children.length, before, after };
      },
      { packed, how },
    );
    assert.deepEqual(found.done, how === 'abort' ? ['Error', 'enough'] : ['AbortError', 'Loading was cancelled.'], how);
    assert.deepEqual([found.more, found.isClosed, found.isComplete, found.children], [[], true, false, 0], how);
    assert.deepEqual(found.after, found.before, how);
  }
  server.shape(packed);
  assert.deepEqual(problems, []);
});

test('loading a URL twice gives two independent models', { skip }, async () => {
  const { packed, bytes } = pack(ownModel('hand.ply'));
  server.shape(packed, { bytesPerSecond: bytes / 2 });
  const { page, problems } = await openStage();
  const found = await page.evaluate(async (packed) => {
    const { ProgressiveLoader, THREE, trianglesOf } = window.stage;
    THREE.Cache.enabled = true;
    const loader = new ProgressiveLoader();
    const [first, second, third] = await Promise.all([loader.loadAsync(packed), loader.loadAsync(packed), new ProgressiveLoader().loadAsync(packed)]);
    const geometryOf = (gltf) => gltf.scene.getObjectByProperty('isMesh', true).geometry;
    const before = trianglesOf(first);
    const areApart = new Set([first, second, third].map(geometryOf)).size === 3;
    first.progressive.dispose();
    await Promise.all([second.progressive.done, third.progressive.done]);
    return { before, areApart, triangles: [first, second, third].map(trianglesOf), isComplete: first.progressive.isComplete };
  }, packed);
  server.shape(packed);
  assert.ok(found.areApart);
  assert.deepEqual([found.triangles[0], found.isComplete], [found.before, false]);
  assert.ok(found.triangles[1] > found.before);
  assert.equal(found.triangles[1], found.triangles[2]);
  assert.deepEqual(problems, []);
});
