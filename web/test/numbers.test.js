import assert from 'node:assert/strict';
import { test } from 'node:test';
import { halves } from '../src/numbers.js';
import { next, previous } from '../src/surface.js';

/** @param {bigint} x */
function halvesOf(x) {
  if (x < 2n) return Number(x);
  const bits = BigInt(x.toString(2).length - 1);
  return Number(2n * bits + ((x >> (bits - 1n)) & 1n));
}

test('twice the logarithm of whole numbers', () => {
  for (let bits = 0; bits < 53; bits++) {
    for (const offset of [-1, 0, 1, 2 ** (bits - 1) - 1, 2 ** (bits - 1)]) {
      const x = Math.max(2 ** bits + Math.floor(offset), 0);
      assert.equal(halves(x), halvesOf(BigInt(x)), `${x}`);
    }
  }
  assert.ok(halves(Infinity) < 128 && halves(NaN) === 0);
});

test('the corners of a triangle follow one another', () => {
  for (const first of [0, 8, 2 ** 29 - 8]) {
    const corners = [first, first + 1, first + 2];
    assert.deepEqual(corners.map(next), [first + 1, first + 2, first]);
    assert.deepEqual(corners.map(previous), [first + 2, first, first + 1]);
  }
});
