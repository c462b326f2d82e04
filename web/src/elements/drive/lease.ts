/** Who has control of a device, and the button to take it or give it back. */

import { css, html, LitElement, type TemplateResult } from "lit";
import { customElement, property } from "lit/decorators.js";
import { base } from "../base.js";
import "../button.js";
import "../status.js";

export type LeaseKind = "unknown" | "free" | "asking" | "mine" | "other";

/**
 * @fires t-take control is wanted
 * @fires t-free control is given back
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
        color: var(--t-muted);
        font-size: var(--t-size-s);
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
    `,
  ];

  @property() kind: LeaseKind = "unknown";
  @property() holder = "";
  /** How long it still holds without renewal (ms). */
  @property({ type: Number }) remains = 0;
  @property({ type: Boolean }) online = true;
  /** STOP is latched: control may be taken (the release needs it), but nothing moves. */
  @property({ type: Boolean }) stopped = false;

  // One button for both ways: who took control by keyboard keeps the focus on it.
  override render(): TemplateResult {
    const mine = this.kind === "mine";
    return html`<div class="row">
      ${mine ? this.mine() : this.standing()}
      <t-button
        kind=${mine ? "plain" : "primary"}
        ?disabled=${!mine && (!this.online || this.kind === "other")}
        ?busy=${this.kind === "asking"}
        @click=${mine ? this.free : this.take}
        >${mine ? "Release control" : this.kind === "asking" ? "Asking…" : "Take control"}</t-button
      >
    </div>`;
  }

  private mine(): TemplateResult {
    const word = this.stopped ? "In control, but STOP is on" : "You have control";
    return html`<span class="who">
        <t-status kind=${this.stopped ? "warn" : "ok"} .word=${word}></t-status>
        <span class="remains" title="Renewed every second while this page is seen">lease ${(this.remains / 1000).toFixed(1)}&#8239;s</span>
      </span>`;
  }

  private standing(): TemplateResult {
    if (!this.online) return html`<t-status kind="offline" word="Not connected: no driving from here"></t-status>`;
    switch (this.kind) {
      case "other":
        return html`<t-status kind="busy" .word=${`${this.holder} has control`}></t-status>`;
      case "asking":
        return html`<t-status kind="busy" word="The gateway is asked"></t-status>`;
      case "free":
        return html`<t-status kind="unknown" word="Nobody has control"></t-status>`;
      case "unknown":
      case "mine":
        return html`<t-status kind="unknown" word="You do not have control"></t-status>`;
    }
  }

  private readonly take = (): void => {
    if (this.online && this.kind !== "other") this.fire("t-take");
  };

  private readonly free = (): void => {
    this.fire("t-free");
  };

  private fire(name: string): void {
    this.dispatchEvent(new CustomEvent(name, { bubbles: true, composed: true }));
  }
}

declare global {
  interface HTMLElementTagNameMap {
    "t-lease": LeaseLine;
  }
}
