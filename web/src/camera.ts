// Cameras of photos in three.js terms: y up and z backwards instead of COLMAP's y down, z forward.

import * as THREE from "three";

import type { Photo } from "./payload";

/** A lens in picture heights, so that it fits any canvas. */
export interface Lens {
  fx: number;
  fy: number;
  /** Principal point from the picture's middle, right and down. */
  right: number;
  down: number;
  /** Width over height of the picture that has to be seen whole. */
  aspect: number;
}

export interface Pose {
  position: THREE.Vector3;
  quaternion: THREE.Quaternion;
}

export function lensOf(photo: Photo): Lens {
  const [fx, fy, cx, cy] = photo.intrinsics;
  const { width, height } = photo;
  return {
    fx: fx / height, fy: fy / height,
    right: (cx - width / 2) / height, down: cy / height - 0.5,
    aspect: width / height,
  };
}

export function poseOf(photo: Photo): Pose {
  const m = photo.camFromWorld;
  const rotation = new THREE.Matrix4().set(
    m[0][0], -m[1][0], -m[2][0], 0,
    m[0][1], -m[1][1], -m[2][1], 0,
    m[0][2], -m[1][2], -m[2][2], 0,
    0, 0, 0, 1,
  );
  const position = new THREE.Vector3(
    ...([0, 1, 2].map((i) => -[0, 1, 2].reduce((sum, j) => sum + m[j][i] * m[j][3], 0)) as
      [number, number, number]),
  );
  return { position, quaternion: new THREE.Quaternion().setFromRotationMatrix(rotation) };
}

/** Where the picture of a lens lies in a canvas that shows it whole, as shares of the canvas. */
export function frameIn(lens: Lens, canvasAspect: number): { width: number; height: number } {
  const relative = lens.aspect / canvasAspect;
  return relative < 1 ? { width: relative, height: 1 } : { width: 1, height: 1 / relative };
}

/** Set a camera's projection so that the lens' picture is seen whole in a canvas. */
export function project(
  camera: THREE.PerspectiveCamera, lens: Lens, canvasAspect: number, near: number, far: number,
): void {
  const frame = frameIn(lens, canvasAspect);
  const [sx, sy] = [(2 * frame.width) / lens.aspect, 2 * frame.height];
  camera.near = near;
  camera.far = far;
  camera.projectionMatrix.set(
    sx * lens.fx, 0, -sx * lens.right, 0,
    0, sy * lens.fy, sy * lens.down, 0,
    0, 0, -(far + near) / (far - near), (-2 * far * near) / (far - near),
    0, 0, -1, 0,
  );
  camera.projectionMatrixInverse.copy(camera.projectionMatrix).invert();
}
