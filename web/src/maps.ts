// Light maps: reading dropped files, and textures of them for the sky.

import * as THREE from "three";
import { EXRLoader } from "three/addons/loaders/EXRLoader.js";
import { HDRLoader } from "three/addons/loaders/HDRLoader.js";

import type { LightMap } from "./harmonics";

const WIDEST = 1024; // pixels; larger maps are averaged down
const LARGEST_HALF = 65504;

/** A file that is no light map; the message says why, for the reader. */
export class MapError extends Error {}

/** Read an equirectangular map; .exr and .hdr are linear, other pictures display values. */
export async function readMap(file: File, gamma: number): Promise<LightMap> {
  const suffix = file.name.toLowerCase().split(".").pop() ?? "";
  const map = await decodedMap(file, suffix, gamma);
  if (map.width !== 2 * map.height) {
    throw new MapError(
      `${file.name} is ${map.width}×${map.height} px; a map of the surroundings is twice as wide ` +
        "as high",
    );
  }
  let reduced = map;
  while (reduced.width > WIDEST && reduced.height % 2 === 0) reduced = halved(reduced);
  return reduced;
}

async function decodedMap(file: File, suffix: string, gamma: number): Promise<LightMap> {
  try {
    if (suffix === "exr") return fromLoader(new EXRLoader().parse(await file.arrayBuffer()), true);
    if (suffix === "hdr") return fromLoader(new HDRLoader().parse(await file.arrayBuffer()), false);
    return await fromPicture(file, gamma);
  } catch (error) {
    const kinds = "give an .hdr, .exr, .jpg or .png file";
    throw new MapError(`${file.name} cannot be read as a picture (${String(error)}); ${kinds}`);
  }
}

interface Loaded {
  data?: ArrayLike<number> | null;
  width?: number;
  height?: number;
  type?: unknown;
}

/** Pixels of a three.js loader, which gives four channels as half floats or floats. */
function fromLoader(loaded: Loaded, isUpsideDown: boolean): LightMap {
  const { data, width, height, type } = loaded;
  if (!data || !width || !height) throw new Error("no pixels");
  const channels = data.length / (width * height);
  const value = (at: number) =>
    type === THREE.HalfFloatType ? THREE.DataUtils.fromHalfFloat(data[at]) : data[at];
  const pixels = new Float32Array(3 * width * height);
  for (let row = 0; row < height; row++) {
    const from = (isUpsideDown ? height - 1 - row : row) * width;
    for (let column = 0; column < width; column++) {
      const at = 3 * (row * width + column);
      for (let c = 0; c < 3; c++) {
        const found = value(channels * (from + column) + (channels >= 3 ? c : 0));
        pixels[at + c] = Number.isFinite(found) ? Math.max(found, 0) : 0;
      }
    }
  }
  return { width, height, pixels };
}

async function fromPicture(file: File, gamma: number): Promise<LightMap> {
  const bitmap = await createImageBitmap(file);
  const { width, height } = bitmap;
  const canvas = new OffscreenCanvas(width, height);
  const context = canvas.getContext("2d");
  if (!context) throw new Error("no canvas");
  context.drawImage(bitmap, 0, 0);
  const bytes = context.getImageData(0, 0, width, height).data;
  const linear = Float32Array.from({ length: 256 }, (_, i) => (i / 255) ** gamma);
  const pixels = new Float32Array(3 * width * height);
  for (let i = 0; i < width * height; i++) {
    for (let c = 0; c < 3; c++) pixels[3 * i + c] = linear[bytes[4 * i + c]];
  }
  return { width, height, pixels };
}

/** Every four pixels as their mean. */
export function halved(map: LightMap): LightMap {
  const width = map.width / 2, height = map.height / 2;
  const pixels = new Float32Array(3 * width * height);
  for (let row = 0; row < height; row++) {
    for (let at = 0; at < 3 * width; at++) {
      const above = 2 * row * map.width * 3 + 6 * Math.floor(at / 3) + (at % 3);
      const below = above + 3 * map.width;
      const p = map.pixels;
      pixels[3 * row * width + at] = (p[above] + p[above + 3] + p[below] + p[below + 3]) / 4;
    }
  }
  return { width, height, pixels };
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
