/**
 * The package in a project: packed by npm, installed with Vite and three.js, type-checked, built,
 * and opened in a browser.
 */
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { cpSync, mkdirSync, mkdtempSync, readFileSync, readdirSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import path from 'node:path';
import { after, test } from 'node:test';
import { fileURLToPath } from 'node:url';
import { skip, startHarness } from './harness.js';
import { ownModel } from './models.js';

const web = fileURLToPath(new URL('../', import.meta.url));
const project = mkdtempSync(path.join(tmpdir(), 'tristrip-consumer-'));
after(() => rmSync(project, { recursive: true, force: true }));

/** @type {(folder: string, command: string, ...words: string[]) => string} */
const run = (cwd, command, ...words) => {
  try {
    return execFileSync(command, words, { cwd, encoding: 'utf8', stdio: ['ignore', 'pipe', 'pipe'] });
  } catch (error) {
    const { stdout, stderr } = /** @type {{ stdout: string, stderr: string }} */ (error);
    throw new Error(`${command} ${words.join(' ')}:\n${stdout}\n${stderr}`);
  }
};

/** Returns packages with the versions of a lock file, as arguments for npm install. */
const pinned = (/** @type {string} */ folder, /** @type {string[]} */ ...names) => {
  const { packages } = JSON.parse(readFileSync(path.join(folder, 'package-lock.json'), 'utf8'));
  return names.map((name) => `${name}@${packages[`node_modules/${name}`].version}`);
};

test('a project with Vite and three.js installs, checks, builds and shows a model', { skip }, async (t) => {
  const harness = await startHarness();
  const packages = [...pinned(path.join(web, 'browser'), 'three', 'vite'), ...pinned(web, '@types/three', 'typescript')];

  await t.test('npm pack', () => {
    cpSync(path.join(web, 'browser/consumer'), project, { recursive: true });
    if (!readdirSync(web).includes('node_modules')) run(web, 'npm', 'ci', '--no-audit', '--no-fund');
    const [{ files }] = JSON.parse(run(web, 'npm', 'pack', '--json', '--silent', '--pack-destination', project).replace(/^[^[]*/, ''));
    const names = files.map((/** @type {{ path: string }} */ file) => file.path);
    for (const name of ['README.md', 'LICENSE-MIT', 'src/client/worker.js', 'types/three/index.d.ts']) assert.ok(names.includes(name), name);
    assert.deepEqual(names.filter((/** @type {string} */ name) => /test|example|browser/.test(name)), []);
  });

  await t.test('npm install', () => {
    const [tarball] = readdirSync(project).filter((name) => name.endsWith('.tgz'));
    run(project, 'npm', 'install', '--no-audit', '--no-fund', '--prefer-offline', `./${tarball}`, ...packages);
  });

  await t.test('types, as bundlers and as Node resolve them', () => {
    run(project, 'npx', 'tsc', '-p', '.');
    run(project, 'npx', 'tsc', '-p', 'tsconfig.nodenext.json');
  });

  await t.test('Node runs the decoder', () => {
    run(project, process.execPath, '--input-type=module', '--eval', "import { GlbDecoder } from 'tristrip'; import { Strips } from 'tristrip/strips'; new GlbDecoder({ strips: Strips });");
  });

  await t.test('vite build', async () => {
    const packed = harness.models.pack(ownModel('milktruck.glb'));
    mkdirSync(path.join(project, 'public'));
    cpSync(path.join(harness.models.folder, packed), path.join(project, 'public/model.glb'));
    run(project, 'npx', 'vite', 'build');
    const assets = readdirSync(path.join(project, 'dist/assets'));
    assert.ok(assets.some((name) => /^worker-.*\.js$/.test(name)), assets.join(', '));
    cpSync(path.join(project, 'dist'), path.join(harness.models.folder, 'dist'), { recursive: true });
    const { page, problems } = await harness.open('/models/dist/index.html');
    await page.waitForFunction('window.found');
    const { covered, updates, isComplete } = await page.evaluate('window.found');
    assert.ok(covered > 0.1, `${covered} of the pixels are drawn`);
    assert.ok(updates > 0 && isComplete);
    assert.deepEqual(problems, []);
  });
});
