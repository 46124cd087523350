// The sky dome on which the sun is dragged: zenith in the middle, horizon at the edge, seen from
// above with +z up and +x to the right.

export interface DomeValue {
  elevation: number;
  azimuth: number;
}

const RADIUS = 90; // SVG units; one per degree from the zenith
const STEP_DEG = 3;
const round = (value: number) => Math.round(10 * value) / 10;

export class Dome {
  private value: DomeValue = { elevation: 45, azimuth: 0 };

  constructor(
    private readonly svg: SVGSVGElement,
    private readonly onChange: (value: DomeValue) => void,
  ) {
    svg.addEventListener("pointerdown", (event) => {
      svg.setPointerCapture(event.pointerId);
      this.follow(event);
    });
    svg.addEventListener("pointermove", (event) => {
      if (svg.hasPointerCapture(event.pointerId)) this.follow(event);
    });
    svg.addEventListener("keydown", (event) => this.step(event));
  }

  show(value: DomeValue): void {
    this.value = value;
    const sun = this.svg.querySelector("#dome-sun")!;
    const away = 90 - value.elevation, turn = (value.azimuth * Math.PI) / 180;
    sun.setAttribute("cx", String(away * Math.sin(turn)));
    sun.setAttribute("cy", String(-away * Math.cos(turn)));
    const text = `${Math.round(value.elevation)}° high, azimuth ${Math.round(value.azimuth)}°`;
    this.svg.setAttribute("aria-valuenow", String(Math.round(value.elevation)));
    this.svg.setAttribute("aria-valuetext", text);
  }

  /** Show which way the viewer looks. */
  look(azimuth: number): void {
    this.svg.querySelector("#dome-look")!.setAttribute("transform", `rotate(${azimuth})`);
  }

  private follow(event: PointerEvent): void {
    const box = this.svg.getBoundingClientRect();
    const view = this.svg.viewBox.baseVal;
    const x = ((event.clientX - box.left) / box.width) * view.width + view.x;
    const y = ((event.clientY - box.top) / box.height) * view.height + view.y;
    const away = Math.min(Math.hypot(x, y), RADIUS);
    const azimuth = away < 0.5 ? this.value.azimuth : (Math.atan2(x, -y) * 180) / Math.PI;
    this.onChange({ elevation: round(90 - away), azimuth: round((azimuth + 360) % 360) });
    event.preventDefault();
  }

  private step(event: KeyboardEvent): void {
    const { elevation, azimuth } = this.value;
    const moves: Record<string, DomeValue> = {
      ArrowUp: { elevation: Math.min(elevation + STEP_DEG, 90), azimuth },
      ArrowDown: { elevation: Math.max(elevation - STEP_DEG, 0), azimuth },
      ArrowLeft: { elevation, azimuth: (azimuth - STEP_DEG + 360) % 360 },
      ArrowRight: { elevation, azimuth: (azimuth + STEP_DEG) % 360 },
    };
    const next = moves[event.key];
    if (!next) return;
    event.preventDefault();
    this.onChange(next);
  }
}
