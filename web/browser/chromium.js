/**
 * Finds or installs Chromium, and starts it.
 * @module
 */
import { spawnSync } from 'node:child_process';
import { existsSync } from 'node:fs';
import { createRequire } from 'node:module';

/** @typedef {import('playwright-core').Browser} Browser */

const { CHROMIUM, TRISTRIP_REQUIRE_BROWSER } = process.env;

/** Without a GPU, SwiftShader renders WebGL. */
const ARGUMENTS = ['--use-angle=swiftshader', '--enable-unsafe-swiftshader', '--no-sandbox', '--enable-precise-memory-info'];

const INSTALL_MILLISECONDS = 300_000;

/** @returns {Promise<typeof import('playwright-core').chromium | undefined>} */
async function playwright() {
  try {
    return (await import('playwright-core')).chromium;
  } catch {
    return undefined;
  }
}

/** Installs Playwright's Chromium. Returns whether it succeeded. */
function install() {
  const cli = createRequire(import.meta.url).resolve('playwright-core/cli.js');
  return spawnSync(process.execPath, [cli, 'install', 'chromium'], { stdio: 'ignore', timeout: INSTALL_MILLISECONDS }).status === 0;
}

/**
 * Starts Chromium.
 * @returns {Promise<Browser | string>} the browser, or why it is not available
 */
async function launch() {
  const chromium = await playwright();
  if (!chromium) return 'playwright-core is not installed: run npm ci in web/browser';
  const own = chromium.executablePath();
  const places = [CHROMIUM, '/usr/bin/chromium', '/usr/bin/google-chrome', own];
  let executablePath = places.find((place) => place && existsSync(place));
  if (CHROMIUM && executablePath !== CHROMIUM) return `there is no ${CHROMIUM}`;
  if (!executablePath && install()) executablePath = own;
  if (!executablePath) return 'Chromium is not installed, and npx playwright-core install chromium has failed';
  return chromium.launch({ executablePath, args: ARGUMENTS });
}

const launched = await launch();
if (typeof launched === 'string' && TRISTRIP_REQUIRE_BROWSER) throw new Error(`TRISTRIP_REQUIRE_BROWSER: ${launched}`);

/** Why browser tests are skipped, for the option `skip` of tests. */
export const skip = typeof launched === 'string' ? `SKIPPED: ${launched}` : false;

/** The browser, unless tests are skipped. */
export const browser = /** @type {Browser} */ (launched);
