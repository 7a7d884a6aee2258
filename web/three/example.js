/**
 * Shows the model named in the address: `example.html?model=model.glb`, a file written by
 * `tristrip pack`.
 */
import * as THREE from 'three';
import { OrbitControls } from 'three/addons/controls/OrbitControls.js';
import { RoomEnvironment } from 'three/addons/environments/RoomEnvironment.js';
import { ProgressiveLoader } from 'tristrip/three.js';

const renderer = new THREE.WebGLRenderer({ antialias: true });
document.body.append(renderer.domElement);

const scene = new THREE.Scene();
scene.background = new THREE.Color(0x334455);
scene.environment = new THREE.PMREMGenerator(renderer).fromScene(new RoomEnvironment()).texture;

const camera = new THREE.PerspectiveCamera(40, 1, 0.01, 100);
const controls = new OrbitControls(camera, renderer.domElement);
const clock = new THREE.Clock();
const mixer = new THREE.AnimationMixer(scene);

function resize() {
  camera.aspect = innerWidth / innerHeight;
  camera.updateProjectionMatrix();
  renderer.setSize(innerWidth, innerHeight);
  renderer.setPixelRatio(devicePixelRatio);
}
addEventListener('resize', resize);
resize();

renderer.setAnimationLoop(() => {
  controls.update();
  mixer.update(clock.getDelta());
  renderer.render(scene, camera);
});

const output = /** @type {HTMLOutputElement} */ (document.querySelector('output'));
try {
  // The base mesh and textures have loaded; the scene refines during rendering.
  const gltf = await new ProgressiveLoader().loadAsync(new URLSearchParams(location.search).get('model') ?? 'model.glb');
  scene.add(gltf.scene);
  const { center, radius } = new THREE.Box3().setFromObject(gltf.scene).getBoundingSphere(new THREE.Sphere());
  camera.near = radius / 100;
  camera.far = radius * 100;
  camera.position.set(0.5, 0.4, 1).setLength(3.2 * radius).add(center);
  controls.target.copy(center);
  camera.updateProjectionMatrix();
  if (gltf.animations.length > 0) mixer.clipAction(gltf.animations[0], gltf.scene).play();

  gltf.progressive.addEventListener('progress', ({ progress }) => {
    output.textContent = `${progress.shownBytes} of ${progress.totalBytes} bytes shown`;
  });
  gltf.progressive.addEventListener('error', ({ error }) => (output.textContent = error.message));
  await gltf.progressive.done;
  output.textContent = '';
} catch (error) {
  output.textContent = error instanceof Error ? error.message : String(error);
}
