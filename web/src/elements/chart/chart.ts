/**
 * A chart of one or more channels over time. Longer than most files: it is where drawing, size,
 * theme, pointer and keys of one chart come together.
 *
 * After each paint `window.__talaiaPainted(address, newestUs, newest)` is called where a page has set it;
 * the benchmarks do.
 */

import { msg } from "@lit/localize";
import { html, LitElement, type PropertyValues, type TemplateResult } from "lit";
import { customElement, property, query } from "lit/decorators.js";
import { knownZone } from "../../format/time.js";
import type { AxisRange } from "../../series/axis-range.js";
import { lengthOf, type TimeSpan } from "../../series/time-window.js";
import { clockOf } from "../../series/zone-clock.js";
import { base } from "../base/base-style.js";
import { ValueAxes } from "./value-axes.js";
import { drawLevel, drawMarks, type ChartMark } from "./draw-marks.js";
import { drawOutliers, type OutlierPoints } from "./draw-outliers.js";
import { drawSeries } from "./draw-series.js";
import { Gestures } from "./gestures.js";
import { keyAction } from "./chart-keys.js";
import { indentOf, type ChartAxis, type ChartSeries, type FollowWindow, type ChartIndent, type CursorValue, type SpanChange } from "./chart-model.js";
import { ChartOverlay } from "./chart-overlay.js";
import { PaintScheduler, type Paintable } from "./paint-scheduler.js";
import { readPalette, watchTheme, type Palette } from "./palette.js";
import { momentText, cursorValue } from "./cursor-values.js";
import { chartStyle } from "./chart-style.js";
import { UplotView } from "./uplot-view.js";

declare global {
  interface Window {
    __talaiaPainted?: (address: string, newestUs: number, newest: number) => void;
  }
}

const NEVER = (): boolean => false;

/** Properties that change the picture. */
const DRAWN: readonly (keyof Chart)[] = [
  "series",
  "marks",
  "level",
  "levels",
  "outliers",
  "span",
  "follow",
  "axis",
  "painter",
  "zone",
  "axisWidth",
  "manyAxes",
  "indent",
];
const NO_AXIS: ChartAxis = { limits: { minimum: null, maximum: null }, least: 0 };
/** The cursor finds a value within so many pixels. */
const REACH = 14;
/** A window that has moved by so many pixels is drawn anew. */
const MOVED = 0.5;
const NO_INDENT: ChartIndent = indentOf(0, 0);
const NO_OUTLIERS: ReadonlyMap<string, OutlierPoints> = new Map();
const NO_LEVELS: readonly number[] = [];
const NO_RANGE: AxisRange = { low: 0, high: 1 };

/**
 * @fires t-span while and after the person zooms or moves the window; detail is `SpanChange`
 * @fires t-cursor detail is the moment under the cursor (µs), or null
 * @fires t-reset the person asks for the window from before
 */
@customElement("t-chart")
export class Chart extends LitElement implements Paintable {
  static override styles = [base, chartStyle];

  @property({ attribute: false }) series: readonly ChartSeries[] = [];
  /** Where something happened, in ascending time. */
  @property({ attribute: false }) marks: readonly ChartMark[] = [];
  /** A value with a dashed line across; NaN for none. */
  @property({ type: Number }) level = NaN;
  /** More of these: the ends of a band. */
  @property({ attribute: false }) levels: readonly number[] = NO_LEVELS;
  /** Samples to point out, by the address of their series. */
  @property({ attribute: false }) outliers: ReadonlyMap<string, OutlierPoints> = NO_OUTLIERS;
  /** The window of a chart that stands still. */
  @property({ attribute: false, hasChanged: isOther }) span: TimeSpan | null = null;
  /** Gives the window of a chart that moves; it wins over `span`. */
  @property({ attribute: false }) follow: FollowWindow | null = null;
  /** Whether it keeps its picture, since what is to be drawn next is about to come. */
  @property({ attribute: false }) isHeld: () => boolean = NEVER;
  @property({ attribute: false }) axis: ChartAxis = NO_AXIS;
  /** Rounds are drawn together with the charts that share it. */
  @property({ attribute: false }) painter: PaintScheduler | null = null;
  @property() zone = "UTC";
  /** What the chart shows, for screen readers. */
  @property() label = "";
  /** Zooms and pans; otherwise only the cursor moves. */
  @property({ type: Boolean }) zoomable = false;
  /** The linked cursor of charts that belong together (µs). */
  @property({ attribute: false }) cursorUs: number | null = null;
  @property({ type: Number, attribute: "axis-width" }) axisWidth = 48;
  /** An axis for each unit among the series, instead of one for all. */
  @property({ type: Boolean, attribute: "many-axes" }) manyAxes = false;
  /** Room at the sides, also where no axes take it, so that the plot lines up with others. */
  @property({ attribute: false }) indent: ChartIndent = NO_INDENT;

  @query(".plot") private place!: HTMLElement;
  @query(".cursor") private cursorLine!: HTMLElement;
  @query(".read") private readBox!: HTMLElement;
  @query(".chosen") private chosenBox!: HTMLElement;
  @query("[aria-live]") private spoken!: HTMLElement;

  private view: UplotView | null = null;
  private overlay: ChartOverlay | null = null;
  private palette: Palette | null = null;
  private axes = new ValueAxes([], false, NO_AXIS);
  private shown: TimeSpan | null = null;
  private cursorPart: number | null = null;
  private size = { width: 0, height: 0 };
  private onScreen = false;
  private dirty = true;
  /** It kept its picture the last time that it was asked. */
  private wasHeld = false;
  private drawnVersion = -1;
  private stops: (() => void)[] = [];
  private speakTimer: ReturnType<typeof setTimeout> | undefined;

  override connectedCallback(): void {
    super.connectedCallback();
    if (this.hasUpdated) this.startPainting();
  }

  override disconnectedCallback(): void {
    super.disconnectedCallback();
    clearTimeout(this.speakTimer);
    for (const stop of this.stops) stop();
    this.stops = [];
    this.view?.destroy();
    this.view = null;
  }

  override render(): TemplateResult {
    return html`<div
        class="plot"
        role="group"
        tabindex="0"
        aria-roledescription=${msg("chart")}
        aria-label=${this.label}
        @keydown=${this.onKeyDown}
        @blur=${this.onBlur}
      ></div>
      <div class="cursor" hidden></div>
      <div class="chosen" hidden></div>
      <div class="read" aria-hidden="true" hidden></div>
      <div class="visually-hidden" aria-live="polite"></div>`;
  }

  protected override firstUpdated(): void {
    this.overlay = new ChartOverlay(this.cursorLine, this.readBox, this.chosenBox);
    new Gestures(this.place, {
      span: () => this.shown,
      partAt: (x) => this.partAt(x),
      moveCursor: (part) => {
        this.moveCursor(part);
      },
      showSelection: (from, to) => {
        if (this.view !== null) this.overlay?.showSelection(this.view.plotBox, from, to);
      },
      hideSelection: () => {
        this.overlay?.hideSelection();
      },
      changeSpan: (span, settled) => {
        this.fireSpanChange({ span, settled });
      },
      resetSpan: () => {
        this.fireEvent("t-reset", null);
      },
      zoomable: this.zoomable,
    });
    this.startPainting();
  }

  protected override willUpdate(changed: PropertyValues<this>): void {
    const before = this.axes;
    const axes = changed.has("series") || changed.has("manyAxes") || changed.has("axis") ? new ValueAxes(this.series, this.manyAxes, this.axis) : before;
    // Axes that are the same keep what they cover, so that they do not jump with every answer.
    if (axes.key !== before.key || changed.has("axis")) this.axes = axes;
    const other = axes.key !== before.key || changed.has("zone") || changed.has("axisWidth") || changed.has("indent");
    if (other && this.view !== null) this.recreateView();
  }

  protected override updated(changed: PropertyValues<this>): void {
    // The cursor lies over the picture: what is below it need not be drawn again.
    if (DRAWN.some((name) => changed.has(name))) this.markDirty();
    else if (changed.has("cursorUs")) this.placeCursor();
  }

  /** Time of one column of what is drawn now (µs); 0 before the first picture. */
  get columnUs(): number {
    return this.shown === null || this.view === null ? 0 : this.widthUs(this.shown);
  }

  // ── painting ────────────────────────────────────────────────────────────────────────────

  get isFresh(): boolean {
    return this.dirty || this.dataVersion() !== this.drawnVersion;
  }

  needsPaint(nowMs: number): boolean {
    if (!this.onScreen || this.view === null) return false;
    if (this.isHeld()) {
      this.wasHeld = true;
      return false;
    }
    // Half a pixel is seen as movement; less is not worth a picture, unless something new came.
    return this.dirty || (this.shown !== null && this.follow !== null && (this.isFresh || this.movedPart(nowMs) >= MOVED));
  }

  restMs(nowMs: number): number {
    const { follow, shown } = this;
    if (follow === null || !this.onScreen) return Infinity;
    if (shown === null) return 0;
    // Of a moment that is moved by a person or plays, nobody knows how soon it will be elsewhere.
    const rate = (follow(nowMs + 1000).toUs - follow(nowMs).toUs) / 1000;
    return rate > 0 ? Math.max(0, ((MOVED - this.movedPart(nowMs)) * this.widthUs(shown)) / rate) : 0;
  }

  /** By how many pixels the window has moved since it was drawn. */
  private movedPart(nowMs: number): number {
    const { follow, shown } = this;
    return follow === null || shown === null ? 0 : (follow(nowMs).toUs - shown.toUs) / this.widthUs(shown);
  }

  paintFrame(nowMs: number): void {
    const span = this.follow?.(nowMs) ?? this.span;
    const { view, palette } = this;
    if (span === null || view === null || palette === null) return;
    if (this.wasHeld) this.adoptSize(view);
    this.shown = span;
    this.dirty = false;
    this.drawnVersion = this.dataVersion();
    const columnUs = this.widthUs(span);
    const ranges = this.axes.axisRanges(this.series, span, columnUs);
    const rangeOf = (series: ChartSeries): AxisRange => ranges[this.axes.axisIndex(series)] ?? NO_RANGE;
    view.paintView(span, ranges, (plot) => {
      drawSeries(plot, this.series, { palette, columnUs, moving: this.follow !== null, rangeOf });
      drawMarks(plot, this.marks, palette);
      for (const level of [this.level, ...this.levels].filter((value) => !Number.isNaN(value))) drawLevel({ ...plot, range: ranges[0] ?? NO_RANGE }, level, palette);
      for (const series of this.series) {
        const points = this.outliers.get(series.address);
        if (points !== undefined) drawOutliers({ ...plot, range: rangeOf(series) }, points, palette);
      }
    });
    this.placeCursor();
    const tell = window.__talaiaPainted;
    if (tell !== undefined) for (const { address, samples } of this.series) tell(address, samples.newestUs, samples.newest);
  }

  /** What is written around it has changed with what is drawn now: drawn as large as it is, it need not be drawn again. */
  private adoptSize(view: UplotView): void {
    this.wasHeld = false;
    if (this.changeSize(this.place.getBoundingClientRect())) view.resize(this.size);
  }

  /** Gives whether it is another size, in whole pixels. */
  private changeSize(box: DOMRectReadOnly): boolean {
    const before = this.size;
    this.size = { width: Math.floor(box.width), height: Math.floor(box.height) };
    return this.size.width !== before.width || this.size.height !== before.height;
  }

  /** Time of one pixel column (µs). Rounded: a window that moves must not change it by a hair. */
  private widthUs(span: TimeSpan): number {
    return Math.max(1, Math.round(lengthOf(span) / Math.max(1, Math.round(this.view?.plotBox.width ?? 1))));
  }

  private dataVersion(): number {
    let sum = 0;
    for (const { samples } of this.series) sum += samples.version;
    return sum;
  }

  // ── coming and going ────────────────────────────────────────────────────────────────────

  private startPainting(): void {
    this.painter ??= new PaintScheduler();
    const painter = this.painter;
    const inView = new IntersectionObserver((entries) => {
      this.onScreen = entries.at(-1)?.isIntersecting ?? false;
      if (!this.onScreen) return;
      void this.createView();
      this.markDirty();
    }, { rootMargin: "80px" });
    inView.observe(this);
    const sized = new ResizeObserver(([entry]) => {
      if (entry === undefined) return;
      const changed = this.changeSize(entry.contentRect);
      if (this.view !== null && !changed) return;
      if (this.view === null) void this.createView();
      else this.view.resize(this.size);
      this.markDirty();
    });
    sized.observe(this.place);
    this.stops = [
      painter.addChart(this),
      watchTheme(() => {
        this.palette = readPalette(this);
        this.view?.recolour(this.palette);
        this.markDirty();
      }),
      () => {
        inView.disconnect();
        sized.disconnect();
      },
    ];
  }

  private async createView(): Promise<void> {
    if (!this.lacksView()) return;
    const { UPlot, sheet } = await import("./uplot-loader.js");
    if (!this.lacksView()) return;
    const root = this.renderRoot;
    if (root instanceof ShadowRoot && !root.adoptedStyleSheets.includes(sheet)) root.adoptedStyleSheets.push(sheet);
    this.palette = readPalette(this);
    this.view = new UplotView(UPlot, this.place, this.size, this.palette, {
      clock: clockOf(knownZone(this.zone)),
      axisWidth: this.axisWidth,
      axes: this.axes.looks,
      indent: this.indent,
    });
    this.markDirty();
  }

  private lacksView(): boolean {
    return this.view === null && this.onScreen && this.isConnected && this.size.width >= 10 && this.size.height >= 10;
  }

  private recreateView(): void {
    this.view?.destroy();
    this.view = null;
    void this.createView();
  }

  private markDirty(): void {
    this.dirty = true;
    this.painter?.wakeUp();
  }

  // ── pointer and keys ────────────────────────────────────────────────────────────────────

  private partAt(clientX: number): number {
    const box = this.view?.plotBox;
    if (box === undefined) return 0;
    const part = (clientX - this.place.getBoundingClientRect().left - box.left) / Math.max(1, box.width);
    return Math.min(1, Math.max(0, part));
  }

  private moveCursor(part: number | null): void {
    this.cursorPart = part;
    const us = this.cursorMoment();
    this.placeCursor();
    this.fireEvent("t-cursor", us);
  }

  /** On a moving chart the cursor keeps its place, on one that stands still its moment. */
  private cursorMoment(): number | null {
    const { shown, cursorPart } = this;
    if (shown === null || cursorPart === null) return null;
    return shown.fromUs + cursorPart * lengthOf(shown);
  }

  private placeCursor(): void {
    const { shown, view, overlay, cursorPart } = this;
    const us = this.follow === null ? (this.cursorUs ?? this.cursorMoment()) : this.cursorMoment();
    if (us === null || shown === null || view === null || us < shown.fromUs || us > shown.toUs) {
      overlay?.hideCursor();
      return;
    }
    const part = (us - shown.fromUs) / lengthOf(shown);
    overlay?.showCursor(view.plotBox, part);
    // A chart whose cursor is another's shows the place only: its values stand beside it.
    if (cursorPart === null) overlay?.hideReadOut();
    else overlay?.showReadOut(view.plotBox, part, this.size.width, this.readText(us, shown));
  }

  /** Values near a moment, one for each series. */
  readAt(us: number): CursorValue[] {
    const { shown } = this;
    if (shown === null) return [];
    const width = this.widthUs(shown);
    return this.series.map((series) => cursorValue(series, us, width, REACH * width));
  }

  private readText(us: number, shown: TimeSpan): string {
    const moment = momentText(us, knownZone(this.zone), lengthOf(shown));
    const values = this.readAt(us).map(({ series, text }) => (this.series.length > 1 ? `${series.name} ${text}` : text));
    const gap = this.series.flatMap(({ gaps }) => gaps).find(({ from_us, to_us }) => us >= from_us && us <= to_us);
    return [moment, ...values, ...(gap === undefined ? [] : [gap.reason || msg("no samples")])].join("\n");
  }

  private fireSpanChange(detail: SpanChange): void {
    this.fireEvent("t-span", detail);
  }

  // Out of the chart's own frame, so that what stands around several charts hears all of them.
  private fireEvent(kind: string, detail: unknown): void {
    this.dispatchEvent(new CustomEvent(kind, { detail, bubbles: true, composed: true }));
  }

  private readonly onBlur = (): void => {
    this.moveCursor(null);
  };

  private readonly onKeyDown = (event: KeyboardEvent): void => {
    const { shown } = this;
    if (shown === null || event.ctrlKey || event.metaKey || event.altKey) return;
    const wish = keyAction(event.key, event.shiftKey, this.cursorPart, shown, this.zoomable);
    if (wish === null) return;
    event.preventDefault();
    event.stopPropagation();
    if (wish.wish === "reset") this.fireEvent("t-reset", null);
    else if (wish.wish === "span") this.fireSpanChange({ span: wish.span, settled: false });
    else this.moveCursor(wish.part);
    this.speakSoon();
  };

  /** Said once the keys rest: a screen reader should not be flooded. */
  private speakSoon(): void {
    clearTimeout(this.speakTimer);
    this.speakTimer = setTimeout(() => {
      const us = this.cursorMoment();
      if (us === null || this.shown === null) return;
      this.spoken.textContent = this.readText(us, this.shown).replaceAll("\n", ", ");
    }, 300);
  }
}

/** Windows are made anew with every render; it is their ends that matter. */
function isOther(span: TimeSpan | null, before: TimeSpan | null | undefined): boolean {
  return span?.fromUs !== before?.fromUs || span?.toUs !== before?.toUs;
}

declare global {
  interface HTMLElementTagNameMap {
    "t-chart": Chart;
  }
  interface HTMLElementEventMap {
    "t-span": CustomEvent<SpanChange>;
    "t-cursor": CustomEvent<number | null>;
  }
}
