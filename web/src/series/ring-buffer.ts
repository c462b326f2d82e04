/**
 * The newest samples of one channel, bounded by time and by count.
 *
 * Samples stand side by side in two arrays that are filled to the end and then moved back, so a
 * reader always sees one unbroken stretch (a wrapped ring would need two).
 */
import { firstIndexFrom } from "./binary-search.js";

const SMALLEST = 256;

export class RingBuffer {
  private time = new Float64Array(SMALLEST);
  private value = new Float64Array(SMALLEST);
  private start = 0;
  private end = 0;

  /**
   * @param spanUs samples older than this behind the newest are forgotten (µs)
   * @param most at most so many samples are kept; the oldest go first
   */
  constructor(
    public spanUs: number,
    readonly most: number = 65_536,
  ) {
    if (!(spanUs > 0) || !(most >= 1)) throw new RangeError("a ring needs a span and room for one sample");
  }

  get length(): number {
    return this.end - this.start;
  }

  /** Times in ascending order (µs since the epoch). A view: it is stale after the next change. */
  get times(): Float64Array {
    return this.time.subarray(this.start, this.end);
  }

  /** Values by the same index. A view, as `times`. */
  get values(): Float64Array {
    return this.value.subarray(this.start, this.end);
  }

  get newestUs(): number {
    return this.length ? (this.time[this.end - 1] ?? NaN) : NaN;
  }

  get newest(): number {
    return this.length ? (this.value[this.end - 1] ?? NaN) : NaN;
  }

  /**
   * Take one sample in. Returns "end" when it is the newest, "inside" when it went between
   * others (it came late), "refused" when it is too old, or there already.
   */
  push(timeUs: number, value: number): "end" | "inside" | "refused" {
    const newest = this.newestUs;
    if (!Number.isFinite(timeUs) || timeUs < newest - this.spanUs) return "refused";
    if (timeUs <= newest) return this.insertSorted(timeUs, value);
    this.makeRoom();
    this.time[this.end] = timeUs;
    this.value[this.end] = value;
    this.end += 1;
    this.dropOldest();
    return "end";
  }

  /** Take many older samples in at once (a back-fill), in ascending time. Those known stay. */
  backfill(times: ArrayLike<number>, values: ArrayLike<number>): void {
    const own = { times: this.times.slice(), values: this.values.slice() };
    this.clear();
    let mine = 0;
    let theirs = 0;
    while (mine < own.times.length || theirs < times.length) {
      const here = own.times[mine] ?? Infinity;
      const there = times[theirs] ?? Infinity;
      if (here === Infinity && there === Infinity) break;
      if (here <= there) {
        this.push(here, own.values[mine] ?? NaN);
        mine += 1;
        if (here === there) theirs += 1;
      } else {
        this.push(there, values[theirs] ?? NaN);
        theirs += 1;
      }
    }
  }

  clear(): void {
    this.start = 0;
    this.end = 0;
  }

  /** An independent copy that later samples do not change. */
  copy(): RingBuffer {
    const twin = new RingBuffer(this.spanUs, this.most);
    twin.time = this.times.slice();
    twin.value = this.values.slice();
    twin.end = twin.time.length;
    return twin;
  }

  private insertSorted(timeUs: number, value: number): "inside" | "refused" {
    const at = this.start + firstIndexFrom(this.times, timeUs);
    if (this.time[at] === timeUs) return "refused";
    if (this.length >= this.most && at === this.start) return "refused";
    this.makeRoom();
    const place = this.start + firstIndexFrom(this.times, timeUs);
    this.time.copyWithin(place + 1, place, this.end);
    this.value.copyWithin(place + 1, place, this.end);
    this.time[place] = timeUs;
    this.value[place] = value;
    this.end += 1;
    this.dropOldest();
    return "inside";
  }

  private dropOldest(): void {
    const oldest = this.newestUs - this.spanUs;
    while (this.length > this.most || (this.time[this.start] ?? Infinity) < oldest) this.start += 1;
  }

  private makeRoom(): void {
    if (this.end < this.time.length) return;
    const held = this.length;
    // Moved back only when at least half is free, so each sample is moved about once.
    const room = held * 2 > this.time.length ? this.time.length * 2 : this.time.length;
    const time = room === this.time.length ? this.time : new Float64Array(room);
    const value = room === this.time.length ? this.value : new Float64Array(room);
    time.set(this.times);
    value.set(this.values);
    this.time = time;
    this.value = value;
    this.start = 0;
    this.end = held;
  }
}
