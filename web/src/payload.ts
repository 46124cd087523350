// What Python puts into the page (r3gw.view): names and units of every number.

import type { State } from "./state";

/** Numbers shared with the Python renderer (r3gw.view.constants). */
export interface Constants {
  gamma: number;
  darkest: number;
  darkestIrradiance: number;
  darkestSpecular: number;
  dielectricF0: number;
  smallestCosine: number;
  cosineBands: number[];
  reinhardWhite: number;
  nearPlane: number;
  lowPassPx2: number;
  maxAlpha: number;
  minAlpha: number;
  frustumMargin: number;
  /** Of r3gw.relight.uncovered and r3gw.relight.witnesses. */
  faint: number;
  gapsFrom: number;
  skyFrom: number;
  smallestShare: number;
  mostNear: number;
  smallestWeight: number;
  /** Of r3gw.relight.seen. */
  nearDeg: number;
  enoughPhotos: number;
  mostAsked: number;
  guessedBrightness: number;
  guessedColour: number;
  poorShare: number;
  shNorms: number[];
  yawCosines: number[][][];
  yawSines: number[][][];
}

/** Sun and sky of clear days (r3gw.view.daylight). */
export interface Daylight {
  params: number[][][][];
  radiance: number[][][];
  sunIrradiance: number[][][];
  ground: number[];
}

/** One photo's camera, and its picture if the page carries it. */
export interface Photo {
  name: string;
  split: "train" | "test";
  width: number;
  height: number;
  /** fx, fy, cx, cy in pixels; pixel centres at +0.5. */
  intrinsics: [number, number, number, number];
  /** Four rows of the rigid transform; camera axes x right, y down, z forward. */
  camFromWorld: number[][];
  thumbnail: string | null;
  picture: string | null;
}

/** What a photo taught the scene: its light and the coefficients of its sky. */
export interface LearnedLight {
  photo: string;
  light: number[][];
  sky: number[][];
}

/** Points of the scene's surfaces, and which photos see each. */
export interface Coverage {
  points: number[][];
  normals: number[][];
  /** Per point, indices of photos (of `Payload.photos`) in which it is visible. */
  seenBy: number[][];
}

/** Photos that know which uncovered places are dark; their maps are the blob ``dark``. */
export interface WitnessRecords {
  /** Indices of `Payload.photos`, one per layer of the blob. */
  photos: number[];
  /** How far each speaks, world units. */
  reaches: number[];
  /** Centre and radius of the sky's dome, world units. */
  dome: number[] | null;
  /** Pixels of a map's side. */
  size: number;
}

export interface Payload {
  title: string;
  numForeground: number;
  numSky: number;
  numLeftOut: number;
  rows: number;
  withSpecular: boolean;
  lightDegree: number;
  hasShadows: boolean;
  transferScale: number[];
  tableSize: number;
  constants: Constants;
  daylight: Daylight;
  lights: LearnedLight[];
  /** Median mean light of the learned lights: what exposure "auto" aims at; null without lights. */
  learnedMean: number | null;
  photos: Photo[];
  /** Point that orbits turn about. */
  focus: number[];
  /** Depths that the depth picture spans, world units. */
  depthRange: [number, number];
  coverage: Coverage | null;
  /** Photos (indices of `photos`) of which the blob ``seen`` has a bit each per Gaussian. */
  asked: number[];
  witnesses: WitnessRecords;
  licences: string;
  facts: string[];
  /** State in which the page opens, over its own beginning (r3gw.view.start). */
  start: Partial<State>;
}
