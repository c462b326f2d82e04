/** What the shown window amounts to, of every sample in it, as the hub counts it. */

import type { StatisticsList, StatisticsShape } from "../../../generated/api.js";
import { lengthOf, type TimeSpan } from "../../../series/time-window.js";
import { LatestRequest } from "./latest-request.js";

export interface StatisticsSource {
  statistics(site: string, channels: readonly string[], span: TimeSpan, signal?: AbortSignal): Promise<StatisticsList>;
}

interface StatisticsQuestion {
  readonly site: string;
  readonly channels: readonly string[];
  readonly span: TimeSpan;
}

/** A window that follows is counted again once it has moved by this part of itself. */
const STEP = 0.01;
/** Numbers of a window that is this much another are not shown. */
const NEAR = 0.05;

export class StatisticsLoader {
  private found: ReadonlyMap<string, StatisticsShape> = new Map();
  private of: StatisticsQuestion | null = null;
  private asked: StatisticsQuestion | null = null;
  private readonly asker: LatestRequest<StatisticsQuestion, StatisticsList>;

  constructor(counting: StatisticsSource, changed: () => void) {
    this.asker = new LatestRequest<StatisticsQuestion, StatisticsList>({
      fetch: ({ site, channels, span }, signal) => counting.statistics(site, channels, span, signal),
      isStillUseful: (running, next) => running.site === next.site,
      onAnswer: (list, question) => {
        this.found = new Map(list.statistics.map((statistics) => [statistics.address, statistics]));
        this.of = question;
      },
      onChange: changed,
    });
  }

  /** @param following the window goes with the time: it is not counted at each step */
  loadStatistics(site: string, channels: readonly string[], span: TimeSpan, following: boolean): void {
    const question = { site, channels, span: { fromUs: Math.round(span.fromUs), toUs: Math.round(span.toUs) } };
    const before = this.asked;
    const same = before !== null && before.site === site && before.channels.join("\n") === channels.join("\n");
    if (same && following && windowDistance(before.span, span) < STEP) return;
    this.asked = question;
    if (channels.length === 0) this.asker.cancelRequest("ready");
    else this.asker.request(question);
  }

  /** The numbers of a window, as far as they are known of this one or one that is hardly another. */
  numbersOf(site: string, span: TimeSpan): ReadonlyMap<string, StatisticsShape> {
    const known = this.of !== null && this.of.site === site && windowDistance(this.of.span, span) < NEAR;
    return known ? this.found : NONE;
  }

  close(): void {
    this.asker.cancelRequest();
    this.of = null;
    this.asked = null;
  }
}

const NONE: ReadonlyMap<string, StatisticsShape> = new Map();

/** How far the ends of two windows are from each other, as a part of the second. */
export function windowDistance(a: TimeSpan, b: TimeSpan): number {
  return Math.max(Math.abs(a.fromUs - b.fromUs), Math.abs(a.toUs - b.toUs)) / lengthOf(b);
}
