/** How often charts are drawn: as often as an eye can tell, within a share of one core. */

/** The last rounds, of which the quicker ones tell what drawing takes: longer ones were held up by other programs. */
const ROUNDS = 9;

export class DrawRate {
  private readonly costs: number[] = [];
  private last = -Infinity;

  /**
   * @param leastMs what only moves is never drawn more often than this (33 ms is 30 pictures a second)
   * @param share drawing takes at most this part of the time
   * @param mostMs never less often than this, however dear drawing is
   */
  constructor(
    private readonly leastMs = 33,
    private readonly share = 0.3,
    private readonly mostMs = 250,
  ) {}

  /**
   * Time between the starts of two rounds (ms).
   *
   * @param fresh something new has come: as soon as the share allows; else no oftener than movement is drawn
   */
  intervalMs(fresh: boolean): number {
    const sorted = [...this.costs].sort((a, b) => a - b);
    const cost = sorted[sorted.length >> 2] ?? 0;
    return Math.min(this.mostMs, Math.max(fresh ? 0 : this.leastMs, cost / this.share));
  }

  /** Whether a round may start now. A frame that is a little early counts: the next would be late. */
  isDue(nowMs: number, fresh: boolean): boolean {
    return nowMs - this.last >= this.intervalMs(fresh) - 4;
  }

  /** Take down a round that was drawn. */
  recordRound(startedMs: number, tookMs: number): void {
    this.last = startedMs;
    this.costs.push(tookMs);
    if (this.costs.length > ROUNDS) this.costs.shift();
  }
}
