// The scene's Gaussians as a generator of Spark: each is read from textures and coloured by
// shading.ts whenever light or camera change. Spark sorts them in its worker and draws them.

import { dyno, SplatGenerator } from "@sparkjsdev/spark";
import * as THREE from "three";

import { blob, hasBlob } from "./blobs";
import type { Payload } from "./payload";
import { skySource, splatSource } from "./shading";
import type { Uniforms } from "./uniforms";

const WIDTH = 2048;
const TRANSFER_LAYERS = 7;

export async function makeSplats(payload: Payload, uniforms: Uniforms): Promise<SplatGenerator> {
  const { rows } = payload;
  const place = new Float32Array((await blob("place")).buffer);
  const shape = new Uint32Array((await blob("shape")).buffer);
  const surface = await blob("surface");
  const seen = new Uint32Array((await blob("seen")).buffer);
  const table = new Uint16Array((await blob("table")).buffer);
  const textures = {
    uPlace: texture(place, WIDTH, rows, THREE.RGBAFormat, THREE.FloatType),
    uShape: texture(shape, WIDTH, rows, THREE.RGBAIntegerFormat, THREE.UnsignedIntType),
    uSurface: texture(surface, WIDTH, rows, THREE.RGBAFormat, THREE.UnsignedByteType),
    uTransfer: await transfer(rows),
    uSeenBy: texture(seen, WIDTH, rows, THREE.RedIntegerFormat, THREE.UnsignedIntType),
    uTable: texture(
      table, payload.tableSize, payload.tableSize, THREE.RGFormat, THREE.HalfFloatType,
    ),
  };
  textures.uShape.internalFormat = "RGBA32UI";
  textures.uSeenBy.internalFormat = "R32UI";
  textures.uTable.minFilter = textures.uTable.magFilter = THREE.LinearFilter;
  const all: Record<string, THREE.IUniform> = { ...uniforms };
  for (const [name, value] of Object.entries(textures)) all[name] = { value };
  const generator = new dyno.Dyno({
    inTypes: { index: "int" },
    outTypes: { gsplat: dyno.Gsplat },
    generate: ({ inputs, outputs }) => ({
      globals: [dyno.defineGsplat, skySource(payload.constants) + splatSource(payload.constants)],
      statements: [`sceneSplat(${inputs.index}, ${outputs.gsplat});`],
      uniforms: all,
    }),
  });
  return new SplatGenerator({
    numSplats: payload.numForeground + payload.numSky,
    generator,
    update: ({ camera }) => {
      if (!camera) return;
      camera.getWorldPosition(uniforms.uEye.value);
      camera.getWorldDirection(uniforms.uForward.value);
    },
  });
}

async function transfer(rows: number): Promise<THREE.DataArrayTexture> {
  const isPresent = hasBlob("transfer");
  const values = isPresent ? await blob("transfer") : new Uint8Array(4 * TRANSFER_LAYERS);
  const [width, height] = isPresent ? [WIDTH, rows] : [1, 1];
  const array = new THREE.DataArrayTexture(values, width, height, TRANSFER_LAYERS);
  array.needsUpdate = true;
  return array;
}

function texture(
  data: THREE.TypedArray, width: number, height: number,
  format: THREE.PixelFormat, type: THREE.TextureDataType,
): THREE.DataTexture {
  const made = new THREE.DataTexture(data as never, width, height, format, type);
  made.needsUpdate = true;
  return made;
}
