/** The one moment that the charts' cursor and all films stand at. Pure: told the time by who asks. */

/** Slower and faster than things were; the browser plays them all. */
export const SPEEDS: readonly number[] = [0.5, 1, 2, 4, 8, 16];

export class Playhead {
  private anchorUs = 0;
  private anchorMs = 0;
  private going = false;
  private held = false;
  private pace = 1;

  get playing(): boolean {
    return this.going;
  }

  get speed(): number {
    return this.pace;
  }

  /** @param nowMs a clock that only goes forward (ms) */
  timeUs(nowMs: number): number {
    if (!this.going || this.held) return this.anchorUs;
    return this.anchorUs + (nowMs - this.anchorMs) * 1000 * this.pace;
  }

  seek(us: number, nowMs: number): void {
    this.anchorUs = us;
    this.anchorMs = nowMs;
  }

  play(nowMs: number): void {
    this.freezeTime(nowMs);
    this.going = true;
    this.held = false;
  }

  pause(nowMs: number): void {
    this.freezeTime(nowMs);
    this.going = false;
  }

  /** Stands still while a picture that should be shown has not come; goes on by itself. */
  setWaiting(held: boolean, nowMs: number): void {
    if (held === this.held) return;
    this.freezeTime(nowMs);
    this.held = held;
  }

  setSpeed(speed: number, nowMs: number): void {
    this.freezeTime(nowMs);
    this.pace = speed;
  }

  private freezeTime(nowMs: number): void {
    this.seek(this.timeUs(nowMs), nowMs);
  }
}

/** The next speed up or down; the same at either end. */
export function nextSpeed(speed: number, by: 1 | -1): number {
  return SPEEDS[SPEEDS.indexOf(speed) + by] ?? speed;
}
