import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { mkdtempSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { test } from 'node:test';
import { GlbDecoder } from '../src/index.js';
import { fingerprint } from '../testing/fingerprint.js';
import { document, glb, MESHES } from '../testing/glb.js';
import { Random } from '../testing/vectors.js';

const { chunks } = MESHES;
const stream = MESHES.bytes;

test('the stream of a file is found however its bytes are split', () => {
  const file = glb(document());
  const start = file.length - 3 - stream.length;
  for (let seed = 0; seed < 6; seed++) {
    const random = new Random(seed);
    const decoder = new GlbDecoder();
    assert.equal(decoder.offset, 0);
    let decoded = 0;
    for (let at = 0, length = 0; at < file.length; at += length) {
      length = seed === 0 ? file.length : seed === 1 ? 1 : random.below(200);
      decoded += decoder.update(file.subarray(at, at + length));
    }
    assert.deepEqual(decoder.json, document());
    assert.deepEqual([decoded, decoder.chunkCount, decoder.offset], [chunks.length, chunks.length, start + stream.length]);
    for (const { primitives } of decoder.json.meshes) {
      const { stream } = primitives[0].extensions.TRISTRIP_progressive;
      const last = chunks.filter((chunk) => chunk.stream === stream).pop();
      assert.equal(fingerprint(decoder.part(stream)), last.fingerprint);
    }
    assert.equal(decoder.parts.length, 2);
  }
});

test('the base meshes are available before the end of the file', () => {
  const file = glb(document());
  const decoder = new GlbDecoder();
  decoder.update(file.subarray(0, file.length - 3 - stream.length + chunks[1].end));
  assert.deepEqual(decoder.parts.map((part) => part.level), [0, 0]);
});

test('other files are rejected', () => {
  const refused = (/** @type {Uint8Array} */ file, /** @type {object} */ error) => {
    const decoder = new GlbDecoder({ chunkBytes: 10_000 });
    assert.throws(() => decoder.update(file), { name: 'StreamError', ...error });
    assert.throws(() => decoder.update(file), { name: 'StreamError', ...error });
  };
  const changed = (/** @type {(json: any) => void} */ change) => {
    const json = document();
    change(json);
    return glb(json);
  };
  refused(glb(document(), { magic: 0 }), { at: 'byte 0', found: 'no GLB of version 2' });
  refused(glb('{'), { at: 'byte 20', found: 'no JSON' });
  refused(glb('null'), { found: 'no extension TRISTRIP_progressive' });
  refused(changed((json) => delete json.extensions), { found: 'no extension TRISTRIP_progressive' });
  refused(changed((json) => (json.extensions.TRISTRIP_progressive.version = 2)), { found: 'version 2 of the stream' });
  for (const change of [
    (/** @type {any} */ json) => delete json.bufferViews,
    (/** @type {any} */ json) => (json.bufferViews[1].buffer = 1),
    (/** @type {any} */ json) => (json.bufferViews[1].byteOffset = -1),
    (/** @type {any} */ json) => (json.bufferViews[1].byteLength = '9'),
    (/** @type {any} */ json) => (json.buffers[0].uri = 'other.bin'),
  ]) {
    refused(changed(change), { found: 'a stream without a buffer view in the file' });
  }
  refused(changed((json) => (json.bufferViews[1].byteLength = 2 ** 40)), { expected: /^a binary chunk of at least/ });
  refused(glb(document(), { type: 0 }), { found: 'another chunk' });
  refused(glb(JSON.stringify(document()).padEnd(10_001)), { expected: 'at most 10000' });
  refused(changed((json) => (json.bufferViews[1].byteOffset = 41)), { at: 'chunk 0 at byte 0' });
});

test('the example of the README runs', () => {
  const readme = readFileSync(new URL('../README.md', import.meta.url), 'utf8');
  const examples = [...readme.matchAll(/```js\n(.*?)```/gs)].map(([, code]) => code);
  const example = examples.find((code) => code.includes('createReadStream')) ?? '';
  const folder = mkdtempSync(join(tmpdir(), 'tristrip-'));
  try {
    writeFileSync(join(folder, 'model.glb'), glb(document()));
    const code = example.replace("'tristrip'", `'${new URL('../src/index.js', import.meta.url)}'`);
    writeFileSync(join(folder, 'example.mjs'), code);
    const printed = execFileSync(process.execPath, ['example.mjs'], { cwd: folder, encoding: 'utf8' });
    for (const { triangles, vertices } of chunks.slice(-1)) assert.match(printed, new RegExp(`${triangles} of ${triangles} triangles, ${vertices} vertices`));
  } finally {
    rmSync(folder, { recursive: true });
  }
});
