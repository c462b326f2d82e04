/** What was recorded, in stretches of equal length that are asked for once and kept while they are of use. */

import type { HistoryAnswer, SeriesShape, ValueList, ValueShape } from "../../generated/api.js";
import type { HistoryQuery } from "../../wire/hub-api.js";
import { firstIndexFrom } from "../../series/binary-search.js";
import { channelGroups } from "./channel-groups.js";

/** What is asked of the hub. */
export interface PastSource {
  history(site: string, query: HistoryQuery, signal?: AbortSignal): Promise<HistoryAnswer>;
  /** The last sample of each channel before a moment. */
  lastValues(site: string, channels: readonly string[], beforeUs: number, signal?: AbortSignal): Promise<ValueList>;
}

/** One channel in one stretch. */
export interface PastColumn {
  readonly series: SeriesShape;
  /** The last sample before the stretch; null for none, or where nobody needs it. */
  readonly before: ValueShape | null;
}

/**
 * How long a stretch is (µs), for how many pixels it is asked, how many that follow one another are asked for
 * `together` in one question, and whether what came before it counts (then each is asked for alone).
 */
export interface ChunkForm {
  readonly lengthUs: number;
  readonly width: number;
  readonly together: number;
  readonly withLast: boolean;
}

interface Chunk {
  readonly columns: Map<string, PastColumn>;
  /** Being asked for. */
  readonly asked: Set<string>;
  /** Later samples may have come in since it was asked for (µs). */
  untilUs: number;
}

/** Stretches that follow one another. */
interface Run {
  readonly first: number;
  count: number;
  readonly channels: readonly string[];
}

/** Questions that run at a time: who scrubs wants the last one, not all between. */
const MOST_RUNNING = 2;
/** Stretches that are kept, for each that is asked for together. */
const MOST_KEPT = 16;

export class PastChunks {
  /** Why the newest question was not answered; null while all are. */
  failure: unknown = null;
  /** Counts up with each answer. */
  version = 0;
  private readonly chunks = new Map<number, Chunk>();
  private wanted: readonly string[] = [];
  private running = 0;
  private readonly ending = new AbortController();

  /**
   * @param changed an answer has come, or none will
   * @param nowUs what time it is (µs): nothing later is asked for
   */
  constructor(
    private readonly site: string,
    private readonly source: PastSource,
    readonly form: ChunkForm,
    private readonly changed: () => void,
    private readonly nowUs: () => number,
  ) {}

  wantChannels(channels: readonly string[]): void {
    this.wanted = [...new Set(channels)].sort();
  }

  /**
   * Asks for what of a stretch is not known; what is too much at once waits for the next call.
   *
   * @param most questions that may run at a time
   */
  load(fromUs: number, toUs: number, most = MOST_RUNNING): void {
    if (this.failure !== null) return;
    const untilUs = Math.min(toUs, this.nowUs());
    for (const { first, count, channels } of this.missingRuns(fromUs, untilUs)) {
      if (this.running >= most) return;
      void this.askFor(first, count, channels);
    }
  }

  /** Everything wanted of a stretch is known, as far as time has come. */
  isReady(fromUs: number, toUs: number): boolean {
    const untilUs = Math.min(toUs, this.nowUs());
    for (let i = this.indexOf(fromUs); i <= this.indexOf(untilUs); i += 1) {
      const chunk = this.chunks.get(i);
      if (this.wanted.length > 0 && (chunk === undefined || this.wanted.some((channel) => !chunk.columns.has(channel)))) return false;
    }
    return true;
  }

  columnAt(channel: string, us: number): PastColumn | undefined {
    return this.chunks.get(this.indexOf(us))?.columns.get(channel);
  }

  /** In order of time; only those that are known. */
  columnsOf(channel: string, fromUs: number, toUs: number): readonly PastColumn[] {
    const found: PastColumn[] = [];
    for (let i = this.indexOf(fromUs); i <= this.indexOf(toUs); i += 1) {
      const column = this.chunks.get(i)?.columns.get(channel);
      if (column !== undefined) found.push(column);
    }
    return found;
  }

  /** After a failure: ask once more. */
  retry(): void {
    this.failure = null;
  }

  close(): void {
    this.ending.abort();
    this.chunks.clear();
  }

  private indexOf(us: number): number {
    return Math.floor(us / this.form.lengthUs);
  }

  /** What is not known, as stretches that follow one another and lack the same channels. */
  private missingRuns(fromUs: number, untilUs: number): Run[] {
    const { lengthUs, together } = this.form;
    const runs: Run[] = [];
    for (let index = this.indexOf(fromUs); index <= this.indexOf(untilUs); index += 1) {
      const chunk = this.chunks.get(index);
      if (chunk !== undefined) this.markUsed(index, chunk);
      const grown = chunk !== undefined && chunk.untilUs < Math.min((index + 1) * lengthUs, untilUs);
      const channels = this.wanted.filter((channel) => (grown || chunk?.columns.has(channel) !== true) && chunk?.asked.has(channel) !== true);
      if (channels.length === 0) continue;
      const last = runs.at(-1);
      if (last !== undefined && last.first + last.count === index && last.count < together && last.channels.join("\n") === channels.join("\n")) last.count += 1;
      else runs.push({ first: index, count: 1, channels });
    }
    return runs;
  }

  /** The one used longest ago stands first, and goes first. */
  private markUsed(index: number, chunk: Chunk): void {
    this.chunks.delete(index);
    this.chunks.set(index, chunk);
    for (const oldest of this.chunks.keys()) {
      if (this.chunks.size <= MOST_KEPT * this.form.together) return;
      this.chunks.delete(oldest);
    }
  }

  private async askFor(first: number, count: number, channels: readonly string[]): Promise<void> {
    const askedUs = this.nowUs();
    const asked = Array.from({ length: count }, (_, i) => {
      const chunk = this.chunks.get(first + i) ?? { columns: new Map(), asked: new Set(), untilUs: 0 };
      this.markUsed(first + i, chunk);
      for (const channel of channels) chunk.asked.add(channel);
      return chunk;
    });
    this.running += 1;
    try {
      for (const group of channelGroups(channels)) await this.askSome(asked, first, group);
      for (const chunk of asked) chunk.untilUs = askedUs;
    } catch (error) {
      if (!this.ending.signal.aborted) this.failure = error;
    }
    this.running -= 1;
    for (const chunk of asked) for (const channel of channels) chunk.asked.delete(channel);
    if (this.ending.signal.aborted) return;
    this.version += 1;
    this.changed();
  }

  private async askSome(chunks: readonly Chunk[], first: number, channels: readonly string[]): Promise<void> {
    const { lengthUs, width, withLast } = this.form;
    const fromUs = first * lengthUs;
    const count = chunks.length;
    const { signal } = this.ending;
    const [{ series }, { values }] = await Promise.all([
      this.source.history(this.site, { channels, fromUs, toUs: fromUs + count * lengthUs, width: count * width }, signal),
      withLast ? this.source.lastValues(this.site, channels, fromUs, signal) : Promise.resolve<ValueList>({ values: [] }),
    ]);
    for (const channel of series) {
      const before = values.find(({ address }) => address === channel.address) ?? null;
      chunks.forEach((chunk, i) => {
        const cut = count === 1 ? channel : cutSeries(channel, fromUs + i * lengthUs, i + 1 === count ? Infinity : fromUs + (i + 1) * lengthUs);
        chunk.columns.set(channel.address, { series: cut, before });
      });
    }
  }
}

/** A part of a series, from one moment up to another (µs), without that. */
function cutSeries(series: SeriesShape, fromUs: number, toUs: number): SeriesShape {
  const [from, to] = [firstIndexFrom(series.t_us, fromUs), firstIndexFrom(series.t_us, toUs)];
  return {
    ...series,
    t_us: series.t_us.slice(from, to),
    v: series.v.slice(from, to),
    ...(series.text == null ? {} : { text: series.text.slice(from, to) }),
    gaps: series.gaps.filter((gap) => gap.from_us < toUs && gap.to_us >= fromUs),
  };
}
