/** Asks the hub for windows, and keeps what it has until the next has come. */

import { silences, type Gap } from "../../series/gaps.js";
import { Trace } from "../../series/trace.js";
import { lengthOf, type Span } from "../../series/window.js";
import { SECOND_US } from "../../series/zone.js";
import { samplesOf } from "../../tiles/chart/past.js";
import type { History, HistorySeries } from "../../wire/api.js";
import type { HistoryQuery } from "../../wire/http.js";

export interface Past {
  history(site: string, query: HistoryQuery, signal?: AbortSignal): Promise<History>;
}

/** One channel as it was loaded. */
export interface Loaded {
  readonly trace: Trace;
  readonly gaps: readonly Gap[];
  readonly texts: readonly { readonly timeUs: number; readonly text: string }[];
  /** Samples or pairs of them in the answer. */
  readonly count: number;
}

export interface Question {
  readonly site: string;
  /** Channels with their limits of age (s). */
  readonly channels: readonly { readonly address: string; readonly maxAge: number }[];
  readonly span: Span;
  /** CSS pixels */
  readonly width: number;
}

export type LoaderState = "idle" | "loading" | "ready" | "failed";

/** So much more is asked for on each side, so that a small move has something to show at once. */
const MARGIN = 0.25;
const MOST = 200_000;

export class HistoryLoader {
  state: LoaderState = "idle";
  error: unknown = null;
  /** What is there, by address. A new map with each answer. */
  data: ReadonlyMap<string, Loaded> = new Map();
  private asked = "";
  private timer: ReturnType<typeof setTimeout> | undefined;
  private asking: AbortController | null = null;

  constructor(
    private readonly past: Past,
    private readonly changed: () => void,
  ) {}

  /** Ask, unless this was the last question. @param afterMs a newer question within this replaces it */
  ask(question: Question, afterMs: number): void {
    const key = JSON.stringify(question);
    if (key === this.asked) return;
    this.asked = key;
    clearTimeout(this.timer);
    if (question.channels.length === 0) {
      this.asking?.abort();
      this.become("ready", null, new Map());
      return;
    }
    this.timer = setTimeout(() => void this.load(question), afterMs);
  }

  /** The next `ask` asks, also when the question is the same. */
  forget(): void {
    this.asked = "";
  }

  close(): void {
    clearTimeout(this.timer);
    this.asking?.abort();
    this.asked = "";
  }

  private async load(question: Question): Promise<void> {
    this.asking?.abort();
    const asking = new AbortController();
    this.asking = asking;
    this.become("loading", null, this.data);
    const more = lengthOf(question.span) * MARGIN;
    try {
      const answer = await this.past.history(
        question.site,
        {
          channels: question.channels.map(({ address }) => address),
          fromUs: question.span.fromUs - more,
          toUs: question.span.toUs + more,
          width: Math.ceil(question.width * (1 + 2 * MARGIN)),
        },
        asking.signal,
      );
      const ages = new Map(question.channels.map(({ address, maxAge }) => [address, maxAge * SECOND_US]));
      this.become("ready", null, new Map(answer.series.map((one) => [one.address, loadedOf(one, ages.get(one.address) ?? 0)])));
    } catch (error) {
      if (!asking.signal.aborted) this.become("failed", error, this.data);
    }
  }

  private become(state: LoaderState, error: unknown, data: ReadonlyMap<string, Loaded>): void {
    this.state = state;
    this.error = error;
    this.data = data;
    this.changed();
  }
}

/** @param maxAgeUs the signal's limit of age (µs) */
export function loadedOf(series: HistorySeries, maxAgeUs: number): Loaded {
  const { times, values, intervalUs } = samplesOf(series);
  const trace = new Trace(Infinity, maxAgeUs, MOST);
  trace.backfill(times, values, intervalUs);
  const known = series.gaps;
  // A silence that the hub has a reason for is told once, with the reason.
  const silent = silences(trace.times, trace.allowedUs).filter(
    (gap) => !known.some(({ from_us, to_us }) => from_us < gap.to_us && to_us > gap.from_us),
  );
  const texts = (series.text ?? []).flatMap((text, i) =>
    typeof series.v[i] === "number" ? [] : [{ timeUs: series.t_us[i] ?? NaN, text }],
  );
  return { trace, gaps: [...known, ...silent], texts, count: series.t_us.length };
}
