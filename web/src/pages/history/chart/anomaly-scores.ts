/** The anomaly detectors of the chosen signals: score under the charts, why in words, "not an anomaly". */

import { consume } from "@lit/context";
import { msg, str } from "@lit/localize";
import { css, html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, property } from "lit/decorators.js";
import { repeat } from "lit/directives/repeat.js";
import { ActionController } from "../../../controllers/action.js";
import { AnomalyDetectorsController, type AnomalySource } from "../../../controllers/anomaly-detectors.js";
import { LoadController } from "../../../controllers/load.js";
import { base, panelBox, quietText } from "../../../elements/base/base-style.js";
import { indentOf, type ChartSeries, type ChartIndent } from "../../../elements/chart/chart-model.js";
import type { PaintScheduler } from "../../../elements/chart/paint-scheduler.js";
import { anomalyMarks } from "../../../elements/chart/anomaly-marks.js";
import { detectorWords } from "../../../format/kinds/detector-kinds.js";
import { adviceFor } from "../../../format/error-advice.js";
import type { TimeSpan } from "../../../series/time-window.js";
import { apiContext } from "../../../state/contexts.js";
import { subjectOf, type Detector } from "../../../state/anomaly-detectors.js";
import type { HistoryAnswer } from "../../../generated/api.js";
import type { HistoryQuery, HubApi } from "../../../wire/hub-api.js";
import { loadedSeries } from "../data/history-loader.js";
import { renderAdvice } from "../../../elements/feedback/load-state.js";
import "../../../elements/analysis/detector.js";
import "../../../elements/feedback/loading.js";

/** Scores are written at least this often while samples come (µs). */
const WRITTEN_US = 130e6;

/** What this needs of the hub's HTTP interface. */
export interface ScoreSource extends AnomalySource {
  history(site: string, query: HistoryQuery): Promise<HistoryAnswer>;
  dismissAnomaly(site: string, address: string, detector: string): Promise<boolean>;
}

@customElement("t-anomalies")
export class AnomalyScores extends LitElement {
  static override styles = [
    base,
    css`
      :host {
        display: grid;
        gap: var(--t-space-3);
        min-inline-size: 0;
      }
      /* The same room at the sides as the charts above, so that moments stand below each other. */
      t-detector {
        padding: var(--t-space-3) var(--t-space-3) var(--t-space-2);
        ${panelBox}
      }
      .said {
        ${quietText}
      }
      .said:empty {
        display: none;
      }
    `,
  ];

  @property() site = "";
  /** Names the site's description: another one has other detectors. */
  @property() edition = "";
  @property({ attribute: false }) channels: readonly string[] = [];
  @property({ attribute: false }) span: TimeSpan = { fromUs: 0, toUs: 1 };
  @property({ attribute: false }) indent: ChartIndent = indentOf(1, 60);
  @property({ attribute: false }) painter: PaintScheduler | null = null;
  @property({ attribute: false }) cursorUs: number | null = null;
  /** The window is being moved: scores are asked for once it rests. */
  @property({ type: Boolean }) moving = false;
  @property({ type: Number }) width = 0;
  @property() zone = "UTC";

  /** Names of signals by their addresses; without them addresses stand there. */
  @property({ attribute: false }) labels: ReadonlyMap<string, string> = new Map();
  /** No heading: it stands on a page of its own. */
  @property({ type: Boolean }) bare = false;

  /** Answers in the hub's place; the gallery has one for each state. */
  @property({ attribute: false }) hub: ScoreSource | null = null;

  @consume({ context: apiContext, subscribe: true }) private readonly api: HubApi | undefined;

  private readonly detectors = new AnomalyDetectorsController(this);
  private readonly scores = new LoadController<HistoryAnswer>(this);
  private readonly action = new ActionController(this);
  private series = new Map<string, ChartSeries>();
  private drawnOf: HistoryAnswer | undefined;

  protected override willUpdate(): void {
    const { site, span, width } = this;
    const api = this.hub ?? this.api;
    if (api === undefined || site === "") return;
    this.detectors.loadDetectors(api, site, this.edition);
    if (width === 0 || this.moving) return;
    const { fromUs, toUs } = span;
    const channels = this.shownDetectors().map(({ scores }) => scores);
    if (channels.length === 0) return;
    // A window that follows the time is asked for anew now and then, not with each step.
    const step = Math.max(1, (toUs - fromUs) / 60);
    const key = `${site} ${String(Math.round(fromUs / step))} ${String(Math.round(step))} ${channels.join(" ")}`;
    this.scores.load(key, () => api.history(site, { channels, fromUs, toUs, width }));
    if (this.scores.value !== this.drawnOf) this.buildSeries(this.scores.value);
  }

  override render(): unknown {
    if (this.detectors.state === "failed") {
      const advice = adviceFor(this.detectors.renderError, msg("the anomaly detectors"));
      return html`<h2>${msg("Anomalies")}</h2>
        ${renderAdvice(advice, this.retry)}`;
    }
    if (!this.detectors.hasList) return html`<t-loading what=${msg("Loading the anomaly detectors")}></t-loading>`;
    const shown = this.shownDetectors();
    if (shown.length === 0) {
      // A site without any detector need not be told so below every chart.
      if (this.detectors.book.list.length === 0) return nothing;
      return html`<p class="said">${msg("No anomaly detector watches these signals.")}</p>`;
    }
    const { problem, doneText: done } = this.action;
    return html`${this.bare ? nothing : html`<h2>${msg("Anomalies")}</h2>`}
      <p role="status" class="said">${done}</p>
      ${renderAdvice(problem)}
      ${this.scores.result.state === "failed" ? this.renderNoScores(this.scores.result.error) : nothing}
      ${repeat(
        shown,
        ({ scores }) => scores,
        (detector) => this.renderDetector(detector),
      )}`;
  }

  private renderNoScores(error: unknown): TemplateResult {
    return renderAdvice(adviceFor(error, msg("the scores of before")), this.retryScores);
  }

  private renderDetector(detector: Detector): TemplateResult {
    return html`<t-detector
      named
      .labels=${this.labels}
      .detector=${detector}
      .series=${this.series.get(detector.scores) ?? null}
      .marks=${detector.anomaly === null ? [] : anomalyMarks([detector.anomaly])}
      .span=${this.span}
      .indent=${this.indent}
      .painter=${this.painter}
      .cursorUs=${this.cursorUs}
      axis-width=${this.indent.left}
      zone=${this.zone}
      ?may-forgive=${this.detectors.book.mayForgive}
      ?busy=${this.action.busy}
      @t-forgive=${this.onForgive}
    ></t-detector>`;
  }

  /** Detectors of the signals that are shown, and of the groups that look at any of them. */
  private shownDetectors(): readonly Detector[] {
    const chosen = new Set(this.channels);
    return this.detectors.book.list.filter(({ address, signals }) => chosen.has(address) || signals.some((signal) => chosen.has(signal)));
  }

  private buildSeries(history: HistoryAnswer | undefined): void {
    this.drawnOf = history;
    this.series = new Map(
      (history?.series ?? []).map((series, colour): [string, ChartSeries] => {
        const { trace, gaps } = loadedSeries(series, WRITTEN_US);
        const plain = { address: series.address, name: msg("Score"), unit: "", decimals: 2, states: [], stale: false };
        return [series.address, { ...plain, colour, samples: trace, gaps }];
      }),
    );
  }

  private readonly onForgive = (event: CustomEvent<Detector>): void => {
    event.stopPropagation();
    void this.forgive(event.detail);
  };

  private async forgive(said: Detector): Promise<void> {
    const { address, detector, name } = said;
    const { site } = this;
    const api = this.hub ?? this.api;
    if (api === undefined) return;
    const done = await this.action.run(msg("tell the detector"), () => api.dismissAnomaly(site, address, detector), msg(str`Noted: ${subjectOf(said)} is as usual for “${detectorWords(name)}”.`));
    if (done) this.retry();
  }

  private readonly retry = (): void => {
    this.detectors.retry();
  };

  private readonly retryScores = (): void => {
    this.scores.invalidate();
  };
}

declare global {
  interface HTMLElementTagNameMap {
    "t-anomalies": AnomalyScores;
  }
}
