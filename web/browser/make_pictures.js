#!/usr/bin/env node
/**
 * Creates the images of the README from the real page: `docs/viewer.png`, and `docs/refining.gif`,
 * in which a model refines.
 *
 *     node make_pictures.js
 *
 * Each frame is the model after a number of chunks, so the frames do not depend on the speed of the
 * machine.
 * @module
 */
import { statSync, writeFileSync } from 'node:fs';
import path from 'node:path';
import gifenc from 'gifenc';
import { PNG } from 'pngjs';
import { browser } from './chromium.js';
import { Harness } from './harness.js';
import { ownModel } from './models.js';

const { applyPalette, GIFEncoder, quantize } = gifenc;

const DOCS = new URL('../../docs/', import.meta.url);
const PAGE = { viewport: { width: 1000, height: 790 } };
const ANIMATION = { viewport: { width: 900, height: 600 } };
const COLOURS = 128;
/** The duration of frames in milliseconds; the first and last are longer. */
const FRAME = 160;
const FIRST = 700;
const LAST = 2500;
const FRAMES = 20;

const harness = await new Harness().start();
const { models } = harness;
const hand = models.pack(ownModel('hand.ply'));
const truck = models.pack(ownModel('milktruck.glb'));
const listed = [hand, truck].map((name) => ({
  name: name.replace('.packed', ''),
  url: `models/${name}`,
  kind: 'progressive',
  bytes: statSync(path.join(models.folder, name)).size,
  triangles: null,
  vertices: null,
}));
writeFileSync(path.join(models.folder, 'models.json'), JSON.stringify({ models: listed }));

/** @param {import('playwright-core').Page} page */
const shown = (page) => page.evaluate(() => window.tristrip.viewer.figures.progress?.shownChunks ?? 0);

/**
 * Opens a model, and waits until it is complete.
 * @param {string} name
 * @param {string} state the rest of the address
 * @param {import('playwright-core').BrowserContextOptions} options
 */
async function open(name, state, options) {
  const { page } = await harness.open(`/index.html#model=models/${name}${state}`, options);
  await page.waitForFunction(() => window.tristrip?.viewer.state === 'complete');
  return page;
}

/**
 * Shows the model after some chunks.
 * @param {import('playwright-core').Page} page
 * @param {number} count
 */
async function showChunks(page, count) {
  await page.locator('#level').fill(String(count));
  await page.waitForFunction((count) => window.tristrip.viewer.figures.progress?.shownChunks === count, count);
  await page.locator('#level').blur();
  await page.waitForTimeout(300);
}

const still = await open(hand, '&mode=strips', PAGE);
await showChunks(still, Math.ceil((await shown(still)) / 2));
writeFileSync(new URL('viewer.png', DOCS), await still.screenshot());

const moving = await open(hand, '', ANIMATION);
const all = await shown(moving);
const first = await moving.evaluate(() => window.tristrip.viewer.figures.baseChunks);
const counts = [...new Set(Array.from({ length: FRAMES }, (_, i) => Math.round(first + ((all - first) * i) / (FRAMES - 1))))];
const gif = GIFEncoder();
for (const count of counts) {
  await showChunks(moving, count);
  const { data, width, height } = PNG.sync.read(await moving.screenshot());
  const palette = quantize(data, COLOURS);
  const delay = count === first ? FIRST : count === all ? LAST : FRAME;
  gif.writeFrame(applyPalette(data, palette), width, height, { palette, delay });
}
gif.finish();
writeFileSync(new URL('refining.gif', DOCS), gif.bytes());

harness.close();
await browser.close();
