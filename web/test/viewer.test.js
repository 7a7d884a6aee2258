import assert from 'node:assert/strict';
import { test } from 'node:test';
import { curveOf } from '../viewer/curve.js';
import { Figures } from '../viewer/figures.js';

const pointsOf = (...errors) => errors.map((error, i) => ({ bytes: 10 * (i + 1), triangles: i, error }));

test('a curve lies between two powers of ten', () => {
  const points = pointsOf(0.5, 0.02);
  const { least, most, step, totalBytes } = curveOf(points, 100);
  assert.deepEqual([least, most, step].map((log) => Number(Math.exp(log).toPrecision(9))), [0.01, 1, 10]);
  assert.equal(totalBytes, 100);
  assert.deepEqual(curveOf(points, 0).points, points);
  assert.equal(curveOf(points, 0).totalBytes, 20);
  const { least: below, most: above } = curveOf(pointsOf(0.1), 10);
  assert.ok(below < above);
});

test('non-finite errors are not on the curve', () => {
  assert.equal(curveOf(pointsOf(0, Infinity, -1, NaN), 100), undefined);
  const { points, least, most, step } = curveOf(pointsOf(Infinity, 1e300, 1e-300, 0), 100);
  assert.deepEqual(points.map(({ error }) => error), [1e300, 1e-300]);
  assert.ok((most - least) / step < 4);
});

test('a curve of many points is thinned out', () => {
  const many = Array.from({ length: 300_000 }, (_, i) => ({ bytes: i + 1, triangles: i, error: 1 / (i + 1) }));
  const { points } = curveOf(many, many.length);
  assert.ok(points.length > 400 && points.length < 510, `${points.length} points`);
  assert.deepEqual([points[0], points.at(-1)], [many[0], many.at(-1)]);
});

/** A document with a streamed mesh that has these position bounds. */
const documentOf = (bounds) => ({ meshes: [{ primitives: [{ attributes: { POSITION: 0 }, extensions: { TRISTRIP_progressive: { stream: 0 } } }] }], accessors: [bounds] });

test('errors are fractions of the size, and finite', () => {
  const errorOf = (bounds, error) => {
    const figures = new Figures();
    figures.open(documentOf(bounds));
    figures.addChunks([{ stream: 0, end: 10, triangles: 1, error }]);
    return figures.points[0].error;
  };
  assert.equal(errorOf({ min: [0, 0, 0], max: [3, 4, 0] }, 1), 0.2);
  assert.equal(errorOf({ min: [0, 0, 0], max: [1e-300, 0, 0] }, 1e20), 0);
  assert.equal(errorOf({ min: [0, 0, 0], max: [1, 0, 0] }, Infinity), 0);
  // Invalid bounds leave the size unknown.
  for (const bounds of [{ min: 5, max: 5 }, { min: [0], max: [1] }, { min: ['a', 0, 0], max: [1, 1, 1] }, {}, null]) assert.equal(errorOf(bounds, 0.5), 0.5);
});

test('incremental sums over chunks are correct, in time independent of the number of meshes', () => {
  const meshes = 3000;
  const figures = new Figures();
  let seed = 1;
  const random = (n) => (seed = (seed * 48271) % 2147483647) % n;
  let reads = 0;
  const chunkOf = (stream, end) => {
    const values = { stream, end, triangles: random(1000), error: random(1e6) / 1e3 };
    return { values, read: new Proxy(values, { get: (of, name) => (reads++, of[name]) }) };
  };
  const known = new Map();
  for (let round = 0; round < 6; round++) {
    const chunks = Array.from({ length: meshes }, (_, i) => chunkOf(round === 0 ? i : random(meshes), round * meshes + i));
    figures.addChunks(chunks.map(({ read }) => read));
    for (const [i, { values }] of chunks.entries()) {
      known.set(values.stream, values);
      // Recomputing all of them would take too long.
      if (i % 500 !== 499 && round > 0) continue;
      if (round === 0 && i > 40) continue;
      const all = [...known.values()];
      const { triangles, error } = figures.points[round * meshes + i];
      assert.equal(triangles, all.reduce((sum, one) => sum + one.triangles, 0));
      assert.equal(error, Math.max(...all.map((one) => one.error)));
    }
  }
  assert.equal(figures.baseChunks, meshes);
  assert.equal(figures.points.length, 6 * meshes);
  assert.equal(reads, 4 * 6 * meshes, 'each chunk is read once');
});
