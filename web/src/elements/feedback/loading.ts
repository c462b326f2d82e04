import { msg } from "@lit/localize";
import { css, html, LitElement, type TemplateResult } from "lit";
import { customElement, property } from "lit/decorators.js";
import { base } from "../base/base-style.js";

/** Something is on its way. Shows itself only after a moment, so that quick things do not flash. */
@customElement("t-loading")
export class LoadingIndicator extends LitElement {
  static override styles = [
    base,
    css`
      :host {
        display: flex;
        align-items: center;
        justify-content: center;
        gap: var(--t-space-3);
        padding: var(--t-space-5);
        color: var(--t-muted);
        animation: appear 0.2s 0.25s both;
      }
      .ring {
        inline-size: 1.25em;
        block-size: 1.25em;
        border: 2px solid var(--t-line);
        border-block-start-color: var(--t-accent);
        border-radius: 50%;
        /* Not before it is seen: what turns asks for every frame. */
        animation: turn 1s 0.25s linear infinite;
      }
      @keyframes appear {
        from {
          opacity: 0;
        }
      }
      @keyframes turn {
        to {
          rotate: 1turn;
        }
      }
    `,
  ];

  @property() what = msg("Loading");

  override connectedCallback(): void {
    super.connectedCallback();
    this.setAttribute("role", "status");
  }

  override render(): TemplateResult {
    return html`<span class="ring"></span><span>${this.what}…</span>`;
  }
}

declare global {
  interface HTMLElementTagNameMap {
    "t-loading": LoadingIndicator;
  }
}
