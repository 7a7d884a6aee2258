/**
 * Measures the viewer with large models: decoding time, longest main-thread call, first image.
 * There are no limits, because times depend on the machine.
 *
 *     TRISTRIP_MODELS=../../../shared/models node --test times.js
 */
import { statSync } from 'node:fs';
import path from 'node:path';
import { skip, startHarness } from './harness.js';
import { largeModels } from './models.js';
import { traced } from './processor_time.js';

const RUNS = 3;

const { models, open, server, test } = await startHarness();
const missing = skip || (!largeModels && 'SKIPPED: TRISTRIP_MODELS is not set');

/** @param {string} name */
function pack(name) {
  const packed = models.pack(path.join(/** @type {string} */ (largeModels), name));
  return { url: `/models/${packed}`, bytes: statSync(path.join(models.folder, packed)).size };
}

test('decoding', { skip: missing }, async (t) => {
  const bunny = pack('bunny.ply');
  const { page } = await open('/browser/pages/blank.html');
  await page.evaluate(async () => {
    const { Client } = await import('/src/client/client.js');
    const client = new Client();
    const load = (/** @type {string} */ url) =>
      new Promise((resolve) => {
        const model = client.load(url, {
          update: ({ progress }) => {
            if (!progress.isComplete) return;
            model.close();
            resolve(progress);
          },
        });
      });
    Object.assign(window, { load });
  });
  // The first run includes compilation of the decoder.
  for (let run = 0; run < RUNS; run++) {
    let decode = 0;
    const { sharing } = await traced(page, async () => {
      const progress = await page.evaluate((url) => window.load(url), bunny.url);
      decode = progress.decodeMilliseconds;
    });
    t.diagnostic(`bunny: ${decode.toFixed(0)} ms, ${(decode / sharing).toFixed(0)} ms of the processor`);
  }
});

test('the main thread', { skip: missing }, async (t) => {
  const bunny = pack('bunny.ply');
  for (let run = 0; run < RUNS; run++) {
    const { page } = await open('/index.html');
    await page.waitForFunction('window.tristrip');
    const { longest } = await traced(page, async () => {
      await page.evaluate((url) => void (location.hash = `#model=${url}`), bunny.url.slice(1));
      await page.waitForFunction(() => window.tristrip.viewer.state === 'complete');
    });
    const clock = await page.evaluate(() => window.tristrip.viewer.longestTask);
    t.diagnostic(`bunny: longest call ${longest.toFixed(1)} ms of the processor, ${clock.toFixed(1)} ms by the clock`);
  }
});

test('the first image', { skip: missing }, async (t) => {
  const dragon = pack('dragon.ply');
  server.shape(dragon.url, { bytesPerSecond: 5e6 / 8 });
  for (let run = 0; run < RUNS; run++) {
    const { page } = await open('/index.html');
    await page.waitForFunction('window.tristrip');
    await page.waitForTimeout(500);
    await page.evaluate((url) => void (location.hash = `#model=${url}`), dragon.url.slice(1));
    await page.waitForFunction(() => window.tristrip.viewer.hasPicture);
    const first = await page.evaluate(() => performance.getEntriesByName('tristrip:first-picture', 'measure')[0].duration);
    t.diagnostic(`dragon at 5 Mbit/s: ${first.toFixed(0)} ms after the click`);
  }
});
