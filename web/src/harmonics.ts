// Spherical harmonics as r3gw.lighting.sh defines them: real, orthonormal, no Condon-Shortley
// phase, index l*l + l + m. Coefficients are flat: 25 rows of red, green, blue.

import type { Constants } from "./payload";

export const DEGREE = 4;
export const COUNT = (DEGREE + 1) ** 2;

/** Basis values towards a unit vector, written to `out`; the recursion of r3gw.lighting.sh. */
export function basis(
  x: number, y: number, z: number, norms: number[], out: Float64Array,
): void {
  let cosine = 1, sine = 0, double = 1;
  for (let m = 0; m <= DEGREE; m++) {
    let previous = 0, current = double;
    for (let l = m; l <= DEGREE; l++) {
      const at = l * l + l;
      out[at + m] = norms[at + m] * current * cosine;
      if (m > 0) out[at - m] = norms[at - m] * current * sine;
      const following = ((2 * l + 1) * z * current - (l + m) * previous) / (l - m + 1);
      previous = current;
      current = following;
    }
    [cosine, sine] = [x * cosine - y * sine, x * sine + y * cosine];
    double *= 2 * m + 1;
  }
}

/** A linear equirectangular map, rows from up to down, three values a pixel. */
export interface LightMap {
  width: number;
  height: number;
  pixels: Float32Array;
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

/** SH light of a map, up to a degree: r3gw.lighting.envmap.project, pixel by pixel. */
export function projected(map: LightMap, degree: number, constants: Constants): Float64Array {
  const { width, height, pixels } = map;
  const light = new Float64Array(3 * COUNT);
  const values = new Float64Array(COUNT);
  let total = 0;
  for (let row = 0; row < height; row++) {
    const theta = (Math.PI * (row + 0.5)) / height;
    const sine = Math.sin(theta);
    for (let column = 0; column < width; column++) {
      const phi = 2 * Math.PI * ((column + 0.5) / width - 0.5);
      const x = sine * Math.sin(phi), z = sine * Math.cos(phi);
      basis(x, -Math.cos(theta), z, constants.shNorms, values);
      const at = 3 * (row * width + column);
      for (let i = 0; i < (degree + 1) ** 2; i++) {
        const weight = sine * values[i];
        light[3 * i] += weight * pixels[at];
        light[3 * i + 1] += weight * pixels[at + 1];
        light[3 * i + 2] += weight * pixels[at + 2];
      }
      total += sine;
    }
  }
  return light.map((value) => (value * 4 * Math.PI) / total);
}

/** Coefficients turned about the vertical, from +z towards +x; works for shorter lights too. */
export function turned(light: Float64Array, yaw: number, constants: Constants): Float64Array {
  if (yaw === 0) return light;
  const count = light.length / 3;
  const result = new Float64Array(light.length);
  for (let k = 0; k <= DEGREE; k++) {
    const cosine = Math.cos(k * yaw), sine = Math.sin(k * yaw);
    const [evens, odds] = [constants.yawCosines[k], constants.yawSines[k]];
    for (let i = 0; i < count; i++) {
      for (let j = 0; j < count; j++) {
        const factor = cosine * evens[i][j] + sine * odds[i][j];
        if (factor === 0) continue;
        for (let c = 0; c < 3; c++) result[3 * i + c] += factor * light[3 * j + c];
      }
    }
  }
  return result;
}

/** Between two lights of one length. */
export function mixed(a: Float64Array, b: Float64Array, share: number): Float64Array {
  return a.map((value, i) => value + share * (b[i] - value));
}

/** Rows of coefficients as a flat light of `count` rows; missing bands are 0. */
export function flat(rows: number[][], count: number): Float64Array {
  const light = new Float64Array(3 * count);
  rows.forEach((row, i) => light.set(row, 3 * i));
  return light;
}
