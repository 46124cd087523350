// The page's one controller: state in, picture out.

import * as THREE from "three";

import { lensOf, poseOf, project, type Lens } from "./camera";
import { CoverageMeter } from "./coverage";
import type { LightMap } from "./harmonics";
import { Lights } from "./lights";
import { Navigation } from "./navigation";
import { Pace } from "./pace";
import type { Payload, Photo } from "./payload";
import { hashOf, stateFrom, type State } from "./state";
import type { Stage } from "./stage";

const FAR = 1e5;
const MOST_PIXELS = 2_600_000; // of the drawing buffer; sharper screens are drawn coarser
const QUIET_MS = 300;

/** What the page shows besides the canvas. */
export interface View {
  show(state: State): void;
  /** The photo whose camera the view has exactly, and its lens; null if it was moved. */
  atPhoto(photo: Photo | null): void;
  coverage(sentence: string): void;
  /** Azimuth in which the viewer looks, degrees from +z towards +x. */
  look(azimuth: number): void;
}

export class App {
  state: State;
  view: View | null = null;
  mapsRead = 0;
  readonly navigation: Navigation;
  private readonly initial: State;
  private readonly photos: Map<string, Photo>;
  private readonly meter: CoverageMeter;
  private readonly pace: Pace;
  private lens: Lens;
  private scale = 1;
  private fixedSize: [number, number] | null = null;
  private quiet = 0;
  private day = 0;

  constructor(
    readonly payload: Payload,
    readonly stage: Stage,
    private readonly lights: Lights,
    private readonly canvas: HTMLCanvasElement,
  ) {
    this.photos = new Map(payload.photos.map((photo) => [photo.name, photo]));
    this.initial = firstState(payload);
    this.state = { ...this.initial };
    this.lens = lensOf(payload.photos[0]);
    this.meter = new CoverageMeter(payload);
    this.pace = new Pace((scale) => this.setScale(scale));
    stage.onFrame = (milliseconds) => this.pace.frame(milliseconds);
    const focus = new THREE.Vector3(...(payload.focus as [number, number, number]));
    this.navigation = new Navigation(stage.camera, canvas, focus, () => this.moved());
    new ResizeObserver(() => this.resize()).observe(canvas);
    this.readHash();
    addEventListener("hashchange", () => this.readHash());
  }

  /** Change some of the state. */
  change(part: Partial<State>): void {
    this.state = { ...this.state, ...part };
    this.lights.apply(this.state);
    this.pace.moved();
    this.stage.recolour();
    this.changed();
  }

  /** Light the scene with a dropped map. */
  useMap(map: LightMap): void {
    this.mapsRead++;
    this.lights.dropped = map;
    this.change({ light: "map" });
  }

  get hasMap(): boolean {
    return this.lights.dropped !== null;
  }

  /** Carry the camera to a photo's. */
  async jump(name: string): Promise<void> {
    const photo = this.photos.get(name);
    if (!photo) return;
    this.lens = lensOf(photo);
    this.state = { ...this.state, lens: name };
    this.resize();
    await this.navigation.glideTo(poseOf(photo));
  }

  /** Let the sun run from morning to evening, or stop it. */
  playDay(seconds: number, onEnd: () => void): boolean {
    const mine = ++this.day;
    if (seconds === 0) return false;
    const start = performance.now();
    const step = (now: number) => {
      if (mine !== this.day) return onEnd();
      const share = Math.min((now - start) / (1000 * seconds), 1);
      const elevation = 4 + 56 * Math.sin(Math.PI * share);
      this.change({ light: "sun", elevation, azimuth: 90 + 180 * share });
      if (share < 1) requestAnimationFrame(step);
      else onEnd();
    };
    requestAnimationFrame(step);
    return true;
  }

  /** The view as a PNG picture, at the canvas' full size. */
  async picture(): Promise<Blob> {
    this.setScale(1);
    await this.stage.settle();
    return new Promise((resolve, reject) => {
      this.canvas.toBlob((found) => (found ? resolve(found) : reject(new Error("no picture"))));
    });
  }

  /** For tests: a state and a photo's camera drawn at a size in pixels, as a data URL. */
  async probe(part: Partial<State>, name: string, width: number, height: number): Promise<string> {
    const photo = this.photos.get(name)!;
    this.change({ ...this.initial, ...part });
    this.navigation.place(poseOf(photo));
    this.lens = lensOf(photo);
    this.fixedSize = [width, height];
    this.resize();
    await this.stage.settle();
    return this.canvas.toDataURL("image/png");
  }

  private get near(): number {
    return this.payload.constants.nearPlane;
  }

  private readHash(): void {
    const names = new Set(this.photos.keys());
    this.state = stateFrom(location.hash, this.initial, names);
    if (this.state.light === "map" && !this.hasMap) this.state.light = "learned";
    const photo = this.photos.get(this.state.lens) ?? this.payload.photos[0];
    this.lens = lensOf(photo);
    const [x, y, z, ...turn] = this.state.camera;
    const pose = turn.length
      ? { position: new THREE.Vector3(x, y, z), quaternion: new THREE.Quaternion(...turn).normalize() }
      : poseOf(photo);
    this.resize();
    this.navigation.place(pose);
    this.change({});
  }

  private moved(): void {
    this.pace.moved();
    this.stage.request();
    this.changed();
  }

  private setScale(scale: number): void {
    this.scale = scale;
    this.resize();
  }

  private resize(): void {
    const { clientWidth, clientHeight } = this.canvas;
    const [width, height] = this.fixedSize ?? [clientWidth, clientHeight];
    if (!width || !height) return;
    const sharpest = Math.sqrt(MOST_PIXELS / (width * height));
    const ratio = this.fixedSize ? 1 : Math.min(devicePixelRatio, sharpest) * this.scale;
    const pixels = (length: number) => Math.max(1, Math.round(length * ratio));
    this.stage.setSize(pixels(width), pixels(height));
    project(this.stage.camera, this.lens, width / height, this.near, FAR);
  }

  /** Show the state now, and what is slower once nothing has changed for a moment. */
  private changed(): void {
    this.view?.show(this.state);
    this.view?.atPhoto(this.photoHere());
    const ahead = new THREE.Vector3(0, 0, -1).applyQuaternion(this.stage.camera.quaternion);
    this.view?.look((Math.atan2(ahead.x, ahead.z) * 180) / Math.PI);
    clearTimeout(this.quiet);
    this.quiet = window.setTimeout(() => this.settled(), QUIET_MS);
  }

  private settled(): void {
    const { position, quaternion } = this.stage.camera;
    const camera = [...position.toArray(), ...quaternion.toArray()] as number[];
    this.state = { ...this.state, camera: this.isFirstView() ? [] : camera };
    const hash = hashOf(this.state, this.initial);
    history.replaceState(null, "", hash ? `#${hash}` : location.pathname + location.search);
    this.stage.camera.updateMatrixWorld();
    this.view?.coverage(this.meter.sentence(this.stage.camera));
  }

  private isFirstView(): boolean {
    return this.photoHere()?.name === this.payload.photos[0].name;
  }

  private photoHere(): Photo | null {
    const photo = this.photos.get(this.state.lens);
    if (!photo) return null;
    const { position, quaternion } = poseOf(photo);
    const isHere = position.distanceTo(this.stage.camera.position) < 1e-4 &&
      Math.abs(quaternion.dot(this.stage.camera.quaternion)) > 1 - 1e-6;
    return isHere ? photo : null;
  }
}

function firstState(payload: Payload): State {
  const photo = payload.lights[0]?.photo ?? "";
  return {
    light: "learned", photo, photo2: "", blend: 0,
    elevation: 40, azimuth: 150, strength: 1, turbidity: 3,
    yaw: 0, auto: true, stops: 0, tone: "standard", sky: "own", show: "picture", parts: "both",
    camera: [], lens: payload.photos[0].name,
    ...payload.start,
  };
}
