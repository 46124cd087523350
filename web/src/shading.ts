// GLSL of what a Gaussian and the sky look like, written with the numbers of the Python renderer.

import type { Constants } from "./payload";

/** A number that GLSL reads as a float. */
export const float = (value: number) => {
  const text = String(value);
  return /[.e]/.test(text) ? text : `${text}.0`;
};

const array = (values: number[]) =>
  `float[${values.length}](${values.map(float).join(", ")})`;

/** Tone curves (r3gw.relight.tone) and the sky as it is seen (r3gw.relight.picture). */
export const skySource = (c: Constants) => `
uniform int uTone;
uniform int uSky; // 0 white, 1 learned, 2 map, 3 none
uniform float uSkyExposure;
uniform float uSkyYaw;
uniform vec3 uSkyLight[4];
uniform highp sampler2D uSkyMap;

vec3 displayFromLinear(vec3 linear) {
  return pow(clamp(linear, ${float(c.darkest)}, 1.0), vec3(1.0 / ${float(c.gamma)}));
}

vec3 toned(vec3 linear) {
  if (uTone == 1) {
    const float white = ${float(c.reinhardWhite)};
    linear = linear * (1.0 + linear / (white * white)) / (1.0 + linear);
  } else if (uTone == 2) {
    vec3 above = linear * (2.51 * linear + 0.03);
    linear = above / (linear * (2.43 * linear + 0.59) + 0.14);
  }
  return displayFromLinear(linear);
}

vec3 skySeen(vec3 d) {
  if (uSky == 0) return vec3(1.0);
  if (uSky == 3) return vec3(0.0);
  if (uSky == 1) {
    vec3 value = ${float(c.shNorms[0])} * uSkyLight[0] + ${float(c.shNorms[1])} *
      (d.y * uSkyLight[1] + d.z * uSkyLight[2] + d.x * uSkyLight[3]);
    vec3 display = clamp(value + 0.5, 0.0, 1.0);
    return toned(uSkyExposure * pow(display, vec3(${float(c.gamma)})));
  }
  const float pi = 3.14159265358979;
  float row = acos(clamp(-d.y, -1.0, 1.0)) / pi;
  float turn = (atan(d.x, d.z) - uSkyYaw) / (2.0 * pi) + 0.5;
  // The texture repeats sideways, so a turn beyond a circle is the same turn.
  return toned(uSkyExposure * textureLod(uSkyMap, vec2(turn, row), 0.0).rgb);
}
`;

/** Gaussians of the scene: unpacking (r3gw.view.buffers) and the colour of surfaces. */
export const splatSource = (c: Constants) => `
uniform highp sampler2D uPlace;
uniform highp usampler2D uShape;
uniform highp sampler2D uSurface;
uniform highp sampler2DArray uTransfer;
uniform highp sampler2D uTable;
uniform float uTableSize;
uniform float uTransferScale[28];
uniform vec3 uLight[25];
uniform vec3 uEye;
uniform vec3 uForward;
uniform vec2 uDepthRange;
uniform int uNumForeground;
uniform int uShow; // 0 picture, 1 albedo, 2 normals, 3 depth, 4 roughness, 5 light, 6 guessed
uniform highp usampler2D uSeenBy; // a bit per photo
uniform vec3 uPhotoPlaces[${c.mostAsked}];
uniform int uPhotoCount;
uniform bool uWithSpecular;
uniform bool uWithShadows;
uniform bool uForegroundShown;
uniform bool uSkyShown;

const float kNorms[25] = ${array(c.shNorms)};
const float kCosineBands[3] = ${array(c.cosineBands)};

// The recursion of r3gw.lighting.sh.
void shBasis(vec3 d, out float y[25]) {
  float cosine = 1.0, sine = 0.0, doubled = 1.0;
  for (int m = 0; m <= 4; m++) {
    float previous = 0.0, current = doubled;
    for (int l = m; l <= 4; l++) {
      int at = l * l + l;
      y[at + m] = kNorms[at + m] * current * cosine;
      if (m > 0) y[at - m] = kNorms[at - m] * current * sine;
      float following = (float(2 * l + 1) * d.z * current - float(l + m) * previous) /
        float(l - m + 1);
      previous = current;
      current = following;
    }
    float turned = d.x * cosine - d.y * sine;
    sine = d.x * sine + d.y * cosine;
    cosine = turned;
    doubled *= float(2 * m + 1);
  }
}

// Irradiance of a surface before shadows (r3gw.lighting.irradiance).
vec3 irradiance(vec3 normal) {
  float y[25];
  shBasis(normal, y);
  vec3 sum = vec3(0.0);
  for (int l = 0; l <= 2; l++) {
    for (int i = l * l; i < (l + 1) * (l + 1); i++) sum += kCosineBands[l] * y[i] * uLight[i];
  }
  return max(sum, ${float(c.darkestIrradiance)});
}

// What shadows take from it, at most 0 for a light that is nowhere negative.
vec3 shadowed(ivec2 texel) {
  vec3 sum = vec3(0.0);
  for (int layer = 0; layer < 7; layer++) {
    vec4 levels = texelFetch(uTransfer, ivec3(texel, layer), 0) * 255.0;
    vec4 values = (levels - 128.0) / 127.0;
    for (int i = 0; i < 4 && 4 * layer + i < 25; i++) {
      sum += values[i] * uTransferScale[4 * layer + i] * uLight[4 * layer + i];
    }
  }
  return sum;
}

// The split sum (r3gw.rendering.cook_torrance).
vec3 specular(vec3 normal, vec3 toCamera, float roughness) {
  float cosine = dot(normal, toCamera);
  float y[25];
  shBasis(2.0 * cosine * normal - toCamera, y);
  vec3 radiance = vec3(0.0);
  for (int l = 0; l <= 4; l++) {
    float smoothing = exp(-float(l * (l + 1)) * roughness * roughness);
    for (int i = l * l; i < (l + 1) * (l + 1); i++) radiance += smoothing * y[i] * uLight[i];
  }
  float root = sqrt(clamp(cosine, ${float(c.smallestCosine)}, 1.0));
  vec2 at = (vec2(roughness, root) * (uTableSize - 1.0) + 0.5) / uTableSize;
  vec2 f = textureLod(uTable, at, 0.0).rg;
  return max(radiance, ${float(c.darkestSpecular)}) * (${float(c.dielectricF0)} * f.x + f.y);
}

// Whether enough photos saw a place from near a direction (r3gw.relight.seen).
bool isWellSeen(ivec2 texel, vec3 place, vec3 toCamera) {
  uint seenBy = texelFetch(uSeenBy, texel, 0).r;
  int count = 0;
  for (int i = 0; i < uPhotoCount; i++) {
    bool isSeen = ((seenBy >> uint(i)) & 1u) == 1u;
    float cosine = dot(normalize(uPhotoPlaces[i] - place), toCamera);
    if (isSeen && cosine >= ${float(Math.cos((c.nearDeg * Math.PI) / 180))}) count++;
  }
  return count >= ${c.enoughPhotos};
}

vec3 dimmed(vec3 colour) {
  vec3 grey = vec3((colour.r + colour.g + colour.b) / 3.0);
  return ${float(c.guessedBrightness)} * mix(grey, colour, ${float(c.guessedColour)});
}

vec3 surfaceColour(ivec2 texel, vec3 centre, vec3 axis) {
  vec4 stored = texelFetch(uSurface, texel, 0);
  vec3 albedo = pow(stored.rgb, vec3(${float(c.gamma)}));
  vec3 toCamera = normalize(uEye - centre);
  vec3 normal = dot(axis, toCamera) < 0.0 ? -axis : axis;
  if (uShow == 1) return displayFromLinear(albedo);
  if (uShow == 2) return 0.5 * normal + 0.5;
  if (uShow == 4) return vec3(stored.a);
  if (uShow == 5) albedo = vec3(0.8);
  vec3 arriving = irradiance(normal);
  if (uWithShadows) arriving += shadowed(texel);
  vec3 linear = albedo / 3.14159265358979 * arriving;
  if (uWithSpecular && uShow != 5) linear += specular(normal, toCamera, stored.a);
  vec3 colour = toned(linear);
  return uShow == 6 && !isWellSeen(texel, centre, toCamera) ? dimmed(colour) : colour;
}

vec3 depthColour(vec3 centre) {
  float depth = dot(centre - uEye, uForward);
  return vec3(1.0 - clamp((depth - uDepthRange.x) / (uDepthRange.y - uDepthRange.x), 0.0, 1.0));
}

void sceneSplat(int index, inout Gsplat splat) {
  ivec2 texel = ivec2(index & 2047, index >> 11);
  vec4 place = texelFetch(uPlace, texel, 0);
  uvec4 shape = texelFetch(uShape, texel, 0);
  bool isForeground = index < uNumForeground;
  splat.flags = (isForeground ? uForegroundShown : uSkyShown) ? GSPLAT_FLAG_ACTIVE : 0u;
  splat.index = index;
  splat.center = place.xyz;
  splat.quaternion = normalize(vec4(unpackSnorm2x16(shape.x), unpackSnorm2x16(shape.y)));
  splat.scales = exp(vec3(unpackHalf2x16(shape.z), unpackHalf2x16(shape.w).x));
  vec3 colour;
  if (uShow == 3) {
    colour = depthColour(place.xyz);
  } else if (isForeground) {
    colour = surfaceColour(texel, place.xyz, quatVec(splat.quaternion, vec3(0.0, 0.0, 1.0)));
  } else {
    colour = skySeen(normalize(place.xyz - uEye));
  }
  splat.rgba = vec4(colour, place.w);
}
`;
