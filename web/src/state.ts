// Everything that a reader can set, as one flat record; it lives in the URL's hash.

export const LIGHTS = ["learned", "sun", "map"] as const;
export const TONES = ["standard", "reinhard", "filmic"] as const;
export const SKIES = ["own", "learned", "white", "none"] as const;
export const SHOWN = ["picture", "albedo", "normals", "depth", "roughness", "light", "guessed"] as const;
export const PARTS = ["both", "foreground", "sky"] as const;

export interface State {
  light: (typeof LIGHTS)[number];
  /** Photo whose light is learned; a second one to blend with, and its share. */
  photo: string;
  photo2: string;
  blend: number;
  /** Sun: degrees above the horizon, and from +z towards +x; factor; haze 1 to 10. */
  elevation: number;
  azimuth: number;
  strength: number;
  turbidity: number;
  /** Turn of light and sky about the vertical, degrees, towards a map's right. */
  yaw: number;
  /** Exposure: whether the mean light is matched to the photos', and stops on top. */
  auto: boolean;
  stops: number;
  tone: (typeof TONES)[number];
  sky: (typeof SKIES)[number];
  show: (typeof SHOWN)[number];
  parts: (typeof PARTS)[number];
  /** Camera: position, quaternion xyzw, and the photo whose lens it has. */
  camera: number[];
  lens: string;
}

const CHOICES: Partial<Record<keyof State, readonly string[]>> = {
  light: LIGHTS, tone: TONES, sky: SKIES, show: SHOWN, parts: PARTS,
};
const LIMITS: Partial<Record<keyof State, [number, number]>> = {
  blend: [0, 1], elevation: [0, 90], azimuth: [-360, 360], strength: [0, 4], turbidity: [1, 10],
  yaw: [-360, 360], stops: [-6, 6],
};
const DIGITS = 5;

/** The state as text for a URL's hash; what is as in `initial` is left out. */
export function hashOf(state: State, initial: State): string {
  const parts = (Object.keys(state) as (keyof State)[])
    .filter((key) => String(state[key]) !== String(initial[key]))
    .map((key) => `${key}=${encodeURIComponent(written(state[key]))}`);
  return parts.join("&");
}

function written(value: State[keyof State]): string {
  if (Array.isArray(value)) return value.map((x) => Number(x.toFixed(DIGITS))).join(",");
  return typeof value === "number" ? String(Number(value.toFixed(DIGITS))) : String(value);
}

/** Read a hash over an initial state; what is unknown or out of range is left as it was. */
export function stateFrom(hash: string, initial: State, photos: ReadonlySet<string>): State {
  const state = { ...initial, camera: [...initial.camera] };
  for (const pair of hash.replace(/^#/, "").split("&")) {
    const [key, text] = [pair.slice(0, pair.indexOf("=")), pair.slice(pair.indexOf("=") + 1)];
    if (Object.hasOwn(initial, key)) read(state, key as keyof State, decoded(text), photos);
  }
  return state;
}

function decoded(text: string): string {
  try {
    return decodeURIComponent(text);
  } catch {
    return "";
  }
}

function read(state: State, key: keyof State, text: string, photos: ReadonlySet<string>): void {
  const target = state as unknown as Record<string, unknown>;
  const choices = CHOICES[key], limits = LIMITS[key];
  if (choices) {
    if (choices.includes(text)) target[key] = text;
  } else if (limits) {
    const value = Number(text);
    if (text !== "" && value >= limits[0] && value <= limits[1]) target[key] = value;
  } else if (key === "auto") {
    state.auto = text === "true";
  } else if (key === "camera") {
    const numbers = text.split(",").map(Number);
    if (numbers.length === 7 && numbers.every(Number.isFinite)) state.camera = numbers;
  } else if (photos.has(text) || (key === "photo2" && text === "")) {
    target[key] = text;
  }
}
