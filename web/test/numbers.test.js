import assert from 'node:assert/strict';
import { test } from 'node:test';
import { logarithm } from '../src/math.js';
import { next, previous } from '../src/surface.js';

/** @param {bigint} x */
function logarithmOf(x) {
  const digits = (x > 0n ? x : 1n).toString(2);
  return 8 * (digits.length - 1) + parseInt(`${digits}000`.slice(1, 4), 2);
}

test('logarithms of integers', () => {
  for (let bits = 0; bits < 53; bits++) {
    for (const offset of [-1, 0, 1, 2 ** (bits - 1) - 1, 2 ** (bits - 1)]) {
      const x = Math.max(2 ** bits + Math.floor(offset), 1);
      assert.equal(logarithm(x), logarithmOf(BigInt(x)), `${x}`);
    }
  }
});

test('the corners of a triangle follow one another', () => {
  for (const first of [0, 8, 2 ** 29 - 8]) {
    const corners = [first, first + 1, first + 2];
    assert.deepEqual(corners.map(next), [first + 1, first + 2, first]);
    assert.deepEqual(corners.map(previous), [first + 2, first, first + 1]);
  }
});
