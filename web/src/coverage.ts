// How well the photos cover what is in view.

import * as THREE from "three";

import { poseOf } from "./camera";
import type { Payload } from "./payload";

export class CoverageMeter {
  private readonly centres: THREE.Vector3[];

  constructor(private readonly payload: Payload) {
    this.centres = payload.photos
      .filter((photo) => photo.split === "train")
      .map((photo) => poseOf(photo).position);
  }

  /** A sentence about a view; empty if the page carries no points. */
  sentence(camera: THREE.PerspectiveCamera): string {
    const counts = this.counts(camera);
    if (!this.payload.coverage) return "";
    if (counts.length === 0) return "No part of the scene that photos show is in view.";
    const { enoughPhotos, nearDeg, poorShare } = this.payload.constants;
    const well = counts.filter((count) => count >= enoughPhotos).length / counts.length;
    const median = counts.sort((a, b) => a - b)[Math.floor(counts.length / 2)];
    const photos = median === 1 ? "1 photo" : `${median} photos`;
    const remark = well < poorShare ? " Most of it is guessed: Show has it darkened." : "";
    return `${Math.round(100 * well)} % of this view was seen by ${enoughPhotos} photos from within ` +
      `${nearDeg}°; a typical point by ${photos}.${remark}`;
  }

  /** Per point in view and facing the viewer, the photos that see it from a similar direction. */
  private counts(camera: THREE.PerspectiveCamera): number[] {
    const { coverage } = this.payload;
    if (!coverage) return [];
    const fromWorld = camera.matrixWorld.clone().invert();
    const clipFromWorld = camera.projectionMatrix.clone().multiply(fromWorld);
    const limit = Math.cos((this.payload.constants.nearDeg * Math.PI) / 180);
    const [point, clip, view] = [new THREE.Vector3(), new THREE.Vector4(), new THREE.Vector3()];
    const towards = new THREE.Vector3();
    const counts: number[] = [];
    coverage.points.forEach((values, i) => {
      point.fromArray(values);
      clip.set(point.x, point.y, point.z, 1).applyMatrix4(clipFromWorld);
      if (clip.w <= 0 || Math.abs(clip.x) > clip.w || Math.abs(clip.y) > clip.w) return;
      view.copy(camera.position).sub(point).normalize();
      if (view.dot(towards.fromArray(coverage.normals[i])) < 0) return;
      const near = coverage.seenBy[i].filter((photo) => {
        towards.copy(this.centres[photo]).sub(point).normalize();
        return towards.dot(view) >= limit;
      });
      counts.push(near.length);
    });
    return counts;
  }
}
