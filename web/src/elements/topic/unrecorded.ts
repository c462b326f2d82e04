/** No recording holds a moment: says so, and leads to the nearest that there is. */

import { msg } from "@lit/localize";
import { css, html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, property } from "lit/decorators.js";
import { StoreController } from "../../controllers/store-controller.js";
import { timeText } from "../../format/time.js";
import type { PastBoard } from "../../state/past/past-board.js";
import { base, quietText } from "../base/base-style.js";
import "../base/icon.js";
import "../forms/button.js";

@customElement("t-unrecorded")
export class Unrecorded extends LitElement {
  static override styles = [
    base,
    css`
      :host {
        display: grid;
        align-content: center;
        justify-items: center;
        gap: var(--t-space-1);
        min-block-size: 6rem;
        ${quietText}
        text-align: center;
      }
      strong {
        color: var(--t-text);
      }
      .ways {
        display: flex;
        flex-wrap: wrap;
        justify-content: center;
        gap: var(--t-space-1);
      }
    `,
  ];

  @property({ attribute: false }) past: PastBoard | null = null;
  @property() zone = "UTC";
  /** What is not there, as a sentence. */
  @property() what = "";

  private readonly watched = new StoreController(this);

  protected override willUpdate(): void {
    this.watched.setStore(this.past);
  }

  override render(): TemplateResult {
    const moment = this.past?.topics.moment ?? null;
    return html`<t-icon name="history"></t-icon><strong>${msg("Nothing was recorded at this moment")}</strong>
      ${this.what === "" ? nothing : html`<span>${this.what}</span>`}
      ${moment === null ? nothing : html`<span class="ways">${this.renderWay(msg("Before, until"), moment.earlier_us)}${this.renderWay(msg("Next, from"), moment.later_us)}</span>`}
      ${moment?.problems.map((problem) => html`<span>${problem}</span>`) ?? nothing}`;
  }

  private renderWay(word: string, us: number | null): TemplateResult | typeof nothing {
    const { past } = this;
    if (us === null || past === null) return nothing;
    const go = (): void => {
      past.seek(us);
    };
    return html`<t-button kind="quiet" @click=${go}>${word} ${timeText(us, this.zone, past.us).local}</t-button>`;
  }
}

declare global {
  interface HTMLElementTagNameMap {
    "t-unrecorded": Unrecorded;
  }
}
