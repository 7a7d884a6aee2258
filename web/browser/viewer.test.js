/** The viewer page in a browser: slow links, errors, keyboard, phones, and resource use. */
import assert from 'node:assert/strict';
import { mkdirSync, readFileSync, statSync, writeFileSync } from 'node:fs';
import path from 'node:path';
import { setTimeout as sleep } from 'node:timers/promises';
import { skip, startHarness } from './harness.js';
import { heapOf } from './heap.js';
import { largeModels, ownModel, texturedScenes } from './models.js';
import { difference } from './pictures.js';
import { morphingSquare, sceneGlb } from '../testing/scene_glb.js';

/**
 * The maximum fraction of differing pixels between equal images, and the minimum between different
 * ones.
 */
const EQUAL = 0.0005;
const DIFFERENT = 0.002;

/** The number of bytes of a large model that suffice for a first image. */
const FIRST_BYTES = 100_000;

/**
 * The maximum growth of memory in bytes while models are opened and closed; each model needs more.
 */
const MAX_GROWTH = 2 ** 21;

/** The number of models opened; 50 in nightly runs. */
const OPENED_MODELS = Number(process.env.TRISTRIP_OPENED_MODELS ?? 12);

/**
 * How long a model is orbited in seconds (a minute before releases), and the maximum growth of
 * memory in the meantime.
 */
const ORBIT_SECONDS = Number(process.env.TRISTRIP_ORBIT_SECONDS ?? 12);
const MAX_ORBIT_GROWTH = 0.1;

const needsModels = !largeModels && 'SKIPPED: TRISTRIP_MODELS is not set';

const DESKTOP = { viewport: { width: 1000, height: 700 } };
const PHONE = { viewport: { width: 390, height: 844 }, deviceScaleFactor: 2, isMobile: true, hasTouch: true };

const harness = await startHarness();
const { models, server, test } = harness;

/** @typedef {{ name: string, url: string, bytes: number }} PackedModel */

/** @param {string} file @returns {PackedModel} */
function pack(file) {
  const packed = models.pack(file);
  return { name: packed, url: `/models/${packed}`, bytes: statSync(path.join(models.folder, packed)).size };
}

const hand = skip ? undefined : pack(ownModel('hand.ply'));
const truck = skip ? undefined : pack(texturedScenes[2] ?? ownModel('milktruck.glb'));

/** @type {(model: PackedModel | undefined) => PackedModel} */
const present = (model) => /** @type {PackedModel} */ (model);

if (!skip) {
  const listed = [present(hand), present(truck)].map(({ name, url, bytes }) => {
    return { name: name.replace('.packed.glb', ''), url: url.slice(1), kind: 'packed', bytes, triangles: 1000, vertices: 500 };
  });
  writeFileSync(path.join(models.folder, 'models.json'), JSON.stringify({ models: listed }));
}

/**
 * A model with morph targets and two animations. Its weights at rest are those of the first
 * animation, or zeros.
 */
const [morphed, unmorphed] = [{ node: [1, 0] }, {}].map((weights, i) => {
  const name = `morph${i}.glb`;
  const { bytes } = morphingSquare(weights);
  writeFileSync(path.join(models.folder, name), bytes);
  return { name, url: `/models/${name}`, bytes: bytes.length };
});

/** @typedef {import('playwright-core').Page} Page */

/**
 * Opens the viewer with the gallery or a model.
 * @param {PackedModel} [model]
 * @param {import('playwright-core').BrowserContextOptions} [options]
 */
async function openViewer(model, options = DESKTOP) {
  const tab = await harness.open(`/index.html${model ? `#model=${model.url.slice(1)}` : ''}`, options);
  await tab.page.waitForFunction('window.tristrip');
  return tab;
}

/** @type {(page: Page, state: string) => Promise<unknown>} */
const waitForState = (page, state) => page.waitForFunction((state) => window.tristrip.viewer.state === state, state);

/** Returns a picture of the model alone. @param {Page} page */
const picture = (page) => page.locator('#canvas').screenshot({ style: '#view > :not(canvas) { visibility: hidden }' });

/** Waits until a picture is drawn. @param {Page} page */
const waitForPicture = (page) => page.waitForFunction(() => window.tristrip.viewer.hasPicture);

/** Waits until the picture shows all that has arrived. @param {Page} page */
const settle = (page) => page.waitForFunction(() => window.tristrip.viewer.renderer.isIdle);

/**
 * Changes the hash of the address, and waits until the page has followed.
 * @type {(page: Page, hash: string) => Promise<void>}
 */
const goTo = (page, hash) =>
  page.evaluate(
    (hash) =>
      new Promise((resolve) => {
        const { href } = location;
        window.addEventListener('hashchange', () => resolve(undefined), { once: true });
        location.hash = hash;
        if (location.href === href) resolve(undefined);
      }),
    hash,
  );

/** The maximum duration of repeated checks, in milliseconds. */
const PATIENCE = 60_000;

/**
 * Repeats a check until it passes.
 * @param {() => Promise<void>} check throws until it passes
 */
async function eventually(check) {
  for (const end = Date.now() + PATIENCE; ; await sleep(100)) {
    try {
      return await check();
    } catch (error) {
      if (Date.now() > end) throw error;
    }
  }
}

/** @param {Page} page */
const triangles = (page) => page.evaluate(() => window.tristrip.viewer.figures.sums.triangles);

test('a model refines from its base mesh to the full image over a stalling link', { skip }, async () => {
  const model = present(hand);
  const reference = await openViewer(model);
  await waitForState(reference.page, 'complete');
  const full = await picture(reference.page);

  // The link stalls at four positions.
  const holds = [0.2, 0.4, 0.6, 0.8].map((share) => Math.floor(share * model.bytes));
  server.shape(model.url, { holdAfter: holds[0] });
  const { page, problems } = await openViewer(model);
  const pictures = [];
  let shown = 0;
  for (const bytes of holds) {
    server.hold(model.url, bytes);
    await page.waitForFunction((shown) => window.tristrip.viewer.hasPicture && window.tristrip.viewer.figures.sums.triangles > shown, shown);
    await settle(page);
    shown = await triangles(page);
    pictures.push(await picture(page));
  }
  server.hold(model.url);
  await waitForState(page, 'complete');
  await settle(page);
  pictures.push(await picture(page));

  const differences = [];
  for (const one of pictures) differences.push(await difference(page, full, one));
  const text = differences.map((one) => `${(100 * one).toFixed(2)} %`).join(', ');
  assert.ok(differences[0] > DIFFERENT, `the first picture is a coarse one: ${text}`);
  assert.ok(differences[4] <= EQUAL, text);
  for (let i = 1; i < differences.length; i++) assert.ok(differences[i] <= differences[i - 1] + EQUAL, `each picture is nearer than the one before: ${text}`);
  assert.deepEqual([...problems, ...reference.problems], []);
});

test('a flipped bit shows a message, and the last valid image remains', { skip }, async () => {
  const model = present(hand);
  server.shape(model.url, { flipAt: Math.floor(0.6 * model.bytes) });
  const { page, problems } = await openViewer(model);
  await waitForState(page, 'failed');
  server.shape(model.url);
  const message = page.locator('#message');
  await message.locator('p').first().waitFor();
  assert.match(await message.innerText(), /damaged/);
  const shown = await triangles(page);
  assert.ok(shown > 256, `${shown} triangles are shown`);
  const before = await picture(page);
  await page.locator('#canvas').focus();
  await page.keyboard.press('ArrowLeft');
  await settle(page);
  assert.ok((await difference(page, before, await picture(page))) > DIFFERENT, 'the picture can still be turned');
  assert.equal(await triangles(page), shown);
  assert.deepEqual(problems, []);
});

test('missing files, and files that are not GLB, show a message', { skip }, async () => {
  const { page } = await openViewer();
  for (const [name, words] of /** @type {[string, RegExp][]} */ ([['models/none.glb', /refused/], ['models/models.json', /not a GLB/]])) {
    await goTo(page, `#model=${name}`);
    await page.locator('#message', { hasText: words }).waitFor();
  }
});

test('a scene without meshes, and an error after the context was lost, show a message', { skip }, async () => {
  const json = '{"asset":{"version":"2.0"}} ';
  const header = Uint32Array.of(0x46546c67, 2, 28 + json.length, json.length, 0x4e4f534a);
  const binary = Uint32Array.of(0, 0x004e4942);
  writeFileSync(path.join(models.folder, 'empty.glb'), Buffer.concat([Buffer.from(header.buffer), Buffer.from(json), Buffer.from(binary.buffer)]));
  const { page } = await openViewer();
  const show = (/** @type {string} */ name) => goTo(page, `#model=models/${name}`);
  await show('empty.glb');
  await page.locator('#message', { hasText: 'nothing to show' }).waitFor();
  assert.ok(await page.locator('#busy').isHidden());
  await show('none.glb');
  const error = page.locator('#message', { hasText: /refused/ });
  await error.waitFor();
  await page.evaluate(() => {
    window.loss = document.querySelector('canvas').getContext('webgl2').getExtension('WEBGL_lose_context');
    window.loss.loseContext();
  });
  await page.locator('#message', { hasText: 'graphics context' }).waitFor();
  await page.evaluate(() => window.loss.restoreContext());
  await error.waitFor();
  await page.locator('#message button').click();
  assert.equal(await page.evaluate(() => document.activeElement?.id), 'canvas');
});

test('a lost connection resumes where it was lost', { skip }, async () => {
  const model = present(hand);
  const drop = Math.floor(0.5 * model.bytes);
  const known = server.requestsOf(model.url).length;
  server.shape(model.url, { bytesPerSecond: model.bytes / 2, dropAfter: drop });
  const { page, problems } = await openViewer(model);
  await waitForState(page, 'complete');
  server.shape(model.url);
  const ranges = server.requestsOf(model.url).slice(known).map(({ range }) => range);
  assert.equal(ranges.length, 2, String(ranges));
  // Data in flight are lost when a connection breaks.
  const first = Number(/^bytes=(\d+)-$/.exec(ranges[1] ?? '')?.[1]);
  assert.ok(first > 0 && first <= drop, `${ranges[1]}, dropped after ${drop}`);
  assert.equal(await page.locator('#message').innerText(), '');
  assert.deepEqual(problems.filter((problem) => !/ERR_(CONNECTION|INCOMPLETE|CONTENT)/.test(problem)), []);
});

test('everything works with the keyboard', { skip }, async () => {
  const model = present(hand);
  const { page, problems } = await openViewer();
  await page.locator('#cards a').first().focus();
  await page.keyboard.press('Enter');
  await waitForState(page, 'complete');
  const isFocused = (/** @type {string} */ id) => page.evaluate((id) => document.activeElement?.id === id, id);
  assert.ok(await isFocused('canvas'), 'the canvas has the focus when a model is opened');
  const start = await picture(page);
  const changed = async () => {
    await settle(page);
    return difference(page, start, await picture(page));
  };
  for (const key of ['ArrowLeft', 'ArrowDown', 'Shift+ArrowRight', '+']) {
    await page.keyboard.press(key);
    assert.ok((await changed()) > DIFFERENT, key);
    await page.keyboard.press('0');
    assert.ok((await changed()) <= EQUAL, `0 after ${key}`);
  }
  for (const [key, mode] of ['shaded', 'textured', 'wireframe', 'strips', 'normals'].entries()) {
    await page.keyboard.press(String(key + 1));
    assert.equal(await page.evaluate(() => window.tristrip.viewer.renderer.mode), mode);
    assert.ok(await page.locator(`#modes input[value=${mode}]`).isChecked());
  }
  await page.keyboard.press('?');
  assert.ok(await page.locator('#help-dialog').isVisible());
  await page.keyboard.press('Escape');
  assert.ok(!(await page.locator('#help-dialog').isVisible()));
  // Change the level of detail with the slider.
  const full = await triangles(page);
  await page.locator('#level').focus();
  await page.keyboard.press('Home');
  await page.waitForFunction((full) => window.tristrip.viewer.figures.sums.triangles < full, full);
  await page.keyboard.press('End');
  await page.waitForFunction((full) => window.tristrip.viewer.figures.sums.triangles === full, full);
  await page.keyboard.press('Escape');
  await page.locator('#gallery').waitFor({ state: 'visible' });

  // Pause and continue.
  server.shape(model.url, { bytesPerSecond: model.bytes / 4 });
  await page.locator('#cards a').first().focus();
  await page.keyboard.press('Enter');
  await waitForPicture(page);
  await page.keyboard.press(' ');
  await page.waitForFunction(() => window.tristrip.viewer.connection === 'paused');
  await settle(page);
  const paused = await triangles(page);
  await page.waitForTimeout(1000);
  assert.equal(await triangles(page), paused, 'nothing is refined while it is paused');
  await page.keyboard.press(' ');
  await waitForState(page, 'complete');
  server.shape(model.url);
  assert.deepEqual(problems, []);
});

test('a missing thumbnail is requested again, and the page shows that it waits for a busy server', { skip }, async () => {
  const { page } = await openViewer();
  const listed = [present(hand)].map(({ name, url, bytes }) => ({ name, url: url.slice(1), kind: 'packed', bytes, triangles: 1, vertices: 3, thumbnail: 'thumbnails/hand.svg' }));
  await page.route('**/models.json', (route) => route.fulfill({ json: { models: listed, notes: [] } }));
  const busy = { status: 503, headers: { 'Retry-After': '2' }, body: 'not finished yet' };
  let asked = 0;
  const svg = '<svg xmlns="http://www.w3.org/2000/svg" width="320" height="240"/>';
  await page.route('**/thumbnails/*', (route) => route.fulfill(asked++ === 0 ? busy : { contentType: 'image/svg+xml', body: svg }));
  let loaded = 0;
  await page.route(`**${present(hand).url}`, (route) => (loaded++ < 3 ? route.fulfill(busy) : route.continue()));
  await page.reload();
  await page.waitForFunction(() => document.querySelector('#cards img')?.complete && document.querySelector('#cards img').naturalWidth === 320);
  assert.equal(asked, 2);
  await page.locator('#cards a').click();
  await page.locator('#loaded', { hasText: 'waiting for the server' }).waitFor();
  await waitForState(page, 'complete');
  assert.equal(loaded, 4, 'answers of a busy server are no lost connections');
});

test('an animation can be selected, and is part of the address', { skip }, async () => {
  const { page, problems } = await openViewer(unmorphed);
  await waitForState(page, 'complete');
  const choice = page.getByRole('combobox', { name: 'Animation', exact: true });
  const isPlayed = page.getByRole('checkbox', { name: 'Animate' });
  assert.deepEqual(await choice.locator('option').allInnerTexts(), ['Stretch', 'Animation 2']);
  assert.ok(!(await isPlayed.isChecked()), 'nothing moves unless it is asked for');
  const rest = await picture(page);
  await isPlayed.check();
  await page.waitForURL(/&animation=1$/);
  const stretched = await picture(page);
  assert.ok((await difference(page, rest, stretched)) > DIFFERENT, 'weights are animated');
  await choice.selectOption('Animation 2');
  await page.waitForURL(/&animation=2$/);
  assert.ok((await difference(page, rest, await picture(page))) <= EQUAL, 'the second animation does not change the weights');
  await page.reload();
  await waitForState(page, 'complete');
  assert.deepEqual([await choice.inputValue(), await isPlayed.isChecked()], ['1', true]);
  await goTo(page, `#model=${unmorphed.url.slice(1)}&animation=1`);
  assert.equal(await choice.inputValue(), '0');
  assert.ok((await difference(page, stretched, await picture(page))) <= EQUAL);
  await page.locator('#replay').click();
  await waitForState(page, 'complete');
  assert.ok(await isPlayed.isChecked(), 'it is played after a replay, too');
  await isPlayed.uncheck();
  await settle(page);
  assert.ok((await difference(page, stretched, await picture(page))) <= EQUAL, 'it is paused where it is');
  for (const animation of ['3', '0', '-1', 'x', '1e9']) {
    await goTo(page, `#model=${unmorphed.url.slice(1)}&animation=${animation}`);
    assert.deepEqual([await choice.inputValue(), await isPlayed.isChecked()], ['0', false], animation);
  }
  await goTo(page, `#model=${present(truck).url.slice(1)}`);
  await waitForState(page, 'complete');
  assert.ok(await choice.isHidden(), 'there is nothing to choose');
  const still = await harness.open(`/index.html#model=${unmorphed.url.slice(1)}&animation=2`, { ...DESKTOP, reducedMotion: 'reduce' });
  await waitForState(still.page, 'complete');
  assert.deepEqual([await still.page.locator('#animations').inputValue(), await still.page.locator('#animation input').isChecked()], ['1', false]);
  assert.deepEqual([...problems, ...still.problems], []);
});

test('morph targets are drawn in all modes, at the weights of the node', { skip }, async () => {
  const played = await openViewer(unmorphed);
  await waitForState(played.page, 'complete');
  const rest = await picture(played.page);
  await played.page.locator('#animation input').check();
  const { page, problems } = await openViewer(morphed);
  await waitForState(page, 'complete');
  for (const mode of ['textured', 'shaded', 'wireframe', 'strips', 'normals']) {
    for (const tab of [page, played.page]) await tab.locator(`#modes input[value=${mode}]`).check({ force: true });
    await settle(page);
    const shown = await picture(page);
    assert.ok((await difference(page, rest, shown)) > DIFFERENT, `${mode} has the morph targets`);
    assert.ok((await difference(page, shown, await picture(played.page))) <= EQUAL, `${mode} at rest is as the animation has it`);
  }
  assert.deepEqual([...problems, ...played.problems], []);
});

/** @param {PackedModel} model */
async function assertReached(model) {
  const { page } = await openViewer(model);
  await waitForState(page, 'complete');
  const expected = await page.evaluate(() =>
    [...document.querySelectorAll('a, button, input:not([type=radio]):not([type=file]), select, canvas')]
      .filter((element) => element.checkVisibility() && !(/** @type {HTMLButtonElement} */ (element).disabled))
      .map((element) => element.id || element.className),
  );
  const reached = new Set();
  for (let i = 0; i < expected.length + 4; i++) {
    await page.keyboard.press('Tab');
    reached.add(await page.evaluate(() => document.activeElement?.id || document.activeElement?.className));
  }
  assert.deepEqual(expected.filter((id) => !reached.has(id)), []);
  await page.context().close();
}

/** A PNG of one pixel. @param {'red' | 'blue'} color */
const pixel = (color) => {
  const data = { red: 'iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAIAAACQd1PeAAAADElEQVR4nGP4z8AAAAMBAQDJ/pLvAAAAAElFTkSuQmCC', blue: 'iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAIAAACQd1PeAAAADElEQVR4nGNgYPgPAAEDAQAIicLsAAAAAElFTkSuQmCC' };
  return data[color];
};

/**
 * Returns a square with a texture.
 * @param {string} uri that of its image
 */
function texturedSquare(uri) {
  const { json, arrays } = morphingSquare();
  json.accessors = [json.accessors[0], json.accessors[3], { bufferView: 7, componentType: 5126, count: 4, type: 'VEC2' }].map((accessor) => ({ ...accessor }));
  json.meshes = /** @type {any} */ ([{ primitives: [{ attributes: { POSITION: 0, TEXCOORD_0: 2 }, indices: 1, material: 0 }] }]);
  const rest = { images: [{ uri }], textures: [{ source: 0 }], materials: [{ doubleSided: true, extensions: { KHR_materials_unlit: {} }, pbrMetallicRoughness: { baseColorTexture: { index: 0 } } }] };
  const { animations, ...scene } = json;
  return sceneGlb({ ...scene, ...rest }, [...arrays, Float32Array.of(0, 0, 1, 0, 0, 1, 1, 1)]);
}

/** The colour in the middle of the picture. @param {Page} page @returns {Promise<'red' | 'blue' | 'white' | 'other'>} */
async function middleColor(page) {
  const png = (await picture(page)).toString('base64');
  return page.evaluate(async (png) => {
    const bitmap = await createImageBitmap(await (await fetch(`data:image/png;base64,${png}`)).blob());
    const canvas = new OffscreenCanvas(1, 1);
    const context = canvas.getContext('2d');
    context.drawImage(bitmap, -bitmap.width / 2, -bitmap.height / 2);
    const [r, g, b] = context.getImageData(0, 0, 1, 1).data;
    return r > 200 && g > 200 && b > 200 ? 'white' : r > 200 && b < 50 ? 'red' : b > 200 && r < 50 ? 'blue' : 'other';
  }, png);
}

test('images in other files are loaded only from the directory of the model', { skip }, async () => {
  const write = (/** @type {string} */ name, /** @type {Uint8Array} */ bytes) => writeFileSync(path.join(models.folder, name), bytes);
  mkdirSync(path.join(models.folder, 'inner/images'), { recursive: true });
  write('inner/images/a b.png', Buffer.from(pixel('red'), 'base64'));
  write('outside.png', Buffer.from(pixel('red'), 'base64'));
  const { page, problems } = await openViewer();
  const missing = page.locator('#facts div', { hasText: 'Missing files' }).locator('dd');
  const show = async (/** @type {string} */ uri) => {
    write('inner/model.glb', texturedSquare(uri));
    await goTo(page, '');
    await waitForState(page, 'empty');
    const known = server.requests.length;
    await goTo(page, '#model=models/inner/model.glb');
    await waitForState(page, 'complete');
    await settle(page);
    // The panel follows after 50 milliseconds.
    await page.evaluate(() => new Promise((resolve) => setTimeout(resolve, 100)));
    const asked = server.requests.slice(known).map((request) => request.path).filter((path) => !path.endsWith('.glb'));
    return { color: await middleColor(page), missing: (await missing.count()) > 0 ? await missing.innerText() : '', asked };
  };
  assert.deepEqual(await show('images/a%20b.png'), { color: 'red', missing: '', asked: ['/models/inner/images/a b.png'] });
  assert.deepEqual(await show('./images/../images/a%20b.png'), { color: 'red', missing: '', asked: ['/models/inner/images/a b.png'] });
  assert.deepEqual(await show(`data:image/png;base64,${pixel('blue')}`), { color: 'blue', missing: '', asked: [] });
  const { origin } = server;
  const other = origin.replace('127.0.0.1', 'localhost');
  for (const uri of ['../outside.png', '%2e%2e/outside.png', '..\\\\outside.png', '/models/outside.png', `${origin}/models/outside.png`, `${other}/models/inner/images/a%20b.png`, `//${other.slice(5)}/a.png`, 'blob:abc', 'javascript:1', 'file:///etc/passwd']) {
    const found = await show(uri);
    assert.deepEqual([found.color, found.asked], ['white', []], uri);
    assert.ok(found.missing.length > 0, uri);
  }
  assert.deepEqual(await show('images/none.png'), { color: 'white', missing: 'images/none.png', asked: ['/models/inner/images/none.png'] });
  assert.deepEqual(problems.filter((problem) => !problem.includes('404')), []);
});

test('a model and its images can be dropped together', { skip }, async () => {
  const { page, problems } = await openViewer();
  const drop = (/** @type {[string, string, string][]} */ ...files) =>
    page.evaluate((files) => {
      const dataTransfer = new DataTransfer();
      for (const [name, type, data] of files) dataTransfer.items.add(new File([Uint8Array.from(atob(data), (char) => char.charCodeAt(0))], name, { type }));
      window.dispatchEvent(new DragEvent('drop', { dataTransfer, bubbles: true, cancelable: true }));
    }, files);
  const model = Buffer.from(texturedSquare('textures/my%20image.png')).toString('base64');
  await drop(['my image.png', 'image/png', pixel('blue')], ['square.glb', '', model]);
  await waitForState(page, 'complete');
  await settle(page);
  assert.equal(await middleColor(page), 'blue');
  await drop(['square.glb', '', model]);
  await page.locator('#facts', { hasText: 'textures/my image.png' }).waitFor();
  await settle(page);
  assert.equal(await middleColor(page), 'white');
  // The message names unsupported data.
  await drop(['scene.bin', '', ''], ['scene.gltf', '', Buffer.from('{"asset":{"version":"2.0"},"buffers":[]}').toString('base64')]);
  await page.locator('#message', { hasText: 'tristrip pack scene.gltf -o model.glb' }).waitFor();
  const { json, arrays } = morphingSquare();
  const split = sceneGlb({ ...json, buffers: [{ byteLength: 4, uri: 'far.bin' }] }, arrays);
  await drop(['split.glb', '', Buffer.from(split).toString('base64')]);
  await page.locator('#message', { hasText: 'far.bin' }).waitFor();
  assert.deepEqual(problems, []);
});

test('invalid and damaged files show a message, and the next model is shown', { skip }, async () => {
  const whole = readFileSync(path.join(models.folder, present(hand).name));
  const changed = (/** @type {(bytes: Buffer) => void} */ change) => {
    const bytes = Buffer.from(whole);
    change(bytes);
    return bytes;
  };
  /** @type {[string, Uint8Array, RegExp][]} */
  const files = [
    ['no bytes', Buffer.alloc(0), /not a GLB file[^]*empty/],
    ['text', Buffer.from('hello'), /not a GLB file/],
    ['half a header', whole.subarray(0, 10), /not a GLB file/],
    ['another version', changed((bytes) => (bytes[4] = 1)), /not a GLB file/],
    ['too long a document', changed((bytes) => bytes.writeUInt32LE(0x7fffffff, 12)), /not a GLB file/],
    ['no document', changed((bytes) => bytes.fill(0x7b, 20, 30)), /not a GLB file/],
    ['cut in the document', whole.subarray(0, 100), /not a GLB file/],
    ['cut in a chunk', whole.subarray(0, Math.floor(0.7 * whole.length)), /damaged[^]*is shown/],
    ['a flipped bit', changed((bytes) => (bytes[bytes.length - 10] ^= 1)), /damaged[^]*is shown/],
  ];
  const { page, problems } = await openViewer();
  for (const [what, bytes, message] of files) {
    writeFileSync(path.join(models.folder, 'broken.glb'), bytes);
    await goTo(page, '#model=models/broken.glb');
    await waitForState(page, 'failed');
    await page.locator('#message p').first().waitFor();
    assert.match(await page.locator('#message').innerText(), message, what);
    assert.ok(await page.locator('#busy').isHidden(), what);
    await goTo(page, `#model=${unmorphed.url.slice(1)}`);
    await waitForState(page, 'complete');
    assert.equal(await page.locator('#message').innerText(), '', what);
  }
  assert.deepEqual(problems, []);
});

test('a local file that changes after its selection is not read, and is not kept by a reload', { skip }, async () => {
  const file = path.join(models.folder, 'chosen.glb');
  writeFileSync(file, readFileSync(path.join(models.folder, present(hand).name)));
  const { page, problems } = await openViewer();
  await page.setInputFiles('#file', file);
  await waitForState(page, 'complete');
  writeFileSync(file, 'another one');
  await page.locator('#replay').click();
  await page.locator('#message', { hasText: /cannot be read/ }).waitFor();
  await page.reload();
  await page.locator('#drop', { hasText: 'was not saved' }).waitFor();
  assert.equal(await page.evaluate(() => location.hash), '');
  assert.deepEqual(problems, []);
});

test('models can be opened in sequence, closed early and revisited through the history', { skip }, async () => {
  const { page, problems } = await openViewer();
  const [first, second] = [present(hand), present(truck)].map(({ url }) => `#model=${url.slice(1)}`);
  const nameOf = () => page.locator('#name').innerText();
  // Of two models opened in a row, the last one is shown.
  await page.evaluate(([first, second]) => {
    location.hash = first;
    location.hash = second;
  }, [first, second]);
  await page.waitForFunction(() => window.tristrip.viewer.state === 'complete' && /truck/i.test(document.querySelector('#name')?.textContent ?? ''));
  const all = await triangles(page);
  // Close the model during decoding.
  server.shape(present(hand).url, { bytesPerSecond: present(hand).bytes / 4 });
  await goTo(page, first);
  await page.waitForFunction(() => window.tristrip.viewer.figures.sums.triangles > 256);
  await page.locator('.back').click();
  await waitForState(page, 'empty');
  assert.ok(await page.evaluate((first) => document.activeElement?.getAttribute('href') === first, first), 'the card has the focus');
  // Data decoded before do not arrive late.
  await page.waitForTimeout(500);
  assert.equal(await triangles(page), 0);
  server.shape(present(hand).url);
  // Back to the first model, to the second, and forward to the gallery.
  await page.goBack();
  await waitForState(page, 'complete');
  assert.match(await nameOf(), /hand/);
  await page.goBack();
  await page.waitForFunction((all) => window.tristrip.viewer.state === 'complete' && window.tristrip.viewer.figures.sums.triangles === all, all);
  assert.match(await nameOf(), /truck/i);
  await page.goForward();
  await page.goForward();
  await waitForState(page, 'empty');
  assert.ok(await page.locator('#gallery').isVisible());
  assert.deepEqual(problems, []);
});

test('a view survives a reload, and an invalid one is ignored', { skip }, async () => {
  const { page, problems } = await openViewer(unmorphed);
  await waitForState(page, 'complete');
  // The focus outline is part of the images.
  const unfocused = async () => {
    await page.evaluate(() => /** @type {HTMLElement} */ (document.activeElement).blur());
    return picture(page);
  };
  const first = await unfocused();
  await page.locator('#canvas').focus();
  for (const key of ['ArrowLeft', '+', '+', 'd', '4']) await page.keyboard.press(key);
  await page.waitForURL(/&view=.*&mode=strips$/);
  await settle(page);
  const moved = await unfocused();
  await page.reload();
  await waitForState(page, 'complete');
  await settle(page);
  const again = await difference(page, moved, await unfocused());
  assert.ok(again <= EQUAL, `${again}`);
  for (const view of ['0,0,1e300,0,0,0', '0,0,1,1e38,0,0', '0,0,0,0,0,0', 'a,b,c', '1,2', '%00']) {
    await goTo(page, `#model=${unmorphed.url.slice(1)}&view=${view}&mode=none`);
    await settle(page);
    assert.ok((await difference(page, first, await unfocused())) <= EQUAL, view);
  }
  // Zoom in and out to the limits, and back.
  for (const key of ['+', '-']) {
    await page.locator('#canvas').focus();
    for (let i = 0; i < 150; i++) await page.keyboard.press(key);
    await settle(page);
    assert.ok(await page.evaluate(() => window.tristrip.viewer.renderer.camera.viewProjection.every(Number.isFinite)));
    await page.locator('#canvas').focus();
    await page.keyboard.press('0');
    await settle(page);
    assert.ok((await difference(page, first, await unfocused())) <= EQUAL, key);
  }
  assert.deepEqual(problems, []);
});

test('the context is lost while a model loads, and while another one is opened', { skip }, async () => {
  const reference = await openViewer(unmorphed);
  await waitForState(reference.page, 'complete');
  const model = present(hand);
  server.shape(model.url, { bytesPerSecond: model.bytes / 2 });
  const { page, problems } = await openViewer(model);
  await page.locator('#modes input[value=wireframe]').check({ force: true });
  await page.waitForFunction(() => window.tristrip.viewer.figures.sums.triangles > 256);
  await page.evaluate(() => {
    window.loss = document.querySelector('canvas').getContext('webgl2').getExtension('WEBGL_lose_context');
    window.loss.loseContext();
  });
  const message = page.locator('#message', { hasText: 'graphics context' });
  await message.waitFor();
  await page.evaluate(() => window.loss.restoreContext());
  await waitForState(page, 'complete');
  server.shape(model.url);
  assert.equal(await page.locator('#message').innerText(), '');
  const full = await openViewer({ ...model, url: `${model.url}&mode=wireframe` });
  await waitForState(full.page, 'complete');
  for (const tab of [page, full.page]) await settle(tab);
  assert.ok((await difference(page, await picture(full.page), await picture(page))) <= EQUAL);
  await page.evaluate(() => window.loss.loseContext());
  await message.waitFor();
  await goTo(page, `#model=${unmorphed.url.slice(1)}`);
  await page.waitForFunction(() => window.tristrip.viewer.connection === 'done');
  assert.ok(await message.isVisible(), 'the message stays when another model is opened');
  await page.evaluate(() => window.loss.restoreContext());
  await waitForState(page, 'complete');
  for (const tab of [page, reference.page]) await settle(tab);
  assert.equal(await page.locator('#message').innerText(), '');
  assert.ok((await difference(page, await picture(reference.page), await picture(page))) <= EQUAL);
  assert.deepEqual([...problems, ...full.problems, ...reference.problems].filter((problem) => !/context/i.test(problem)), []);
});

test('a texture that is uploaded while the context is lost is created again', { skip }, async () => {
  writeFileSync(path.join(models.folder, 'square.glb'), texturedSquare(`data:image/png;base64,${pixel('blue')}`));
  const { page, problems } = await openViewer();
  await page.addInitScript(() => {
    // Code that awaits a frame is held until it is released.
    const { requestAnimationFrame } = window;
    window.held = [];
    window.requestAnimationFrame = (callback) => (String(callback).includes('native code') ? window.held.push(callback) : requestAnimationFrame(callback));
  });
  await page.reload();
  await goTo(page, '#model=models/square.glb');
  await page.waitForFunction(() => window.held.length === 1);
  await page.evaluate(() => {
    window.loss = document.querySelector('canvas').getContext('webgl2').getExtension('WEBGL_lose_context');
    window.loss.loseContext();
  });
  await page.locator('#message', { hasText: 'graphics context' }).waitFor();
  await page.evaluate(() => window.loss.restoreContext());
  await page.waitForFunction(() => window.held.length === 2);
  // The texture of the new context comes first.
  for (const i of [1, 0]) {
    await page.evaluate((i) => window.held[i](0), i);
    await eventually(async () => assert.equal(await middleColor(page), 'blue'));
  }
  await settle(page);
  assert.equal(await middleColor(page), 'blue');
  assert.deepEqual(problems.filter((problem) => !/CONTEXT_LOST/.test(problem)), []);
});

test('without WebGL 2, the page shows a message and no useless controls', { skip }, async () => {
  const { page, problems } = await openViewer();
  await page.addInitScript(() => (HTMLCanvasElement.prototype.getContext = () => null));
  await page.reload();
  await page.locator('#message', { hasText: 'WebGL' }).waitFor();
  const controls = await page.evaluate(() => [...document.querySelectorAll('button, select, input, a')].filter((element) => element.checkVisibility()).map((element) => element.className || element.id));
  assert.deepEqual(controls, ['brand']);
  assert.deepEqual(problems, []);
});

test('no content overflows a screen of 360 pixels', { skip }, async () => {
  const { page } = await openViewer(undefined, { ...PHONE, viewport: { width: 360, height: 640 } });
  const name = `${'long-name-'.repeat(12)}.glb`;
  // Its errors are small.
  const fine = texturedScenes[3] ? pack(texturedScenes[3]) : present(hand);
  writeFileSync(path.join(models.folder, name), texturedSquare(`${'missing'.repeat(30)}.png`));
  const fits = async (/** @type {string} */ what) => {
    const find = () => page.evaluate(() => {
      const tools = [...document.querySelectorAll('.tools > *')].filter((element) => element.checkVisibility()).map((element) => element.getBoundingClientRect());
      const chart = /** @type {Element} */ (document.querySelector('#chart'));
      const cut = [...chart.querySelectorAll('text')].filter((text) => chart.checkVisibility() && text.getBoundingClientRect().right > chart.getBoundingClientRect().right);
      return { overflow: document.documentElement.scrollWidth - innerWidth, cut: cut.map(({ textContent }) => textContent), isBeside: tools.every(({ left, right }) => left >= 0 && right <= innerWidth) };
    });
    await eventually(async () => assert.deepEqual(await find(), { overflow: 0, cut: [], isBeside: true }, what));
  };
  await fits('gallery');
  for (const model of [`models/${name}`, unmorphed.url.slice(1), present(hand).url.slice(1), present(truck).url.slice(1), fine.url.slice(1), 'models/none.glb']) {
    await goTo(page, `#model=${model}`);
    await page.waitForFunction(() => ['complete', 'failed'].includes(window.tristrip.viewer.state));
    await fits(model);
  }
  await page.locator('#help').click();
  await fits('help');
});

test('all controls can be reached by Tab', { skip }, async () => {
  // One model has levels, the other a choice of animations.
  await assertReached(present(hand));
  await assertReached(unmorphed);
});

test('the page fits a phone', { skip }, async () => {
  const { page, problems } = await openViewer(present(truck), PHONE);
  await waitForState(page, 'complete');
  const find = () =>
    page.evaluate(() => {
      const { width, height } = /** @type {Element} */ (document.getElementById('canvas')).getBoundingClientRect();
      const small = [...document.querySelectorAll('button, select, #level')].filter((element) => element.checkVisibility() && element.getBoundingClientRect().height < 24);
      return { overflow: document.documentElement.scrollWidth - innerWidth, width, height, small: small.map(({ id }) => id) };
    });
  const found = await find();
  assert.ok(found.overflow <= 0, `${found.overflow} pixels are beyond the screen`);
  assert.ok(found.width > 380 && found.height > 250, `canvas of ${found.width} × ${found.height}`);
  assert.deepEqual(found.small, [], 'controls are large enough for a finger');
  const before = await picture(page);
  const box = await page.locator('#canvas').boundingBox();
  assert.ok(box);
  const touch = await page.context().newCDPSession(page);
  const [x, y] = [box.x + box.width / 2, box.y + box.height / 2];
  await touch.send('Input.dispatchTouchEvent', { type: 'touchStart', touchPoints: [{ x, y }] });
  for (let i = 1; i <= 5; i++) await touch.send('Input.dispatchTouchEvent', { type: 'touchMove', touchPoints: [{ x: x + 20 * i, y }] });
  await touch.send('Input.dispatchTouchEvent', { type: 'touchEnd', touchPoints: [] });
  await eventually(async () => assert.ok((await difference(page, before, await picture(page))) > DIFFERENT, 'one finger turns the model'));
  await goTo(page, '');
  await page.locator('#gallery').waitFor({ state: 'visible' });
  assert.ok((await find()).overflow <= 0);
  assert.deepEqual(problems, []);
});

test('the page meets WCAG A and AA, light and dark', { skip }, async (t) => {
  for (const colorScheme of /** @type {const} */ (['light', 'dark'])) {
    for (const view of ['gallery', 'model', 'animations', 'error', 'help']) {
      await t.test(`${view}, ${colorScheme}`, async () => {
        const { page } = await openViewer(view === 'gallery' ? undefined : view === 'animations' ? unmorphed : present(truck), { ...DESKTOP, colorScheme });
        if (view !== 'gallery') await waitForState(page, 'complete');
        else await page.locator('#cards a').first().waitFor();
        if (view === 'help') await page.locator('#help').click();
        if (view === 'error') {
          await goTo(page, '#model=models/models.json');
          await page.locator('#message p').first().waitFor();
        }
        await page.addScriptTag({ url: '/node_modules/axe-core/axe.min.js' });
        const violations = await page.evaluate(async () => {
          const { violations } = await window.axe.run(document, { runOnly: ['wcag2a', 'wcag2aa', 'wcag21a', 'wcag21aa', 'wcag22aa'] });
          return violations.map(({ id, nodes }) => `${id}: ${nodes.map(({ target }) => target.join(' ')).join(', ')}`);
        });
        assert.deepEqual(violations, []);
        await page.context().close();
      });
    }
  }
});

test('GPU resources are freed with the mode that needs them, and with the model', { skip }, async (t) => {
  const { page, problems } = await openViewer();
  await page.evaluate(() => {
    const live = { Texture: 0, Buffer: 0, VertexArray: 0 };
    /** The bytes of the textures that have storage. @type {Map<WebGLTexture, number>} */
    const sizes = new Map();
    const context = WebGL2RenderingContext.prototype;
    for (const kind of Object.keys(live)) {
      const { [`create${kind}`]: create, [`delete${kind}`]: remove } = context;
      context[`create${kind}`] = function () {
        live[kind]++;
        return create.call(this);
      };
      context[`delete${kind}`] = function (object) {
        if (object) live[kind]--;
        sizes.delete(object);
        remove.call(this, object);
      };
    }
    const { texStorage2D } = context;
    context.texStorage2D = function (target, levels, format, width, height) {
      const bytes = { [this.RG32UI]: 8, [this.RGB32F]: 12, [this.RGBA32F]: 16 }[format] ?? 4;
      sizes.set(this.getParameter(this.TEXTURE_BINDING_2D), width * height * bytes);
      texStorage2D.call(this, target, levels, format, width, height);
    };
    window.live = () => ({ ...live, bytes: [...sizes.values()].reduce((a, b) => a + b, 0) });
  });
  const note = async () => {
    await settle(page);
    return page.evaluate(() => window.live());
  };
  const choose = (/** @type {string} */ mode) => page.locator(`#modes input[value=${mode}]`).check({ force: true });
  const before = await note();
  for (const model of [present(hand), present(truck), unmorphed]) {
    await goTo(page, `#model=${model.url.slice(1)}`);
    await waitForState(page, 'complete');
    const plain = await note();
    for (const mode of ['wireframe', 'strips']) {
      await choose(mode);
      await page.waitForFunction((count) => window.live().Texture > count, plain.Texture);
      const pulled = await note();
      t.diagnostic(`${model.name}, ${mode}: ${pulled.Texture - plain.Texture} textures of ${pulled.bytes - plain.bytes} bytes`);
    }
    await choose('shaded');
    assert.deepEqual(await note(), plain, model.name);
    await choose('wireframe');
    await goTo(page, '');
    await waitForState(page, 'empty');
    assert.deepEqual(await note(), before, model.name);
  }
  assert.deepEqual(problems, []);
});

test('memory does not grow with the number of models opened', { skip }, async (t) => {
  const { page, problems } = await openViewer();
  const openAll = async (/** @type {number} */ count) => {
    for (let i = 0; i < count; i++) {
      const model = present(i % 2 ? hand : truck);
      await goTo(page, `#model=${model.url.slice(1)}`);
      await waitForState(page, 'complete');
      await goTo(page, '');
      await page.waitForFunction(() => window.tristrip.viewer.state === 'empty');
    }
  };
  await openAll(6);
  const before = await heapOf(page);
  await openAll(OPENED_MODELS);
  const after = await heapOf(page);
  const megabytes = (/** @type {number} */ bytes) => `${(bytes / 2 ** 20).toFixed(1)} MB`;
  for (const place of /** @type {const} */ (['page', 'worker'])) {
    t.diagnostic(`${place}: ${megabytes(before[place])}, after ${OPENED_MODELS} models ${megabytes(after[place])}`);
    assert.ok(after[place] < before[place] + MAX_GROWTH, `${place}: ${megabytes(after[place] - before[place])} more`);
  }
  assert.deepEqual(problems, []);
});

test('the first image of a large model needs few of its bytes', { skip: skip || needsModels }, async (t) => {
  const dragon = pack(path.join(/** @type {string} */ (largeModels), 'dragon.ply'));
  server.shape(dragon.url, { holdAfter: FIRST_BYTES });
  const { page } = await openViewer(dragon);
  await waitForPicture(page);
  t.diagnostic(`${FIRST_BYTES} of ${dragon.bytes} bytes`);
  server.shape(dragon.url);
});

test('a full model is orbited while another one loads', { skip: skip || needsModels, timeout: 1000 * ORBIT_SECONDS + 240_000 }, async (t) => {
  const bunny = pack(path.join(/** @type {string} */ (largeModels), 'bunny.ply'));
  const horse = pack(path.join(/** @type {string} */ (largeModels), 'horse.ply'));
  const { page, problems } = await openViewer(bunny);
  await waitForState(page, 'complete');
  // The second model keeps arriving while the first one is viewed.
  server.shape(horse.url, { bytesPerSecond: horse.bytes / ORBIT_SECONDS });
  const known = server.requestsOf(horse.url).length;
  const other = await openViewer(horse, { viewport: { width: 300, height: 400 } });
  await page.bringToFront();
  const { width, height } = /** @type {{ width: number, height: number }} */ (await page.locator('#canvas').boundingBox());
  const orbit = async (/** @type {number} */ seconds) => {
    await page.mouse.move(width / 2, height / 2 + 60);
    await page.mouse.down();
    const end = performance.now() + 1000 * seconds;
    for (let i = 0; performance.now() < end; i++) {
      const angle = i / 20;
      await page.mouse.move(width / 2 + 200 * Math.sin(angle), height / 2 + 60 + 40 * Math.cos(angle));
      await page.waitForTimeout(16);
    }
    await page.mouse.up();
  };
  await orbit(ORBIT_SECONDS / 6);
  const before = await heapOf(page);
  const frames = await page.evaluate(() => window.tristrip.viewer.renderer.frames);
  await orbit((5 * ORBIT_SECONDS) / 6);
  const after = await heapOf(page);
  const drawn = (await page.evaluate(() => window.tristrip.viewer.renderer.frames)) - frames;
  await waitForState(other.page, 'complete');
  server.shape(horse.url);
  const growth = (/** @type {'page' | 'worker'} */ place) => after[place] / before[place] - 1;
  t.diagnostic(`${ORBIT_SECONDS} s, ${drawn} frames; memory of the page ${(100 * growth('page')).toFixed(1)} %, of the worker ${(100 * growth('worker')).toFixed(1)} % more`);
  assert.ok(drawn > 10, `${drawn} frames`);
  assert.ok(growth('page') <= MAX_ORBIT_GROWTH && growth('worker') <= MAX_ORBIT_GROWTH);
  assert.equal(server.requestsOf(horse.url).length, known + 1, 'the connection was kept');
  assert.deepEqual([...problems, ...other.problems], []);
});
