import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { test } from 'node:test';
import { crc32 } from 'node:zlib';
import { Decoder } from '../src/index.js';
import { Random } from '../src/paths.js';
import { Strips } from '../src/strips.js';
import { fingerprint } from '../testing/fingerprint.js';
import { canonical, drawnByStrips, triples } from '../testing/triangles.js';
import { chunkBytes, chunksOf, Random as Seeded, vectors } from '../testing/vectors.js';

/** The checksums of the strips that the decoder in Rust maintains. */
const EXPECTED = JSON.parse(readFileSync(new URL('../../testdata/stream/strips.json', import.meta.url), 'utf8'));

/** @param {import('../src/decoder.js').StreamPart} part */
function assertStrips(part) {
  const { strips } = part;
  assert.ok(strips);
  const indices = strips.indices();
  assert.equal(indices.length, strips.verticesSent + Math.max(strips.count - 1, 0));
  assert.deepEqual(canonical(drawnByStrips(indices)), canonical(triples(part.triangles())));
  return indices;
}

/** @param {Uint16Array | Uint32Array} indices the checksum is computed over 32-bit indices */
function checksum(indices) {
  return crc32(new Uint8Array(Uint32Array.from(indices, (index) => (indices instanceof Uint16Array && index === 65535 ? 4294967295 : index)).buffer));
}

for (const vector of vectors()) {
  test(`the strips of ${vector.name} are those of the other decoder`, () => {
    const decoder = new Decoder({ strips: Strips });
    let start = 0;
    const found = vector.chunks.map(({ end, stream }) => {
      decoder.update(vector.bytes.subarray(start, end));
      start = end;
      const part = decoder.part(stream);
      assert.ok(part);
      return checksum(assertStrips(part));
    });
    assert.deepEqual(found, EXPECTED[vector.name]);
    const whole = new Decoder({ strips: Strips });
    whole.update(vector.bytes);
    assert.deepEqual(whole.parts.map((part) => part.strips?.indices()), decoder.parts.map((part) => part.strips?.indices()));
    const plain = new Decoder();
    plain.update(vector.bytes);
    assert.ok(plain.parts.every((part) => part.strips === undefined));
    assert.deepEqual(plain.parts.map((part) => fingerprint(part)), whole.parts.map((part) => fingerprint(part)));
  });
}

test('strips of invalid chunks draw the part that was decoded', () => {
  const random = new Seeded(2);
  const small = vectors().filter(({ bytes }) => bytes.length < 6000);
  let faults = 0;
  for (let round = 0; round < 400; round++) {
    const chunks = chunksOf(small[round % small.length]);
    const damaged = random.below(chunks.length);
    const decoder = new Decoder({ strips: Strips, triangles: 100_000 });
    try {
      chunks.forEach(({ head, payload }, i) => {
        const mutated = payload.slice();
        if (i === damaged && mutated.length > 0) mutated[random.below(mutated.length)] = random.below(256);
        decoder.update(chunkBytes(head, mutated));
      });
    } catch (error) {
      if (!(error instanceof Error) || error.name !== 'StreamError') throw error;
      faults++;
    }
    decoder.parts.forEach(assertStrips);
  }
  assert.ok(faults > 100, `${faults}`);
});

test('random numbers are those of SplitMix64', () => {
  const random = new Random();
  let state = 0n;
  const mask = (1n << 64n) - 1n;
  for (let i = 0; i < 1000; i++) {
    state = (state + 0x9e3779b97f4a7c15n) & mask;
    let z = ((state ^ (state >> 30n)) * 0xbf58476d1ce4e5b9n) & mask;
    z = ((z ^ (z >> 27n)) * 0x94d049bb133111ebn) & mask;
    z ^= z >> 31n;
    random.next();
    assert.deepEqual([random.high, random.low], [Number(z >> 32n), Number(z & 0xffffffffn)]);
  }
});
