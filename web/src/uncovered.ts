// GLSL of what shows where no Gaussian covers a pixel: r3gw.relight.uncovered and
// r3gw.relight.witnesses, on what the Gaussians left in two pictures.

import type { Constants } from "./payload";
import { float, skySource } from "./shading";

/** The last pass: puts sky or black behind the Gaussians. */
export const composeSource = (c: Constants) => `
precision highp float;
precision highp sampler2DArray;
in vec2 vNdc;
out vec4 fragColor;
uniform highp sampler2D uDrawn; // colour and opacity of all Gaussians
uniform highp sampler2D uSkyDrawn; // the opacity that the sky's contribute, in red
uniform bool uSkyPerPixel;
uniform mat3 uRayFromNdc;
uniform vec4 uDome; // centre, and the radius: 0 without a dome
uniform int uNearCount;
uniform mat4 uNearPose[${c.mostNear}]; // camera from world
uniform vec4 uNearLens[${c.mostNear}]; // focal lengths and middle, in shares of the photo
uniform float uNearWeight[${c.mostNear}];
uniform int uNearLayer[${c.mostNear}];
uniform sampler2DArray uDarkMaps;
${skySource(c)}

float darkness(vec3 look) {
  vec4 behind = vec4(look, 0.0);
  vec3 start = cameraPosition - uDome.xyz;
  float inside = uDome.w * uDome.w - dot(start, start);
  if (inside > 0.0) {
    float along = dot(look, start);
    behind = vec4(cameraPosition + (sqrt(along * along + inside) - along) * look, 1.0);
  }
  float surest = 0.0;
  for (int i = 0; i < uNearCount; i++) {
    vec3 local = (uNearPose[i] * behind).xyz;
    if (local.z <= 0.0) continue;
    vec2 at = uNearLens[i].xy * local.xy / local.z + uNearLens[i].zw;
    if (any(greaterThan(abs(at - 0.5), vec2(0.5)))) continue;
    float seen = textureLod(uDarkMaps, vec3(at, float(uNearLayer[i])), 0.0).r;
    surest = max(surest, uNearWeight[i] * seen);
  }
  return surest;
}

void main() {
  ivec2 pixel = ivec2(gl_FragCoord.xy);
  vec4 drawn = texelFetch(uDrawn, pixel, 0);
  if (uSky == 3) {
    fragColor = drawn;
    return;
  }
  float sky = min(texelFetch(uSkyDrawn, pixel, 0).r, drawn.a);
  float foreground = drawn.a - sky;
  float rest = (1.0 - drawn.a) * (sky + ${float(c.faint)}) / (drawn.a + ${float(c.faint)});
  vec3 look = normalize(uRayFromNdc * vec3(vNdc, 1.0));
  float dark = uNearCount == 0 ? 0.0 : darkness(look);
  if (uSkyPerPixel) {
    float share = sky / max(1.0 - foreground, ${float(c.smallestShare)});
    dark *= 1.0 - smoothstep(${float(c.gapsFrom)}, ${float(c.skyFrom)}, share);
  }
  float weight = rest * (1.0 - dark) + (uSkyPerPixel ? sky : 0.0);
  fragColor = vec4(drawn.rgb + weight * skySeen(look), 1.0);
}
`;
