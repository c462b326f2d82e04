/**
 * The last value of every signal at one moment: less to find and to send than all samples around it, which are
 * needed only once somebody plays on from there.
 */

import type { ValueShape } from "../../generated/api.js";
import { channelGroups } from "./channel-groups.js";
import type { PastSource } from "./past-chunks.js";

/** Questions that run at a time: who scrubs wants the last moment, not all between. */
const MOST_RUNNING = 2;

export class PastMoment {
  /** Why the newest question was not answered; null while all are. */
  failure: unknown = null;
  private wanted: readonly string[] = [];
  /** Which moment (µs), for which channels, and what the hub said of them; null where it has none. */
  private known: { readonly us: number; readonly values: ReadonlyMap<string, ValueShape | null> } | null = null;
  /** Moments that are being asked for, each with its channels. */
  private readonly asked = new Map<number, ReadonlySet<string>>();
  private readonly ending = new AbortController();

  /** @param changed an answer has come, or none will */
  constructor(
    private readonly site: string,
    private readonly source: PastSource,
    private readonly changed: () => void,
  ) {}

  wantChannels(channels: readonly string[]): void {
    this.wanted = channels;
  }

  isKnown(us: number): boolean {
    const { known } = this;
    return known?.us === us && this.wanted.every((channel) => known.values.has(channel));
  }

  /** What a channel last was; undefined for nothing, or while it is not known. */
  valueAt(channel: string, us: number): ValueShape | undefined {
    return this.known?.us === us ? (this.known.values.get(channel) ?? undefined) : undefined;
  }

  /** @param most questions that may run at a time */
  load(us: number, most = MOST_RUNNING): void {
    if (this.failure !== null || this.isKnown(us) || this.asked.size >= most) return;
    // Whole: a value that is known already may be of another moment.
    const asked = this.asked.get(us);
    if (asked !== undefined && this.wanted.every((channel) => asked.has(channel))) return;
    void this.askFor(us, this.wanted);
  }

  retry(): void {
    this.failure = null;
  }

  close(): void {
    this.ending.abort();
    this.known = null;
  }

  private async askFor(us: number, channels: readonly string[]): Promise<void> {
    this.asked.set(us, new Set(channels));
    const values = new Map<string, ValueShape | null>(channels.map((channel) => [channel, null]));
    try {
      // "Before" leaves the moment itself out.
      const before = Math.floor(us) + 1;
      const answers = await Promise.all(channelGroups(channels).map((group) => this.source.lastValues(this.site, group, before, this.ending.signal)));
      for (const answer of answers) for (const value of answer.values) values.set(value.address, value);
      if (!this.ending.signal.aborted) this.known = { us, values };
    } catch (error) {
      if (!this.ending.signal.aborted) this.failure = error;
    }
    this.asked.delete(us);
    if (!this.ending.signal.aborted) this.changed();
  }
}
