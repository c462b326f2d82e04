/** The samples behind a page of live charts: one subscription, one trace for each channel. */

import { Trace } from "../../series/trace.js";
import { LiveEdge } from "../../series/live-edge.js";
import { lengthOf, type TimeSpan } from "../../series/time-window.js";
import { SECOND_US } from "../../series/zone-clock.js";
import { toShown } from "../../format/unit.js";
import type { GapShape, HistoryAnswer, ShownUnitShape, SignalShape } from "../../generated/api.js";
import type { HistoryQuery } from "../../wire/hub-api.js";
import type { Batch } from "../../wire/subscriptions.js";
import { channelGroups } from "../../state/past/channel-groups.js";
import { samplesOf } from "../../state/past/history-samples.js";

/** What the feed needs of a connection. */
export interface SampleSource {
  subscribe(site: string, channels: readonly string[], everyMs: number, listener: (batch: Batch) => void): () => void;
}

/** What the feed needs of the hub's HTTP interface. */
export interface HistorySource {
  history(site: string, query: HistoryQuery, signal?: AbortSignal): Promise<HistoryAnswer>;
}

/** Twenty pictures' worth a second; a chart is drawn hardly more often. */
const EVERY_MS = 50;
/** A back-fill never needs more pixels than a wide chart has. */
const BACKFILL_PX = 1200;

/** The history has a score at least this often while samples come (s). */
const WRITTEN_S = 130;

/** One channel of the feed. */
export interface FeedChannel {
  /** Numbers as they are shown to the person, see `format/unit.ts`; parts of a position as they are stored. */
  readonly trace: Trace;
  /** Stretches that the hub knows to be missing; added to in place. */
  readonly gaps: GapShape[];
  /** The newest text; null for a number. */
  text: string | null;
  /** When the newest sample was taken (µs since the epoch); NaN before the first. */
  timeUs: number;
  /** This page's monotonic clock (ms) at the moment when it was fresh. */
  freshAtMs: number;
}

export type BackfillState = "idle" | "loading" | "done" | "failed";

export class ChartFeed {
  readonly edge = new LiveEdge();
  backfill: BackfillState = "idle";
  private readonly channels = new Map<string, FeedChannel>();
  private readonly ageLimits = new Map<string, number>();
  private readonly shown = new Map<string, ShownUnitShape>();
  private scores: ReadonlySet<string> = new Set();
  private readonly filledFrom = new Map<string, number>();
  private asked = "";
  private wanted: readonly string[] = [];
  private cancel: (() => void) | null = null;
  private asking: AbortController | null = null;
  private lengthUs: number;

  /**
   * @param changed called when a sample or a back-fill has come in
   * @param now this page's monotonic clock (ms)
   */
  constructor(
    readonly site: string,
    private readonly source: SampleSource,
    private readonly past: HistorySource,
    private readonly changed: () => void,
    lengthUs: number,
    private readonly now: () => number = () => performance.now(),
  ) {
    this.lengthUs = lengthUs;
  }

  /**
   * Listen to these signals and no others. What was heard of others is kept.
   *
   * @param scores channels of the scores of their anomaly detectors
   */
  subscribeSignals(signals: readonly SignalShape[], scores: readonly string[] = []): void {
    for (const signal of signals) for (const channel of signal.channels) this.ageLimits.set(channel, signal.max_age);
    for (const { type, shown, channels } of signals) if (type === "number" && shown !== null) for (const channel of channels) this.shown.set(channel, shown);
    for (const channel of scores) this.ageLimits.set(channel, WRITTEN_S);
    this.scores = new Set(scores);
    const wanted = [...signals.flatMap((signal) => signal.channels), ...scores];
    const key = wanted.join("\n");
    if (key === this.asked) return;
    this.asked = key;
    this.wanted = wanted;
    const before = this.cancel;
    // What is not listened to any more has a hole from now on.
    for (const address of this.filledFrom.keys()) if (!wanted.includes(address)) this.filledFrom.delete(address);
    this.cancel = wanted.length === 0 ? null : this.source.subscribe(this.site, wanted, EVERY_MS, this.batchListener());
    before?.();
  }

  close(): void {
    this.cancel?.();
    this.cancel = null;
    this.asked = "";
    this.asking?.abort();
    this.asking = null;
  }

  channelOf(address: string): FeedChannel {
    let channel = this.channels.get(address);
    if (channel === undefined) {
      const trace = new Trace(this.keptUs(address), (this.ageLimits.get(address) ?? 5) * SECOND_US);
      channel = { trace, gaps: [], text: null, timeUs: NaN, freshAtMs: NaN };
      this.channels.set(address, channel);
    }
    return channel;
  }

  /** Age of the newest sample (s); NaN before the first. */
  ageS(address: string): number {
    return (this.now() - (this.channels.get(address)?.freshAtMs ?? NaN)) / 1000;
  }

  /** The window that ends now, by the robot's clock. */
  readonly currentWindow = (nowMs: number): TimeSpan => {
    const toUs = this.edge.isKnown ? this.edge.nowUs(nowMs) : Date.now() * 1000;
    return { fromUs: toUs - this.lengthUs, toUs };
  };

  /** Show so much time (µs) from now on. */
  setLength(lengthUs: number): void {
    if (lengthUs === this.lengthUs) return;
    this.lengthUs = lengthUs;
    for (const [address, { trace }] of this.channels) trace.spanUs = this.keptUs(address);
    void this.loadHistory(false);
  }

  /** A tenth more is kept, so that the left edge of a chart never shows a sample dropping out. */
  private keptUs(address: string): number {
    return this.lengthUs * 1.1 + this.leadUs(address);
  }

  /** The history has a score that stays the same once a minute: the line begins with one from before the window. */
  private leadUs(address: string): number {
    return this.scores.has(address) ? WRITTEN_S * SECOND_US : 0;
  }

  /** A listener of its own for each subscription: its second first batch means a lost connection. */
  private batchListener(): (batch: Batch) => void {
    let begun = false;
    return (batch) => {
      this.receiveBatch(batch);
      // What came before is asked for: of new channels, or of all after a loss.
      if (batch.first) void this.loadHistory(begun);
      begun ||= batch.first;
    };
  }

  private receiveBatch(batch: Batch): void {
    const { channel: index, timeUs, value, texts, ageMs } = batch.columns;
    const now = this.now();
    for (let i = 0; i < index.length; i += 1) {
      const address = batch.channels[index[i] ?? -1];
      if (address === undefined) continue;
      const shown = toShown(this.shown.get(address) ?? null, value[i] ?? NaN);
      this.addSample(this.channelOf(address), timeUs[i] ?? NaN, shown, texts[i] ?? null, now, ageMs[i] ?? 0);
    }
    this.changed();
  }

  private addSample(held: FeedChannel, timeUs: number, value: number, text: string | null, now: number, ageMs: number): void {
    this.edge.observe(timeUs, now, ageMs);
    held.trace.addSample(timeUs, value);
    if (held.timeUs > timeUs) return;
    held.timeUs = timeUs;
    held.text = text;
    held.freshAtMs = now - ageMs;
  }

  private async loadHistory(again: boolean): Promise<void> {
    const span = this.currentWindow(this.now());
    const missing = this.wanted.filter((address) => again || (this.filledFrom.get(address) ?? Infinity) > span.fromUs);
    if (missing.length === 0) return;
    this.asking?.abort();
    const asking = new AbortController();
    this.asking = asking;
    this.backfill = "loading";
    try {
      for (const some of [missing.filter((address) => !this.scores.has(address)), missing.filter((address) => this.scores.has(address))]) {
        for (const group of channelGroups(some)) await this.loadHistoryOf(group, span, asking.signal);
      }
      this.backfill = "done";
    } catch {
      if (asking.signal.aborted) return;
      this.backfill = "failed";
    }
    this.changed();
  }

  private async loadHistoryOf(channels: readonly string[], span: TimeSpan, signal: AbortSignal): Promise<void> {
    const answer = await this.past.history(
      this.site,
      { channels, fromUs: span.fromUs - lengthOf(span) * 0.05 - this.leadUs(channels[0] ?? ""), toUs: span.toUs, width: BACKFILL_PX },
      signal,
    );
    for (const series of answer.series) {
      const { times, values, intervalUs } = samplesOf(series);
      const held = this.channelOf(series.address);
      const shown = this.shown.get(series.address) ?? null;
      held.trace.backfill(times, shown === null ? values : values.map((value) => toShown(shown, value)), intervalUs);
      held.gaps.splice(0, Infinity, ...series.gaps);
      this.filledFrom.set(series.address, span.fromUs);
    }
  }
}
