/** How the history page shows what is chosen. */

import { css, html, LitElement, type TemplateResult } from "lit";
import { customElement, property } from "lit/decorators.js";
import { base } from "../../elements/base.js";
import type { HistoryView } from "./query.js";
import "../../elements/button.js";

/** @fires t-view detail is what of the view is asked to be otherwise */
@customElement("t-view-options")
export class ViewOptions extends LitElement {
  static override styles = [
    base,
    css`
      :host {
        display: flex;
        flex-wrap: wrap;
        align-items: center;
        gap: var(--t-space-2);
      }
    `,
  ];

  @property({ attribute: false }) view: HistoryView | null = null;

  override render(): TemplateResult | null {
    const { view } = this;
    if (view === null) return null;
    return html`<t-button pressed=${view.joined ? "true" : "false"} @click=${this.join}>Units in one chart</t-button>`;
  }

  private readonly join = (): void => {
    this.tell({ joined: this.view?.joined !== true });
  };

  private tell(detail: Partial<HistoryView>): void {
    this.dispatchEvent(new CustomEvent("t-view", { detail }));
  }
}

declare global {
  interface HTMLElementTagNameMap {
    "t-view-options": ViewOptions;
  }
  interface HTMLElementEventMap {
    "t-view": CustomEvent<Partial<HistoryView>>;
  }
}
