/**
 * Models for tests: sources, and versions packed by the command.
 * @module
 */
import { execFileSync } from 'node:child_process';
import { cpSync, existsSync, mkdtempSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import path from 'node:path';
import { fileURLToPath } from 'node:url';

const repository = fileURLToPath(new URL('../../', import.meta.url));

/** @returns {string} the path of the command, which is built if needed */
function findCommand() {
  const { TRISTRIP_COMMAND, CARGO_TARGET_DIR = 'target' } = process.env;
  const command = TRISTRIP_COMMAND ?? path.resolve(repository, CARGO_TARGET_DIR, 'release/tristrip');
  if (!existsSync(command)) {
    if (TRISTRIP_COMMAND) throw new Error(`TRISTRIP_COMMAND: there is no ${command}`);
    execFileSync('cargo', ['build', '--release', '--quiet', '-p', 'tristrip-cli'], { cwd: repository, stdio: 'inherit' });
  }
  return command;
}

/** The directory of the models in the repository. */
const ownModels = path.join(repository, 'testdata/models');

/** The directory of textured scenes, if `TRISTRIP_MODELS` is set. */
const textured = process.env.TRISTRIP_MODELS && path.join(process.env.TRISTRIP_MODELS, 'textured');

/** The directory of larger models, if `TRISTRIP_MODELS` is set. */
export const largeModels = process.env.TRISTRIP_MODELS;

/** @param {string} file */
const nameOf = (file) => path.basename(file).replace(/\.\w+$/, '');

/** A temporary directory for the models of a test file. */
export class Models {
  /** @type {string} */
  folder = mkdtempSync(path.join(tmpdir(), 'tristrip-models-'));

  /**
   * Runs the command in the directory.
   * @param {string[]} words
   */
  #run(...words) {
    execFileSync(findCommand(), [...words, '--quiet'], { cwd: this.folder });
  }

  /**
   * Packs a model.
   * @param {string} file
   * @returns {string} the name of the file in the directory
   */
  pack(file) {
    const packed = `${nameOf(file)}.packed.glb`;
    this.#run('pack', file, '-o', packed, '--position-bits', '14');
    return packed;
  }

  /**
   * Unpacks a packed model.
   * @param {string} packed its name in the directory
   * @returns {string} the name of the file in the directory
   */
  unpack(packed) {
    const full = packed.replace('.packed.glb', '.full.glb');
    this.#run('unpack', packed, '-o', full);
    return full;
  }

  /**
   * Copies a model, with the files next to a glTF document.
   * @param {string} file
   * @returns {string} the path in the directory
   */
  copy(file) {
    const isDocument = file.endsWith('.gltf');
    cpSync(isDocument ? path.dirname(file) : file, path.join(this.folder, isDocument ? nameOf(file) : path.basename(file)), { recursive: true });
    return isDocument ? `${nameOf(file)}/${path.basename(file)}` : path.basename(file);
  }

  remove() {
    rmSync(this.folder, { recursive: true, force: true });
  }
}

/**
 * Returns the path of a model of the repository.
 * @param {string} name
 */
export const ownModel = (name) => path.join(ownModels, name);

/** The textured scenes, if the environment variable `TRISTRIP_MODELS` is set. */
export const texturedScenes = textured
  ? ['Duck.glb', 'CesiumMan.glb', 'CesiumMilkTruck/CesiumMilkTruck.gltf', 'Fox/Fox.gltf'].map((name) => path.join(textured, name))
  : [];
