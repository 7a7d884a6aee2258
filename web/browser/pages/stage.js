/**
 * A stage for models in three.js: renders them from several sides, and compares images.
 * @module
 */
import * as THREE from 'three';
import { GLTFLoader } from 'three/addons/loaders/GLTFLoader.js';
import { RoomEnvironment } from 'three/addons/environments/RoomEnvironment.js';
import { ProgressiveLoader } from 'tristrip/three.js';

export { GLTFLoader, ProgressiveLoader, THREE };

const SIZE = 512;
/** The maximum difference per channel of pixels that count as equal. */
const TOLERANCE = 8;

/** The number of GPU buffers, which three.js does not count. */
export const live = { buffers: 0 };
const context = WebGL2RenderingContext.prototype;
const { createBuffer, deleteBuffer } = context;
context.createBuffer = function () {
  live.buffers++;
  return createBuffer.call(this);
};
context.deleteBuffer = function (buffer) {
  if (buffer) live.buffers--;
  deleteBuffer.call(this, buffer);
};

const canvas = /** @type {HTMLCanvasElement} */ (document.getElementById('canvas'));
export const renderer = new THREE.WebGLRenderer({ canvas, preserveDrawingBuffer: true });
renderer.setSize(SIZE, SIZE, false);

/** @type {THREE.Texture | undefined} */
let environment;

/**
 * Returns a scene with light and a model.
 * @param {THREE.Object3D} model
 */
export function lit(model) {
  environment ??= new THREE.PMREMGenerator(renderer).fromScene(new RoomEnvironment(), 0.04).texture;
  const scene = new THREE.Scene();
  scene.background = new THREE.Color(0x404858);
  scene.environment = environment;
  const sun = new THREE.DirectionalLight(0xffffff, 2);
  sun.position.set(1, 2, 3);
  return scene.add(sun, model);
}

/**
 * Returns a camera that views a box from one of several sides.
 * @param {THREE.Box3} box
 * @param {number} turn fraction of a circle
 */
export function cameraAt(box, turn) {
  const angle = 2 * Math.PI * turn;
  const center = box.getCenter(new THREE.Vector3());
  const radius = box.getSize(new THREE.Vector3()).length() / 2;
  const camera = new THREE.PerspectiveCamera(40, 1, radius / 100, radius * 20);
  camera.position.set(Math.sin(angle), turn % 0.5 ? -0.3 : 0.45, Math.cos(angle)).normalize().multiplyScalar((radius / Math.sin(Math.PI / 9)) * 0.85).add(center);
  camera.lookAt(center);
  camera.updateMatrixWorld();
  return camera;
}

/**
 * Renders a model from several sides, and returns the pixels of each image.
 * @param {{ scene: THREE.Object3D, animations: THREE.AnimationClip[] }} gltf
 * @param {{ views?: number, time?: number, box?: THREE.Box3 }} [options]
 * @returns {{ pictures: Uint8Array[], box: THREE.Box3 }} `box` is that of the model, or the option
 */
export function picturesOf(gltf, { views = 4, time, box } = {}) {
  const scene = lit(gltf.scene);
  if (time !== undefined) {
    const mixer = new THREE.AnimationMixer(gltf.scene);
    mixer.clipAction(gltf.animations[0]).play();
    mixer.setTime(time);
  }
  scene.updateMatrixWorld(true);
  box ??= new THREE.Box3().setFromObject(gltf.scene, true);
  const pictures = [];
  for (let view = 0; view < views; view++) {
    renderer.render(scene, cameraAt(box, view / views));
    const gl = renderer.getContext();
    const pixels = new Uint8Array(4 * SIZE * SIZE);
    gl.readPixels(0, 0, SIZE, SIZE, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
    pictures.push(pixels);
  }
  return { pictures, box };
}

/**
 * Returns the fraction of pixels that differ.
 * @param {Uint8Array[]} a
 * @param {Uint8Array[]} b
 */
export function difference(a, b) {
  let different = 0;
  for (const [i, pixels] of a.entries()) {
    for (let at = 0; at < pixels.length; at += 4) {
      for (let j = 0; j < 3; j++) {
        if (Math.abs(pixels[at + j] - b[i][at + j]) <= TOLERANCE) continue;
        different++;
        break;
      }
    }
  }
  return different / (a.length * SIZE * SIZE);
}

/**
 * Returns the number of non-degenerate triangles. Strips that GLTFLoader converts to lists contain
 * degenerate ones.
 * @param {{ scene: THREE.Object3D }} gltf
 */
export function trianglesOf({ scene }) {
  let triangles = 0;
  scene.traverse((node) => {
    const { geometry, isMesh } = /** @type {THREE.Mesh} */ (node);
    if (!isMesh) return;
    const { index, attributes } = geometry;
    const vertex = (/** @type {number} */ i) => (index ? index.getX(i) : i);
    const count = (index ?? attributes.position).count;
    for (let i = 0; i < count; i += 3) {
      const [a, b, c] = [vertex(i), vertex(i + 1), vertex(i + 2)];
      if (a !== b && b !== c && c !== a) triangles++;
    }
  });
  return triangles;
}

/** Waits for the next frame. */
export const nextFrame = () => new Promise((resolve) => requestAnimationFrame(resolve));
