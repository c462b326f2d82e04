/** Several signals over time in one tile: numbers in a chart, states as bands. */

import { msg, str } from "@lit/localize";
import { css, html, LitElement, nothing, type PropertyValues, type TemplateResult } from "lit";
import { customElement, property } from "lit/decorators.js";
import { repeat } from "lit/directives/repeat.js";
import { StoreController } from "../../controllers/store-controller.js";
import { TickerController } from "../../controllers/ticker.js";
import { base, quietText } from "../../elements/base/base-style.js";
import type { ChartAxis, ChartSeries, FollowWindow } from "../../elements/chart/chart-model.js";
import { seriesMarks } from "../../elements/chart/series-marks.js";
import { decimalsFor, formatNumber } from "../../format/number.js";
import { shownUnit, toShown } from "../../format/unit.js";
import { formatAge } from "../../format/duration.js";
import { stateWord } from "../../format/state-label.js";
import type { SignalShape } from "../../generated/api.js";
import { SECOND_US } from "../../series/zone-clock.js";
import "../../elements/chart/chart.js";
import type { BoardTileContext } from "./board-tile-entry.js";

const REFRESH_MS = 500;

const lineStyle = css`
  :host {
    display: grid;
    grid-template-columns: minmax(0, 1fr);
    min-block-size: 0;
    block-size: 100%;
  }
  .swatch {
    display: inline-block;
    inline-size: 0.75rem;
    block-size: 0.25rem;
    margin-inline-end: 0.3rem;
    border-radius: 2px;
    vertical-align: 0.2em;
    background: var(--t-series-1);
  }
  ${seriesMarks}
  .stale {
    color: var(--t-stale);
  }
`;

/** What a chart and a timeline share: lines of the board's feed, and a window that ends now. */
abstract class FeedTile extends LitElement {
  @property({ attribute: false }) context: BoardTileContext | null = null;
  @property({ attribute: false }) signals: readonly SignalShape[] = [];
  @property({ type: Number }) seconds = 300;

  protected series: readonly ChartSeries[] = [];
  protected follow: FollowWindow | null = null;
  private readonly watched = new StoreController(this);
  private made = "";
  private followed: unknown = null;

  constructor() {
    super();
    new TickerController(this, REFRESH_MS);
  }

  protected override willUpdate(changed: PropertyValues<this>): void {
    this.watched.setStore(this.context?.past ?? null);
    const feed = this.context?.feed ?? null;
    if (feed !== this.followed || changed.has("seconds")) {
      this.followed = feed;
      const lengthUs = this.seconds * SECOND_US;
      this.follow = feed === null ? null : (nowMs) => {
        const { toUs } = feed.currentWindow(nowMs);
        return { fromUs: toUs - lengthUs, toUs };
      };
      this.made = "";
    }
    this.makeSeries();
  }

  /** The same list while nothing of it is another: the chart is told of real changes only. */
  private makeSeries(): void {
    const feed = this.context?.feed ?? null;
    const key = `${this.signals.map((signal) => `${signal.address} ${String(this.isStale(signal))}`).join()} ${String(feed === null)}`;
    if (key === this.made) return;
    this.made = key;
    this.series = feed === null ? [] : this.signals.map((signal, colour): ChartSeries => {
      const held = feed.channelOf(signal.channels[0] ?? signal.address);
      return {
        address: signal.address, name: signal.name, ...shownUnit(signal), colour: colour % 8,
        samples: held.trace, states: signal.type === "state" ? signal.states : [], gaps: held.gaps, stale: this.isStale(signal),
      };
    });
  }

  protected readonly isHeld = (): boolean => this.context?.past?.holdsCharts ?? false;

  /** What is written stays with what is drawn: words that come and go would move the chart, and it be drawn twice. */
  protected override shouldUpdate(changed: PropertyValues<this>): boolean {
    return changed.size > 0 || !this.isHeld();
  }

  protected get isPast(): boolean {
    return (this.context?.past ?? null) !== null;
  }

  protected ageOf(signal: SignalShape): number {
    return this.context?.feed?.ageS(signal.channels[0] ?? signal.address) ?? Number.NaN;
  }

  /** What was recorded is being asked for: nobody knows yet whether there is anything. */
  private get isComing(): boolean {
    const past = this.context?.past ?? null;
    return past !== null && past.feed.failure === null && !past.feed.isReady;
  }

  protected isStale(signal: SignalShape): boolean {
    if (this.isComing) return false;
    const age = this.ageOf(signal);
    return Number.isNaN(age) || this.context?.online !== true || age > signal.max_age;
  }

  protected newestText(signal: SignalShape): string {
    const newest = this.context?.feed?.channelOf(signal.channels[0] ?? signal.address).trace.newest ?? Number.NaN;
    if (signal.type === "state") return stateWord(signal.states, newest);
    const { unit, decimals } = shownUnit(signal);
    const number = formatNumber(newest, decimalsFor(unit, decimals));
    return unit === "" ? number : `${number} ${unit}`;
  }

  /** How old a value is that is not of now; empty while it is. */
  protected staleText(signal: SignalShape): string {
    if (!this.isStale(signal)) return "";
    const age = this.ageOf(signal);
    if (Number.isNaN(age)) return this.isPast ? msg("nothing recorded") : msg("no data yet");
    return msg(str`stale, ${formatAge(age)}`);
  }
}

@customElement("t-tile-chart")
export class ChartBoardTile extends FeedTile {
  static override styles = [
    base,
    lineStyle,
    css`
      :host {
        grid-template-rows: auto minmax(4rem, 1fr);
        gap: var(--t-space-1);
      }
      ul {
        display: flex;
        flex-wrap: wrap;
        gap: 0 var(--t-space-4);
        margin: 0;
        padding: 0;
        font-size: var(--t-size-s);
        font-variant-numeric: tabular-nums;
        list-style: none;
      }
      t-chart {
        block-size: 100%;
        min-block-size: 0;
      }
    `,
  ];

  @property({ type: Number }) least = Number.NaN;
  @property({ type: Number }) most = Number.NaN;
  @property({ type: Boolean, attribute: "many-axes" }) manyAxes = false;

  private levels: readonly number[] = [];
  private axis: ChartAxis | null = null;

  protected override willUpdate(changed: PropertyValues<this>): void {
    super.willUpdate(changed);
    if (this.axis !== null && !changed.has("least") && !changed.has("most") && !changed.has("signals")) return;
    // The board says them in the first signal's own unit.
    const shown = this.signals[0]?.shown ?? null;
    const [least, most] = [toShown(shown, this.least), toShown(shown, this.most)];
    this.levels = [least, most].filter((value) => !Number.isNaN(value));
    const end = (value: number): number | null => (Number.isNaN(value) ? null : value);
    this.axis = { limits: { minimum: end(least), maximum: end(most) }, least: 0 };
  }

  override render(): TemplateResult {
    const units = new Set(this.signals.map((signal) => shownUnit(signal).unit));
    return html`<ul>
        ${repeat(
          this.signals,
          ({ address }) => address,
          (signal, i) => html`<li><span class="swatch c${(i % 8) + 1}"></span>${this.signals.length > 1 ? `${signal.name} ` : nothing}<b class=${this.isStale(signal) ? "stale" : ""}>${this.newestText(signal)}</b> ${this.staleText(signal)}</li>`,
        )}
      </ul>
      <t-chart
        class="number"
        .series=${this.series}
        .axis=${this.axis}
        .levels=${this.levels}
        .follow=${this.follow}
        .isHeld=${this.isHeld}
        .painter=${this.context?.painter ?? null}
        ?many-axes=${this.manyAxes && units.size > 1}
        zone=${this.context?.zone ?? "UTC"}
        label=${this.isPast ? msg(str`${this.signals.map(({ name }) => name).join(", ")}, up to the moment`) : msg(str`${this.signals.map(({ name }) => name).join(", ")}, live`)}
      ></t-chart>`;
  }
}

@customElement("t-tile-timeline")
export class TimelineBoardTile extends FeedTile {
  static override styles = [
    base,
    lineStyle,
    css`
      :host {
        align-content: start;
        gap: var(--t-space-1);
      }
      .line {
        display: grid;
        grid-template-columns: minmax(4rem, 8rem) minmax(0, 1fr);
        align-items: center;
        gap: var(--t-space-2);
      }
      .name {
        display: grid;
        ${quietText}
        overflow-wrap: anywhere;
      }
      .name b {
        color: var(--t-text);
      }
      .name b.stale {
        color: var(--t-stale);
        font-weight: var(--t-weight);
      }
      t-chart {
        block-size: 4rem;
        min-block-size: 0;
      }
    `,
  ];

  private readonly lists = new Map<string, readonly ChartSeries[]>();

  override render(): TemplateResult {
    return html`${repeat(
      this.signals,
      ({ address }) => address,
      (signal) => html`<div class="line">
        <div class="name"><span>${signal.name}</span><b class=${this.isStale(signal) ? "stale" : ""}>${this.newestText(signal)}</b>${this.staleText(signal)}</div>
        <t-chart class="state" .series=${this.listOf(signal)} .follow=${this.follow} .isHeld=${this.isHeld} .painter=${this.context?.painter ?? null} zone=${this.context?.zone ?? "UTC"} label=${this.isPast ? msg(str`${signal.name}, up to the moment`) : msg(str`${signal.name}, live`)}></t-chart>
      </div>`,
    )}`;
  }

  private listOf({ address }: SignalShape): readonly ChartSeries[] {
    const series = this.series.find((line) => line.address === address);
    const before = this.lists.get(address);
    if (before !== undefined && before[0] === series) return before;
    const list = series === undefined ? [] : [series];
    this.lists.set(address, list);
    return list;
  }
}

declare global {
  interface HTMLElementTagNameMap {
    "t-tile-chart": ChartBoardTile;
    "t-tile-timeline": TimelineBoardTile;
  }
}
