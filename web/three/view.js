/**
 * The size of a model on screen, which determines the download order.
 * @module
 */
import { Frustum, Matrix4, Sphere, Vector3 } from 'three';

/** @import { Camera, InstancedMesh, Mesh, Object3D } from 'three' */

const ELEMENT_OF_SCALE = 5;

const frustum = new Frustum();
const matrix = new Matrix4();
const sphere = new Sphere();
const eye = new Vector3();

/** @param {Object3D} object */
function isShown(object) {
  for (let at = /** @type {Object3D | null} */ (object); at; at = at.parent) if (!at.visible) return false;
  return true;
}

/**
 * Returns the bounding sphere of the visible meshes of some objects, in world coordinates. Its
 * radius is negative if there are none.
 * @param {Object3D[]} objects with up-to-date matrices
 */
function worldSphere(objects) {
  const union = new Sphere(new Vector3(), -1);
  for (const object of objects) {
    object.traverseVisible((node) => {
      const mesh = /** @type {Mesh & InstancedMesh} */ (node);
      if (!mesh.isMesh) return;
      if (mesh.isInstancedMesh && !mesh.boundingSphere) mesh.computeBoundingSphere();
      const bounds = mesh.boundingSphere ?? mesh.geometry.boundingSphere;
      if (bounds) union.union(sphere.copy(bounds).applyMatrix4(mesh.matrixWorld));
    });
  }
  return union;
}

/**
 * Returns the height of objects on screen as a fraction of the view height, or 0 if they are out of
 * view or invisible. If the camera is inside them, they count as filling the view.
 * @param {Object3D[]} objects
 * @param {Camera} camera
 * @returns {number}
 */
export function sizeOnScreen(objects, camera) {
  const shown = objects.filter(isShown);
  for (const object of shown) object.updateWorldMatrix(true, true);
  const { center, radius } = worldSphere(shown);
  if (radius < 0) return 0;
  camera.updateWorldMatrix(true, false);
  matrix.copy(camera.matrixWorld).invert().premultiply(camera.projectionMatrix);
  frustum.setFromProjectionMatrix(matrix, camera.coordinateSystem);
  if (!frustum.intersectsSphere(sphere.set(center, radius))) return 0;
  const isPerspective = camera.projectionMatrix.elements[15] === 0;
  const distance = isPerspective ? Math.max(eye.setFromMatrixPosition(camera.matrixWorld).distanceTo(center), radius) : 1;
  return (radius * camera.projectionMatrix.elements[ELEMENT_OF_SCALE]) / (distance || 1);
}
