/** The samples behind the charts of a board that looks back: windows that end at a past moment. */

import { toShown } from "../../format/unit.js";
import type { GapShape, ShownUnitShape, SignalShape } from "../../generated/api.js";
import { firstIndexFrom } from "../../series/binary-search.js";
import { Columns } from "../../series/columns.js";
import { pauseAllowed } from "../../series/gaps.js";
import type { TimeSpan } from "../../series/time-window.js";
import { MINUTE_US, SECOND_US } from "../../series/zone-clock.js";
import { gapsOfParts, joinSeries } from "./history-samples.js";
import { PastChunks, type PastColumn, type PastSource } from "./past-chunks.js";

/**
 * Pixels of the widest chart: twice as many points come for each line, and all of them before a moment is shown. No more
 * than these are asked for, and in whole steps: a chart that is a little wider needs no other answer.
 */
const MOST_WIDTH = 800;
const WIDTH_STEP = 100;
/** A window is asked for in so many parts: what sticks out of it at its two ends is one of them, and not another window. */
const PARTS = 8;
const NO_TIMES = new Float64Array();

interface Line {
  readonly trace: PastTrace;
  readonly gaps: GapShape[];
}

export class PastFeed {
  private lines = new Map<string, Line>();
  private readonly ageLimits = new Map<string, number>();
  private readonly shown = new Map<string, ShownUnitShape>();
  private chunks: PastChunks;
  private wanted: readonly string[] = [];
  private width = 0;

  /**
   * @param us the moment that is shown (µs)
   * @param jumps counts the times that it was put elsewhere
   */
  constructor(
    private readonly site: string,
    private readonly source: PastSource,
    private readonly us: () => number,
    private readonly jumps: () => number,
    private readonly changed: () => void,
    private readonly nowUs: () => number,
    private lengthUs = 5 * MINUTE_US,
  ) {
    this.chunks = this.makeChunks();
  }

  /** The longest window that any chart shows (µs). */
  setLength(lengthUs: number): void {
    if (lengthUs === this.lengthUs) return;
    this.lengthUs = lengthUs;
    this.remakeChunks();
  }

  /** How wide the widest chart is (CSS pixels). A board that becomes narrower keeps what it has. */
  setWidth(pixels: number): void {
    const width = Math.min(MOST_WIDTH, Math.max(1, Math.ceil(pixels / WIDTH_STEP)) * WIDTH_STEP);
    if (width <= this.width) return;
    this.width = width;
    this.remakeChunks();
  }

  private remakeChunks(): void {
    this.chunks.close();
    this.chunks = this.makeChunks();
    this.chunks.wantChannels(this.wanted);
    // Lines are of the chunks: their charts are made anew.
    this.lines = new Map();
    this.changed();
  }

  subscribeSignals(signals: readonly SignalShape[]): void {
    for (const { channels, max_age: limit } of signals) for (const channel of channels) this.ageLimits.set(channel, limit);
    for (const { type, shown, channels } of signals) if (type === "number" && shown !== null) for (const channel of channels) this.shown.set(channel, shown);
    const wanted = signals.flatMap(({ channels }) => channels);
    if (wanted.join("\n") === this.wanted.join("\n")) return;
    this.wanted = wanted;
    this.chunks.wantChannels(wanted);
    this.changed();
  }

  channelOf(address: string): Line {
    let line = this.lines.get(address);
    if (line === undefined) {
      const gaps: GapShape[] = [];
      const { chunks } = this;
      const pieces = (): readonly PastColumn[] => chunks.columnsOf(address, this.us() - this.lengthUs, this.us());
      const allowedUs = (this.ageLimits.get(address) ?? 5) * SECOND_US;
      line = { gaps, trace: new PastTrace(pieces, gaps, { us: this.us, jumps: this.jumps, allowedUs, shown: this.shown.get(address) ?? null }) };
      this.lines.set(address, line);
    }
    return line;
  }

  /** Age of the newest sample at the moment (s); NaN where the window has none. */
  ageS(address: string): number {
    return Math.max(0, this.us() - this.channelOf(address).trace.newestUs) / 1e6;
  }

  readonly currentWindow = (): TimeSpan => ({ fromUs: this.us() - this.lengthUs, toUs: this.us() });

  /**
   * @param aheadUs so much after the moment is asked for, too
   * @param most questions that may run at a time
   */
  load(aheadUs: number, most?: number): void {
    const us = this.us();
    this.chunks.load(us - this.lengthUs, us, most);
    if (aheadUs > 0) this.chunks.load(us, us + aheadUs);
  }

  get isReady(): boolean {
    return this.chunks.isReady(this.us() - this.lengthUs, this.us());
  }

  get failure(): unknown {
    return this.chunks.failure;
  }

  retry(): void {
    this.chunks.retry();
  }

  close(): void {
    this.chunks.close();
  }

  private makeChunks(): PastChunks {
    const lengthUs = Math.ceil(Math.max(MINUTE_US, this.lengthUs) / PARTS);
    return new PastChunks(this.site, this.source, { lengthUs, width: Math.ceil((this.width || MOST_WIDTH) / PARTS), together: PARTS + 1, withLast: false }, this.changed, this.nowUs);
  }
}

interface TraceFacts {
  readonly us: () => number;
  readonly jumps: () => number;
  readonly allowedUs: number;
  readonly shown: ShownUnitShape | null;
}

/** One channel as a chart holds it, up to the moment; see `ChartSamples`. */
class PastTrace {
  private pieces: readonly PastColumn[] = [];
  private allTimes: Float64Array = NO_TIMES;
  private allValues: Float64Array = NO_TIMES;
  private intervalUs = Number.NaN;
  private changes = 0;
  private columns: Columns | null = null;
  private drawn = 0;

  constructor(
    private readonly piecesNow: () => readonly PastColumn[],
    private readonly gaps: GapShape[],
    private readonly facts: TraceFacts,
  ) {}

  get times(): Float64Array {
    const length = this.length;
    return this.allTimes.subarray(0, length);
  }

  get values(): Float64Array {
    const length = this.length;
    return this.allValues.subarray(0, length);
  }

  /** Samples up to the moment. */
  get length(): number {
    this.assemble();
    return firstIndexFrom(this.allTimes, this.facts.us() + 1);
  }

  get newestUs(): number {
    // First: it puts together what has come, and with that the times.
    const newest = this.newestIndex();
    return this.allTimes[newest] ?? Number.NaN;
  }

  get newest(): number {
    const newest = this.newestIndex();
    return this.allValues[newest] ?? Number.NaN;
  }

  get version(): number {
    this.assemble();
    return this.changes + this.facts.jumps();
  }

  get allowedUs(): number {
    return pauseAllowed(this.intervalUs, this.facts.allowedUs);
  }

  /** Added to as the moment goes on; made anew when it went back. */
  columnsAt(widthUs: number): Columns {
    const { length } = this;
    if (this.columns?.widthUs !== widthUs || this.drawn > length) {
      this.columns = new Columns(widthUs);
      this.drawn = 0;
    }
    for (; this.drawn < length; this.drawn += 1) this.columns.append(this.allTimes[this.drawn] ?? Number.NaN, this.allValues[this.drawn] ?? Number.NaN, this.allowedUs);
    return this.columns;
  }

  /** A gap's "not a number" is no sample. */
  private newestIndex(): number {
    let i = this.length - 1;
    while (i >= 0 && Number.isNaN(this.allValues[i])) i -= 1;
    return i;
  }

  private assemble(): void {
    const pieces = this.piecesNow();
    if (pieces.length === this.pieces.length && pieces.every((piece, i) => piece === this.pieces[i])) return;
    this.pieces = pieces;
    const parts = pieces.map(({ series }) => series);
    const { times, values, intervalUs } = joinSeries(parts);
    const { shown } = this.facts;
    this.allTimes = times;
    this.allValues = shown === null ? values : values.map((value) => toShown(shown, value));
    this.intervalUs = intervalUs;
    this.gaps.splice(0, Infinity, ...gapsOfParts(parts));
    this.columns = null;
    this.changes += 1;
  }
}
