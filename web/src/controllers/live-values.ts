/** Ties live values to an element. */

import { ContextConsumer } from "@lit/context";
import type { ReactiveController, ReactiveControllerHost } from "lit";
import { liveContext, reachContext } from "../state/contexts.js";
import type { Reading, ReadingSource } from "../state/live-values.js";
import type { Reachability } from "../state/device-reachability.js";
import { ContextStoreController } from "./context-store.js";

/** How a value stands: nothing has come, it is fresh, older than its limit, or its device is not reached. */
export type Freshness = "unknown" | "live" | "stale" | "unreached";

/**
 * Watches channels while the element is on the page, draws it again when one changes and once a
 * second besides, so that a value that has stopped coming turns stale by itself.
 */
export class LiveValuesController implements ReactiveController {
  private live: ReadingSource | undefined;
  private readonly reach: ContextStoreController<Reachability>;
  private site = "";
  private channels: readonly string[] = [];
  private stops: (() => void)[] = [];
  private timer: ReturnType<typeof setInterval> | undefined;

  constructor(private readonly host: ReactiveControllerHost & HTMLElement) {
    host.addController(this);
    this.reach = new ContextStoreController(host, reachContext);
    new ContextConsumer(host, {
      context: liveContext,
      callback: (live) => {
        this.live = live;
        this.subscribeAll();
      },
    });
  }

  /** Says what to watch; call it from `willUpdate`. The same again changes nothing. */
  observeChannels(site: string, channels: readonly string[]): void {
    const same =
      site === this.site &&
      channels.length === this.channels.length &&
      channels.every((channel, i) => channel === this.channels[i]);
    if (same) return;
    this.site = site;
    this.channels = [...channels];
    this.unsubscribeAll();
    this.subscribeAll();
  }

  readingOf(channel: string): Reading | undefined {
    return this.live?.latestReading(this.site, channel);
  }

  /** What is read is of a past moment. */
  get isPast(): boolean {
    return this.live?.isPast === true;
  }

  /** Age of the newest reading (s); NaN when there is none. */
  ageS(channel: string): number {
    const reading = this.readingOf(channel);
    return reading === undefined || this.live === undefined ? Number.NaN : this.live.ageS(reading);
  }

  /** @param maxAge the signal's limit (s) */
  freshnessOf(channel: string, maxAge: number): Freshness {
    // What a device last said is not true any more, however young it is.
    if (this.reach.store?.unreachableSince(this.site, deviceOf(channel)) !== undefined) return "unreached";
    const age = this.ageS(channel);
    if (Number.isNaN(age)) return "unknown";
    return age > maxAge ? "stale" : "live";
  }

  hostConnected(): void {
    this.timer ??= setInterval(() => {
      this.host.requestUpdate();
    }, 1000);
    this.subscribeAll();
  }

  hostDisconnected(): void {
    clearInterval(this.timer);
    this.timer = undefined;
    this.unsubscribeAll();
  }

  private subscribeAll(): void {
    const live = this.live;
    if (live === undefined || this.stops.length > 0 || !this.host.isConnected) return;
    this.stops = this.channels.map((channel) =>
      live.watchChannel(this.site, channel, () => {
        this.host.requestUpdate();
      }),
    );
    this.host.requestUpdate();
  }

  private unsubscribeAll(): void {
    for (const stop of this.stops) stop();
    this.stops = [];
  }
}

/** The device of a channel's address. */
export function deviceOf(channel: string): string {
  return channel.slice(0, Math.max(0, channel.indexOf("/")));
}
