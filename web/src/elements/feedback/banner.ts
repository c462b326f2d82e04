import { css, html, LitElement, type TemplateResult } from "lit";
import { customElement, property } from "lit/decorators.js";
import { base } from "../base/base-style.js";
import "../base/icon.js";

/**
 * A strip over the page while something is so: the link is lost, an interlock is overridden.
 *
 * @slot - what is so, and what it means
 */
@customElement("t-banner")
export class Banner extends LitElement {
  static override styles = [
    base,
    css`
      :host {
        display: flex;
        align-items: center;
        gap: var(--t-space-2);
        padding: var(--t-space-2) var(--t-space-4);
        border-block-end: 1px solid var(--t-line);
        border-inline-start: 4px solid var(--t-info);
        background: var(--t-raised);
        color: var(--t-text);
      }
      t-icon {
        color: var(--t-info);
      }
      :host([kind="warn"]) {
        border-inline-start-color: var(--t-warn);
      }
      :host([kind="warn"]) t-icon {
        color: var(--t-warn);
      }
      :host([kind="bad"]) {
        border-inline-start-color: var(--t-bad);
      }
      :host([kind="bad"]) t-icon {
        color: var(--t-bad);
      }
    `,
  ];

  @property({ reflect: true }) kind: "info" | "warn" | "bad" = "info";

  override connectedCallback(): void {
    super.connectedCallback();
    this.setAttribute("role", "status");
  }

  override render(): TemplateResult {
    return html`<t-icon name=${this.kind === "info" ? "info" : "warn"}></t-icon><span><slot></slot></span>`;
  }
}

declare global {
  interface HTMLElementTagNameMap {
    "t-banner": Banner;
  }
}
