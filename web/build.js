#!/usr/bin/env node
/**
 * Bundles the viewer for the server into `crates/tristrip-serve/dist`. The bundle is committed, so
 * the server can be built without Node.js. It is in the crate of the server, so a source package of
 * the crate includes it.
 *
 *     npm run build
 *
 * The output is reproducible; test/dist.test.js fails if the committed bundle differs from the
 * sources.
 * @module
 */
import { mkdir, readFile, rm, writeFile } from 'node:fs/promises';
import { fileURLToPath } from 'node:url';
import { build } from 'esbuild';

const HERE = new URL('.', import.meta.url);

/** The directory of the bundle. */
export const DIST = new URL('../crates/tristrip-serve/dist/', HERE);

/** The entry points. The page and the worker are separate modules. */
const ENTRIES = { viewer: 'viewer/main.js', worker: 'src/client/worker.js', style: 'viewer/viewer.css' };

/**
 * Bundles the viewer.
 * @returns {Promise<Map<string, Uint8Array>>} the files by name
 */
export async function bundle() {
  const { outputFiles } = await build({
    absWorkingDir: fileURLToPath(HERE),
    entryPoints: Object.entries(ENTRIES).map(([out, path]) => ({ in: path, out })),
    outdir: 'dist',
    bundle: true,
    minify: true,
    format: 'esm',
    target: 'es2022',
    charset: 'utf8',
    legalComments: 'none',
    write: false,
  });
  const files = new Map(outputFiles.map(({ path, contents }) => [path.split('/').at(-1) ?? '', contents]));
  const page = await readFile(new URL('index.html', HERE), 'utf8');
  const ofBundles = page.replace('viewer/viewer.css', 'style.css').replace('viewer/main.js', 'viewer.js');
  files.set('index.html', new TextEncoder().encode(ofBundles.replace(/^\s+/gm, '')));
  return files;
}

if (process.argv[1] === fileURLToPath(import.meta.url)) {
  await rm(DIST, { recursive: true, force: true });
  await mkdir(DIST);
  for (const [name, bytes] of await bundle()) await writeFile(new URL(name, DIST), bytes);
}
