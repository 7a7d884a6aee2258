/**
 * The npm package: its files and exports, as listed by `npm pack`. browser/package.test.js installs
 * and uses it.
 */
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { readdirSync, readFileSync } from 'node:fs';
import { test } from 'node:test';
import { fileURLToPath } from 'node:url';

const web = fileURLToPath(new URL('../', import.meta.url));
const manifest = JSON.parse(readFileSync(new URL('../package.json', import.meta.url), 'utf8'));

/** Returns the files of the package. Runs `prepack`, which creates types and copies licences. */
function packedFiles() {
  const output = execFileSync('npm', ['pack', '--dry-run', '--json', '--silent'], { cwd: web, encoding: 'utf8', stdio: ['ignore', 'pipe', 'inherit'] });
  // Scripts may print before the JSON.
  const [{ files }] = JSON.parse(output.replace(/^[^[]*/, ''));
  return files.map((/** @type {{ path: string }} */ file) => file.path).sort();
}

/** Returns the modules of a folder, except examples. */
function modulesOf(/** @type {string} */ folder) {
  const names = readdirSync(new URL(`../${folder}/`, import.meta.url), { recursive: true, encoding: 'utf8' });
  return names.filter((name) => name.endsWith('.js') && !name.endsWith('example.js')).map((name) => `${folder}/${name}`);
}

test('the package has the modules, their types, the README and the licences, and nothing else', () => {
  const modules = ['src', 'three', 'webgl'].flatMap(modulesOf);
  const types = modules.map((name) => `types/${name.replace(/\.js$/, '.d.ts')}`);
  const files = packedFiles();
  assert.deepEqual(files, ['LICENSE-APACHE', 'LICENSE-MIT', 'README.md', 'package.json', ...modules, ...types].sort());

  const targets = Object.values(manifest.exports).flatMap((target) => (typeof target === 'string' ? [target] : Object.values(target)));
  for (const target of [manifest.types, ...targets]) assert.ok(files.includes(target.replace('./', '')), `${target} is not in the package`);
});

test('the package has the metadata that npm shows', () => {
  for (const key of ['name', 'version', 'description', 'keywords', 'author', 'license', 'engines']) assert.ok(manifest[key], key);
});
