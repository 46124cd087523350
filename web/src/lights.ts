// From the state to light and sky: the JavaScript side of r3gw.relight.lights.

import type * as THREE from "three";

import { clearDay } from "./daylight";
import { COUNT, flat, halved, mixed, projected, turned, type LightMap } from "./harmonics";
import { textureOf } from "./maps";
import type { Payload } from "./payload";
import { SHOWN, TONES, type State } from "./state";
import { setVectors, type Uniforms } from "./uniforms";

const WHITE_SKY = 0, LEARNED_SKY = 1, MAP_SKY = 2, NO_SKY = 3;
const WIDEST_PROJECTED = 128;
const DARKEST_MEAN = 1e-6;

interface Own {
  light: Float64Array;
  skyLight: Float64Array | null;
  map: LightMap | null;
}

export class Lights {
  dropped: LightMap | null = null;
  private readonly learned = new Map<string, { light: Float64Array; sky: Float64Array }>();
  private own: Own | null = null;
  private ownKey = "";
  private texture: THREE.Texture | null = null;
  private textureOwner: LightMap | null = null;

  constructor(private readonly payload: Payload, private readonly uniforms: Uniforms) {
    for (const { photo, light, sky } of payload.lights) {
      this.learned.set(photo, { light: flat(light, COUNT), sky: flat(sky, 4) });
    }
  }

  /** Write the state's light, sky, tone and mode into the uniforms. */
  apply(state: State): void {
    const own = this.ownLight(state);
    const { constants } = this.payload;
    const yaw = (state.yaw * Math.PI) / 180;
    const exposure = this.exposure(state, own.light);
    const light = turned(own.light, yaw, constants).map((value) => value * exposure);
    const u = this.uniforms;
    setVectors(u.uLight.value, light);
    u.uTone.value = TONES.indexOf(state.tone);
    u.uShow.value = SHOWN.indexOf(state.show);
    u.uSkyExposure.value = exposure;
    u.uSkyYaw.value = yaw;
    const skyLight = state.sky === "learned" ? this.learnedOf(state.photo).sky : own.skyLight;
    if (skyLight) setVectors(u.uSkyLight.value, turned(skyLight, yaw, constants));
    u.uSky.value = this.sky(state, own);
    u.uSkyMap.value = this.textureFor(own.map);
    const isDepth = state.show === "depth";
    u.uForegroundShown.value = state.parts !== "sky";
    u.uSkyShown.value = state.parts !== "foreground" && (u.uSky.value !== NO_SKY || isDepth);
    u.uSkyPerPixel.value = u.uSky.value !== LEARNED_SKY && !isDepth;
  }

  /** Factor on light and sky. */
  exposure(state: State, light: Float64Array): number {
    const aim = this.payload.learnedMean;
    const factor = 2 ** state.stops;
    if (!state.auto || aim === null) return factor;
    const mean = light.slice(0, 3).reduce((sum, value) => sum + value, 0) / 3;
    return (factor * aim) / Math.max(mean, DARKEST_MEAN);
  }

  private sky(state: State, own: Own): number {
    const isPicture = state.show === "picture" || state.show === "guessed";
    if (!isPicture || state.parts === "foreground") return NO_SKY;
    if (state.sky === "none") return NO_SKY;
    if (state.sky === "white") return WHITE_SKY;
    if (state.sky === "learned") return LEARNED_SKY;
    if (own.map) return MAP_SKY;
    return own.skyLight ? LEARNED_SKY : WHITE_SKY;
  }

  private ownLight(state: State): Own {
    const { light, photo, photo2, blend, elevation, azimuth, strength, turbidity } = state;
    const key = JSON.stringify(
      light === "learned" ? [photo, photo2, blend]
        : light === "sun" ? [elevation, azimuth, strength, turbidity] : light,
    );
    if (this.own && key === this.ownKey && light !== "map") return this.own;
    this.ownKey = key;
    if (light === "sun") {
      const sun = { elevationDeg: elevation, azimuthDeg: azimuth, strength, turbidity };
      this.own = this.fromMap(clearDay(sun, this.payload.daylight));
    } else if (light === "map" && this.dropped) {
      if (this.own?.map !== this.dropped) this.own = this.fromMap(this.dropped);
    } else {
      this.own = this.fromPhotos(photo, photo2, blend);
    }
    return this.own;
  }

  private fromMap(map: LightMap): Own {
    let small = map;
    while (small.width > WIDEST_PROJECTED && small.height % 2 === 0) small = halved(small);
    const light = projected(small, this.payload.lightDegree, this.payload.constants);
    return { light, skyLight: null, map };
  }

  private fromPhotos(photo: string, photo2: string, blend: number): Own {
    const a = this.learnedOf(photo), b = this.learnedOf(photo2 || photo);
    return {
      light: mixed(a.light, b.light, blend), skyLight: mixed(a.sky, b.sky, blend), map: null,
    };
  }

  private learnedOf(photo: string): { light: Float64Array; sky: Float64Array } {
    const found = this.learned.get(photo);
    return found ?? { light: grey(), sky: new Float64Array(12) };
  }

  private textureFor(map: LightMap | null): THREE.Texture | null {
    if (map !== this.textureOwner) {
      this.texture?.dispose();
      this.texture = map ? textureOf(map) : null;
      this.textureOwner = map;
    }
    return this.texture;
  }
}

/** Light of a scene without learned lights: the same radiance everywhere. */
function grey(): Float64Array {
  const light = new Float64Array(3 * COUNT);
  light.fill(Math.sqrt(4 * Math.PI), 0, 3);
  return light;
}
