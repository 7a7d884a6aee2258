/**
 * Shared by browser tests: pages, their console messages, and cleanup.
 * @module
 */
import { after, test } from 'node:test';
import { browser, skip } from './chromium.js';
import { Models } from './models.js';
import { Server } from './server.js';

export { skip };

/** The timeout of a page in milliseconds, long enough for a busy machine. */
const PATIENCE = 120_000;

/** Messages of the graphics driver, which are not about the page. */
const NOISE = /GPU stall|GL Driver|WebGL-0x|GroupMarkerNotSet/;

/**
 * A page and the problems in it.
 * @typedef {{ page: import('playwright-core').Page, problems: string[] }} Tab
 */

/** The files of the bundled viewer, as the server of the command delivers it. */
const BUNDLE = ['index.html', 'style.css', 'viewer.js', 'worker.js'];

/**
 * A server for the directory `web` with the bundled viewer, installed packages under
 * `/node_modules/`, and models under `/models/`; and its pages.
 */
export class Harness {
  models = new Models();
  /** @type {import('playwright-core').BrowserContext[]} */
  #contexts = [];
  server = new Server({
    '/': new URL('../', import.meta.url),
    ...Object.fromEntries(BUNDLE.map((name) => [`/${name}`, new URL(`../../crates/tristrip-serve/dist/${name}`, import.meta.url)])),
    '/node_modules/': new URL('node_modules/', import.meta.url),
    '/models.json': `${this.models.folder}/models.json`,
    '/models/': `${this.models.folder}/`,
  });

  /** @returns {Promise<this>} */
  async start() {
    await this.server.start();
    return this;
  }

  /**
   * Defines a test whose pages are closed at its end, because they would slow down the next tests.
   * @param {string} name
   * @param {import('node:test').TestOptions} options
   * @param {(t: import('node:test').TestContext) => Promise<void>} act
   */
  test = (name, options, act) => {
    test(name, options, async (t) => {
      try {
        await act(t);
      } finally {
        await Promise.all(this.#contexts.splice(0).map((context) => context.close()));
      }
    });
  };

  /**
   * Opens a page.
   * @param {string} path
   * @param {import('playwright-core').BrowserContextOptions} [options]
   * @returns {Promise<Tab>}
   */
  open = async (path, options = { viewport: { width: 512, height: 512 } }) => {
    const context = await browser.newContext(options);
    context.setDefaultTimeout(PATIENCE);
    this.#contexts.push(context);
    const page = await context.newPage();
    /** @type {string[]} */
    const problems = [];
    page.on('console', (message) => {
      if (['error', 'warning'].includes(message.type()) && !NOISE.test(message.text())) problems.push(`${message.type()}: ${message.text()}`);
    });
    page.on('pageerror', (error) => problems.push(`error: ${error.message}`));
    await page.goto(`${this.server.origin}${path}`);
    return { page, problems };
  };

  close() {
    this.server.close();
    this.models.remove();
  }
}

/**
 * Starts a harness for a test file. It and the browser are closed after the tests.
 * @returns {Promise<Harness>}
 */
export async function startHarness() {
  const harness = await new Harness().start();
  after(async () => {
    harness.close();
    if (!skip) await browser.close();
  });
  return harness;
}
