// Moving about: orbit and fly with mouse, touch and keys, and glides to photos' cameras.

import * as THREE from "three";
import { OrbitControls } from "three/addons/controls/OrbitControls.js";

import type { Pose } from "./camera";

export type Mode = "orbit" | "fly";

const GLIDE_MS = 700;
const FLY_REACH = 0.01; // world units from the eye to the point that a look turns about
const TURN_PER_S = 0.8; // radians, by arrow keys
const MOVES: Record<string, [number, number, number]> = {
  w: [0, 0, -1], s: [0, 0, 1], a: [-1, 0, 0], d: [1, 0, 0], e: [0, 1, 0], q: [0, -1, 0],
};
const TURNS: Record<string, [number, number]> = {
  arrowleft: [1, 0], arrowright: [-1, 0], arrowup: [0, 1], arrowdown: [0, -1],
};

export class Navigation {
  private readonly controls: OrbitControls;
  private readonly pressed = new Set<string>();
  private mode: Mode = "orbit";
  private lastStep = 0;
  private glide = 0;

  constructor(
    private readonly camera: THREE.PerspectiveCamera,
    canvas: HTMLCanvasElement,
    private readonly focus: THREE.Vector3,
    private readonly onMove: () => void,
  ) {
    this.controls = new OrbitControls(camera, canvas);
    this.controls.addEventListener("change", () => this.onMove());
    this.controls.addEventListener("start", () => this.stop());
    canvas.addEventListener("keydown", (event) => this.press(event));
    canvas.addEventListener("keyup", (event) => this.pressed.delete(event.key.toLowerCase()));
    canvas.addEventListener("blur", () => this.pressed.clear());
  }

  setMode(mode: Mode): void {
    this.mode = mode;
    this.controls.rotateSpeed = mode === "fly" ? -0.4 : 1;
    this.controls.zoomSpeed = mode === "fly" ? 0 : 1;
    this.aim();
  }

  /** Put the camera somewhere at once. */
  place(pose: Pose): void {
    this.stop();
    this.set(pose);
  }

  /** Carry the camera to a pose, or put it there if motion is not wanted. */
  async glideTo(pose: Pose): Promise<void> {
    this.stop();
    const mine = ++this.glide;
    const from = { position: this.camera.position.clone(), quaternion: this.camera.quaternion.clone() };
    const start = performance.now();
    const isStill = matchMedia("(prefers-reduced-motion: reduce)").matches;
    for (let share = isStill ? 1 : 0; mine === this.glide; ) {
      const eased = share * share * (3 - 2 * share);
      this.set({
        position: from.position.clone().lerp(pose.position, eased),
        quaternion: from.quaternion.clone().slerp(pose.quaternion, eased),
      });
      if (share >= 1) return;
      const now = await new Promise<number>((resolve) => requestAnimationFrame(resolve));
      share = Math.min((now - start) / GLIDE_MS, 1);
    }
  }

  private stop(): void {
    this.glide++;
  }

  private set(pose: Pose): void {
    this.camera.position.copy(pose.position);
    this.camera.quaternion.copy(pose.quaternion);
    this.aim();
    this.onMove();
  }

  /** Put the point that drags turn about straight ahead. */
  private aim(): void {
    const ahead = new THREE.Vector3(0, 0, -1).applyQuaternion(this.camera.quaternion);
    const towards = this.focus.clone().sub(this.camera.position);
    const distance = this.mode === "fly" ? FLY_REACH : Math.max(towards.dot(ahead), 0.2 * towards.length());
    this.controls.target.copy(this.camera.position).addScaledVector(ahead, Math.max(distance, FLY_REACH));
  }

  private press(event: KeyboardEvent): void {
    const key = event.key.toLowerCase();
    if (event.ctrlKey || event.metaKey || event.altKey || !(key in MOVES || key in TURNS)) return;
    event.preventDefault();
    this.stop();
    const wasIdle = this.pressed.size === 0;
    this.pressed.add(key);
    if (wasIdle) {
      this.lastStep = performance.now();
      requestAnimationFrame((now) => this.walk(now));
    }
  }

  private walk(now: number): void {
    const seconds = Math.min((now - this.lastStep) / 1000, 0.3);
    this.lastStep = now;
    const speed = 0.4 * Math.max(this.focus.distanceTo(this.camera.position), 0.5);
    const shift = new THREE.Vector3();
    let [yaw, pitch] = [0, 0];
    for (const key of this.pressed) {
      shift.add(new THREE.Vector3(...(MOVES[key] ?? [0, 0, 0])));
      yaw += TURNS[key]?.[0] ?? 0;
      pitch += TURNS[key]?.[1] ?? 0;
    }
    shift.multiplyScalar(speed * seconds).applyQuaternion(this.camera.quaternion);
    this.camera.position.add(shift);
    this.turn(yaw * TURN_PER_S * seconds, pitch * TURN_PER_S * seconds);
    this.onMove();
    if (this.pressed.size) requestAnimationFrame((next) => this.walk(next));
  }

  /** Look left (positive) and up. */
  private turn(yaw: number, pitch: number): void {
    const about = new THREE.Quaternion().setFromAxisAngle(this.camera.up, yaw);
    const nod = new THREE.Quaternion().setFromAxisAngle(new THREE.Vector3(1, 0, 0), pitch);
    this.camera.quaternion.premultiply(about).multiply(nod);
    this.aim();
  }
}
