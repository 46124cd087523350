// r3gw.lighting.daylight.clear_day in the browser: Hosek and Wilkie's sky, the sun in the four
// pixels around its direction, and a matt ground that both light.

import type { LightMap } from "./harmonics";
import type { Daylight } from "./payload";

export const MAP_HEIGHT = 64;
const BINOMIAL = [1, 5, 10, 10, 5, 1];
const LOWEST_DEG = 0.01; // on the horizon itself the model has no sun

export interface SunState {
  elevationDeg: number;
  /** From +z towards +x. */
  azimuthDeg: number;
  /** Factor on the sun alone; 1 is the model's. */
  strength: number;
  turbidity: number;
}

/** The map of a clear day. */
export function clearDay(sun: SunState, tables: Daylight): LightMap {
  const height = MAP_HEIGHT, width = 2 * MAP_HEIGHT;
  const pixels = new Float32Array(3 * width * height);
  const elevationDeg = Math.max(sun.elevationDeg, LOWEST_DEG);
  paintSky({ ...sun, elevationDeg }, tables, pixels, width, height);
  addSun({ ...sun, elevationDeg }, tables, pixels, width, height);
  paintGround(tables, pixels, width, height);
  return { width, height, pixels };
}

function paintSky(
  sun: SunState, tables: Daylight, pixels: Float32Array, width: number, height: number,
): void {
  const { params, radiance } = skyParameters(sun, tables);
  const elevation = (sun.elevationDeg * Math.PI) / 180, azimuth = (sun.azimuthDeg * Math.PI) / 180;
  for (let row = 0; row < height / 2; row++) {
    const theta = (Math.PI * (row + 0.5)) / height;
    const upward = Math.cos(theta), root = Math.sqrt(upward);
    for (let column = 0; column < width; column++) {
      const phi = 2 * Math.PI * ((column + 0.5) / width - 0.5);
      const level = Math.sin(theta) * Math.cos(elevation) * Math.cos(phi - azimuth);
      const cosine = Math.min(Math.max(level + upward * Math.sin(elevation), -1), 1);
      const gamma = Math.acos(cosine);
      for (let c = 0; c < 3; c++) {
        const p = params[c];
        const horizon = 1 + p[0] * Math.exp(p[1] / (upward + 0.01));
        const chi = (1 + cosine ** 2) / (1 + p[8] ** 2 - 2 * p[8] * cosine) ** 1.5;
        const glow = p[2] + p[3] * Math.exp(p[4] * gamma) + p[5] * cosine ** 2 + p[6] * chi;
        const value = horizon * (glow + p[7] * root) * radiance[c];
        pixels[3 * (row * width + column) + c] = Math.max(value, 0);
      }
    }
  }
}

/** Parameters at a turbidity (linear) and an elevation (a Bezier curve over its cube root). */
function skyParameters(sun: SunState, tables: Daylight): { params: number[][]; radiance: number[] } {
  const [low, share] = between(sun.turbidity - 1, tables.params.length);
  const x = Math.cbrt(sun.elevationDeg / 90);
  const params = [0, 1, 2].map(() => new Array<number>(9).fill(0));
  const radiance = [0, 0, 0];
  BINOMIAL.forEach((factor, k) => {
    const weight = factor * (1 - x) ** (5 - k) * x ** k;
    for (let c = 0; c < 3; c++) {
      const mix = (a: number, b: number) => weight * ((1 - share) * a + share * b);
      radiance[c] += mix(tables.radiance[low][k][c], tables.radiance[low + 1][k][c]);
      for (let i = 0; i < 9; i++) {
        params[c][i] += mix(tables.params[low][k][c][i], tables.params[low + 1][k][c][i]);
      }
    }
  });
  return { params, radiance };
}

/** Irradiance of a surface that faces the sun. */
function sunIrradiance(sun: SunState, tables: Daylight): number[] {
  const [low, share] = between(sun.turbidity - 1, tables.sunIrradiance.length);
  const samples = tables.sunIrradiance[low].length;
  const [at, step] = between(Math.sqrt(sun.elevationDeg / 90) * (samples - 1), samples);
  return [0, 1, 2].map((c) => {
    const along = (t: number) =>
      (1 - step) * tables.sunIrradiance[t][at][c] + step * tables.sunIrradiance[t][at + 1][c];
    return sun.strength * ((1 - share) * along(low) + share * along(low + 1));
  });
}

function addSun(
  sun: SunState, tables: Daylight, pixels: Float32Array, width: number, height: number,
): void {
  const irradiance = sunIrradiance(sun, tables);
  const row = ((90 - sun.elevationDeg) / 180) * height - 0.5;
  const turn = (((sun.azimuthDeg / 360 + 0.5) % 1) + 1) % 1;
  const column = turn * width - 0.5;
  const [top, left] = [Math.floor(row), Math.floor(column)];
  for (const [i, down] of [[top, top + 1 - row], [top + 1, row - top]]) {
    if (i < 0) continue; // straight above: no row beyond the zenith
    for (const [j, across] of [[left, left + 1 - column], [left + 1, column - left]]) {
      const at = 3 * (i * width + ((j + width) % width));
      const share = (down * across) / solidAngle(i, height);
      for (let c = 0; c < 3; c++) pixels[at + c] += irradiance[c] * share;
    }
  }
}

function paintGround(
  tables: Daylight, pixels: Float32Array, width: number, height: number,
): void {
  const level = [0, 0, 0];
  for (let row = 0; row < height / 2; row++) {
    const weight = solidAngle(row, height) * Math.cos((Math.PI * (row + 0.5)) / height);
    for (let column = 0; column < width; column++) {
      for (let c = 0; c < 3; c++) level[c] += weight * pixels[3 * (row * width + column) + c];
    }
  }
  const ground = level.map((value, c) => (tables.ground[c] / Math.PI) * value);
  for (let at = (3 * width * height) / 2; at < pixels.length; at++) pixels[at] = ground[at % 3];
}

/** Of one pixel of a row, in steradian. */
function solidAngle(row: number, height: number): number {
  const edge = (i: number) => Math.cos((Math.PI * i) / height);
  return ((edge(row) - edge(row + 1)) * Math.PI) / height;
}

/** Index of the node below a position, and the share of the one above. */
function between(position: number, count: number): [number, number] {
  const low = Math.min(Math.max(Math.floor(position), 0), count - 2);
  return [low, position - low];
}
