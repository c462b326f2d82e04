/**
 * A board's past: the moment that all of its tiles show, how it moves, and what was recorded around it.
 *
 * It is told the time by whoever owns it: `tick` is called for each picture.
 *
 * Long, because all that follows the moment has to agree about it: what is asked for, told and held back.
 */

import { SECOND_US } from "../../series/zone-clock.js";
import type { Batch, BatchListener } from "../../wire/subscriptions.js";
import type { Reading } from "../live-values.js";
import { Store } from "../store.js";
import type { PastSource } from "./past-chunks.js";
import { PastFeed } from "./past-feed.js";
import { PastTopics, type PastTopicSource } from "./past-topics.js";
import { PastValues } from "./past-values.js";
import { Playhead } from "./playhead.js";

export const PAST_SPEEDS: readonly number[] = [1, 2, 5, 10];
/** Playing, tiles are drawn anew this often (ms): more than an eye reads. */
const EVERY_MS = 100;
/** So long after the last jump the moment counts as settled (ms). */
const SETTLED_MS = 150;
/** So long after a jump (ms) nothing is drawn but what is known whole: it would be drawn twice. */
const BLINK_MS = 300;
/** So much play time (s) is asked for ahead of the moment. */
const AHEAD_S = 8;
/** Without any sample for so long (µs), the board says that nothing was recorded. */
const SILENT_US = 60 * SECOND_US;
/** A sample takes up to this long from the robot into the history (µs). */
const LATE_US = 2 * SECOND_US;

export type PastState = "ready" | "loading" | "failed" | "silent";

/** What time it is: by a clock that only goes forward (ms), and by the world's (µs). */
export interface PastTime {
  nowMs(): number;
  wallUs(): number;
}

const BROWSER_TIME: PastTime = { nowMs: () => performance.now(), wallUs: () => Date.now() * 1000 };

/** Recordings that nobody can ask: of a board in a test, or without a hub. */
const NO_RECORDINGS: PastTopicSource = {
  moment: () => Promise.resolve({ topics: [], earlier_us: null, later_us: null, problems: [] }),
  trees: (_site, _wishes, _fromUs, untilUs) => Promise.resolve({ topics: [], messages: [], untilUs }),
  bytes: (_site, _wishes, _points, _fromUs, untilUs) => Promise.resolve({ topics: [], messages: [], untilUs }),
};
/** Stretches of recordings weigh more than samples: so much play time (s) is asked for ahead, and so much time at the most (s). */
const TOPICS_AHEAD_S = 2;
const MOST_TOPICS_AHEAD_S = 12;
/** Questions of a kind while a hand moves the moment about: the last place waits behind what is under way for those before. */
const MOST_WHILE_DRAGGED = 1;

interface Replay {
  readonly site: string;
  readonly channels: readonly string[];
  readonly listener: BatchListener;
  /** Told up to here (µs); NaN before the first time. */
  toldUs: number;
}

export class PastBoard extends Store {
  readonly values: PastValues;
  readonly feed: PastFeed;
  /** Raw topics, as recordings hold them. */
  readonly topics: PastTopics;
  private readonly head = new Playhead();
  private readonly replays = new Set<Replay>();
  private jumped = 0;
  private jumpedMs: number;
  private toldJumps = -1;
  private tickedMs = -Infinity;
  private loadSoon = false;
  private wasSettled = false;
  private wasBlink = false;
  private dragged = false;
  private ended = false;
  private closed = false;

  constructor(
    readonly site: string,
    source: PastSource,
    atUs: number,
    private readonly time: PastTime = BROWSER_TIME,
    recordings: PastTopicSource = NO_RECORDINGS,
  ) {
    super();
    const us = (): number => this.us;
    const nowUs = (): number => this.endUs;
    const changed = (): void => {
      this.onAnswer();
    };
    const wish = (): void => {
      this.askSoon();
    };
    this.values = new PastValues(site, source, us, wish, changed, nowUs);
    this.feed = new PastFeed(site, source, us, () => this.jumped, wish, nowUs);
    this.topics = new PastTopics(site, recordings, us, wish);
    this.jumpedMs = time.nowMs();
    this.head.seek(Math.min(atUs, this.endUs), time.nowMs());
    this.ended = atUs >= this.endUs;
  }

  /** The moment that is shown (µs since the epoch, UTC); never later than now. */
  get us(): number {
    return Math.min(this.head.timeUs(this.time.nowMs()), this.endUs);
  }

  /** The moment as a clock that ages are counted by (ms). */
  readonly nowMs = (): number => this.us / 1000;

  /** The newest moment that can be shown (µs): what is later may still be on its way to the history. */
  get endUs(): number {
    return this.time.wallUs() - LATE_US;
  }

  get playing(): boolean {
    return this.head.playing;
  }

  get speed(): number {
    return this.head.speed;
  }

  /** The moment has come up to the newest: there is nothing to play. */
  get isAtEnd(): boolean {
    return this.ended;
  }

  /** Counts the times that the moment was put elsewhere. */
  get jumps(): number {
    return this.jumped;
  }

  /** Nobody is just moving it about. */
  get isSettled(): boolean {
    return this.time.nowMs() - this.jumpedMs >= SETTLED_MS;
  }

  /** For a blink after a jump charts keep their picture, and are drawn once: with what has come by then. */
  get holdsCharts(): boolean {
    return this.isBlink && !this.feed.isReady;
  }

  /** A jump was a moment ago, and no hand goes on: nothing has to be drawn that is about to be drawn anew. */
  private get isBlink(): boolean {
    return !this.dragged && this.time.nowMs() - this.jumpedMs < BLINK_MS;
  }

  get state(): PastState {
    const { us, values, feed } = this;
    if (values.failure !== null || feed.failure !== null) return "failed";
    if (!values.isReady(us) || !feed.isReady) return "loading";
    return values.watchesAny && !(us - values.newestUs() <= SILENT_US) ? "silent" : "ready";
  }

  /** Why the hub gave nothing; null while it does. */
  get failure(): unknown {
    return this.values.failure ?? this.feed.failure;
  }

  play(): void {
    if (this.ended) return;
    this.head.play(this.time.nowMs());
    this.update();
  }

  pause(): void {
    this.head.seek(this.us, this.time.nowMs());
    this.head.pause(this.time.nowMs());
    this.update();
  }

  /** @param us later than now is now */
  seek(us: number): void {
    const { endUs } = this;
    this.values.retry();
    this.feed.retry();
    this.topics.retry();
    this.jumpTo(Math.max(0, Math.min(us, endUs)));
    this.ended = us >= endUs;
    if (this.ended && this.playing) this.pause();
    this.update();
  }

  step(byUs: number): void {
    if (this.playing) this.pause();
    this.seek(this.us + byUs);
  }

  setSpeed(speed: number): void {
    this.head.setSpeed(speed, this.time.nowMs());
    this.update();
  }

  retry(): void {
    this.values.retry();
    this.feed.retry();
    this.topics.retry();
    this.update();
  }

  /** Moves on to the time that it is. */
  tick(): void {
    const now = this.time.nowMs();
    const settles = (this.isSettled && !this.wasSettled) || (this.wasBlink && !this.isBlink);
    this.wasSettled = this.isSettled;
    this.wasBlink = this.isBlink;
    if (!this.playing) {
      if (settles) this.update();
      return;
    }
    if (this.head.timeUs(now) >= this.endUs) {
      this.ended = true;
      this.pause();
      return;
    }
    if (now - this.tickedMs >= EVERY_MS || settles) this.update();
  }


  /** @param listener hears the last sample of each channel first, then each one that the moment comes to */
  replayChannels(site: string, channels: readonly string[], listener: BatchListener): () => void {
    const replay: Replay = { site, channels, listener, toldUs: Number.NaN };
    this.replays.add(replay);
    const stops = channels.map((channel) => this.values.watchChannel(site, channel, () => undefined));
    this.tellReplay(replay);
    return () => {
      this.replays.delete(replay);
      for (const stop of stops) stop();
    };
  }

  close(): void {
    this.closed = true;
    this.values.close();
    this.feed.close();
    this.topics.close();
    this.replays.clear();
  }

  private jumpTo(us: number): void {
    const now = this.time.nowMs();
    this.dragged = this.jumped > 0 && !this.isSettled;
    this.head.seek(us, now);
    this.jumped += 1;
    this.jumpedMs = now;
    this.wasSettled = false;
    this.wasBlink = this.isBlink;
    for (const replay of this.replays) replay.toldUs = Number.NaN;
  }

  private onAnswer(): void {
    if (!this.closed) this.update();
  }

  /** A board that is drawn asks for many channels at once: ask the hub once, afterwards. */
  private askSoon(): void {
    if (this.loadSoon || this.closed) return;
    this.loadSoon = true;
    queueMicrotask(() => {
      this.loadSoon = false;
      if (!this.closed) this.update();
    });
  }

  private update(): void {
    this.tickedMs = this.time.nowMs();
    this.load();
    const us = this.us;
    // The moment waits for what is to be shown: nothing is drawn that was not so.
    this.head.setWaiting(this.playing && !(this.values.chunks.isReady(us, us) && this.topics.isReady(us)), this.time.nowMs());
    for (const replay of this.replays) this.tellReplay(replay);
    this.topics.advance(this.toldJumps !== this.jumped);
    this.toldJumps = this.jumped;
    if (!this.isBlink || this.values.isReady(us)) this.values.notifyWatchers();
    this.notifyWatchers();
  }

  private load(): void {
    const { us } = this;
    const aheadUs = this.playing ? AHEAD_S * SECOND_US * this.speed : 0;
    const most = this.dragged && !this.isSettled ? MOST_WHILE_DRAGGED : undefined;
    // The moment first, and all samples around it once it is shown: who jumps about needs none of them.
    if (!this.playing && !this.values.isReady(us)) this.values.moment.load(us, most);
    else if (this.playing || (this.isSettled && this.isShown(us))) this.values.chunks.load(us, us, most);
    this.feed.load(0, most);
    this.topics.load(this.playing ? Math.min(MOST_TOPICS_AHEAD_S, TOPICS_AHEAD_S * this.speed) * SECOND_US : 0, most);
    if (aheadUs === 0) return;
    this.values.chunks.load(us, us + aheadUs);
    this.feed.load(aheadUs);
  }

  /** All that stands on the board at the moment is known. */
  private isShown(us: number): boolean {
    return this.values.isReady(us) && this.feed.isReady && this.topics.isReady(us);
  }

  private tellReplay(replay: Replay): void {
    const { us } = this;
    const { site, channels, listener, toldUs } = replay;
    const first = Number.isNaN(toldUs) || us < toldUs;
    if (first ? !this.values.isReady(us) : !this.values.chunks.isReady(us, us)) return;
    const found = channels.flatMap((channel, index) => {
      const latest = this.values.latestReading(site, channel);
      const readings = first ? (latest === undefined ? [] : [latest]) : this.values.readingsBetween(channel, toldUs, us);
      return readings.map((reading) => ({ index, reading }));
    });
    replay.toldUs = us;
    if (found.length > 0) listener(batchOf(site, channels, found, us, first));
  }
}

function batchOf(site: string, channels: readonly string[], found: readonly { readonly index: number; readonly reading: Reading }[], us: number, first: boolean): Batch {
  const sorted = [...found].sort((a, b) => a.reading.timeUs - b.reading.timeUs);
  return {
    site, channels, first,
    columns: {
      channel: Uint16Array.from(sorted, ({ index }) => index),
      timeUs: Float64Array.from(sorted, ({ reading }) => reading.timeUs),
      value: Float64Array.from(sorted, ({ reading }) => reading.value),
      texts: Object.fromEntries(sorted.flatMap(({ reading: { text } }, i) => (text === null ? [] : [[i, text]]))),
      ageMs: sorted.map(({ reading }) => Math.max(0, us - reading.timeUs) / 1000),
    },
  };
}
