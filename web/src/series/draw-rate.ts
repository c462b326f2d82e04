/** How often charts are drawn: as often as an eye can tell, within a share of one core. */

const SMOOTHING = 0.1;

export class DrawRate {
  private cost = 0;
  private last = -Infinity;

  /**
   * @param leastMs never more often than this (33 ms is 30 pictures a second)
   * @param share drawing takes at most this part of the time
   * @param mostMs never less often than this, however dear drawing is
   */
  constructor(
    private readonly leastMs = 33,
    private readonly share = 0.3,
    private readonly mostMs = 250,
  ) {}

  /** Time between the starts of two rounds that keeps to the share (ms). */
  get intervalMs(): number {
    return Math.min(this.mostMs, Math.max(this.leastMs, this.cost / this.share));
  }

  /** Whether a round may start now. A frame that is a little early counts: the next would be late. */
  isDue(nowMs: number): boolean {
    return nowMs - this.last >= this.intervalMs - 4;
  }

  /** Take down a round that was drawn. */
  recordRound(startedMs: number, tookMs: number): void {
    this.last = startedMs;
    this.cost += (tookMs - this.cost) * SMOOTHING;
  }
}
