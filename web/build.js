#!/usr/bin/env node
/**
 * Bundles the viewer for the server: its folder `dist` has the page in few bytes. It is committed, so that the server is built without Node, and
 * lies in the crate of the server, so that a package of the source has it.
 *
 *     npm run build
 *
 * The same sources give the same bytes; test/dist.test.js fails where `dist` is not that of the sources.
 * @module
 */
import { mkdir, readFile, rm, writeFile } from 'node:fs/promises';
import { fileURLToPath } from 'node:url';
import { build } from 'esbuild';

const HERE = new URL('.', import.meta.url);

/** The folder of the bundle. */
export const DIST = new URL('../crates/tristrip-serve/dist/', HERE);

/** Where each bundle comes from: the page's two are modules, since the worker is one. */
const ENTRIES = { viewer: 'viewer/main.js', worker: 'src/client/worker.js', style: 'viewer/viewer.css' };

/**
 * Returns the files of the page.
 * @returns {Promise<Map<string, Uint8Array>>} their bytes, by name
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
