// A worker that reads light maps, so that a large one does not hold up the page.

import { FloatType, HalfFloatType } from "three";
import { EXRLoader } from "three/addons/loaders/EXRLoader.js";
import { HDRLoader } from "three/addons/loaders/HDRLoader.js";

import { halved, type LightMap } from "./harmonics";

const WIDEST = 1024; // pixels; larger maps are averaged down

export interface ReaderRequest {
  name: string;
  content: ArrayBuffer;
  gamma: number;
}

export type ReaderAnswer = { map: LightMap } | { refusal: string };

const scope = globalThis as unknown as {
  onmessage: (event: MessageEvent<ReaderRequest>) => void;
  postMessage: (answer: ReaderAnswer, transfer?: Transferable[]) => void;
};

scope.onmessage = async ({ data }) => {
  try {
    const map = await readMap(data);
    scope.postMessage({ map }, [map.pixels.buffer]);
  } catch (error) {
    scope.postMessage({ refusal: error instanceof Error ? error.message : String(error) });
  }
};

/** Read an equirectangular map; .exr and .hdr are linear, other pictures display values. */
async function readMap({ name, content, gamma }: ReaderRequest): Promise<LightMap> {
  let map: LightMap;
  try {
    map = await decoded(name.toLowerCase().split(".").pop() ?? "", content, gamma);
  } catch (error) {
    throw new Error(`${name} cannot be read as a picture (${error}); give .hdr, .exr, .jpg or .png.`);
  }
  if (map.width !== 2 * map.height) {
    const size = `${map.width}×${map.height} px`;
    throw new Error(`${name} is ${size}; a map of the surroundings is twice as wide as high.`);
  }
  if (!map.pixels.some((value) => value > 0)) throw new Error(`${name} is black; it gives no light.`);
  while (map.width > WIDEST && map.height % 2 === 0) map = halved(map);
  return map;
}

async function decoded(suffix: string, content: ArrayBuffer, gamma: number): Promise<LightMap> {
  if (suffix === "exr") {
    const loader = new EXRLoader();
    loader.setDataType(FloatType);
    return fromLoader(loader.parse(content), true);
  }
  if (suffix === "hdr") {
    const loader = new HDRLoader();
    loader.setDataType(FloatType);
    return fromLoader(loader.parse(content), false);
  }
  return fromPicture(new Blob([content]), gamma);
}

interface Loaded {
  data?: ArrayLike<number> | null;
  width?: number;
  height?: number;
  type?: unknown;
}

/** Pixels of a three.js loader: floats of one or four channels. */
function fromLoader(loaded: Loaded, isUpsideDown: boolean): LightMap {
  const { data, width, height } = loaded;
  if (!data || !width || !height || loaded.type === HalfFloatType) throw new Error("no pixels");
  const channels = data.length / (width * height);
  const pixels = new Float32Array(3 * width * height);
  for (let row = 0; row < height; row++) {
    const from = (isUpsideDown ? height - 1 - row : row) * width;
    for (let column = 0; column < width; column++) {
      const at = 3 * (row * width + column);
      for (let c = 0; c < 3; c++) {
        const found = data[channels * (from + column) + (channels >= 3 ? c : 0)];
        pixels[at + c] = Number.isFinite(found) ? Math.max(found, 0) : 0;
      }
    }
  }
  return { width, height, pixels };
}

async function fromPicture(file: Blob, gamma: number): Promise<LightMap> {
  const bitmap = await createImageBitmap(file);
  const { width, height } = bitmap;
  const context = new OffscreenCanvas(width, height).getContext("2d");
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
