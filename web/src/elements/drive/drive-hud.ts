/** What a driver reads without looking away from the picture: speed, heading, battery, and what limits them. */

import { msg, str } from "@lit/localize";
import { css, html, LitElement, nothing, svg, type TemplateResult } from "lit";
import { customElement, property } from "lit/decorators.js";
import { formatNumber } from "../../format/number.js";
import { base } from "../base/base-style.js";
import "../base/icon.js";

/** A number as it is shown; NaN: it is not known now. */
export interface HudNumber {
  readonly value: number;
  readonly unit: string;
  readonly decimals: number;
}

export const NO_NUMBER: HudNumber = { value: Number.NaN, unit: "", decimals: 0 };

/** Below this (%) a battery is to be charged. */
const LOW_PERCENT = 20;

@customElement("t-drive-hud")
export class DriveHud extends LitElement {
  static override styles = [
    base,
    css`
      :host {
        display: flex;
        flex-wrap: wrap;
        align-items: end;
        gap: var(--t-space-1);
        font-variant-numeric: tabular-nums;
      }
      /* Solid: words on a picture are read on every picture. */
      .plate {
        display: grid;
        gap: 0 var(--t-space-1);
        padding: 0.1rem var(--t-space-2) 0.2rem;
        border: 1px solid var(--t-line);
        border-radius: var(--t-radius-s);
        background: var(--t-surface);
        line-height: 1.25;
      }
      .name {
        color: var(--t-muted);
        font-size: var(--t-size-s);
      }
      .value {
        font-size: var(--t-size-m);
        font-weight: var(--t-weight-strong);
        white-space: nowrap;
      }
      .speed .value {
        font-size: var(--t-size-l);
      }
      .heading .value {
        display: inline-flex;
        align-items: center;
        gap: 0.35em;
      }
      svg {
        inline-size: 1.1em;
        block-size: 1.1em;
        color: var(--t-accent);
      }
      progress {
        inline-size: 100%;
        block-size: 0.3rem;
        accent-color: var(--t-accent);
      }
      .warn .value,
      .note {
        color: var(--t-warn);
      }
      .note {
        display: flex;
        align-items: center;
        gap: var(--t-space-1);
        font-size: var(--t-size-s);
        font-weight: var(--t-weight-strong);
      }
      @container (inline-size < 26rem) {
        .name {
          display: none;
        }
        .speed .value {
          font-size: var(--t-size-m);
        }
      }
    `,
  ];

  /** How fast it goes, as measured. */
  @property({ attribute: false }) speed: HudNumber = NO_NUMBER;
  /** As fast as a full push lets it go now; in the unit of the speed. */
  @property({ attribute: false }) limit: HudNumber = NO_NUMBER;
  /** ° clockwise from true north, or with `local` counter-clockwise from x of the robot's own frame. */
  @property({ type: Number }) heading = Number.NaN;
  @property({ type: Boolean }) local = false;
  /** The description names what these are read from. */
  @property({ type: Boolean }) steers = false;
  @property({ attribute: false }) battery: HudNumber | null = null;
  /** Why it goes slower than it is asked, or not at all; empty when nothing is in the way. */
  @property() note = "";

  override render(): TemplateResult {
    const { speed, limit, battery } = this;
    return html`<div class="plate speed">
        <span class="name">${msg("Speed")}</span>
        <span class="value">${numberText({ ...speed, value: Math.abs(speed.value) })}${speed.value < 0 ? msg(" back") : ""}</span>
        ${Number.isFinite(limit.value) && limit.value > 0
          ? html`<progress max=${limit.value} .value=${Number.isFinite(speed.value) ? Math.min(limit.value, Math.abs(speed.value)) : 0} aria-label=${msg(str`Speed, of ${numberText(limit)} at a full push`)}></progress>`
          : nothing}
      </div>
      ${Number.isFinite(limit.value) ? html`<div class="plate"><span class="name">${msg("Full push")}</span><span class="value">${numberText(limit)}</span></div>` : nothing}
      ${this.steers ? this.renderHeading() : nothing}
      ${battery === null
        ? nothing
        : html`<div class="plate ${battery.unit === "%" && battery.value < LOW_PERCENT ? "warn" : ""}">
            <span class="name">${msg("Battery")}</span><span class="value">${numberText(battery)}</span>
          </div>`}
      ${this.note === "" ? nothing : html`<div class="plate note"><t-icon name="warn"></t-icon>${this.note}</div>`}`;
  }

  private renderHeading(): TemplateResult {
    const known = Number.isFinite(this.heading);
    // Of its own frame x points up here, and angles grow to the left.
    const turn = this.local ? -this.heading : this.heading;
    return html`<div class="plate heading">
      <span class="name">${this.local ? msg("Yaw") : msg("Heading")}</span>
      <span class="value"
        >${known
          ? html`<svg viewBox="-10 -10 20 20" aria-hidden="true">${svg`<path transform="rotate(${turn.toFixed(0)})" fill="currentColor" d="M0-9 6 8 0 4-6 8Z"></path>`}</svg>${this.local ? formatNumber(this.heading, 0) : String(Math.round(this.heading) % 360).padStart(3, "0")}°`
          : "–"}</span
      >
    </div>`;
  }
}

function numberText({ value, unit, decimals }: HudNumber): string {
  return Number.isFinite(value) ? `${formatNumber(value, decimals)}\u202f${unit}` : "–";
}

declare global {
  interface HTMLElementTagNameMap {
    "t-drive-hud": DriveHud;
  }
}
