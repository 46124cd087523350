// Light maps of the page: reading dropped files in a worker, and textures of them for the sky.

import * as THREE from "three";

import { blob } from "./blobs";
import type { LightMap } from "./harmonics";
import type { ReaderAnswer, ReaderRequest } from "./reader";

const LARGEST_HALF = 65504;

/** Reads dropped files one after the other. */
export class MapReader {
  private worker: Worker | null = null;

  constructor(private readonly gamma: number) {}

  /** The map of a file; the promise fails with a sentence for the reader. */
  async read(file: File): Promise<LightMap> {
    const worker = (this.worker ??= await startWorker());
    const content = await file.arrayBuffer();
    const answer = new Promise<ReaderAnswer>((resolve, reject) => {
      worker.onmessage = ({ data }: MessageEvent<ReaderAnswer>) => resolve(data);
      worker.onerror = (event) => reject(new Error(event.message));
    });
    const request: ReaderRequest = { name: file.name, content, gamma: this.gamma };
    worker.postMessage(request, [content]);
    const found = await answer;
    if ("refusal" in found) throw new Error(found.refusal);
    return found.map;
  }
}

async function startWorker(): Promise<Worker> {
  const url = URL.createObjectURL(new Blob([await blob("reader")], { type: "text/javascript" }));
  return new Worker(url);
}

/** A map as a texture that repeats sideways; row 0 is up. */
export function textureOf(map: LightMap): THREE.DataTexture {
  const count = map.width * map.height;
  const halves = new Uint16Array(4 * count);
  for (let i = 0; i < count; i++) {
    for (let c = 0; c < 3; c++) {
      const value = Math.min(map.pixels[3 * i + c], LARGEST_HALF);
      halves[4 * i + c] = THREE.DataUtils.toHalfFloat(value);
    }
  }
  const texture = new THREE.DataTexture(
    halves, map.width, map.height, THREE.RGBAFormat, THREE.HalfFloatType,
  );
  texture.wrapS = THREE.RepeatWrapping;
  texture.minFilter = texture.magFilter = THREE.LinearFilter;
  texture.needsUpdate = true;
  return texture;
}
