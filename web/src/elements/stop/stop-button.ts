/** STOP (software): the one button that is always there. */

import { msg } from "@lit/localize";
import { css, html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, property } from "lit/decorators.js";
import { base } from "../base/base-style.js";
import type { StopShown } from "./stop-labels.js";
import { stopLabel } from "./stop-labels.js";

/**
 * A wide bar, on purpose no red mushroom on yellow: that shape promises an emergency stop in the
 * sense of ISO 13850, which a web page cannot be.
 *
 * @fires t-stop at once when it is touched, not when it is let go
 */
@customElement("t-stop-button")
export class StopButton extends LitElement {
  static override shadowRootOptions: ShadowRootInit = { ...LitElement.shadowRootOptions, delegatesFocus: true };

  static override styles = [
    base,
    css`
      :host {
        display: block;
      }
      button {
        display: grid;
        grid-template-columns: 1fr auto;
        align-items: center;
        gap: 0 var(--t-space-3);
        inline-size: 100%;
        min-block-size: 4rem;
        padding: var(--t-space-2) var(--t-space-4);
        border: 3px solid var(--t-bad);
        border-radius: var(--t-radius);
        background: var(--t-bad);
        color: var(--t-on-bad);
        font: inherit;
        text-align: start;
        cursor: pointer;
        touch-action: manipulation;
        user-select: none;
        -webkit-user-select: none;
        box-shadow: var(--t-shadow);
      }
      @media (max-height: 30rem) {
        button {
          min-block-size: 3.25rem;
          padding-block: 0;
        }
      }
      button:active {
        transform: translateY(1px);
      }
      button:focus-visible {
        outline: 3px solid var(--t-text);
        outline-offset: 2px;
      }
      .word {
        font-size: 1.6rem;
        line-height: 1.1;
        font-weight: 750;
        letter-spacing: 0.04em;
      }
      .word small {
        font-size: var(--t-size-m);
        font-weight: var(--t-weight-strong);
        letter-spacing: 0;
      }
      .state {
        grid-column: 1;
        font-size: var(--t-size-s);
        font-weight: var(--t-weight-strong);
      }
      kbd {
        grid-column: 2;
        grid-row: 1 / 3;
        padding: 0.15rem 0.5rem;
        border: 1px solid currentColor;
        border-radius: var(--t-radius-s);
        font: inherit;
        font-size: var(--t-size-s);
      }
      /* Latched: turned inside out, so that it reads as engaged without colour. */
      :host([engaged]) button {
        border-style: double;
        border-width: 8px;
        padding: calc(var(--t-space-2) - 5px) calc(var(--t-space-4) - 5px);
        background: var(--t-surface);
        color: var(--t-bad);
      }
      @media (pointer: coarse) {
        kbd {
          display: none;
        }
      }
    `,
  ];

  @property({ attribute: false }) stop: StopShown = { phase: "unknown" };
  @property({ type: Boolean }) online = true;
  /** What is said in place of how one device stands: it is of a group. */
  @property() label = "";
  @property({ type: Boolean, reflect: true }) engaged = false;

  override willUpdate(): void {
    this.engaged = this.stop.phase === "latched" || this.stop.phase === "confirmed";
  }

  override render(): TemplateResult {
    const line = this.label === "" ? stopLabel(this.stop, this.online) : this.label;
    return html`<button type="button" @pointerdown=${this.onPointerDown} @click=${this.onClick}>
      <span class="word">${msg(html`STOP <small>(software)</small>`)}</span>
      ${line === "" ? nothing : html`<span class="state" role="status">${line}</span>`}
      <kbd aria-hidden="true">Esc</kbd>
    </button>`;
  }

  private readonly onPointerDown = (event: PointerEvent): void => {
    if (event.button === 0) this.fireStop();
  };

  // A click after a touch would be a second STOP; one by keyboard or by a helper has no detail.
  private readonly onClick = (event: MouseEvent): void => {
    if (event.detail === 0) this.fireStop();
  };

  private fireStop(): void {
    this.dispatchEvent(new CustomEvent("t-stop", { bubbles: true, composed: true }));
  }
}

declare global {
  interface HTMLElementTagNameMap {
    "t-stop-button": StopButton;
  }
}
