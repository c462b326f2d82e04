/**
 * One signal, live: name, large value, how fresh it is, its chart, and what watches it.
 *
 * Long, because chart and strips below it share one window, one pause and one set of marks.
 */

import { msg, str } from "@lit/localize";
import { html, LitElement, nothing, type PropertyValues, type TemplateResult } from "lit";
import { customElement, property, query, state } from "lit/decorators.js";
import { map } from "lit/directives/map.js";
import { deviceOf } from "../../controllers/live-values.js";
import { ContextStoreController } from "../../controllers/context-store.js";
import { TickerController } from "../../controllers/ticker.js";
import { base } from "../../elements/base/base-style.js";
import type { Chart } from "../../elements/chart/chart.js";
import type { ChartAxis, ChartSeries, FollowWindow } from "../../elements/chart/chart-model.js";
import type { PaintScheduler } from "../../elements/chart/paint-scheduler.js";
import { anomalyMarks } from "../../elements/chart/anomaly-marks.js";
import type { ChartMark } from "../../elements/chart/draw-marks.js";
import type { ValueState } from "../../elements/values/value.js";
import { formatAge } from "../../format/duration.js";
import { messageLevel, stateLevel } from "../../format/severity.js";
import { decimalsFor, formatNumber } from "../../format/number.js";
import { limitToShown, shownUnit, toStored } from "../../format/unit.js";
import { outOfRange, stateWord } from "../../format/state-label.js";
import { formatClock } from "../../format/time.js";
import type { AlarmMark } from "../../series/alarm-marks.js";
import { outlierText } from "../../series/outlier-text.js";
import { OutlierMemo, type Outliers } from "../../series/outliers.js";
import { summarize } from "../../series/columns.js";
import { lengthOf, type TimeSpan } from "../../series/time-window.js";
import { reachContext } from "../../state/contexts.js";
import { shareOf, type Anomaly, type Detector } from "../../state/anomaly-detectors.js";
import type { SignalShape } from "../../generated/api.js";
import "../../elements/forms/button.js";
import "../../elements/chart/chart.js";
import "../../elements/analysis/detector.js";
import "../../elements/base/icon.js";
import "../../elements/feedback/status.js";
import "../../elements/values/value.js";
import { positionPart, tileStyle } from "./chart-tile-style.js";
import type { ChartFeed } from "./chart-feed.js";

/** Values change five times a second: faster can not be read. Staleness shows as fast. */
const REFRESH_MS = 200;
/** An axis without limits covers at least so many of the last digit. */
const LEAST_DIGITS = 20;
const COARSE = 300;
const NO_MARKS: readonly ChartMark[] = [];

@customElement("t-chart-tile")
export class ChartTile extends LitElement {
  static override styles = [base, tileStyle];

  @property({ attribute: false }) feed: ChartFeed | null = null;
  @property({ attribute: false }) signal: SignalShape | null = null;
  @property({ attribute: false }) painter: PaintScheduler | null = null;
  @property() zone = "UTC";
  /** Place among the eight colours. */
  @property({ type: Number }) colour = 0;
  /** All charts of the page stand still. */
  @property({ type: Boolean }) paused = false;
  /** Nothing can come, because a link on the way is down: no value is fresh, however young. */
  @property({ type: Boolean }) cut = false;
  /** Outliers are pointed out beyond so many times the distance of the quartiles; 0 for none. */
  @property({ type: Number }) outliers = 0;
  /** What happened to the alarms of its device. */
  @property({ attribute: false }) marks: readonly AlarmMark[] = [];
  /** What watches the signal for anomalies. */
  @property({ attribute: false }) detectors: readonly Detector[] = [];
  /** Anomalies of the signal that are known, in order of time. */
  @property({ attribute: false }) anomalies: readonly Anomaly[] = [];
  /** The person may say that one is none. */
  @property({ type: Boolean, attribute: "may-forgive" }) mayForgive = false;
  /** That is being said. */
  @property({ type: Boolean }) busy = false;
  /** The person may not see it. */
  @property({ type: Boolean }) forbidden = false;

  @state() private held = false;

  @query("t-chart") private readonly drawn!: Chart | null;

  private frozen: { span: TimeSpan; series: ChartSeries; scores: ReadonlyMap<string, ChartSeries> } | null = null;
  private scores: ReadonlyMap<string, ChartSeries> = new Map();
  private drawnMarks: readonly ChartMark[] = [];
  private marksOf: ReadonlyMap<string, readonly ChartMark[]> = new Map();
  private series: ChartSeries | null = null;
  private axis: ChartAxis | null = null;
  private readonly memo = new OutlierMemo();
  private found: Outliers | null = null;
  private points: ReadonlyMap<string, Outliers> = new Map();

  private readonly reach = new ContextStoreController(this, reachContext);

  constructor() {
    super();
    new TickerController(this, REFRESH_MS);
  }

  protected override willUpdate(changed: PropertyValues<this>): void {
    if (changed.has("signal") || changed.has("feed")) {
      this.series = null;
      this.axis = null;
      this.frozen = null;
    }
    this.prepareSeries();
    if (changed.has("anomalies") || changed.has("marks")) this.buildMarks();
    if (changed.has("detectors") || changed.has("feed")) this.prepareScores();
    const still = this.paused || this.held;
    if (!still) this.frozen = null;
    else if (this.frozen === null) this.freezeWindow();
  }

  override render(): TemplateResult | null {
    const { signal, feed } = this;
    if (signal === null || feed === null) return null;
    this.toggleAttribute("stale", ["stale", "unreached"].includes(this.freshness()));
    return html`
      <div class="head">
        <h3 title=${signal.address}>${signal.name}</h3>
        ${this.renderStatus()}
        ${this.series === null || this.forbidden ? nothing : this.renderPauseButton(signal)}
      </div>
      ${this.renderReading(signal, feed)} ${this.renderChart(signal)} ${this.renderDetectors()}
    `;
  }

  private freshness(): ValueState {
    if (this.forbidden) return "forbidden";
    if (this.reach.store?.unreachableSince(this.feed?.site ?? "", deviceOf(this.signal?.address ?? "")) !== undefined) return "unreached";
    const age = this.feed?.ageS(this.signal?.channels[0] ?? "") ?? NaN;
    if (Number.isNaN(age)) return "unknown";
    if (this.cut || age > (this.signal?.max_age ?? 0)) return "stale";
    const newest = this.feed?.channelOf(this.signal?.channels[0] ?? "").trace.newest ?? NaN;
    return this.signal !== null && outOfRange(this.signal, toStored(this.signal.shown, newest)) ? "outside" : "live";
  }

  private renderStatus(): TemplateResult {
    const age = this.feed?.ageS(this.signal?.channels[0] ?? "") ?? NaN;
    switch (this.freshness()) {
      case "live":
        return html`<t-status kind="online" word=${msg("live")}></t-status>`;
      case "outside":
        return html`<t-status kind="warn" word=${msg("out of range")}></t-status>`;
      case "stale":
        return html`<t-status kind="stale" word=${msg(str`stale, ${formatAge(age)}`)}></t-status>`;
      case "unknown":
        return html`<t-status kind="unknown" word=${msg("no data yet")}></t-status>`;
      case "unreached":
        return html`<t-status kind="unknown" word=${msg("not reached")}></t-status>`;
      case "forbidden":
        return html`<t-status kind="unknown" word=${msg("not yours to see")}></t-status>`;
    }
  }

  private renderPauseButton(signal: SignalShape): TemplateResult {
    const still = this.paused || this.held;
    return html`<t-button
      kind="quiet"
      class="pause"
      ?disabled=${this.paused}
      pressed=${still ? "true" : "false"}
      label=${msg(str`Pause the chart of ${signal.name}`)}
      @click=${this.togglePause}
      ><svg viewBox="0 0 16 16" aria-hidden="true">
        <path d=${still ? "M4 2.5v11l9-5.5z" : "M4 3h3v10H4zM9 3h3v10H9z"} fill="currentColor"></path></svg
    ></t-button>`;
  }

  private renderReading(signal: SignalShape, feed: ChartFeed): TemplateResult {
    const freshness = this.freshness();
    const held = feed.channelOf(signal.channels[0] ?? signal.address);
    const word = stateWord(signal.states, held.trace.newest);
    switch (signal.type) {
      case "position":
        return html`<dl class="parts">
          ${map(signal.channels, (channel) => {
            const part = positionPart(signal, channel, feed.channelOf(channel).trace.newest);
            return html`<div>
              <dt>${part.name}</dt>
              <dd><t-value bare size="l" .state=${freshness} .text=${part.text}></t-value></dd>
            </div>`;
          })}
        </dl>`;
      case "text":
        return html`<p class="text ${messageLevel(held.text ?? "")}">${this.renderMessage(freshness, held.text)}</p>
          <p class="range">${Number.isNaN(held.timeUs) ? nothing : msg(str`at ${formatClock(held.timeUs, this.zone)}`)}</p>`;
      case "state":
        return html`<t-value bare size="xl" .state=${freshness} .text=${word} .level=${stateLevel(signal, held.trace.newest)}></t-value>`;
      case "number":
        return html`<div class="number">
          <t-value
            bare
            size="xl"
            .state=${freshness}
            .value=${held.trace.newest}
            .unit=${shownUnit(signal).unit}
            .decimals=${shownUnit(signal).decimals}
          ></t-value>
          <p class="range">${this.forbidden ? nothing : this.renderExtremes(signal)}</p>
        </div>`;
    }
  }

  /** A message; a grave one has a mark besides. */
  private renderMessage(freshness: ValueState, text: string | null): unknown {
    if (freshness === "unreached" || text === null) return "–";
    return messageLevel(text) === "" ? text : html`<t-icon name="warn"></t-icon> ${text}`;
  }

  /** Least and greatest of what the chart shows. */
  private renderExtremes(signal: SignalShape): unknown {
    const samples = this.frozen?.series.samples ?? this.series?.samples;
    const span = this.frozen?.span ?? this.feed?.currentWindow(performance.now());
    if (samples === undefined || span === undefined) return nothing;
    const seen = summarize(samples.columnsAt(this.chartColumn(span)), span.fromUs, span.toUs);
    if (seen.count === 0) return html`${msg("nothing in this window")}`;
    const decimals = digitsOf(signal);
    return html`<span>min <b>${formatNumber(seen.min, decimals)}</b></span>
      <span>${msg(html`max <b>${formatNumber(seen.max, decimals)}</b>`)}</span>`;
  }

  /** What the newest of the marks in the chart is of. */
  private renderNewestMark(): unknown {
    const span = this.frozen?.span ?? this.feed?.currentWindow(performance.now());
    const newest = this.marks.filter(({ timeUs }) => span !== undefined && span.fromUs <= timeUs && timeUs <= span.toUs).at(-1);
    if (newest === undefined) return nothing;
    return html`<p class="outliers">${msg(str`Alarm at ${formatClock(newest.timeUs, this.zone)}:`)} ${newest.said}</p>`;
  }

  /** The newest anomaly of a group in the chart that this signal had a part in. */
  private renderNewestGroup({ address }: SignalShape): unknown {
    const span = this.frozen?.span ?? this.feed?.currentWindow(performance.now());
    const newest = this.anomalies.filter(({ title, fromUs, toUs }) => title !== "" && span !== undefined && fromUs <= span.toUs && toUs >= span.fromUs).at(-1);
    if (newest === undefined) return nothing;
    const share = `${formatNumber(shareOf(newest, address) * 100, 0)} %`;
    return html`<p class="outliers">${msg(str`Anomaly of ${newest.title} at ${formatClock(newest.fromUs, this.zone)}, ${share} of it by this signal.`)}</p>`;
  }

  // The chart's own columns are asked for where there is one: two resolutions would thin twice.
  private chartColumn(span: TimeSpan): number {
    return this.drawn?.columnUs || Math.round(lengthOf(span) / COARSE);
  }

  private renderChart(signal: SignalShape): unknown {
    const series = this.frozen?.series ?? this.series;
    if (series === null || this.axis === null || this.forbidden) return nothing;
    const stale = this.freshness() === "stale";
    if (series.stale !== stale) this.setStale(stale);
    const now = this.frozen?.series ?? this.series ?? series;
    this.seekOutliers(now);
    return html`<t-chart
        class=${signal.type}
        .series=${this.asList(now)}
        .axis=${this.axis}
        .span=${this.frozen?.span ?? null}
        .follow=${this.frozen === null ? this.follow() : null}
        .outliers=${this.points}
        .marks=${this.drawnMarks}
        .painter=${this.painter}
        zone=${this.zone}
        label=${this.frozen === null ? msg(str`${signal.name}, live`) : msg(str`${signal.name}, paused`)}
      ></t-chart>
      ${this.renderNewestMark()} ${this.renderNewestGroup(signal)}
      ${this.found === null ? nothing : html`<p class="outliers">${outlierText(this.found, shownUnit(signal).unit, digitsOf(signal), false)}</p>`}
      ${this.frozen === null
          ? nothing
          : html`<p class="still">${msg(str`Chart paused at ${formatClock(this.frozen.span.toUs, this.zone)}; the value goes on.`)}</p>`}`;
  }

  /** What the detectors say, below the chart and over the same window. */
  private renderDetectors(): unknown {
    if (this.forbidden || this.series === null) return nothing;
    return this.detectors.map((detector) => {
      const series = this.frozen?.scores.get(detector.scores) ?? this.scores.get(detector.scores) ?? null;
      return html`<t-detector
        .detector=${detector}
        .score=${this.scores.get(detector.scores)?.samples.newest ?? NaN}
        .series=${series}
        .marks=${this.marksOf.get(detector.scores) ?? NO_MARKS}
        .span=${this.frozen?.span ?? null}
        .follow=${this.frozen === null ? this.follow() : null}
        .painter=${this.painter}
        zone=${this.zone}
        ?may-forgive=${this.mayForgive}
        ?busy=${this.busy}
      ></t-detector>`;
    });
  }

  /** Of what the chart holds: the hub sends no more of a fast signal than a screen can show. */
  private seekOutliers({ samples, address, states }: ChartSeries): void {
    const span = this.frozen?.span ?? this.feed?.currentWindow(performance.now());
    if (this.outliers === 0 || states.length > 0 || span === undefined) {
      if (this.found !== null) this.points = new Map();
      this.found = null;
      return;
    }
    const found = this.memo.outliersOf(samples, span, this.outliers);
    if (found !== this.found) this.points = new Map([[address, found]]);
    this.found = found;
  }

  private list: readonly ChartSeries[] = [];

  // The same array while the series is the same: the chart is told of real changes only.
  private asList(series: ChartSeries): readonly ChartSeries[] {
    if (this.list[0] !== series) this.list = [series];
    return this.list;
  }

  private follow(): FollowWindow | null {
    return this.feed?.currentWindow ?? null;
  }

  private setStale(stale: boolean): void {
    if (this.series !== null) this.series = { ...this.series, stale };
    if (this.frozen !== null) this.frozen = { ...this.frozen, series: { ...this.frozen.series, stale } };
  }

  private prepareSeries(): void {
    const { signal, feed } = this;
    if (signal === null || feed === null || this.series !== null) return;
    if (signal.type !== "number" && signal.type !== "state") return;
    const channel = feed.channelOf(signal.channels[0] ?? signal.address);
    this.series = {
      address: signal.address,
      name: signal.name,
      ...shownUnit(signal),
      colour: this.colour,
      samples: channel.trace,
      states: signal.type === "state" ? signal.states : [],
      gaps: channel.gaps,
      stale: false,
    };
    const limits = { minimum: limitToShown(signal.shown, signal.minimum), maximum: limitToShown(signal.shown, signal.maximum) };
    this.axis = { limits, least: LEAST_DIGITS * 10 ** -digitsOf(signal) };
  }

  /** The chart shows alarms and all anomalies, and each strip the anomalies of its detector. */
  private buildMarks(): void {
    this.drawnMarks = [...this.marks, ...anomalyMarks(this.anomalies)].sort((a, b) => a.timeUs - b.timeUs);
    const anomaliesOf = (scores: string): readonly Anomaly[] => this.anomalies.filter((anomaly) => anomaly.scores === scores);
    this.marksOf = new Map(this.anomalies.map(({ scores }) => [scores, anomalyMarks(anomaliesOf(scores))]));
  }

  private prepareScores(): void {
    const { feed } = this;
    if (feed === null) return;
    this.scores = new Map(
      this.detectors.map(({ scores }): [string, ChartSeries] => {
        const before = this.scores.get(scores);
        const { trace, gaps } = feed.channelOf(scores);
        if (before?.samples === trace) return [scores, before];
        const plain = { address: scores, name: msg("Score"), unit: "", decimals: 2, states: [], stale: false };
        return [scores, { ...plain, colour: this.colour, samples: trace, gaps }];
      }),
    );
  }

  private freezeWindow(): void {
    const { feed, signal, series } = this;
    if (feed === null || signal === null || series === null) return;
    const samples = feed.channelOf(signal.channels[0] ?? signal.address).trace.copy();
    const scores = new Map(
      [...this.scores].map(([address, one]): [string, ChartSeries] => [address, { ...one, samples: feed.channelOf(address).trace.copy() }]),
    );
    this.frozen = { span: feed.currentWindow(performance.now()), series: { ...series, samples, gaps: [...series.gaps] }, scores };
  }

  private readonly togglePause = (): void => {
    if (!this.paused) this.held = !this.held;
  };
}

/** Digits after the point of a signal's values as they are shown. */
function digitsOf(signal: SignalShape): number {
  const { unit, decimals } = shownUnit(signal);
  return decimalsFor(unit, decimals);
}

declare global {
  interface HTMLElementTagNameMap {
    "t-chart-tile": ChartTile;
  }
}
