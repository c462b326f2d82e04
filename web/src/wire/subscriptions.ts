/** Which channels this page listens to, and under which number. No sockets here. */

import type { Subscribe, Unsubscribe, Values } from "../generated/wire.js";
import { columnsOf, type ValueColumns, type Sendable } from "./codec.js";

/** Samples of one subscription, with the list that `columns.channel` indexes. */
export interface Batch {
  readonly site: string;
  readonly channels: readonly string[];
  readonly columns: ValueColumns;
  /** True for the first batch after (re)subscribing: the last known sample of each channel. */
  readonly first: boolean;
}

export type BatchListener = (batch: Batch) => void;

interface SubscriptionEntry {
  readonly site: string;
  readonly channels: readonly string[];
  readonly everyMs: number;
  readonly listener: BatchListener;
  first: boolean;
  /** Whether the hub has taken it on this connection. */
  taken: boolean;
}

const NUMBERS = 65_536;

/**
 * Numbers are not used again until they wrap around, so that samples that are still under way for
 * an old list are never read with a new one.
 */
export class Subscriptions {
  private readonly entries = new Map<number, SubscriptionEntry>();
  private next = 0;

  add(site: string, channels: readonly string[], everyMs: number, listener: BatchListener): number {
    while (this.entries.has(this.next)) this.next = (this.next + 1) % NUMBERS;
    const sub = this.next;
    this.next = (this.next + 1) % NUMBERS;
    this.entries.set(sub, { site, channels: [...channels], everyMs, listener, first: true, taken: false });
    return sub;
  }

  remove(sub: number): Sendable<Unsubscribe> | null {
    return this.entries.delete(sub) ? { t: "unsubscribe", sub } : null;
  }

  /** What to send for one subscription; null when it is gone. */
  messageFor(sub: number): Sendable<Subscribe> | null {
    const entry = this.entries.get(sub);
    if (entry === undefined) return null;
    return { t: "subscribe", sub, site: entry.site, channels: entry.channels, every_ms: entry.everyMs };
  }

  /** Everything to send on a fresh connection. */
  restartMessages(): Sendable<Subscribe>[] {
    const messages: Sendable<Subscribe>[] = [];
    for (const [sub, entry] of this.entries) {
      entry.first = true;
      entry.taken = false;
      const message = this.messageFor(sub);
      if (message !== null) messages.push(message);
    }
    return messages;
  }

  /** The hub has answered. */
  markAccepted(sub: number): void {
    const entry = this.entries.get(sub);
    if (entry !== undefined) entry.taken = true;
  }

  /** What the hub has not taken yet. */
  pendingMessages(): Sendable<Subscribe>[] {
    return [...this.entries].flatMap(([sub, { taken }]) => (taken ? [] : (this.messageFor(sub) ?? [])));
  }

  /**
   * Hands samples to whoever asked for them; nobody when the subscription has just ended.
   *
   * @throws FrameError when the columns are not of one length
   */
  deliver(values: Values): void {
    const entry = this.entries.get(values.sub);
    if (entry === undefined) return;
    const first = entry.first;
    entry.first = false;
    entry.listener({ site: entry.site, channels: entry.channels, columns: columnsOf(values), first });
  }
}
