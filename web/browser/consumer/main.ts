import { AmbientLight, Color, DirectionalLight, PerspectiveCamera, Scene, Sphere, WebGLRenderer } from 'three';
import { ProgressiveLoader, type ProgressiveGLTF } from 'tristrip/three.js';

const renderer = new WebGLRenderer({ antialias: true, preserveDrawingBuffer: true });
renderer.setSize(256, 256);
document.body.append(renderer.domElement);

const scene = new Scene();
scene.background = new Color(0x000000);
const sun = new DirectionalLight(0xffffff, 3);
sun.position.set(1, 2, 3);
scene.add(sun, new AmbientLight(0xffffff, 0.5));

const gltf: ProgressiveGLTF = await new ProgressiveLoader().loadAsync('model.glb', {
  onProgress: ({ loaded, total }) => console.debug(`${loaded} of ${total} bytes`),
});
scene.add(gltf.scene);

const { center, radius } = new Sphere();
const camera = new PerspectiveCamera(40, 1, 0.01, 1000);

/** Returns the share of pixels that are not background. */
function render(): number {
  camera.position.copy(center).add({ x: 4, y: 4, z: 8 + Math.max(radius, 0) });
  camera.lookAt(center);
  renderer.render(scene, camera);
  const gl = renderer.getContext();
  const pixels = new Uint8Array(4 * 256 * 256);
  gl.readPixels(0, 0, 256, 256, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
  let covered = 0;
  for (let i = 0; i < pixels.length; i += 4) if ((pixels[i] ?? 0) + (pixels[i + 1] ?? 0) + (pixels[i + 2] ?? 0) > 24) covered++;
  return covered / (256 * 256);
}

let updates = 0;
gltf.progressive.onUpdate((update) => {
  updates += update.meshes.length;
  render();
});
gltf.progressive.addEventListener('error', ({ error }) => console.error(error.kind, error.message));
await gltf.progressive.done;
Object.assign(window, { found: { covered: render(), updates, isComplete: gltf.progressive.isComplete } });
