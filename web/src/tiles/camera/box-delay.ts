/** How long pictures wait for what is seen on them, by what is measured. Pure. */

/** Nothing waits longer than this (ms). */
export const MOST_HOLD_MS = 300;
/** What was measured longer ago does not count (ms). */
const RECENT_MS = 3000;
const MOST_KEPT = 30;
/** Waiting is as long as for this part of the boxes, and a little more. */
const PART = 0.9;
const MARGIN_MS = 10;
/** In steps, so that the picture does not run faster and slower all the time. */
const STEP_MS = 20;
/** It is made shorter only when it would be by so much. */
const EASE_MS = 40;

export class BoxDelay {
  private latencies: { readonly at: number; readonly ms: number }[] = [];
  private held = 0;

  /** Boxes came so much later than their picture. */
  recordLatency(ms: number, now: number): void {
    this.latencies = [...this.recentLatencies(now).slice(1 - MOST_KEPT), { at: now, ms: Math.max(0, ms) }];
  }

  /**
   * How long a picture that comes now waits (ms). It is 0 where nothing is known to come, and where
   * the longest wait would not be long enough: that would be late for nothing.
   */
  delayMs(now: number): number {
    const sorted = this.recentLatencies(now).map(({ ms }) => ms).sort((a, b) => a - b);
    const late = sorted[Math.ceil(sorted.length * PART) - 1];
    const wanted = late === undefined ? 0 : Math.ceil((late + MARGIN_MS) / STEP_MS) * STEP_MS;
    if (wanted > MOST_HOLD_MS || late === undefined) this.held = 0;
    else if (wanted > this.held || wanted <= this.held - EASE_MS) this.held = wanted;
    return this.held;
  }

  private recentLatencies(now: number): typeof this.latencies {
    return this.latencies.filter(({ at }) => now - at < RECENT_MS);
  }
}
