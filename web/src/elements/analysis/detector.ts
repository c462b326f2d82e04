/** One anomaly detector of a signal: how it stands, its score over time, why, and "not an anomaly". */

import { msg, str } from "@lit/localize";
import { css, html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, property } from "lit/decorators.js";
import { detectorWords } from "../../format/kinds/detector-kinds.js";
import { formatNumber } from "../../format/number.js";
import { plural } from "../../words/plural.js";
import type { TimeSpan } from "../../series/time-window.js";
import { subjectOf, type Detector } from "../../state/anomaly-detectors.js";
import { base, quietText } from "../base/base-style.js";
import type { ChartMark } from "../chart/draw-marks.js";
import { indentOf, type ChartAxis, type ChartSeries, type FollowWindow, type ChartIndent } from "../chart/chart-model.js";
import type { PaintScheduler } from "../chart/paint-scheduler.js";
import "../forms/button.js";
import "../chart/chart.js";
import "../feedback/status.js";
import "./signal-shares.js";

const SCORE: ChartAxis = { limits: { minimum: 0, maximum: 1 }, least: 1 };

/** @fires t-forgive a person says that the newest anomaly is none; detail is the detector */
@customElement("t-detector")
export class DetectorElement extends LitElement {
  static override styles = [
    base,
    css`
      :host {
        display: grid;
        gap: var(--t-space-1);
        min-inline-size: 0;
      }
      .head {
        display: flex;
        flex-wrap: wrap;
        align-items: center;
        gap: var(--t-space-1) var(--t-space-3);
        font-size: var(--t-size-s);
      }
      .name {
        font-weight: var(--t-weight-strong);
      }
      .score {
        color: var(--t-muted);
        font-variant-numeric: tabular-nums;
      }
      .why {
        ${quietText}
        overflow-wrap: anywhere;
      }
      :host([on]) .why {
        color: var(--t-text);
      }
      .act {
        display: flex;
        flex-wrap: wrap;
        align-items: center;
        gap: var(--t-space-1) var(--t-space-3);
      }
      .act .why {
        flex: 1 1 14rem;
      }
      t-chart {
        margin-inline: calc(-1 * var(--t-space-2));
        block-size: 4.5rem;
      }
    `,
  ];

  @property({ attribute: false }) detector: Detector | null = null;
  /** Names of signals by their addresses, for the shares of a group. */
  @property({ attribute: false }) labels: ReadonlyMap<string, string> = new Map();
  /** With the signal's name before the detector's: where they stand below charts of several. */
  @property({ type: Boolean }) named = false;
  /** The newest score; NaN where it is not shown. */
  @property({ type: Number }) score = NaN;
  @property({ attribute: false }) series: ChartSeries | null = null;
  @property({ attribute: false }) marks: readonly ChartMark[] = [];
  @property({ attribute: false }) span: TimeSpan | null = null;
  @property({ attribute: false }) follow: FollowWindow | null = null;
  @property({ attribute: false }) indent: ChartIndent = indentOf(0, 0);
  @property({ type: Number, attribute: "axis-width" }) axisWidth = 48;
  @property({ attribute: false }) painter: PaintScheduler | null = null;
  @property({ attribute: false }) cursorUs: number | null = null;
  @property() zone = "UTC";
  /** The person may say that something is none. */
  @property({ type: Boolean, attribute: "may-forgive" }) mayForgive = false;
  /** Something is being said to it. */
  @property({ type: Boolean }) busy = false;

  private list: readonly ChartSeries[] = [];

  override render(): TemplateResult | null {
    const { detector, series } = this;
    if (detector === null) return null;
    this.toggleAttribute("on", detector.on);
    return html`<div class="head">
        <span class="name">${this.named ? `${subjectOf(detector)}, ${detectorWords(detector.name)}` : msg(str`Anomaly score, ${detectorWords(detector.name)}`)}</span>
        ${renderStatusOf(detector)}
        <span class="score">${Number.isNaN(this.score) ? nothing : `${formatNumber(this.score, 2)}, `}${msg(str`told from ${formatNumber(detector.bar, 2)}`)}${this.renderScope(detector)}</span>
      </div>
      ${series === null ? nothing : this.renderChart(detector, series)} ${this.renderWords(detector)}
      ${detector.anomaly === null || detector.anomaly.shares.length === 0
          ? nothing
          : html`<t-signal-shares .shares=${detector.anomaly.shares} .labels=${this.labels}></t-signal-shares>`}`;
  }

  /** How many signals a group looks at, how often, and the way of running that it is in. */
  private renderScope({ signals, stepS, mode }: Detector): unknown {
    if (signals.length === 0) return nothing;
    const many = plural(signals.length, msg("1 signal"), msg(str`${String(signals.length)} signals`));
    const often = plural(stepS, msg("once a second"), msg(str`once in ${formatNumber(stepS, 0)} s`));
    return mode === "" ? msg(str`, ${many} ${often}`) : msg(str`, ${many} ${often}, way of running: ${mode}`);
  }

  private renderChart(detector: Detector, series: ChartSeries): TemplateResult {
    if (this.list[0] !== series) this.list = [series];
    return html`<t-chart
      .series=${this.list}
      .marks=${this.marks}
      .level=${detector.bar}
      .span=${this.span}
      .follow=${this.follow}
      .axis=${SCORE}
      .indent=${this.indent}
      .painter=${this.painter}
      .cursorUs=${this.cursorUs}
      axis-width=${this.axisWidth}
      zone=${this.zone}
      label=${msg(str`Anomaly score of ${subjectOf(detector)} by ${detectorWords(detector.name)}`)}
    ></t-chart>`;
  }

  private renderWords(detector: Detector): unknown {
    const { anomaly, on, learns, learning } = detector;
    if (anomaly === null) {
      if (learning === 0) return nothing;
      const group = detector.signals.length > 0;
      const left = formatNumber(learning, 0);
      return html`<p class="why">${group
        ? plural(learning, msg("It learns what is usual for 1 more step, and tells nothing before."), msg(str`It learns what is usual for ${left} more steps, and tells nothing before.`))
        : plural(learning, msg("It learns what is usual for 1 more sample, and tells little before."), msg(str`It learns what is usual for ${left} more samples, and tells little before.`))}</p>`;
    }
    const { why, forgiven } = anomaly;
    const button =
      this.mayForgive && learns && !forgiven
        ? html`<t-button ?disabled=${this.busy} label=${msg(str`Not an anomaly: ${subjectOf(detector)}, ${detectorWords(detector.name)}`)} @click=${this.forgive}>${msg("Not an anomaly")}</t-button>`
        : nothing;
    return html`<div class="act">
      <p class="why">${on ? msg("Now") : msg("Last")}: ${why}${forgiven ? msg(". Someone said that it was none, and it has learned.") : ""}</p>
      ${button}
    </div>`;
  }

  private readonly forgive = (): void => {
    this.dispatchEvent(new CustomEvent("t-forgive", { detail: this.detector, bubbles: true, composed: true }));
  };
}

function renderStatusOf({ on, anomaly, learning }: Detector): TemplateResult {
  if (on) return html`<t-status kind="warn" word=${msg("anomaly")}></t-status>`;
  if (learning > 0) return html`<t-status kind="busy" word=${msg("learning")}></t-status>`;
  return html`<t-status kind="ok" word=${anomaly?.forgiven === true ? msg("as usual, marked") : msg("as usual")}></t-status>`;
}

declare global {
  interface HTMLElementTagNameMap {
    "t-detector": DetectorElement;
  }
  interface HTMLElementEventMap {
    "t-forgive": CustomEvent<Detector>;
  }
}
