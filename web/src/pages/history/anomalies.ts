/** The anomaly detectors of the chosen signals: score under the charts, why in words, "not an anomaly". */

import { consume } from "@lit/context";
import { css, html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, property } from "lit/decorators.js";
import { repeat } from "lit/directives/repeat.js";
import { ActionController } from "../../controllers/action.js";
import { LoadController } from "../../controllers/load.js";
import { base } from "../../elements/base.js";
import { indentOf, type Axis, type ChartSeries, type Indent } from "../../elements/chart/model.js";
import type { Painter } from "../../elements/chart/painter.js";
import { adviceFor } from "../../format/problem.js";
import type { Span } from "../../series/window.js";
import { apiContext } from "../../state/contexts.js";
import type { AnomalyInfo, AnomalyList, History } from "../../wire/api.js";
import type { HubApi } from "../../wire/http.js";
import { loadedOf } from "./loader.js";
import "../../elements/button.js";
import "../../elements/chart/chart.js";
import "../../elements/problem.js";
import "../../elements/status.js";

const SCORE: Axis = { limits: { minimum: 0, maximum: 1 }, least: 1 };
/** Scores are written at least this often while samples come (µs). */
const WRITTEN_US = 130e6;

@customElement("t-anomalies")
export class Anomalies extends LitElement {
  static override styles = [
    base,
    css`
      :host {
        display: grid;
        gap: var(--t-space-3);
        min-inline-size: 0;
      }
      /* The same room at the sides as the charts above, so that moments stand below each other. */
      .one {
        display: grid;
        gap: var(--t-space-1);
        padding: var(--t-space-3) var(--t-space-3) var(--t-space-2);
        border: 1px solid var(--t-line);
        border-radius: var(--t-radius);
        background: var(--t-surface);
        min-inline-size: 0;
      }
      .head {
        display: flex;
        flex-wrap: wrap;
        align-items: center;
        gap: var(--t-space-1) var(--t-space-3);
      }
      .why {
        flex: 1 1 16rem;
        color: var(--t-muted);
        font-size: var(--t-size-s);
        overflow-wrap: anywhere;
      }
      t-chart {
        margin-inline: calc(-1 * var(--t-space-2));
        block-size: 4.5rem;
      }
    `,
  ];

  @property() site = "";
  @property({ attribute: false }) channels: readonly string[] = [];
  @property({ attribute: false }) span: Span = { fromUs: 0, toUs: 1 };
  @property({ attribute: false }) indent: Indent = indentOf(1, 60);
  @property({ attribute: false }) painter: Painter | null = null;
  @property({ attribute: false }) cursorUs: number | null = null;
  /** The window is being moved: scores are asked for once it rests. */
  @property({ type: Boolean }) moving = false;
  @property({ type: Number }) width = 0;
  @property() zone = "UTC";

  @consume({ context: apiContext, subscribe: true }) private api: HubApi | undefined;

  private readonly detectors = new LoadController<AnomalyList>(this);
  private readonly scores = new LoadController<History>(this);
  private readonly action = new ActionController(this);
  private series = new Map<string, ChartSeries>();
  private drawnOf: History | undefined;

  protected override willUpdate(): void {
    const { api, site, span, width } = this;
    if (api === undefined || site === "" || width === 0 || this.moving) return;
    const { fromUs, toUs } = span;
    // A window that follows the time is asked for anew now and then, not with each step.
    const step = Math.max(1, (toUs - fromUs) / 60);
    const key = `${site} ${String(Math.round(fromUs / step))} ${String(Math.round(step))}`;
    this.detectors.ask(key, () => api.anomalies(site));
    const channels = this.shown().map(({ scores }) => scores);
    if (channels.length === 0) return;
    this.scores.ask(`${key} ${channels.join(" ")}`, () => api.history(site, { channels, fromUs, toUs, width }));
    if (this.scores.value !== this.drawnOf) this.draw(this.scores.value);
  }

  override render(): unknown {
    const detectors = this.detectors.result;
    if (detectors.state === "failed") {
      const advice = adviceFor(detectors.error, "the anomaly detectors");
      return html`<t-problem what=${advice.what} how=${advice.how} retry="Try again" @t-retry=${this.again}></t-problem>`;
    }
    const shown = this.shown();
    if (shown.length === 0) return nothing;
    const { problem, done } = this.action;
    return html`<h2>Anomalies</h2>
      <p role="status" class="why">${done}</p>
      ${problem === null ? nothing : html`<t-problem what=${problem.what} how=${problem.how}></t-problem>`}
      ${repeat(
        shown,
        ({ scores }) => scores,
        (one) => this.one(one),
      )}`;
  }

  private one(one: AnomalyInfo): TemplateResult {
    const on = one.began_us >= 0;
    const series = this.series.get(one.scores);
    return html`<div class="one">
      <div class="head">
        <strong>${one.address}, ${one.name}</strong>
        <t-status kind=${on ? "warn" : "ok"} word=${on ? "anomaly" : "as usual"}></t-status>
        <span class="why">score ${one.score.toFixed(2)}, told from ${one.bar.toFixed(2)}${one.why === "" ? "" : `; ${on ? "now" : "last"}: ${one.why}`}</span>
        ${
          this.detectors.value?.may_forgive === true && one.why !== "" && one.detector !== "limits"
            ? html`<t-button ?disabled=${this.action.busy} data-detector=${one.scores} @click=${this.forgiveIt}>Not an anomaly</t-button>`
            : nothing
        }
      </div>
      ${
        series === undefined
          ? nothing
          : html`<t-chart
              .series=${[series]}
              .span=${this.span}
              .axis=${SCORE}
              .indent=${this.indent}
              .painter=${this.painter}
              .cursorUs=${this.cursorUs}
              axis-width=${this.indent.left}
              zone=${this.zone}
              label=${`Anomaly score of ${one.address} by ${one.name}`}
            ></t-chart>`
      }
    </div>`;
  }

  /** Detectors of the signals that are shown. */
  private shown(): readonly AnomalyInfo[] {
    return (this.detectors.value?.detectors ?? []).filter(({ address }) => this.channels.includes(address));
  }

  private draw(history: History | undefined): void {
    this.drawnOf = history;
    this.series = new Map(
      (history?.series ?? []).map((one, colour): [string, ChartSeries] => {
        const { trace, gaps } = loadedOf(one, WRITTEN_US);
        const plain = { address: one.address, name: "Score", unit: "", decimals: 2, states: [], stale: false };
        return [one.address, { ...plain, colour, samples: trace, gaps }];
      }),
    );
  }

  private readonly forgiveIt = (event: Event): void => {
    const asked = event.currentTarget instanceof HTMLElement ? event.currentTarget.dataset["detector"] : undefined;
    const one = this.shown().find(({ scores }) => scores === asked);
    if (one !== undefined) void this.forgive(one);
  };

  private async forgive({ address, detector, name }: AnomalyInfo): Promise<void> {
    const { api, site } = this;
    if (api === undefined) return;
    const done = await this.action.run("tell the detector", () => api.forgive(site, address, detector), `Noted: ${address} is as usual for “${name}”.`);
    if (done) this.again();
  }

  private readonly again = (): void => {
    this.detectors.again();
  };
}

declare global {
  interface HTMLElementTagNameMap {
    "t-anomalies": Anomalies;
  }
}
