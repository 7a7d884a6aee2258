import assert from 'node:assert/strict';
import { test } from 'node:test';
import { crc32 } from 'node:zlib';
import { Decoder, StreamError } from '../src/index.js';
import { fingerprint } from '../testing/fingerprint.js';
import { bunny, chunkBytes, chunksOf, Random, vectors } from '../testing/vectors.js';

/** @param {import('../src/decoder.js').StreamPart} part */
function assertDrawable(part) {
  const triangles = part.triangles();
  assert.equal(triangles.length, 3 * part.triangleCount);
  assert.equal(part.positions().length, 3 * part.vertexCount);
  assert.ok(triangles.every((vertex) => vertex < part.vertexCount));
  for (const { array, components } of part.attributes()) assert.equal(array.length, components * part.vertexCount);
}

/** @param {import('../testing/vectors.js').Vector} vector */
function assertDecodes({ bytes, chunks, parts }) {
  const decoder = new Decoder();
  let start = 0;
  for (const [i, { end, stream, level, triangles, vertices, error, fingerprint: expected }] of chunks.entries()) {
    assert.equal(decoder.update(bytes.subarray(start, end)), 1);
    const part = decoder.part(stream);
    assert.ok(part);
    assert.deepEqual(
      [decoder.chunkCount, decoder.offset, part.level, part.triangleCount, part.vertexCount, part.error, fingerprint(part)],
      [i + 1, end, level, triangles, vertices, Math.fround(error), expected],
    );
    assertDrawable(part);
    start = end;
  }
  assert.equal(decoder.parts.length, parts.length);
  for (const [i, part] of decoder.parts.entries()) {
    const bytesOf = (/** @type {ArrayBufferView} */ { buffer, byteLength }) => crc32(new Uint8Array(buffer, 0, byteLength));
    const attributes = part.attributes().map(({ name, components, normalized, array }) => {
      return { name, components, normalized, array: array.constructor.name, crc: bytesOf(array) };
    });
    const positions = bytesOf(part.positions());
    assert.deepEqual({ fullLevel: part.fullLevel, fullTriangles: part.fullTriangleCount, positions, attributes }, parts[i]);
  }
}

/** @param {Decoder} decoder */
function fingerprints(decoder) {
  return decoder.parts.map((part) => fingerprint(part));
}

for (const vector of vectors()) {
  test(`${vector.name} is decoded as by the encoder`, () => assertDecodes(vector));

  test(`${vector.name} does not depend on how its bytes are split`, () => {
    const whole = new Decoder();
    assert.equal(whole.update(vector.bytes.slice().buffer), vector.chunks.length);
    assert.equal(whole.offset, vector.bytes.length);
    const bytewise = new Decoder();
    for (let i = 0; i < vector.bytes.length; i++) bytewise.update(vector.bytes.subarray(i, i + 1));
    assert.deepEqual(fingerprints(bytewise), fingerprints(whole));
    assert.equal(bytewise.chunkCount, vector.chunks.length);
    for (let seed = 0; seed < 5; seed++) {
      const random = new Random(seed);
      const decoder = new Decoder();
      let decoded = 0;
      for (let at = 0; at < vector.bytes.length; ) {
        const end = at + random.below(seed % 2 ? 100 : 10_000);
        // The piece may be overwritten after the call.
        const piece = vector.bytes.slice(at, end);
        decoded += decoder.update(piece);
        piece.fill(255);
        at = end;
      }
      assert.equal(decoded, vector.chunks.length);
      assert.deepEqual(fingerprints(decoder), fingerprints(whole));
    }
  });
}

const { TRISTRIP_BUNNY } = process.env;
test('the bunny is decoded as by the encoder', { skip: !TRISTRIP_BUNNY && 'TRISTRIP_BUNNY is not set to the path of its stream' }, () => {
  const vector = bunny();
  assert.ok(vector);
  assertDecodes(vector);
});

/**
 * Runs a decoder on bytes that no encoder has written. It may only throw stream errors, and what it
 * has decoded can be drawn.
 * @param {Uint8Array[]} pieces
 */
function tryDecode(pieces) {
  const decoder = new Decoder({ triangles: 100_000, chunkBytes: 100_000 });
  try {
    for (const piece of pieces) decoder.update(piece);
  } catch (error) {
    if (!(error instanceof StreamError)) throw error;
    assert.throws(() => decoder.update(new Uint8Array(1)), error);
    decoder.parts.forEach(assertDrawable);
    return error;
  }
  decoder.parts.forEach(assertDrawable);
  return undefined;
}

test('damaged streams are rejected', { timeout: 600_000 }, () => {
  const random = new Random(1);
  const small = vectors().filter(({ bytes }) => bytes.length < 6000);
  const counts = { complete: 0, checksum: 0, contents: 0 };
  for (let round = 0; round < 2500; round++) {
    const { bytes } = small[round % small.length];
    const mutated = bytes.slice(0, random.below(2) ? bytes.length : random.below(bytes.length));
    for (let flips = random.below(3); flips > 0 && mutated.length > 0; flips--) mutated[random.below(mutated.length)] ^= 1 << random.below(8);
    const error = tryDecode([mutated]);
    counts[!error ? 'complete' : /checksum/.test(error.found) ? 'checksum' : 'contents']++;
  }
  // Repeats this with correct checksums, so that the payloads are decoded.
  for (let round = 0; round < 2500; round++) {
    const chunks = chunksOf(small[round % small.length]);
    const damaged = random.below(chunks.length);
    const pieces = chunks.map(({ head, payload }, i) => {
      if (i !== damaged) return chunkBytes(head, payload);
      const changed = { ...head };
      const mutated = payload.slice(0, random.below(4) ? payload.length : random.below(payload.length + 1));
      for (let flips = random.below(5); flips > 0 && mutated.length > 0; flips--) {
        mutated[random.below(mutated.length)] = random.below(256);
      }
      const field = /** @type {const} */ (['stream', 'visits', 'level', 'triangles', 'error', 'error'])[random.below(6)];
      // Few chunks have enough visits to reach the end of the payload.
      if (field !== 'error' && random.below(3) === 0) changed[field] = random.below(random.below(2) ? 2000 : 2 ** 32);
      return chunkBytes(changed, mutated);
    });
    const error = tryDecode(pieces);
    assert.ok(!error || !/checksum/.test(error.found));
    counts[error ? 'contents' : 'complete']++;
  }
  assert.ok(counts.checksum > 1000 && counts.contents > 1000 && counts.complete > 100, JSON.stringify(counts));
});

test('an error has the location, and the part before it remains', () => {
  const { bytes, chunks } = vectors().filter(({ name }) => name === 'components')[0];
  const damaged = bytes.slice();
  damaged[chunks[1].end - 1] ^= 1;
  const decoder = new Decoder();
  const expected = { name: 'StreamError', at: `chunk 1 at byte ${chunks[0].end}`, found: /^checksum [0-9a-f]{8}$/, expected: /the chunk is damaged/ };
  assert.throws(() => decoder.update(damaged), expected);
  assert.throws(() => decoder.update(bytes), expected);
  assert.equal(decoder.chunkCount, 1);
  assert.equal(decoder.offset, chunks[0].end);
  assert.equal(fingerprint(decoder.part(0)), chunks[0].fingerprint);
});

test('limits are enforced', () => {
  const { bytes, chunks } = vectors().filter(({ name }) => name === 'meshes')[0];
  const most = Math.max(...chunks.map(({ triangles }) => triangles));
  const refused = (/** @type {object} */ limits, /** @type {RegExp} */ expected) => {
    assert.throws(() => new Decoder(limits).update(bytes), { name: 'StreamError', expected });
  };
  refused({ meshes: 1 }, /a number below 1/);
  refused({ triangles: most - 1 }, /at most/);
  refused({ chunkBytes: 100 }, /at most 100/);
  refused({ corners: 500 }, /at most \d+/);
  // The header alone shows that a chunk is too large.
  const head = Uint8Array.from([0, 255, 255, 255, 255, 15, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0]);
  assert.throws(() => new Decoder().update(head), { found: '4294967295 bytes' });
  const tooLong = Uint8Array.from([255, 255, 255, 255, 255]);
  assert.throws(() => new Decoder().update(tooLong), { found: 'a number of more than 32 bits' });
  assert.equal(new Decoder().update(head.subarray(0, 16)), 0);
});
