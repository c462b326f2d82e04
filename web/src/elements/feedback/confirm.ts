import { msg } from "@lit/localize";
import { css, html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, property } from "lit/decorators.js";
import type { Advice } from "../../format/error-advice.js";
import { base } from "../base/base-style.js";
import type { ButtonKind } from "../forms/button.js";
import "../forms/button.js";
import "./dialog.js";
import "./problem.js";

/**
 * Asks before something is done that is hard to take back. The careful answer comes first.
 *
 * @slot - what will happen, and whatever has to be typed for it
 * @fires t-confirm the person wants it
 * @fires t-close it was closed, by whatever way
 */
@customElement("t-confirm")
export class Confirm extends LitElement {
  static override styles = [
    base,
    css`
      /* Takes no place where it stands; its dialog is above everything. */
      :host {
        position: absolute;
      }
      .inside {
        display: grid;
        gap: var(--t-space-3);
        overflow-wrap: anywhere;
      }
    `,
  ];

  @property({ type: Boolean }) open = false;
  @property() heading = "";
  /** The button's words: what is done, as a verb. */
  @property() action = "";
  @property() kind: ButtonKind = "danger";
  /** The words of the way out. */
  @property() keep = msg("Cancel");
  @property({ type: Boolean }) busy = false;
  @property({ attribute: false }) problem: Advice | null = null;

  override render(): TemplateResult {
    return html`<t-dialog heading=${this.heading} ?open=${this.open} @t-close=${this.onClosed}>
      <div class="inside">
        <slot></slot>
        ${this.problem === null
          ? nothing
          : html`<t-problem what=${this.problem.what} how=${this.problem.how}></t-problem>`}
      </div>
      <t-button slot="actions" @click=${this.onCancel}>${this.keep}</t-button>
      <t-button slot="actions" kind=${this.kind} ?busy=${this.busy} @click=${this.onConfirm}>${this.action}</t-button>
    </t-dialog>`;
  }

  private readonly onCancel = (): void => {
    this.open = false;
  };

  private readonly onConfirm = (): void => {
    this.dispatchEvent(new CustomEvent("t-confirm"));
  };

  private readonly onClosed = (): void => {
    this.open = false;
    this.dispatchEvent(new CustomEvent("t-close"));
  };
}

declare global {
  interface HTMLElementTagNameMap {
    "t-confirm": Confirm;
  }
}
