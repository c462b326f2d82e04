/** One channel as a chart holds it: its samples, and the columns drawn of them. */

import { Columns } from "./columns.js";
import { IntervalWatch, pauseAllowed, typicalInterval } from "./gaps.js";
import { RingBuffer } from "./ring-buffer.js";

export class Trace {
  private ring: RingBuffer;
  private columns: Columns | null = null;
  private readonly watch = new IntervalWatch();
  private changes = 0;

  /**
   * @param spanUs samples older than this behind the newest are forgotten (µs)
   * @param maxAgeUs the signal's limit of age (µs)
   */
  constructor(
    spanUs: number,
    private readonly maxAgeUs: number,
    most?: number,
  ) {
    this.ring = new RingBuffer(spanUs, most);
  }

  get times(): Float64Array {
    return this.ring.times;
  }

  get values(): Float64Array {
    return this.ring.values;
  }

  get length(): number {
    return this.ring.length;
  }

  get newestUs(): number {
    return this.ring.newestUs;
  }

  get newest(): number {
    return this.ring.newest;
  }

  /** Counts up with every change, so that a chart knows whether it has anything to draw. */
  get version(): number {
    return this.changes;
  }

  /** The longest pause that is no gap (µs). */
  get allowedUs(): number {
    return pauseAllowed(this.watch.typicalUs, this.maxAgeUs);
  }

  set spanUs(us: number) {
    this.ring.spanUs = us;
  }

  addSample(timeUs: number, value: number): void {
    const where = this.ring.push(timeUs, value);
    if (where === "refused") return;
    this.changes += 1;
    if (where === "inside") {
      this.columns = null;
      return;
    }
    this.watch.addTime(timeUs);
    this.columns?.append(timeUs, value, this.allowedUs);
  }

  /**
   * Take in samples from before.
   *
   * @param intervalUs their usual interval; said by the caller where pairs of least and greatest
   *   stand for many
   */
  backfill(times: ArrayLike<number>, values: ArrayLike<number>, intervalUs = typicalInterval(times)): void {
    this.ring.backfill(times, values);
    this.watch.assumeInterval(intervalUs);
    this.columns = null;
    this.changes += 1;
  }

  /** The columns at a resolution (µs each). Kept and added to while the resolution stays. */
  columnsAt(widthUs: number): Columns {
    if (this.columns?.widthUs !== widthUs) {
      this.columns = new Columns(widthUs);
      const { times, values, allowedUs } = this;
      for (let i = 0; i < times.length; i += 1) this.columns.append(times[i] ?? NaN, values[i] ?? NaN, allowedUs);
    }
    this.columns.dropBefore(this.ring.newestUs - this.ring.spanUs);
    return this.columns;
  }

  /** An independent copy that later samples do not change: what a paused chart shows. */
  copy(): Trace {
    const twin = new Trace(this.ring.spanUs, this.maxAgeUs);
    twin.ring = this.ring.copy();
    twin.watch.continueFrom(this.watch);
    return twin;
  }
}
