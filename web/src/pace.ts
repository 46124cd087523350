// Sharpness against speed: while something moves on a slow machine, pictures are drawn smaller;
// at rest they are drawn at full size.

const SCALES = [1, 0.7, 0.5, 0.35, 0.25];
const SLOW_MS = 90, FAST_MS = 30, REST_MS = 250, PAUSE_MS = 4000;

export class Pace {
  private level = 0;
  private isMoving = false;
  private rest = 0;
  private slow = 0;

  constructor(private readonly onScale: (scale: number) => void) {}

  /** Something moves: frames may be small until it rests. */
  moved(): void {
    clearTimeout(this.rest);
    this.rest = window.setTimeout(() => this.settle(), REST_MS);
    if (this.isMoving) return;
    this.isMoving = true;
    this.onScale(SCALES[this.level]);
  }

  /** A frame came so long after the one before. */
  frame(milliseconds: number): void {
    if (!this.isMoving || milliseconds > PAUSE_MS) return;
    this.slow = milliseconds > SLOW_MS ? this.slow + 1 : milliseconds < FAST_MS ? this.slow - 0.2 : 0;
    const step = this.slow >= 2 ? 1 : this.slow <= -4 ? -1 : 0;
    if (step === 0) return;
    this.slow = 0;
    const next = Math.min(Math.max(this.level + step, 0), SCALES.length - 1);
    if (next === this.level) return;
    this.level = next;
    this.onScale(SCALES[next]);
  }

  private settle(): void {
    this.isMoving = false;
    this.onScale(1);
  }
}
