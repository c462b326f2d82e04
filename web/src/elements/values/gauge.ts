import { msg } from "@lit/localize";
import { css, html, LitElement, nothing, svg, type TemplateResult } from "lit";
import { customElement, property } from "lit/decorators.js";
import { styled } from "../base/style-directive.js";
import { base } from "../base/base-style.js";
import { decimalsFor, formatNumber } from "../../format/number.js";
import "./value.js";
import type { ValueState } from "./value.js";

const RADIUS = 40;
/** The arc begins and ends so far from straight down (degrees). */
const OPEN = 60;

/** A number between two ends: an arc, or a level that fills. What is beyond a limit says so in a word, too. */
@customElement("t-gauge")
export class Gauge extends LitElement {
  static override styles = [
    base,
    css`
      :host {
        display: grid;
        grid-template-rows: minmax(0, 1fr) auto;
        justify-items: center;
        block-size: 100%;
        min-block-size: 0;
        text-align: center;
        --t-value-align: center;
        --tone: var(--t-accent);
      }
      :host([level="warn"]) {
        --tone: var(--t-warn);
      }
      :host(:is([state="stale"], [state="unknown"], [state="unreached"], [state="outside"])) {
        --tone: var(--t-stale);
      }
      svg {
        inline-size: 100%;
        block-size: 100%;
        min-block-size: 0;
      }
      .ground {
        fill: none;
        stroke: var(--t-raised);
        stroke-width: 10;
        stroke-linecap: round;
      }
      .arc {
        fill: none;
        stroke: var(--tone);
        stroke-width: 10;
        stroke-linecap: round;
      }
      .end {
        fill: var(--t-muted);
        font-size: 8px;
      }
      .tube {
        position: relative;
        inline-size: min(4.5rem, 60%);
        block-size: 100%;
        border: 2px solid var(--t-edge);
        border-radius: var(--t-radius-s);
        overflow: hidden;
      }
      .fill {
        position: absolute;
        inset-inline: 0;
        inset-block-end: 0;
        block-size: var(--part);
        background: var(--tone);
      }
      :host([state="stale"]) .fill {
        background: repeating-linear-gradient(45deg, var(--t-stale) 0 6px, transparent 6px 12px);
      }
      p {
        color: var(--t-warn);
        font-size: var(--t-size-s);
        font-weight: var(--t-weight-strong);
      }
    `,
  ];

  @property({ type: Number }) value = Number.NaN;
  @property() unit = "";
  @property({ type: Number }) decimals = -1;
  @property({ type: Number }) least = 0;
  @property({ type: Number }) most = 100;
  @property() look = "gauge";
  /** What is said where there is no value. */
  @property() missing = msg("no data yet");
  @property({ reflect: true }) state: ValueState = "unknown";
  @property({ type: Number }) age = Number.NaN;
  /** "warn" when it is beyond a limit that somebody set. */
  @property({ reflect: true }) level: "" | "warn" = "";

  override render(): TemplateResult {
    const known = this.state === "live" || this.state === "stale" || this.state === "outside";
    const part = known ? Math.min(1, Math.max(0, (this.value - this.least) / (this.most - this.least))) : 0;
    return html`${this.look === "level" ? this.renderLevel(part) : this.renderArc(known ? part : 0)}
      <div>
        <t-value size="l" .state=${this.state} .value=${this.value} .unit=${this.unit} .decimals=${this.decimals} .age=${this.age} .missing=${this.missing}></t-value>
        ${this.level === "warn" && this.state === "live" ? html`<p>${msg("beyond its limit")}</p>` : nothing}
      </div>`;
  }

  private renderArc(part: number): TemplateResult {
    const text = (value: number): string => formatNumber(value, Math.min(1, decimalsFor(this.unit, this.decimals)));
    return html`<svg viewBox="0 0 100 84" aria-hidden="true">
      <path class="ground" d=${arcPath(1)}></path>
      ${part > 0 ? svg`<path class="arc" d=${arcPath(part)}></path>` : nothing}
      <text class="end" x="14" y="83" text-anchor="middle">${text(this.least)}</text>
      <text class="end" x="86" y="83" text-anchor="middle">${text(this.most)}</text>
    </svg>`;
  }

  private renderLevel(part: number): TemplateResult {
    return html`<div class="tube" aria-hidden="true"><div class="fill" ${styled({ "--part": `${(part * 100).toFixed(1)}%` })}></div></div>`;
  }
}

/** The arc from its beginning through a part of the whole, round (50, 50). */
function arcPath(part: number): string {
  const at = (degrees: number): string => {
    const angle = ((degrees + 90) * Math.PI) / 180;
    return `${(50 + RADIUS * Math.cos(angle)).toFixed(2)} ${(48 + RADIUS * Math.sin(angle)).toFixed(2)}`;
  };
  const sweep = (360 - 2 * OPEN) * part;
  return `M${at(OPEN)}A${String(RADIUS)} ${String(RADIUS)} 0 ${sweep > 180 ? "1" : "0"} 1 ${at(OPEN + sweep)}`;
}

declare global {
  interface HTMLElementTagNameMap {
    "t-gauge": Gauge;
  }
}
