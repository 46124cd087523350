// Canvas, sky and Spark: draws a frame when something changed. Spark draws the Gaussians into two
// pictures, colour and opacity, and the sky's share of the opacity; a last pass puts what they leave
// uncovered behind them (uncovered.ts).

import { SparkRenderer, type SplatGenerator } from "@sparkjsdev/spark";
import * as THREE from "three";

import type { Constants } from "./payload";
import { composeSource } from "./uncovered";
import type { Uniforms } from "./uniforms";
import type { Witnesses } from "./witnesses";

const LARGEST_RADIUS_PX = 8192;

export class Stage {
  readonly renderer: THREE.WebGLRenderer;
  readonly camera = new THREE.PerspectiveCamera();
  readonly spark: SparkRenderer;
  onFrame: (milliseconds: number) => void = () => {};
  private readonly scene = new THREE.Scene();
  private readonly whole = new THREE.Scene();
  private readonly drawn = new THREE.WebGLRenderTarget(1, 1, {
    count: 2, depthBuffer: false, minFilter: THREE.NearestFilter, magFilter: THREE.NearestFilter,
  });
  private isRequested = false;
  private lastDrawn = 0;

  constructor(
    canvas: HTMLCanvasElement,
    readonly splats: SplatGenerator,
    private readonly uniforms: Uniforms,
    constants: Constants,
    private readonly witnesses: Witnesses,
  ) {
    this.renderer = new THREE.WebGLRenderer({ canvas, antialias: false, alpha: true });
    this.renderer.setClearColor(0x000000, 0);
    // Asking for errors would wait for the compiler.
    this.renderer.debug.checkShaderErrors = false;
    this.camera.up.set(0, -1, 0);
    this.spark = new SparkRenderer({
      renderer: this.renderer,
      onDirty: () => this.request(),
      accumExtSplats: true, // float32 positions and half-float colours
      sortRadial: false,
      maxStdDev: Math.sqrt(-2 * Math.log(constants.minAlpha)),
      minAlpha: constants.minAlpha,
      preBlurAmount: constants.lowPassPx2,
      blurAmount: 0,
      clipXY: Number.MAX_VALUE,
      maxPixelRadius: LARGEST_RADIUS_PX,
      enableLod: false,
      extraUniforms: uniforms,
      transparent: true,
      depthTest: false,
    });
    adapt(this.spark.material, constants);
    this.scene.add(this.spark, splats);
    this.whole.add(composer(this.drawn, uniforms, constants));
  }

  /** Compile all shaders aside, where the browser can, so that the first picture holds nothing up. */
  async prepare(): Promise<void> {
    if (!this.renderer.extensions.has("KHR_parallel_shader_compile")) return;
    const { generator } = this.splats;
    const { material } = this.spark.current.prepareProgramMaterial(generator);
    const stand = new THREE.Mesh(new THREE.PlaneGeometry(), material);
    stand.frustumCulled = false;
    const scene = new THREE.Scene().add(stand);
    const target = new THREE.WebGLRenderTarget(1, 1); // programs depend on what is drawn to
    this.renderer.setRenderTarget(target);
    await this.renderer.compileAsync(scene, this.camera);
    stand.geometry.dispose();
    target.dispose();
    this.renderer.setRenderTarget(this.drawn);
    await this.renderer.compileAsync(this.scene, this.camera);
    this.renderer.setRenderTarget(null);
    await this.renderer.compileAsync(this.whole, this.camera);
  }

  /** Pixels of the canvas' drawing buffer. */
  setSize(width: number, height: number): void {
    this.renderer.setDrawingBufferSize(width, height, 1);
    this.drawn.setSize(width, height);
    this.request();
  }

  /** The scene's colours have to be computed anew. */
  recolour(): void {
    this.splats.updateVersion();
    this.request();
  }

  /** Draw with the next animation frame. */
  request(): void {
    if (this.isRequested) return;
    this.isRequested = true;
    requestAnimationFrame(() => {
      this.isRequested = false;
      this.draw();
    });
  }

  draw(): void {
    const { camera } = this;
    camera.updateMatrixWorld();
    const rotation = new THREE.Matrix3().setFromMatrix4(camera.matrixWorld);
    const p = camera.projectionMatrix.elements;
    // View ray through a point of the picture: ((x + P02) / P00, (y + P12) / P11, -1).
    const ray = new THREE.Matrix3().set(
      1 / p[0], 0, p[8] / p[0], 0, 1 / p[5], p[9] / p[5], 0, 0, -1,
    );
    this.uniforms.uRayFromNdc.value.copy(rotation.multiply(ray));
    this.witnesses.aim(camera.position);
    this.renderer.setRenderTarget(this.drawn);
    this.renderer.render(this.scene, camera);
    this.renderer.setRenderTarget(null);
    this.renderer.render(this.whole, camera);
    const now = performance.now();
    this.onFrame(now - this.lastDrawn);
    this.lastDrawn = now;
  }

  /** Colour, sort and draw until the picture is complete. */
  async settle(): Promise<void> {
    await this.sorted(); // what is under way is of the picture before
    this.splats.updateVersion();
    this.camera.updateMatrixWorld();
    await this.spark.update({ scene: this.scene, camera: this.camera });
    await this.sorted();
    this.draw();
  }

  private async sorted(): Promise<void> {
    while (this.spark.sorting || this.spark.sortDirty) {
      await new Promise((resolve) => setTimeout(resolve, 2));
    }
  }
}

/** A triangle over the whole picture that puts the sky behind what was drawn. */
function composer(
  drawn: THREE.WebGLRenderTarget, uniforms: Uniforms, constants: Constants,
): THREE.Mesh {
  const geometry = new THREE.BufferGeometry();
  const corners = new Float32Array([-1, -1, 0, 3, -1, 0, -1, 3, 0]);
  geometry.setAttribute("position", new THREE.BufferAttribute(corners, 3));
  const [all, sky] = drawn.textures;
  const material = new THREE.ShaderMaterial({
    glslVersion: THREE.GLSL3,
    uniforms: { ...uniforms, uDrawn: { value: all }, uSkyDrawn: { value: sky } },
    depthTest: false,
    depthWrite: false,
    transparent: true,
    blending: THREE.NoBlending,
    vertexShader: `
      out vec2 vNdc;
      void main() { vNdc = position.xy; gl_Position = vec4(position.xy, 0.0, 1.0); }`,
    fragmentShader: composeSource(constants),
  });
  const quad = new THREE.Mesh(geometry, material);
  quad.frustumCulled = false;
  return quad;
}

/** Where r3gw's rasterizer differs from Spark's shaders: small changes to their text. */
function adapt(material: THREE.ShaderMaterial, c: Constants): void {
  // The Jacobian of the projection is held near the frustum, as r3gw.raster does.
  const reach = (1 + 2 * c.frustumMargin).toFixed(6);
  material.vertexShader = replaced(
    material.vertexShader,
    "vec2 J2 = -(J1 * viewCenter.xy) * invZ;",
    `vec2 middle = vec2(projectionMatrix[2][0], projectionMatrix[2][1]);
        vec2 widen = 1.0 / vec2(projectionMatrix[0][0], projectionMatrix[1][1]);
        vec2 slope = clamp(-viewCenter.xy * invZ, (middle - ${reach}) * widen,
          (middle + ${reach}) * widen);
        vec2 J2 = J1 * slope;`,
  );
  // A faint Gaussian reaches less far before it falls below the smallest alpha.
  material.vertexShader = replaced(
    material.vertexShader,
    "vRgba = rgba;",
    `adjustedStdDev = min(maxStdDev, sqrt(2.0 * log(rgba.a / minAlpha)));
    vRgba = rgba;`,
  );
  let fragment = replaced(
    material.fragmentShader,
    "out vec4 fragColor;",
    `layout(location = 0) out vec4 fragColor;
layout(location = 1) out vec4 fragSky;
uniform int uNumForeground;
uniform bool uSkyPerPixel;`,
  );
  // No Gaussian is quite opaque. The sky's have no colour where a map or a plain sky is seen in their
  // place; values are those of the display already, whatever Spark takes the target for.
  fragment = replaced(
    fragment,
    "if (encodeLinear) {",
    `rgba.a = min(rgba.a, ${c.maxAlpha});
    bool isSky = int(vSplatIndex) >= uNumForeground;
    if (isSky && uSkyPerPixel) rgba.rgb = vec3(0.0);
    if (false) {`,
  );
  material.fragmentShader = replaced(
    fragment,
    "fragColor = vec4(rgba.rgb * rgba.a, rgba.a);",
    `fragColor = vec4(rgba.rgb * rgba.a, rgba.a);
    fragSky = vec4(isSky ? rgba.a : 0.0, 0.0, 0.0, rgba.a);`,
  );
}

function replaced(text: string, part: string, by: string): string {
  if (text.split(part).length !== 2) {
    throw new Error(`Spark's shader is not the one of its pinned version: it lacks "${part}"`);
  }
  return text.replace(part, by);
}
