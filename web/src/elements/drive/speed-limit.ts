/** How fast a full push is: steps of ten per cent, with what that means for this vehicle. */

import { msg, str } from "@lit/localize";
import { css, html, LitElement, type TemplateResult } from "lit";
import { customElement, property, query } from "lit/decorators.js";
import { shownText } from "../../format/unit.js";
import type { ShownUnitShape } from "../../generated/api.js";
import { base, quietText } from "../base/base-style.js";

/**
 * @fires t-level detail is the level that was chosen, 0.1 to 1
 */
@customElement("t-speed-limit")
export class SpeedLimit extends LitElement {
  static override styles = [
    base,
    css`
      :host {
        display: grid;
        gap: var(--t-space-1);
      }
      .head {
        display: flex;
        flex-wrap: wrap;
        align-items: baseline;
        justify-content: space-between;
        gap: 0 var(--t-space-3);
      }
      .head strong {
        font-variant-numeric: tabular-nums;
      }
      .means {
        ${quietText}
        font-variant-numeric: tabular-nums;
      }
      .row {
        display: grid;
        grid-template-columns: auto 1fr auto;
        align-items: center;
        gap: var(--t-space-2);
      }
      button {
        inline-size: var(--t-touch);
        block-size: var(--t-touch);
        border: 1px solid var(--t-edge);
        border-radius: var(--t-radius-s);
        background: var(--t-surface);
        color: var(--t-text);
        font: inherit;
        font-size: var(--t-size-l);
        line-height: 1;
        cursor: pointer;
        touch-action: manipulation;
      }
      button:hover:not(:disabled) {
        background: var(--t-raised);
      }
      button:disabled {
        border-style: dashed;
        color: var(--t-muted);
        cursor: not-allowed;
      }
      input {
        inline-size: 100%;
        min-inline-size: 0;
        block-size: var(--t-touch);
        margin: 0;
        appearance: none;
        background: none;
        cursor: pointer;
        touch-action: pan-y;
      }
      /* Drawn by us: the browser's own track is bright in the night theme. */
      input::-webkit-slider-runnable-track {
        block-size: 0.5rem;
        border-radius: 0.25rem;
        background: linear-gradient(to right, var(--t-accent) var(--filled), var(--t-line) var(--filled));
      }
      input::-moz-range-track {
        block-size: 0.5rem;
        border-radius: 0.25rem;
        background: linear-gradient(to right, var(--t-accent) var(--filled), var(--t-line) var(--filled));
      }
      input::-webkit-slider-thumb {
        appearance: none;
        inline-size: 1.5rem;
        block-size: 1.5rem;
        margin-block-start: -0.5rem;
        border: 3px solid var(--t-surface);
        border-radius: 50%;
        background: var(--t-accent);
        box-shadow: 0 0 0 1px var(--t-accent);
      }
      input::-moz-range-thumb {
        inline-size: 1.125rem;
        block-size: 1.125rem;
        border: 3px solid var(--t-surface);
        border-radius: 50%;
        background: var(--t-accent);
        box-shadow: 0 0 0 1px var(--t-accent);
      }
    `,
  ];

  /** 0.1 to 1 */
  @property({ type: Number }) level = 0.5;
  /** m/s at full level */
  @property({ type: Number }) speed = 0;
  /** rad/s at full level; 0: it does not turn by itself */
  @property({ type: Number }) turn = 0;
  /** How they are shown; null: in m/s and rad/s. */
  @property({ attribute: false }) shownSpeed: ShownUnitShape | null = null;
  @property({ attribute: false }) shownTurn: ShownUnitShape | null = null;
  /** What a full push means, where it is neither of the two. */
  @property() means = "";
  @property({ type: Boolean }) disabled = false;

  @query("input") private readonly slider!: HTMLInputElement;

  override render(): TemplateResult {
    const percent = Math.round(this.level * 100);
    const speed = this.speed > 0 ? shownText({ unit: "m/s", decimals: 2, shown: this.shownSpeed }, this.speed * this.level) : this.means;
    const turn = this.turn > 0 ? shownText({ unit: "rad/s", decimals: 2, shown: this.shownTurn }, this.turn * this.level) : "";
    return html`
      <div class="head">
        <span>${msg(html`Full push is <strong>${percent}&#8239;%</strong>`)}</span>
        <span class="means">${[speed, turn].filter((text) => text !== "").join(" · ")}</span>
      </div>
      <div class="row">
        <button
          type="button"
          aria-label=${msg("Slower")}
          title=${msg("Slower (\u2212)")}
          ?disabled=${this.disabled || percent <= 10}
          @click=${this.slower}
        >
          −
        </button>
        <input
          type="range"
          min="10"
          max="100"
          step="10"
          aria-label=${msg("Speed of a full push, per cent of the limit")}
          aria-valuetext=${speed === "" ? msg(str`${String(percent)} per cent`) : msg(str`${String(percent)} per cent, ${speed}`)}
          .value=${String(percent)}
          ?disabled=${this.disabled}
          @input=${this.onSlide}
        />
        <button
          type="button"
          aria-label=${msg("Faster")}
          title=${msg("Faster (+)")}
          ?disabled=${this.disabled || percent >= 100}
          @click=${this.faster}
        >
          +
        </button>
      </div>
    `;
  }

  // Not as a style attribute: the content security policy of the hub forbids those.
  protected override updated(): void {
    this.slider.style.setProperty("--filled", `${(((this.level - 0.1) / 0.9) * 100).toFixed(1)}%`);
  }

  private readonly onSlide = (event: Event): void => {
    this.choose(Number((event.target as HTMLInputElement).value));
  };

  private readonly slower = (): void => {
    this.choose(Math.round(this.level * 100) - 10);
  };

  private readonly faster = (): void => {
    this.choose(Math.round(this.level * 100) + 10);
  };

  private choose(percent: number): void {
    const detail = Math.min(100, Math.max(10, percent)) / 100;
    this.dispatchEvent(new CustomEvent("t-level", { detail, bubbles: true, composed: true }));
  }
}

declare global {
  interface HTMLElementTagNameMap {
    "t-speed-limit": SpeedLimit;
  }
  interface GlobalEventHandlersEventMap {
    "t-level": CustomEvent<number>;
  }
}
