/** "Now" on the robot's clock, told from its samples: the right edge of a live chart. */

const REMEMBERED_MS = 5000;

/**
 * A sample is always a little late, so the one that was least late tells the offset between the
 * two clocks best. Only the last seconds count: a clock that is set is followed soon.
 */
export class LiveEdge {
  private offset = NaN;
  private best = -Infinity;
  private before = -Infinity;
  private since = NaN;

  /** Whether any sample has been seen. */
  get isKnown(): boolean {
    return Number.isFinite(this.offset);
  }

  /**
   * @param timeUs when the sample was taken, by the robot's clock
   * @param nowMs this page's monotonic clock
   * @param ageMs how old the sample is known to be
   */
  observe(timeUs: number, nowMs: number, ageMs = 0): void {
    const offset = timeUs / 1000 + ageMs - nowMs;
    if (!Number.isFinite(offset)) return;
    if (!(nowMs - this.since < REMEMBERED_MS)) {
      this.before = Number.isNaN(this.since) ? -Infinity : this.best;
      this.best = -Infinity;
      this.since = nowMs;
    }
    this.best = Math.max(this.best, offset);
    this.offset = Math.max(this.best, this.before);
  }

  /** The robot's "now" (µs since the epoch); NaN before the first sample. */
  nowUs(nowMs: number): number {
    return (nowMs + this.offset) * 1000;
  }
}
