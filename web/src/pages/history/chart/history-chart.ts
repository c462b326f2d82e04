/** One chart of the history page with what its lines are and say: values at the cursor, least, mean, greatest. */

import { msg, str } from "@lit/localize";
import { html, LitElement, nothing, type PropertyValues, type TemplateResult } from "lit";
import { customElement, property, query } from "lit/decorators.js";
import { map } from "lit/directives/map.js";
import { repeat } from "lit/directives/repeat.js";
import { base } from "../../../elements/base/base-style.js";
import type { Chart } from "../../../elements/chart/chart.js";
import { indentOf, type ChartSeries, type ChartIndent } from "../../../elements/chart/chart-model.js";
import type { PaintScheduler } from "../../../elements/chart/paint-scheduler.js";
import { momentText, cursorValue } from "../../../elements/chart/cursor-values.js";
import { decimalsFor, formatNumber, NOTHING } from "../../../format/number.js";
import { knownZone, timeText } from "../../../format/time.js";
import { outlierText } from "../../../series/outlier-text.js";
import { OutlierMemo, type Outliers } from "../../../series/outliers.js";
import { compareRuns } from "../../../series/run-difference.js";
import { summarize, type ColumnsSummary } from "../../../series/columns.js";
import { lengthOf, type TimeSpan } from "../../../series/time-window.js";
import { SECOND_US } from "../../../series/zone-clock.js";
import type { OutlierShape, StatisticsShape } from "../../../generated/api.js";
import { historyChartStyle } from "./history-chart-style.js";
import type { LoadedSeries } from "../data/history-loader.js";
import type { EventMark } from "./event-marks.js";
import { shownFence } from "../data/shown-fence.js";
import type { ChannelRow, ChartGroup } from "../data/channel-rows.js";
import { renderStatisticsCells, renderStatisticsHead } from "./statistics-cells.js";
import { textBand, type TextBand } from "../data/text-band.js";
import "../../../elements/chart/chart.js";

/** Columns for statistics, where the chart has not been drawn yet. */
const COLUMNS = 1000;
/** The cursor finds a value within this part of the window. */
const REACH = 0.015;
const TEXTS = 100;
const AXIS_WIDTH = 60;

@customElement("t-history-chart")
export class HistoryChart extends LitElement {
  static override styles = [base, historyChartStyle];

  @property({ attribute: false }) group: ChartGroup | null = null;
  @property({ attribute: false }) data: ReadonlyMap<string, LoadedSeries> = new Map();
  @property({ attribute: false }) span: TimeSpan = { fromUs: 0, toUs: 1 };
  @property({ attribute: false }) cursorUs: number | null = null;
  /** The same channels on another day, so much before (µs); 0 for none. */
  @property({ attribute: false }) ghost: ReadonlyMap<string, LoadedSeries> = new Map();
  @property({ attribute: false }) ghostUs = 0;
  /** The other day, as it is called beside its values. */
  @property({ attribute: "ghost-name" }) ghostName = "";
  /** What the hub counted of the window. */
  @property({ attribute: false }) numbers: ReadonlyMap<string, StatisticsShape> = new Map();
  @property({ attribute: false }) ghostNumbers: ReadonlyMap<string, StatisticsShape> = new Map();
  @property({ attribute: false }) marks: readonly EventMark[] = [];
  /** Outliers are pointed out beyond so many times the distance of the quartiles; 0 for none. */
  @property({ type: Number }) outliers = 0;
  /** What the hub found in all samples, where the chart holds only some. */
  @property({ attribute: false }) fences: ReadonlyMap<string, OutlierShape> = new Map();
  /** It could not look: what the chart holds has to do. */
  @property({ type: Boolean }) unfenced = false;
  @property({ attribute: false }) painter: PaintScheduler | null = null;
  /** When each channel was heard of last (µs), for a window without samples. */
  @property({ attribute: false }) newest: ReadonlyMap<string, number> = new Map();
  /** The first answer has come. */
  @property({ type: Boolean }) loaded = false;
  @property() zone = "UTC";
  /** Several units in the chart, with an axis for each. */
  @property({ type: Boolean }) joined = false;
  /** Room beside the plot, the same for all charts of the page. */
  @property({ attribute: false }) indent: ChartIndent = indentOf(1, AXIS_WIDTH);
  @property({ type: Number, attribute: "axis-width" }) axisWidth = AXIS_WIDTH;

  @query("t-chart") private readonly chart!: Chart | null;

  private series: readonly ChartSeries[] = [];
  private points: ReadonlyMap<string, Outliers> = new Map();
  private readonly memos = new Map<string, OutlierMemo>();

  protected override willUpdate(changed: PropertyValues<this>): void {
    const moved = changed.has("ghostUs") && changed.get("ghostUs") !== this.ghostUs;
    if (changed.has("group") || changed.has("data") || changed.has("ghost") || moved) this.series = this.makeSeries();
    this.seekOutliers();
  }

  override render(): TemplateResult | null {
    const { group } = this;
    if (group === null) return null;
    return html`
      ${this.renderTable(group)}
      <div class="place">
        <t-chart
          class=${group.type === "number" ? "number" : "band"}
          zoomable
          axis-width=${this.axisWidth}
          ?many-axes=${this.joined}
          .indent=${this.indent}
          .series=${this.series}
          .span=${this.span}
          .cursorUs=${this.cursorUs}
          .marks=${this.marks}
          .outliers=${this.points}
          .painter=${this.painter}
          zone=${this.zone}
          label=${msg(str`History of ${group.rows.map(({ name }) => name).join(", ")}`)}
        ></t-chart>
        ${this.loaded && this.series.every((series) => !this.hasAny(series)) ? this.renderEmpty(group) : nothing}
      </div>
      ${this.renderOutlierList()}
      ${group.type === "text" ? this.renderTexts(group) : nothing}
    `;
  }

  private seekOutliers(): void {
    const numbers = this.outliers === 0 ? [] : this.series.filter(({ states }) => states.length === 0);
    const found = numbers.flatMap(({ address, samples }): [string, Outliers][] => {
      const by = this.unfenced || this.data.get(address)?.exact === true ? this.outliers : this.fenceOf(address);
      if (by === undefined) return [];
      const memo = this.memos.get(address) ?? new OutlierMemo();
      this.memos.set(address, memo);
      return [[address, memo.outliersOf(samples, this.span, by)]];
    });
    // The same points are the same map: the chart is drawn again for others only.
    const same = found.length === this.points.size && found.every(([address, one]) => this.points.get(address) === one);
    if (!same) this.points = new Map(found);
  }

  /** How many outliers, and of what: of a long window the chart holds the extremes of each pixel, and the hub counts. */
  private renderOutlierList(): unknown {
    const numbers = this.outliers === 0 ? [] : this.series.filter(({ states }) => states.length === 0);
    if (numbers.length === 0) return nothing;
    return html`<ul class="outliers" role="status" aria-label=${msg("Outliers")}>
      ${map(numbers, (series) => html`<li><strong>${series.name}</strong> ${this.outlierLine(series)}</li>`)}
    </ul>`;
  }

  private fenceOf(address: string): OutlierShape | undefined {
    const fence = this.fences.get(address);
    return fence && shownFence(fence, this.group?.rows.find((row) => row.address === address)?.shown ?? null);
  }

  private outlierLine({ address, unit, decimals }: ChartSeries): string {
    const found = this.points.get(address);
    if (found === undefined) return msg("All samples of the window are being counted…");
    const whole = this.data.get(address)?.exact === true;
    const fences = this.fenceOf(address);
    const places = decimalsFor(unit, decimals);
    if (whole) return `${outlierText(found, unit, places, true)}.`;
    if (!this.unfenced && fences !== undefined) return `${outlierText(found, unit, places, fences.exact || fences.stored)}.`;
    const counted = this.numbers.get(address)?.count;
    const more = counted === undefined ? "" : msg(str` The window has ${formatNumber(counted, 0)} samples, and the hub could not count them now.`);
    return `${outlierText(found, unit, places, false)}.${more}`;
  }

  private renderTable(group: ChartGroup): TemplateResult {
    const { cursorUs } = this;
    return html`<div class="scroll">
      <table>
        <thead>
          <tr>
            <th scope="col">${group.type === "number" ? group.title || msg("without unit") : group.type}</th>
            <th scope="col" class="at">
              ${cursorUs === null ? msg("newest shown") : momentText(cursorUs, knownZone(this.zone), lengthOf(this.span))}
              ${this.ghostName === "" ? nothing : html`<span class="then">${this.ghostName}</span>`}
            </th>
            ${renderStatisticsHead(group.type === "number")}
          </tr>
        </thead>
        <tbody>
          ${repeat(
            group.rows,
            (row) => row.address,
            (row, i) => this.renderLine(row, i),
          )}
        </tbody>
      </table>
    </div>`;
  }

  private renderLine(row: ChannelRow, index: number): TemplateResult {
    const series = this.series.find(({ address }) => address === row.address);
    const swatch = row.type === "number" ? html`<span class="swatch c${(index % 8) + 1}"></span>` : nothing;
    return html`<tr>
      <th scope="row">${swatch}${row.name} <span class="muted">${row.device.name}${row.former ? msg(", no longer in the description") : ""}</span></th>
      <td class="at">${series === undefined ? NOTHING : html`${this.renderValue(series)} ${this.renderGhostValue(series)}`}</td>
      ${renderStatisticsCells(row, this.numbers.get(row.address), series && this.drawn(series))}
    </tr>
    ${series?.ghost === undefined || series.states.length > 0 ? nothing : this.renderDifference(row, series, series.ghost)}`;
  }

  /** The other run's numbers under this one's, and how far the two lie apart. */
  private renderDifference(row: ChannelRow, series: ChartSeries, { samples, shiftUs }: NonNullable<ChartSeries["ghost"]>): TemplateResult {
    const { rms, count } = compareRuns(series.samples, samples, shiftUs, this.span);
    const places = decimalsFor(row.unit, row.decimals) + 1;
    const whole = this.data.get(row.address)?.exact === true && this.ghost.get(row.address)?.exact === true;
    const words = count === 0 ? msg("no moment in common") : msg(str`RMS difference ${formatNumber(rms, places)}`);
    return html`<tr class="other">
      <th scope="row"><span class="muted">${this.ghostName || msg("the other run")}</span></th>
      <td class="at" title=${whole ? msg("Of every sample") : msg("Of what is drawn: zoom in for every sample")}><span class="rms">${words}</span></td>
      ${renderStatisticsCells(row, this.ghostNumbers.get(row.address), undefined)}
    </tr>`;
  }

  private renderValue(series: ChartSeries): unknown {
    const at = this.cursorUs ?? Math.min(this.span.toUs, series.samples.newestUs);
    const { text } = cursorValue(series, at, this.columnUs(), lengthOf(this.span) * REACH);
    if (text === NOTHING) return this.renderNoValueReason(series, at);
    const spread = series.states.length > 0 ? -1 : text.indexOf(" (");
    return spread < 0 ? text : html`${text.slice(0, spread)}<span class="spread">${text.slice(spread)}</span>`;
  }

  /** Where there is no value: the reason, if one is known. */
  private renderNoValueReason(series: ChartSeries, us: number): unknown {
    const reason = series.gaps.find(({ from_us, to_us }) => us >= from_us && us <= to_us)?.reason ?? "";
    return reason === "" ? NOTHING : html`<span class="why">${reason}</span>`;
  }

  private renderGhostValue(series: ChartSeries): unknown {
    const { ghost } = series;
    if (ghost === undefined) return nothing;
    const at = (this.cursorUs ?? this.span.toUs) - ghost.shiftUs;
    const { text } = cursorValue({ ...series, samples: ghost.samples }, at, this.columnUs(), lengthOf(this.span) * REACH);
    return html`<span class="then">${series.states.length > 0 ? text : (text.split(" (")[0] ?? NOTHING)}</span>`;
  }

  private drawn({ samples, states }: ChartSeries): ColumnsSummary | undefined {
    const { fromUs, toUs } = this.span;
    return states.length > 0 ? undefined : summarize(samples.columnsAt(this.columnUs()), fromUs, toUs);
  }

  // The chart's own columns where there is one: two resolutions would thin all of it twice.
  private columnUs(): number {
    return this.chart?.columnUs || Math.max(1, Math.round(lengthOf(this.span) / COLUMNS));
  }

  private renderEmpty(group: ChartGroup): TemplateResult {
    const newest = Math.max(...group.rows.map(({ address }) => this.newest.get(address) ?? 0));
    const now = Date.now() * 1000;
    return html`<div class="none">
      <strong>${msg("No samples in this window")}</strong>
      ${newest > 0 ? html`<span>${msg(str`The newest is of ${timeText(newest, knownZone(this.zone), now).local}.`)}</span>` : nothing}
    </div>`;
  }

  /** All texts of the window, to read and to copy: in the band there is no room for long ones. */
  private renderTexts(group: ChartGroup): TemplateResult | null {
    const { fromUs, toUs } = this.span;
    const held = this.data.get(group.rows[0]?.address ?? "")?.texts ?? [];
    const texts = held.filter(({ timeUs }) => timeUs >= fromUs && timeUs <= toUs);
    if (texts.length === 0) return null;
    return html`<details>
      <summary>${texts.length > TEXTS ? msg(str`The last ${String(TEXTS)} texts`) : msg("All texts")}</summary>
      <ol>
        ${map(
          texts.slice(-TEXTS).reverse(),
          ({ timeUs, text }) => html`<li><time>${momentText(timeUs, knownZone(this.zone), lengthOf(this.span))}</time> ${text}</li>`,
        )}
      </ol>
    </details>`;
  }

  private hasAny({ samples: { times, values } }: ChartSeries): boolean {
    const { fromUs, toUs } = this.span;
    return times.some((time, i) => time >= fromUs && time <= toUs && !Number.isNaN(values[i]));
  }

  private makeSeries(): ChartSeries[] {
    return (this.group?.rows ?? []).flatMap((row, colour) => {
      const held = this.data.get(row.address);
      if (held === undefined) return [];
      const { address, name, unit, decimals } = row;
      const now = bandOf(row, held, row.states);
      const ghost = this.ghostUs === 0 ? undefined : this.ghost.get(address);
      const then = ghost && bandOf(row, ghost, now.words);
      const plain = { address, name, unit, decimals, colour, samples: now.samples, gaps: held.gaps, stale: false };
      if (then === undefined) return [{ ...plain, states: now.words }];
      return [{ ...plain, states: then.words, ghost: { samples: then.samples, shiftUs: this.ghostUs } }];
    });
  }
}

/** A text is drawn as a state; all else is drawn as it is. */
function bandOf(row: ChannelRow, held: LoadedSeries, words: readonly string[]): TextBand {
  return row.type === "text" ? textBand(held, row.maxAge * SECOND_US, words) : { words, samples: held.trace };
}

declare global {
  interface HTMLElementTagNameMap {
    "t-history-chart": HistoryChart;
  }
}
