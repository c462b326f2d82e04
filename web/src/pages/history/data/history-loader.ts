/** Asks the hub for windows, and keeps what it has until the next has come. */

import { gapsOf } from "../../../series/gaps.js";
import { Trace } from "../../../series/trace.js";
import { lengthOf, type TimeSpan } from "../../../series/time-window.js";
import { SECOND_US } from "../../../series/zone-clock.js";
import { samplesOf } from "../../../state/past/history-samples.js";
import { toShown } from "../../../format/unit.js";
import type { GapShape, HistoryAnswer, SeriesShape, ShownUnitShape } from "../../../generated/api.js";
import type { HistoryQuery } from "../../../wire/hub-api.js";
import { LatestRequest, type RequestStatus } from "./latest-request.js";

export interface WindowSource {
  history(site: string, query: HistoryQuery, signal?: AbortSignal): Promise<HistoryAnswer>;
}

/** One channel as it was loaded. */
export interface LoadedSeries {
  readonly trace: Trace;
  readonly gaps: readonly GapShape[];
  readonly texts: readonly { readonly timeUs: number; readonly text: string }[];
  /** Every sample is there, and not the least and greatest of each pixel. */
  readonly exact: boolean;
  /** Samples or pairs of them in the answer. */
  readonly count: number;
}

export interface WindowQuestion {
  readonly site: string;
  /** Channels with their limits of age (s), and how their values are shown. */
  readonly channels: readonly { readonly address: string; readonly maxAge: number; readonly shown: ShownUnitShape | null }[];
  readonly span: TimeSpan;
  /** CSS pixels */
  readonly width: number;
}

/** So much more is asked for on each side, so that a small move has something to show at once. */
const MARGIN = 0.25;
const MOST = 200_000;
/** While the window moves, what is held does until it is this much coarser than the screen. */
const COARSE = 1.3;

export class HistoryLoader {
  /** What is there, by address. A new map with each answer. */
  data: ReadonlyMap<string, LoadedSeries> = new Map();
  private held: WindowQuestion | null = null;
  private readonly asker: LatestRequest<WindowQuestion, HistoryAnswer>;

  constructor(
    private readonly past: WindowSource,
    changed: () => void,
  ) {
    this.asker = new LatestRequest<WindowQuestion, HistoryAnswer>({
      fetch: (question, signal) => this.past.history(question.site, queryOf(question), signal),
      isStillUseful: (running, next) => sameChannels(running, next) && overlapPart(running.span, next.span),
      onAnswer: (answer, question) => {
        const asked = new Map(question.channels.map((channel) => [channel.address, channel]));
        this.data = new Map(
          answer.series.map((series) => {
            const channel = asked.get(series.address);
            return [series.address, loadedSeries(series, (channel?.maxAge ?? 0) * SECOND_US, channel?.shown ?? null)];
          }),
        );
        this.held = question;
      },
      onChange: changed,
    });
  }

  get state(): RequestStatus {
    return this.asker.state;
  }

  get renderError(): unknown {
    return this.asker.error;
  }

  /** Ask, unless this was the last question. @param moving what is held does for as long as it is fine enough */
  loadHistory(question: WindowQuestion, moving: boolean): void {
    if (question.channels.length === 0) {
      this.asker.cancelRequest("ready");
      this.data = new Map();
      this.held = null;
    } else if (!moving || this.held === null || !windowCovers(this.held, question)) {
      this.asker.request(question);
    }
  }

  /** The next `ask` asks, also when the question is the same. */
  invalidate(): void {
    this.asker.invalidate();
  }

  /** Forget what is held: the next site may have signals of the same names. */
  close(): void {
    this.asker.cancelRequest();
    this.data = new Map();
    this.held = null;
  }
}

function queryOf({ channels, span, width }: WindowQuestion): HistoryQuery {
  const { fromUs, toUs } = withMargin(span);
  return { channels: channels.map(({ address }) => address), fromUs, toUs, width: Math.ceil(width * (1 + 2 * MARGIN)) };
}

function withMargin(span: TimeSpan): TimeSpan {
  const more = lengthOf(span) * MARGIN;
  return { fromUs: span.fromUs - more, toUs: span.toUs + more };
}

function sameChannels(a: WindowQuestion, b: WindowQuestion): boolean {
  return a.site === b.site && a.channels.length === b.channels.length && a.channels.every(({ address }, i) => address === b.channels[i]?.address);
}

function overlapPart(a: TimeSpan, b: TimeSpan): boolean {
  return a.fromUs < b.toUs && b.fromUs < a.toUs;
}

function windowCovers(held: WindowQuestion, wanted: WindowQuestion): boolean {
  const { fromUs, toUs } = withMargin(held.span);
  const inside = wanted.span.fromUs >= fromUs && wanted.span.toUs <= toUs;
  const fine = lengthOf(held.span) / held.width <= (COARSE * lengthOf(wanted.span)) / wanted.width;
  return inside && fine && sameChannels(held, wanted);
}

/**
 * @param maxAgeUs the signal's limit of age (µs)
 * @param shown how its values are shown
 */
export function loadedSeries(series: SeriesShape, maxAgeUs: number, shown: ShownUnitShape | null = null): LoadedSeries {
  const { times, values, intervalUs } = samplesOf(series);
  const trace = new Trace(Infinity, maxAgeUs, MOST);
  trace.backfill(times, shown === null ? values : values.map((value) => toShown(shown, value)), intervalUs);
  const known = series.gaps;
  // A silence that the hub has a reason for is told once, with the reason.
  const silent = gapsOf(trace.times, trace.allowedUs).filter(
    (gap) => !known.some(({ from_us, to_us }) => from_us < gap.to_us && to_us > gap.from_us),
  );
  const texts = (series.text ?? []).flatMap((text, i) =>
    typeof series.v[i] === "number" ? [] : [{ timeUs: series.t_us[i] ?? NaN, text }],
  );
  return { trace, gaps: [...known, ...silent], texts, exact: series.kind === "exact", count: series.t_us.length };
}
