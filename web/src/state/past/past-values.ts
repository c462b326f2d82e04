/** What every signal was at a past moment: the same as the live values are, for a board that looks back. */

import { firstIndexFrom } from "../../series/binary-search.js";
import { SECOND_US } from "../../series/zone-clock.js";
import type { Reading, ReadingSource } from "../live-values.js";
import { PastChunks, type PastColumn, type PastSource } from "./past-chunks.js";
import { PastMoment } from "./past-moment.js";

/** Every sample of up to 50 a second comes; of faster ones the least and the greatest of each 20 ms. */
const WIDTH = 1000;
/** Short: who goes elsewhere waits for the whole of one. */
const CHUNK_US = 20 * SECOND_US;

export class PastValues implements ReadingSource {
  readonly isPast = true;
  readonly chunks: PastChunks;
  /** The values of the moment alone, which are there sooner than all around it. */
  readonly moment: PastMoment;
  private readonly counts = new Map<string, number>();
  private readonly watchers = new Set<() => void>();

  /** @param us the moment that is shown (µs) */
  constructor(
    private readonly site: string,
    source: PastSource,
    private readonly us: () => number,
    private readonly wishChanged: () => void,
    changed: () => void,
    nowUs: () => number,
  ) {
    this.chunks = new PastChunks(site, source, { lengthUs: CHUNK_US, width: WIDTH, together: 1, withLast: true }, changed, nowUs);
    this.moment = new PastMoment(site, source, changed);
  }

  latestReading(site: string, channel: string): Reading | undefined {
    if (site !== this.site) return undefined;
    const us = this.us();
    const column = this.chunks.columnAt(channel, us);
    if (column !== undefined) return readingAt(column, us);
    const found = this.moment.valueAt(channel, us);
    return found === undefined ? undefined : readingOf(found.t_us, found.v, found.text ?? null);
  }

  /** Every value of a moment is known. */
  isReady(us: number): boolean {
    return this.chunks.isReady(us, us) || this.moment.isKnown(us);
  }

  /** Why the hub gave nothing; null while it does. */
  get failure(): unknown {
    return this.chunks.failure ?? this.moment.failure;
  }

  /** After a failure: ask once more. */
  retry(): void {
    this.chunks.retry();
    this.moment.retry();
  }

  close(): void {
    this.chunks.close();
    this.moment.close();
  }

  /** Age at the moment that is shown (s). */
  ageS(reading: Reading): number {
    return Math.max(0, this.us() - reading.timeUs) / 1e6;
  }

  watchChannel(site: string, channel: string, watcher: () => void): () => void {
    // An element may stand on the board twice with the same watcher: each has its own.
    const own = (): void => {
      watcher();
    };
    this.watchers.add(own);
    if (site === this.site) this.changeInterest(channel, 1);
    return () => {
      if (this.watchers.delete(own) && site === this.site) this.changeInterest(channel, -1);
    };
  }

  /** Samples after one moment up to another (µs), of one channel, as far as they are known. */
  readingsBetween(channel: string, afterUs: number, toUs: number): readonly Reading[] {
    return this.chunks.columnsOf(channel, afterUs, toUs).flatMap(({ series }) => {
      const from = firstIndexFrom(series.t_us, afterUs + 1);
      const to = firstIndexFrom(series.t_us, toUs + 1);
      return series.t_us.slice(from, to).map((timeUs, i) => readingOf(timeUs, series.v[from + i] ?? null, series.text?.[from + i] ?? null));
    });
  }

  /** When the newest sample of all channels was taken (µs); NaN for none. */
  newestUs(): number {
    let newest = Number.NaN;
    for (const channel of this.counts.keys()) {
      const timeUs = this.latestReading(this.site, channel)?.timeUs ?? Number.NaN;
      if (!(newest >= timeUs) && !Number.isNaN(timeUs)) newest = timeUs;
    }
    return newest;
  }

  get watchesAny(): boolean {
    return this.counts.size > 0;
  }

  /** The moment is another, or an answer has come. */
  notifyWatchers(): void {
    for (const watcher of [...this.watchers]) watcher();
  }

  private changeInterest(channel: string, change: 1 | -1): void {
    const count = (this.counts.get(channel) ?? 0) + change;
    if (count > 0) this.counts.set(channel, count);
    else this.counts.delete(channel);
    const wanted = [...this.counts.keys()];
    this.chunks.wantChannels(wanted);
    this.moment.wantChannels(wanted);
    this.wishChanged();
  }
}

/** The last sample up to a moment; undefined for none. */
function readingAt({ series, before }: PastColumn, us: number): Reading | undefined {
  const i = firstIndexFrom(series.t_us, us + 1) - 1;
  const timeUs = series.t_us[i];
  if (timeUs !== undefined) return readingOf(timeUs, series.v[i] ?? null, series.text?.[i] ?? null);
  // Whatever the hub says: nothing later than the moment is of it.
  return before === null || before.t_us > us ? undefined : readingOf(before.t_us, before.v, before.text ?? null);
}

function readingOf(timeUs: number, value: number | null, text: string | null): Reading {
  return { timeUs, value: value ?? Number.NaN, text: text === "" && value !== null ? null : text, freshAtMs: timeUs / 1000 };
}
