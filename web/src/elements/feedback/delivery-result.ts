/** How a test message went: taken, or not and why, in the words of whoever refused it. */

import { msg } from "@lit/localize";
import { css, html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, property } from "lit/decorators.js";
import type { WentShape } from "../../generated/api.js";
import { base } from "../base/base-style.js";
import "./status.js";

@customElement("t-went")
export class DeliveryResult extends LitElement {
  static override styles = [
    base,
    css`
      :host {
        display: block;
        overflow-wrap: anywhere;
      }
    `,
  ];

  /** Null: nothing was tried. */
  @property({ attribute: false }) went: WentShape | null = null;

  override render(): TemplateResult {
    return html`<div role="status">${this.went === null ? nothing : this.renderMessage(this.went)}</div>`;
  }

  private renderMessage({ sent, problem }: WentShape): TemplateResult {
    return sent
      ? html`<t-status kind="ok" word=${msg("the test was taken")}></t-status>`
      : html`<t-status kind="bad" word=${msg("not sent")}></t-status> ${problem}`;
  }
}

declare global {
  interface HTMLElementTagNameMap {
    "t-went": DeliveryResult;
  }
}
