import assert from 'node:assert/strict';
import { readdirSync, readFileSync } from 'node:fs';
import { test } from 'node:test';
import { gzipSync } from 'node:zlib';
import { bundle, DIST } from '../build.js';

const MAX_BYTES = 60_000;

test('the bundle matches the sources: npm run build', async () => {
  const files = await bundle();
  assert.deepEqual(readdirSync(DIST).sort(), [...files.keys()].sort());
  for (const [name, bytes] of files) assert.ok(readFileSync(new URL(name, DIST)).equals(bytes), `${name} is not that of the sources`);
});

test('the viewer is small', () => {
  const bytes = readdirSync(DIST).map((name) => gzipSync(readFileSync(new URL(name, DIST)), { level: 9 }).length);
  const sum = bytes.reduce((a, b) => a + b);
  console.log(`the viewer takes ${sum} bytes (gzip)`);
  assert.ok(sum <= MAX_BYTES);
});
