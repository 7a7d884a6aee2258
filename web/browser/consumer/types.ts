// Type checks of every entry point of the package.
import { Decoder, GlbDecoder, StreamError, type StreamPart } from 'tristrip';
import { Client, type Model, type Progress, type Update } from 'tristrip/client';
import { Strips } from 'tristrip/strips';
import { ProgressiveError, ProgressiveLoader, type ProgressiveGLTF, type ProgressiveModel } from 'tristrip/three';
import * as webgl from 'tristrip/webgl';
import { PerspectiveCamera } from 'three';
import { GLTFLoader } from 'three/addons/loaders/GLTFLoader.js';

export function decode(bytes: Uint8Array): number[] {
  const decoder = new GlbDecoder({ strips: Strips, triangles: 1000 });
  decoder.update(bytes);
  new Decoder();
  return decoder.parts.map((part: StreamPart) => part.triangleCount + part.positions().length + (part.strips?.count ?? 0));
}

export function load(client: Client): Model {
  return client.load('model.glb', { update: (update: Update) => void show(update.progress) }, { output: 'lists', priority: 2 });
}

function show(progress: Progress | undefined): number {
  return progress?.receivedBytes ?? 0;
}

export async function loadScene(signal: AbortSignal): Promise<number> {
  const loader = new ProgressiveLoader(undefined, { client: new Client(), gltfLoader: new GLTFLoader() }).setPath('models/');
  loader.load('a.glb', (gltf) => gltf.scene.clear(), ({ loaded }) => loaded, (error) => error instanceof ProgressiveError && error.kind);
  const gltf: ProgressiveGLTF = await loader.loadAsync('model.glb', { signal, priority: 0 });
  const progressive: ProgressiveModel = gltf.progressive;
  progressive.addEventListener('progress', ({ progress }) => show(progress));
  progressive.addEventListener('complete', () => progressive.dispose());
  progressive.setView(new PerspectiveCamera());
  loader.updatePriorities(new PerspectiveCamera());
  progressive.pause();
  progressive.resume();
  // @ts-expect-error there is no such event
  progressive.addEventListener('nothing', () => {});
  await progressive.done;
  return show(progressive.progress) + gltf.animations.length + Object.keys(webgl).length;
}

export const isDamaged = (error: unknown): boolean => error instanceof StreamError;
