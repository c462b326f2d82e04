import { msg, str } from "@lit/localize";
import { css, html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, property } from "lit/decorators.js";
import { formatAge } from "../../format/duration.js";
import type { SeverityLevel } from "../../format/severity.js";
import { decimalsFor, formatNumber, NOTHING } from "../../format/number.js";
import { spokenUnit, unitGap } from "../../format/unit.js";
import { base } from "../base/base-style.js";
import "../base/icon.js";

export type ValueState = "live" | "outside" | "stale" | "unknown" | "unreached" | "forbidden";

/** One reading: a number with its unit, or a word. It says in words when it is not to be trusted. */
@customElement("t-value")
export class Value extends LitElement {
  static override styles = [
    base,
    css`
      :host {
        display: inline-grid;
        /* Where it stands at an end or in the middle, so do its words. */
        justify-items: var(--t-value-align, start);
        font-variant-numeric: tabular-nums;
      }
      .reading {
        font-size: var(--t-size-l);
        font-weight: var(--t-weight-strong);
        line-height: 1.15;
        white-space: nowrap;
      }
      :host([size="s"]) .reading {
        font-size: var(--t-size-m);
      }
      :host([size="l"]) .reading {
        font-size: min(var(--t-size-xl), 16cqi);
      }
      :host([size="xl"]) .reading {
        font-size: min(var(--t-size-xxl), 18cqi);
      }
      .unit {
        font-size: 0.62em;
        font-weight: var(--t-weight);
        color: var(--t-muted);
      }
      :host(:is([state="stale"], [state="outside"])) .reading {
        color: var(--t-stale);
        font-weight: var(--t-weight);
        text-decoration: underline dotted 2px;
        text-underline-offset: 0.2em;
      }
      :host(:is([state="unknown"], [state="unreached"])) .reading,
      :host([state="forbidden"]) .reading {
        color: var(--t-muted);
        font-weight: var(--t-weight);
      }
      :host([state="live"][level="warn"]) .reading {
        color: var(--t-warn);
      }
      :host([state="live"][level="bad"]) .reading {
        color: var(--t-bad);
      }
      .grave {
        inline-size: 1em;
        block-size: 1em;
        margin-inline-end: 0.3em;
        vertical-align: -0.1em;
      }
      .note {
        font-size: var(--t-size-s);
        color: var(--t-stale);
        white-space: nowrap;
      }
    `,
  ];

  /** The number; NaN where there is none, or where `text` says it. */
  @property({ type: Number }) value = Number.NaN;
  /** A word in place of a number: a state, a text. */
  @property() text = "";
  @property() unit = "";
  /** Digits after the point; -1 takes the unit's own. */
  @property({ type: Number }) decimals = -1;
  @property({ reflect: true }) state: ValueState = "live";
  @property({ reflect: true }) size: "s" | "m" | "l" | "xl" = "m";
  /** Age (s), said when stale. */
  @property({ type: Number }) age = Number.NaN;
  /** How grave the robot's own word is. */
  @property({ reflect: true }) level: SeverityLevel = "";
  /** What is said where there is none. */
  @property() missing = msg("no data yet");
  /** No words beside a stale or missing value, where the place is too small. */
  @property({ type: Boolean }) bare = false;

  override render(): TemplateResult {
    return html`<span class="reading">${this.renderReading()}</span>${this.bare ? nothing : this.renderNote()}`;
  }

  private renderReading(): unknown {
    if (this.state === "forbidden") return html`<t-icon name="lock"></t-icon>`;
    if (this.state === "unknown" || this.state === "unreached") return NOTHING;
    if (this.text !== "") {
      return this.level === "" ? this.text : html`<t-icon class="grave" name="warn"></t-icon>${this.text}`;
    }
    const number = formatNumber(this.value, decimalsFor(this.unit, this.decimals));
    if (this.unit === "" || number === NOTHING) return number;
    return html`${number}<span class="unit" aria-hidden="true">${unitGap(this.unit)}${this.unit}</span
      ><span class="visually-hidden"> ${spokenUnit(this.unit)}</span>`;
  }

  private renderNote(): unknown {
    switch (this.state) {
      case "live":
        return nothing;
      case "stale":
        return html`<span class="note">${Number.isNaN(this.age) ? msg("stale") : msg(str`stale, ${formatAge(this.age)}`)}</span>`;
      case "outside":
        return html`<span class="note">${msg("out of range")}</span>`;
      case "unknown":
        return html`<span class="note">${this.missing}</span>`;
      case "unreached":
        return html`<span class="note">${msg("not reached")}</span>`;
      case "forbidden":
        return html`<span class="note">${msg("not yours to see")}</span>`;
    }
  }
}

declare global {
  interface HTMLElementTagNameMap {
    "t-value": Value;
  }
}
