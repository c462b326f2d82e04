/** All that is loaded for the window that is shown: samples, those of another day, events, statistics. */

import { msg } from "@lit/localize";
import type { EventList } from "../../../generated/api.js";
import { panned } from "../../../series/time-window.js";
import { EventsLoader, type EventsSource } from "./events-loader.js";
import { HistoryLoader, type LoadedSeries, type WindowSource, type WindowQuestion } from "./history-loader.js";
import { OutliersLoader, type OutliersSource } from "./outliers-loader.js";
import { StatisticsLoader, type StatisticsSource } from "./statistics-loader.js";

export interface WantedWindow extends WindowQuestion {
  /** The other day lies so much before (µs); 0 for none. */
  readonly ghostUs: number;
  /** Fingers or the wheel are at the window. */
  readonly moving: boolean;
  /** The window goes with the time. */
  readonly following: boolean;
  /** Outliers are wanted beyond so many times the distance of the quartiles; 0 for none. */
  readonly outliers: number;
}

export class WindowData {
  readonly now: HistoryLoader;
  private readonly then: HistoryLoader;
  private readonly happened: EventsLoader;
  readonly statistics: StatisticsLoader;
  /** Of the other day, or the other run. */
  readonly ghostStatistics: StatisticsLoader;
  readonly outliers: OutliersLoader;

  constructor(api: WindowSource & EventsSource & StatisticsSource & OutliersSource, changed: () => void) {
    this.now = new HistoryLoader(api, changed);
    this.then = new HistoryLoader(api, changed);
    this.happened = new EventsLoader(api, changed);
    this.statistics = new StatisticsLoader(api, changed);
    this.ghostStatistics = new StatisticsLoader(api, changed);
    this.outliers = new OutliersLoader(api, changed);
  }

  get ghost(): ReadonlyMap<string, LoadedSeries> {
    return this.then.data;
  }

  get events(): EventList {
    return this.happened.list;
  }

  /** What happened, or what was on the other day, could not be loaded. */
  get missingText(): string {
    if (this.then.state === "failed") return msg("The other day cannot be loaded now.");
    return this.happened.failed ? msg("What happened cannot be loaded now.") : "";
  }

  loadWindow({ ghostUs, moving, following, outliers, ...question }: WantedWindow): void {
    const { site, channels, span } = question;
    this.now.loadHistory(question, moving);
    if (ghostUs !== 0) this.then.loadHistory({ ...question, span: panned(span, -ghostUs) }, moving);
    else if (this.then.data.size > 0) this.then.close();
    this.happened.loadEvents(site, span);
    // Lines first: a day's statistics cost the hub as much as its chart, and the eye waits for the chart.
    if (moving || this.now.state !== "ready") return;
    const addresses = channels.map(({ address }) => address);
    this.statistics.loadStatistics(site, addresses, span, following);
    this.ghostStatistics.loadStatistics(site, ghostUs === 0 ? [] : addresses, panned(span, -ghostUs), following);
    // Where the chart holds every sample it counts by itself.
    const thinned = addresses.filter((address) => this.now.data.get(address)?.exact === false);
    this.outliers.loadOutliers(site, thinned, span, outliers, following);
  }

  /** The next `ask` asks, also when the question is the same. */
  invalidate(): void {
    this.now.invalidate();
    this.then.invalidate();
  }

  close(): void {
    for (const loader of [this.now, this.then, this.happened, this.statistics, this.ghostStatistics, this.outliers]) loader.close();
  }
}
