import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { createServer } from 'node:http';
import { test } from 'node:test';
import { Link } from '../src/client/link.js';
import { Session } from '../src/client/session.js';
import { warmUp } from '../src/client/warm_up.js';
import { GlbDecoder } from '../src/index.js';
import { document, glb, MESHES } from '../testing/glb.js';
import { Mirror } from '../testing/mirror.js';
import { canonical, triples } from '../testing/triangles.js';

/** @import { AddressInfo } from 'node:net' */
/** @import { LoadOptions, Output, Progress, Source } from '../src/client/client.js' */

const FILE = glb(document());

/** Packed models for tests of larger files. */
const FILES = (process.env.TRISTRIP_PACKED ?? '').split(':').filter((path) => path !== '');

/** A page that loads a model. */
class Page {
  mirror = new Mirror();
  /** @type {any[]} */
  messages = [];
  /** @type {Progress | undefined} */
  progress;
  /** @type {(() => void)[]} */
  #looks = [];

  /**
   * @param {Source} source
   * @param {LoadOptions} [options]
   * @param {Link} [link]
   */
  constructor(source, options = {}, link = new Link()) {
    this.link = link;
    this.session = new Session((message) => this.#receive(message), link);
    this.session.receive({ type: 'load', source, options });
  }

  /** @param {any} message */
  #receive(message) {
    this.messages.push(message);
    if (message.type === 'update') {
      this.mirror.apply(message.update);
      this.progress = message.update.progress;
      setTimeout(() => this.session.receive({ type: 'taken' }));
    }
    for (const look of [...this.#looks]) look();
  }

  /**
   * Waits for a message.
   * @param {(message: any) => boolean} isIt
   * @returns {Promise<any>}
   */
  until(isIt) {
    return new Promise((resolve) => {
      const look = () => {
        const found = this.messages.find(isIt);
        if (!found) return;
        this.#looks.splice(this.#looks.indexOf(look), 1);
        resolve(found);
      };
      this.#looks.push(look);
      look();
    });
  }

  /** Waits until everything is shown. */
  complete() {
    return this.until(({ type, update }) => type === 'update' && update.progress.isComplete);
  }

  /** Waits for an error. */
  async error() {
    return (await this.until(({ type }) => type === 'error')).error;
  }
}

/**
 * Checks that a page draws the mesh of a decoder.
 * @param {Page} page
 * @param {GlbDecoder} decoder
 * @param {Output} output
 */
function assertSame({ mirror }, decoder, output) {
  for (const [stream, mesh] of mirror.meshes) {
    const part = decoder.part(stream);
    assert.ok(part);
    assert.deepEqual(Float32Array.from(mesh.positions), part.positions());
    for (const { name, array } of part.attributes().filter(({ name }) => name !== 'part')) {
      assert.deepEqual([...(mesh.attributes.get(name) ?? [])], [...array]);
    }
    const drawn = [...mesh.parts.keys()].flatMap((number) => [...mesh.triangles(number, output)]);
    assert.deepEqual(canonical(drawn), canonical(triples(part.triangles())));
  }
}

/** @param {Uint8Array} bytes */
function decoded(bytes) {
  const decoder = new GlbDecoder();
  decoder.update(bytes);
  return decoder;
}

for (const output of /** @type {Output[]} */ (['strips', 'lists'])) {
  test(`a page draws what a decoder has, as ${output}`, async () => {
    for (const bytes of [FILE, ...FILES.map((path) => new Uint8Array(readFileSync(path)))]) {
      const link = new Link();
      link.bitsPerSecond = 8 * bytes.length;
      const page = new Page(new Blob([bytes]), { output, keepBytes: true }, link);
      await page.complete();
      const decoder = decoded(bytes);
      assert.equal(page.progress?.shownChunks, decoder.chunkCount);
      assertSame(page, decoder, output);
      const [{ mirror }, updates] = [page, page.messages.filter(({ type }) => type === 'update').length];
      for (const [stream, { uploaded, whole, update }] of mirror.meshes) {
        if (bytes === FILE) continue;
        const [{ length, strips, verticesSent }] = /** @type {any} */ (update).parts;
        console.log(`# ${output} mesh ${stream}: ${updates} updates, ${uploaded} of ${whole} indices sent; ${length} drawn, ${verticesSent} vertices in ${strips} strips`);
      }
      for (const part of decoder.parts) part.attributes();
    }
  });

  test(`earlier chunks are shown again, as ${output}`, async () => {
    const page = new Page(new Blob([FILE]), { output, keepBytes: true });
    await page.complete();
    const start = FILE.length - 3 - MESHES.bytes.length;
    for (const count of [5, MESHES.chunks.length - 1, 3, 0, MESHES.chunks.length]) {
      const known = page.messages.length;
      page.session.receive({ type: 'show', chunkCount: count });
      // The chunks of base meshes are always shown.
      const shown = Math.max(count, 2);
      await page.until((message) => page.messages.indexOf(message) >= known && message.type === 'update' && message.update.progress.shownChunks === shown);
      assertSame(page, decoded(FILE.subarray(0, start + MESHES.chunks[shown - 1].end)), output);
    }
  });
}

test('the document, the binary chunk before the stream and the chunks are reported', async () => {
  const page = new Page(new Blob([FILE]));
  await page.complete();
  const { json, binaryBytes } = page.messages.find(({ type }) => type === 'document');
  assert.deepEqual([json, binaryBytes], [document(), 40]);
  const binary = page.messages.filter(({ type }) => type === 'binary').flatMap(({ bytes, start }) => [start, ...bytes]);
  assert.deepEqual(binary, [0, ...new Array(40).fill(0)]);
  const told = page.messages.filter(({ type }) => type === 'chunks').flatMap(({ chunks }) => chunks);
  const start = FILE.length - 3 - MESHES.bytes.length;
  assert.deepEqual(
    told.map(({ end, stream, triangles }) => [end, stream, triangles]),
    MESHES.chunks.map(({ end, stream, triangles }) => [start + end, stream, triangles]),
  );
});

test('a damaged file is shown up to the damage, then the error is reported', async () => {
  const bytes = FILE.slice();
  const start = FILE.length - 3 - MESHES.bytes.length;
  bytes[start + MESHES.chunks[4].end - 1] ^= 1;
  const page = new Page(new Blob([bytes]), { output: 'lists' });
  const { kind, message } = await page.error();
  assert.equal(kind, 'damaged');
  assert.match(message, /chunk 4 at byte \d+: found checksum/);
  assert.equal(page.progress?.shownChunks, 4);
  assertSame(page, decoded(FILE.subarray(0, start + MESHES.chunks[3].end)), 'lists');
});

test('a truncated file, or one that is not a GLB, is an error', async () => {
  const errors = [];
  for (const bytes of [new Uint8Array(0), new TextEncoder().encode('solid of a cube, as text'), FILE.slice(0, 500), FILE.slice(0, FILE.length - 100)]) {
    const page = new Page(new Blob([bytes]));
    errors.push((await page.error()).kind);
  }
  assert.deepEqual(errors, ['not-glb', 'not-glb', 'damaged', 'damaged']);
});

test('a GLB without a binary chunk is valid', async () => {
  const text = new TextEncoder().encode('{"asset":{"version":"2.0"}} ');
  const bytes = new Uint8Array(20 + text.length);
  [0x46546c67, 2, bytes.length, text.length, 0x4e4f534a].forEach((word, i) => new DataView(bytes.buffer).setUint32(4 * i, word, true));
  bytes.set(text, 20);
  const page = new Page(new Blob([bytes]));
  await page.complete();
  assert.equal(page.messages.find(({ type }) => type === 'document').binaryBytes, 0);
});

test('a GLB without a stream is reported as a whole', async () => {
  const json = { asset: { version: '2.0' }, buffers: [{ byteLength: 40 }] };
  const page = new Page(new Blob([glb(json)]));
  const { update } = await page.complete();
  assert.deepEqual(update.meshes, []);
  assert.equal(page.messages.find(({ type }) => type === 'document').binaryBytes, 40 + MESHES.bytes.length + 3);
});

/**
 * Serves the file. Each request is answered by the next function; the last function also answers
 * further requests.
 * @param {((request: import('node:http').IncomingMessage, response:
 *   import('node:http').ServerResponse) => void)[]} answers
 */
async function serve(answers) {
  /** @type {string[]} */
  const ranges = [];
  const server = createServer((request, response) => {
    const answer = answers[Math.min(ranges.length, answers.length - 1)];
    ranges.push(`${request.headers.range ?? ''} ${request.headers['if-range'] ?? ''}`.trim());
    answer(request, response);
  });
  await new Promise((resolve) => server.listen(0, '127.0.0.1', () => resolve(undefined)));
  const { port } = /** @type {AddressInfo} */ (server.address());
  const close = () => {
    server.closeAllConnections();
    server.close();
  };
  return { url: `http://127.0.0.1:${port}/model.glb`, ranges, close };
}

/**
 * Sends the rest of the file from the requested byte, and cuts the connection after some bytes.
 * @param {number} [most]
 */
function sending(most = Infinity, tag = '"a"') {
  return (/** @type {import('node:http').IncomingMessage} */ request, /** @type {import('node:http').ServerResponse} */ response) => {
    const first = Number(/^bytes=(\d+)-$/.exec(request.headers.range ?? '')?.[1] ?? 0);
    const headers = { ETag: tag, 'Content-Length': FILE.length - first };
    if (first > 0) response.writeHead(206, { ...headers, 'Content-Range': `bytes ${first}-${FILE.length - 1}/${FILE.length}` });
    else response.writeHead(200, headers);
    response.write(FILE.subarray(first, first + most), () => (most < FILE.length - first ? setTimeout(() => response.destroy(), 50) : response.end()));
  };
}

test('a download resumes where the connection was lost', async () => {
  const { url, ranges, close } = await serve([sending(1000), sending(700), sending()]);
  const page = new Page(url, { output: 'lists' });
  await page.complete();
  assert.deepEqual(ranges, ['', 'bytes=1000- "a"', 'bytes=1700- "a"']);
  assertSame(page, decoded(FILE), 'lists');
  const states = page.messages.filter(({ type }) => type === 'connection').map(({ state }) => state);
  assert.ok(states.includes('retrying'));
  assert.equal(states.at(-1), 'done');
  close();
});

test('a server that ignores ranges, or is busy, is not an error', async () => {
  const whole = (/** @type {any} */ request, /** @type {import('node:http').ServerResponse} */ response) => {
    response.writeHead(200, { ETag: '"a"' }).end(FILE);
  };
  const busy = (/** @type {any} */ request, /** @type {import('node:http').ServerResponse} */ response) => response.writeHead(503).end();
  const { url, close } = await serve([sending(1000), busy, whole]);
  const page = new Page(url, { output: 'lists' });
  await page.complete();
  assertSame(page, decoded(FILE), 'lists');
  close();
});

test('requests are repeated while a server packs the file', async () => {
  const busy = (/** @type {any} */ request, /** @type {import('node:http').ServerResponse} */ response) => response.writeHead(503, { 'Retry-After': '0.01' }).end();
  const { url, ranges, close } = await serve([...Array(12).fill(busy), sending(1000), busy, sending()]);
  const page = new Page(url, { output: 'lists' });
  await page.complete();
  assert.equal(ranges.length, 15);
  assertSame(page, decoded(FILE), 'lists');
  const states = page.messages.filter(({ type }) => type === 'connection').map(({ state }) => state);
  assert.equal(states.filter((state) => state === 'busy').length, 13);
  close();
});

test('missing ranges, and tags that become strong, do not mean that the file changed', async () => {
  const untold = await serve([
    sending(1000),
    (request, response) => {
      const first = Number(/^bytes=(\d+)-$/.exec(request.headers.range ?? '')?.[1]);
      response.writeHead(206, { 'Content-Length': FILE.length - first }).end(FILE.subarray(first));
    },
  ]);
  const page = new Page(untold.url, { output: 'lists' });
  await page.complete();
  assertSame(page, decoded(FILE), 'lists');
  untold.close();
  const weak = await serve([sending(1000, 'W/"a"'), sending()]);
  const other = new Page(weak.url, { output: 'lists' });
  await other.complete();
  assert.deepEqual(weak.ranges, ['', 'bytes=1000-']);
  assertSame(other, decoded(FILE), 'lists');
  weak.close();
});

test('changed and missing files are errors', async () => {
  const changed = await serve([sending(1000), sending(Infinity, '"b"')]);
  assert.equal((await new Page(changed.url).error()).kind, 'changed');
  changed.close();
  const missing = await serve([(request, response) => response.writeHead(404).end()]);
  const { kind, message } = await new Page(missing.url).error();
  assert.deepEqual([kind, message], ['status', 'The server responded with 404 Not Found']);
  missing.close();
});

test('a lost connection can be retried', async () => {
  const { url, close } = await serve([(request, response) => response.destroy(), (request, response) => response.destroy(), sending()]);
  const page = new Page(url, { output: 'lists' });
  assert.equal((await page.error()).kind, 'connection');
  page.session.receive({ type: 'retry' });
  await page.complete();
  assertSame(page, decoded(FILE), 'lists');
  close();
});

test('an error is reported while fewer chunks are shown than have arrived', async () => {
  const { url, close } = await serve([sending(FILE.length - 200), (request, response) => response.writeHead(404).end()]);
  const page = new Page(url, { keepBytes: true });
  await page.until(({ type }) => type === 'document');
  page.session.receive({ type: 'show', chunkCount: 3 });
  assert.equal((await page.error()).kind, 'status');
  assert.equal(page.progress?.shownChunks, 3);
  page.session.receive({ type: 'show', chunkCount: Infinity });
  await page.until(({ type, update }) => type === 'update' && update.progress.shownChunks > 3);
  close();
});

test('a model that is paused can be shown with fewer chunks', async () => {
  const page = new Page(new Blob([FILE]), { keepBytes: true });
  await page.complete();
  page.session.receive({ type: 'pause' });
  page.session.receive({ type: 'show', chunkCount: 4 });
  await page.until(({ type, update }) => type === 'update' && update.progress.shownChunks === 4);
  page.session.receive({ type: 'show', chunkCount: Infinity });
  const known = page.messages.length;
  await page.until((message) => page.messages.indexOf(message) >= known && message.type === 'update' && message.update.progress.isComplete);
});

test('models of higher priority come first', async () => {
  const { url, close } = await serve([sending()]);
  const link = new Link();
  link.bitsPerSecond = 8 * 4 * FILE.length;
  const low = new Page(url, { priority: 0 }, link);
  const high = new Page(url, { priority: 1 }, link);
  await high.complete();
  const { length } = low.messages.filter(({ type }) => type === 'update');
  assert.ok(length <= 1 && !low.progress?.isComplete);
  await low.complete();
  close();
});

test('a paused model can be resumed, and a closed one sends no more messages', async () => {
  const { url, close } = await serve([sending()]);
  const link = new Link();
  link.bitsPerSecond = 8 * 4 * FILE.length;
  const page = new Page(url, {}, link);
  await page.until(({ type }) => type === 'document');
  page.session.receive({ type: 'pause' });
  await page.until(({ state }) => state === 'paused');
  const known = page.messages.length;
  await new Promise((resolve) => setTimeout(resolve, 100));
  assert.ok(page.messages.length <= known + 1);
  page.session.receive({ type: 'resume' });
  await page.complete();
  const other = new Page(url, {}, link);
  await other.until(({ type }) => type === 'document');
  other.session.receive({ type: 'close' });
  const count = other.messages.length;
  await new Promise((resolve) => setTimeout(resolve, 300));
  assert.equal(other.messages.length, count);
  close();
});

test('warming up decodes a mesh of some size', () => {
  assert.ok(warmUp() > 5000);
});
