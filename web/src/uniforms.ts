// The uniforms of all shaders, shared by reference between them.

import * as THREE from "three";

import { poseOf } from "./camera";
import { COUNT } from "./harmonics";
import type { Payload } from "./payload";

const vectors = (count: number) => Array.from({ length: count }, () => new THREE.Vector3());

/** What a frame changes; textures of the scene are added by splats.ts. */
export function makeUniforms(payload: Payload) {
  const several = <T>(make: () => T) => Array.from({ length: payload.constants.mostNear }, make);
  return {
    uTone: { value: 0 },
    uSky: { value: 0 },
    uSkyExposure: { value: 1 },
    uSkyYaw: { value: 0 },
    uSkyLight: { value: vectors(4) },
    uSkyMap: { value: null as THREE.Texture | null },
    uLight: { value: vectors(COUNT) },
    uEye: { value: new THREE.Vector3() },
    uForward: { value: new THREE.Vector3() },
    uDepthRange: { value: new THREE.Vector2(...payload.depthRange) },
    uNumForeground: { value: payload.numForeground },
    uShow: { value: 0 },
    uWithSpecular: { value: payload.withSpecular },
    uWithShadows: { value: payload.hasShadows },
    uForegroundShown: { value: true },
    uSkyShown: { value: true },
    uTableSize: { value: payload.tableSize },
    uTransferScale: { value: payload.transferScale },
    uSkyPerPixel: { value: true },
    uRayFromNdc: { value: new THREE.Matrix3() },
    uPhotoPlaces: { value: photoPlaces(payload) },
    uPhotoCount: { value: payload.asked.length },
    uDome: { value: new THREE.Vector4() },
    uNearCount: { value: 0 },
    uNearPose: { value: several(() => new THREE.Matrix4()) },
    uNearLens: { value: several(() => new THREE.Vector4()) },
    uNearWeight: { value: several(() => 0) },
    uNearLayer: { value: several(() => 0) },
    uDarkMaps: { value: null as THREE.Texture | null },
  };
}

/** Where the photos stood that say how well a surface was seen. */
function photoPlaces(payload: Payload): THREE.Vector3[] {
  const places = payload.asked.map((at) => poseOf(payload.photos[at]).position);
  while (places.length < payload.constants.mostAsked) places.push(new THREE.Vector3());
  return places;
}

export type Uniforms = ReturnType<typeof makeUniforms>;

/** Write a flat light (red, green, blue per coefficient) into an array of vectors. */
export function setVectors(target: THREE.Vector3[], flat: ArrayLike<number>): void {
  target.forEach((vector, i) => vector.set(flat[3 * i], flat[3 * i + 1], flat[3 * i + 2]));
}
