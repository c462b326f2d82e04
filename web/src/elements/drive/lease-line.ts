/** Who has control of a device, and the button to take it or give it back. */

import { msg, str } from "@lit/localize";
import { css, html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, property } from "lit/decorators.js";
import { fixedText } from "../../format/number.js";
import { base, quietText } from "../base/base-style.js";
import type { ButtonKind } from "../forms/button.js";
import "../forms/button.js";
import "../feedback/status.js";

export type LeaseKind = "unknown" | "free" | "asking" | "mine" | "waiting" | "other";

/**
 * @fires t-take control is wanted
 * @fires t-free control is given back, or no longer asked for
 * @fires t-answer detail is true to hand it over to who asks, false to keep it
 * @fires t-force control is taken from a holder who was asked in vain
 */
@customElement("t-lease")
export class LeaseLine extends LitElement {
  static override styles = [
    base,
    css`
      :host {
        display: grid;
        gap: var(--t-space-2);
        align-content: center;
        /* As tall with control as without: what stands below must not move under the thumb. */
        min-block-size: calc(var(--t-touch) + 0.25rem);
      }
      .row {
        display: grid;
        grid-template-columns: minmax(0, 1fr) auto;
        align-items: center;
        gap: var(--t-space-3);
      }
      t-button {
        min-inline-size: 9.5rem;
      }
      .remains {
        ${quietText}
        font-variant-numeric: tabular-nums;
      }
      /* A phone on its side. */
      @media (max-height: 30rem) {
        t-status {
          font-size: var(--t-size-s);
        }
      }
      .who {
        display: grid;
        line-height: 1.25;
      }
      .answers {
        display: flex;
        gap: var(--t-space-2);
      }
      .answers t-button,
      .answers + t-button {
        min-inline-size: 0;
      }
      .who {
        min-inline-size: 0;
      }
      .asked {
        overflow: hidden;
        text-overflow: ellipsis;
        white-space: nowrap;
        color: var(--t-warn);
        font-size: var(--t-size-s);
        font-weight: var(--t-weight-strong);
      }
    `,
  ];

  @property() kind: LeaseKind = "unknown";
  @property() holder = "";
  /** Who asks for the control that I have; empty when nobody does. */
  @property() rival = "";
  /** How long the one who is asked may answer (ms). */
  @property({ type: Number }) answer = 0;
  /** The holder was asked in vain, and this person may force it. */
  @property({ type: Boolean }) forceable = false;
  /** How long it still holds without renewal (ms). */
  @property({ type: Number }) remains = 0;
  @property({ type: Boolean }) online = true;
  /** STOP is latched: control may be taken (the release needs it), but nothing moves. */
  @property({ type: Boolean }) stopped = false;

  // One button for both ways: who took control by keyboard keeps the focus on it.
  override render(): TemplateResult {
    const mine = this.kind === "mine";
    const { word, kind, press } = this.button();
    const asked = mine && this.rival !== "";
    return html`<div class="row">
      ${asked ? this.renderQuestion() : mine ? this.renderMyLease() : this.renderStatus()}
      <span class=${asked ? "answers" : ""}>
        ${asked ? html`<t-button @click=${this.fireKeep}>${msg("Keep", { id: "keep.control" })}</t-button>` : nothing}
        <t-button kind=${kind} ?disabled=${!mine && !this.online} ?busy=${this.kind === "asking"} @click=${press}
          >${word}</t-button
        >
      </span>
    </div>`;
  }

  private button(): { word: string; kind: ButtonKind; press: () => void } {
    switch (this.kind) {
      case "mine":
        // Where "Release control" stood: whoever was about to press that means the same.
        if (this.rival !== "") return { word: msg("Hand over"), kind: "plain", press: this.fireHandOver };
        return { word: msg("Release control"), kind: "plain", press: this.fireFree };
      case "waiting":
        return { word: msg("Withdraw"), kind: "plain", press: this.fireFree };
      case "other":
        if (this.forceable) return { word: msg("Take by force"), kind: "danger", press: this.fireForce };
        return { word: msg("Ask for control"), kind: "primary", press: this.fireTake };
      case "asking":
        return { word: msg("Asking…"), kind: "primary", press: this.fireTake };
      case "unknown":
      case "free":
        return { word: msg("Take control"), kind: "primary", press: this.fireTake };
    }
  }

  private renderQuestion(): TemplateResult {
    return html`<span class="who">
      <span class="asked" role="alert">${msg(str`${this.rival} asks for control`)}</span>
      <span class="remains">${msg(str`${this.seconds()} to answer`)}</span>
    </span>`;
  }

  private seconds(): string {
    return `${Math.ceil(this.answer / 1000).toFixed(0)}\u202fs`;
  }

  private renderMyLease(): TemplateResult {
    const word = this.stopped ? msg("In control, but STOP is on") : msg("You have control");
    return html`<span class="who">
        <t-status kind=${this.stopped ? "warn" : "ok"} .word=${word}></t-status>
        <span class="remains" title=${msg("Renewed every second while this page is seen")}>${msg(str`lease ${fixedText(this.remains / 1000, 1)}\u202fs`)}</span>
      </span>`;
  }

  private renderStatus(): TemplateResult {
    if (!this.online) return html`<t-status kind="offline" word=${msg("Not connected: no driving from here")}></t-status>`;
    switch (this.kind) {
      case "other":
        return html`<t-status kind="busy" .word=${msg(str`${this.holder} has control`)}></t-status>`;
      case "waiting":
        return html`<span class="who">
          <t-status kind="busy" .word=${msg(str`${this.holder} is asked`)}></t-status>
          <span class="remains">${msg(str`${this.seconds()} to answer`)}</span>
        </span>`;
      case "asking":
        return html`<t-status kind="busy" word=${msg("The gateway is asked")}></t-status>`;
      case "free":
        return html`<t-status kind="unknown" word=${msg("Nobody has control")}></t-status>`;
      case "unknown":
      case "mine":
        return html`<t-status kind="unknown" word=${msg("You do not have control")}></t-status>`;
    }
  }

  private readonly fireTake = (): void => {
    if (this.online) this.fireEvent("t-take");
  };

  private readonly fireForce = (): void => {
    if (this.online) this.fireEvent("t-force");
  };

  private readonly fireHandOver = (): void => {
    this.fireEvent("t-answer", true);
  };

  private readonly fireKeep = (): void => {
    this.fireEvent("t-answer", false);
  };

  private readonly fireFree = (): void => {
    this.fireEvent("t-free");
  };

  private fireEvent(name: string, detail?: boolean): void {
    this.dispatchEvent(new CustomEvent(name, { detail, bubbles: true, composed: true }));
  }
}

declare global {
  interface HTMLElementTagNameMap {
    "t-lease": LeaseLine;
  }
}
