/** The newest value of each channel that somebody on this page looks at. */

import type { Batch } from "../wire/subscriptions.js";

export interface Reading {
  /** When the robot took it: µs since the epoch, UTC. */
  readonly timeUs: number;
  /** NaN when it is a text. */
  readonly value: number;
  readonly text: string | null;
  /** This page's monotonic clock (ms) at the moment when the reading was fresh. */
  readonly freshAtMs: number;
}

/** Where elements read values: what comes now, or what was at a past moment. */
export interface ReadingSource {
  /** Its readings are of a past moment, and their age is that of then. */
  readonly isPast?: boolean;
  latestReading(site: string, channel: string): Reading | undefined;
  /** Age of a reading (s). */
  ageS(reading: Reading): number;
  /** Calls `watcher` after each new reading of a channel. Returns the way to end it. */
  watchChannel(site: string, channel: string, watcher: () => void): () => void;
}

/** What the store needs of a connection. */
export interface LiveFeed {
  subscribe(
    site: string,
    channels: readonly string[],
    everyMs: number,
    listener: (batch: Batch) => void,
  ): () => void;
}

interface ChannelGroup {
  readonly wanted: Map<string, number>;
  asked: readonly string[];
  cancel: (() => void) | null;
  scheduled: boolean;
}

/**
 * Collects what the elements of a page want into one subscription for each site. Values come five
 * times a second: more than an eye reads. Charts subscribe by themselves.
 */
export class LiveValues implements ReadingSource {
  private readonly groups = new Map<string, ChannelGroup>();
  private readonly readings = new Map<string, Reading>();
  private readonly watchers = new Map<string, Set<() => void>>();

  constructor(
    private readonly feed: LiveFeed,
    private readonly now: () => number = () => performance.now(),
    private readonly everyMs = 200,
  ) {}

  /** The newest reading, also when nobody watches any more. */
  latestReading(site: string, channel: string): Reading | undefined {
    return this.readings.get(channelKey(site, channel));
  }

  /** Age of a reading (s). */
  ageS(reading: Reading): number {
    return (this.now() - reading.freshAtMs) / 1000;
  }

  /** Calls `watcher` after each new reading of a channel. Returns the way to end it. */
  watchChannel(site: string, channel: string, watcher: () => void): () => void {
    const id = channelKey(site, channel);
    const watchers = this.watchers.get(id) ?? new Set();
    this.watchers.set(id, watchers);
    const notifyWatcher = (): void => {
      watcher();
    };
    watchers.add(notifyWatcher);
    this.changeInterest(site, channel, 1);
    return () => {
      if (!watchers.delete(notifyWatcher)) return;
      if (watchers.size === 0) this.watchers.delete(id);
      this.changeInterest(site, channel, -1);
    };
  }

  /** All readings are older than this page's clock says: it stood still for so long (ms). */
  addAge(ms: number): void {
    for (const [id, reading] of this.readings) {
      this.readings.set(id, { ...reading, freshAtMs: reading.freshAtMs - ms });
      for (const watcher of [...(this.watchers.get(id) ?? [])]) watcher();
    }
  }

  /** Forgets all readings: another person may see other things. */
  clear(): void {
    this.readings.clear();
  }

  private changeInterest(site: string, channel: string, change: 1 | -1): void {
    const fresh: ChannelGroup = { wanted: new Map<string, number>(), asked: [], cancel: null, scheduled: false };
    const group = this.groups.get(site) ?? fresh;
    this.groups.set(site, group);
    const count = (group.wanted.get(channel) ?? 0) + change;
    if (count > 0) group.wanted.set(channel, count);
    else group.wanted.delete(channel);
    if (group.scheduled) return;
    group.scheduled = true;
    // A page that is drawn or left changes many, one after the other in microtasks: ask once, after all of these.
    setTimeout(() => {
      group.scheduled = false;
      this.subscribeGroup(site, group);
    }, 0);
  }

  private subscribeGroup(site: string, group: ChannelGroup): void {
    const channels = [...group.wanted.keys()].sort();
    if (channels.length === group.asked.length && channels.every((name, i) => name === group.asked[i])) return;
    const before = group.cancel;
    group.asked = channels;
    group.cancel =
      channels.length === 0
        ? null
        : this.feed.subscribe(site, channels, this.everyMs, (batch) => {
            this.receiveBatch(batch);
          });
    before?.();
  }

  private receiveBatch(batch: Batch): void {
    const { channel, timeUs, value, texts, ageMs } = batch.columns;
    const touched = new Set<string>();
    for (let i = 0; i < channel.length; i++) {
      const address = batch.channels[channel[i] ?? -1];
      if (address === undefined) continue;
      const id = channelKey(batch.site, address);
      const time = timeUs[i] ?? 0;
      const held = this.readings.get(id);
      if (held !== undefined && held.timeUs > time) continue;
      this.readings.set(id, {
        timeUs: time,
        value: value[i] ?? Number.NaN,
        text: texts[i] ?? null,
        freshAtMs: this.now() - (ageMs[i] ?? 0),
      });
      touched.add(id);
    }
    for (const id of touched) {
      for (const watcher of [...(this.watchers.get(id) ?? [])]) watcher();
    }
  }
}

function channelKey(site: string, channel: string): string {
  return `${site}\n${channel}`;
}
