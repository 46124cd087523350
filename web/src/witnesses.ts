// Photos near the camera that know which uncovered places are dark (r3gw.relight.witnesses).

import * as THREE from "three";

import { blob } from "./blobs";
import { poseOf } from "./camera";
import type { Payload, Photo } from "./payload";
import type { Uniforms } from "./uniforms";

interface Witness {
  layer: number;
  position: THREE.Vector3;
  reach: number;
  pose: THREE.Matrix4;
  lens: THREE.Vector4;
}

export class Witnesses {
  private constructor(
    private readonly all: Witness[],
    private readonly uniforms: Uniforms,
    private readonly smallestWeight: number,
  ) {}

  static async of(payload: Payload, uniforms: Uniforms): Promise<Witnesses> {
    const { photos, reaches, dome, size } = payload.witnesses;
    if (dome) uniforms.uDome.value.fromArray(dome);
    if (photos.length) uniforms.uDarkMaps.value = maps(await blob("dark"), size, photos.length);
    const all = photos.map((at, layer) => witness(payload.photos[at], layer, reaches[layer]));
    return new Witnesses(all, uniforms, payload.constants.smallestWeight);
  }

  /** Let the photos near a place speak, the nearest first. */
  aim(position: THREE.Vector3): void {
    const found = this.all
      .map((each) => ({ each, weight: weightOf(each, position) }))
      .filter(({ weight }) => weight >= this.smallestWeight)
      .sort((a, b) => b.weight - a.weight);
    const u = this.uniforms;
    const count = Math.min(found.length, u.uNearPose.value.length);
    u.uNearCount.value = count;
    for (let i = 0; i < count; i++) {
      const { each, weight } = found[i];
      u.uNearPose.value[i].copy(each.pose);
      u.uNearLens.value[i].copy(each.lens);
      u.uNearWeight.value[i] = weight;
      u.uNearLayer.value[i] = each.layer;
    }
  }
}

function weightOf({ position, reach }: Witness, from: THREE.Vector3): number {
  const share = position.distanceTo(from) / Math.max(reach, 1e-12);
  return Math.max(0, 1 - share * share) ** 2;
}

function witness(photo: Photo, layer: number, reach: number): Witness {
  const [fx, fy, cx, cy] = photo.intrinsics;
  const { width, height } = photo;
  const lens = new THREE.Vector4(fx / width, fy / height, cx / width, cy / height);
  const rows = photo.camFromWorld.flat() as Parameters<THREE.Matrix4["set"]>;
  return { layer, position: poseOf(photo).position, reach, lens, pose: new THREE.Matrix4().set(...rows) };
}

function maps(
  bytes: Uint8Array<ArrayBuffer>, size: number, count: number,
): THREE.DataArrayTexture {
  const texture = new THREE.DataArrayTexture(bytes, size, size, count);
  texture.format = THREE.RedFormat;
  texture.minFilter = texture.magFilter = THREE.LinearFilter;
  texture.unpackAlignment = 1;
  texture.needsUpdate = true;
  return texture;
}
