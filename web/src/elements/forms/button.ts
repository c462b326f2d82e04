import { css, html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, property } from "lit/decorators.js";
import { base } from "../base/base-style.js";

export type ButtonKind = "plain" | "primary" | "danger" | "quiet";

/**
 * A button. With `type="submit"` it submits the form around it.
 *
 * @slot - its words, and an icon if it has one
 */
@customElement("t-button")
export class Button extends LitElement {
  static override shadowRootOptions: ShadowRootInit = { ...LitElement.shadowRootOptions, delegatesFocus: true };

  static override styles = [
    base,
    css`
      :host {
        display: inline-block;
      }
      button {
        display: inline-flex;
        align-items: center;
        justify-content: center;
        gap: var(--t-space-2);
        inline-size: 100%;
        min-block-size: var(--t-touch);
        padding: var(--t-space-1) var(--t-space-4);
        border: 1px solid var(--t-edge);
        border-radius: var(--t-radius-s);
        background: var(--t-surface);
        color: var(--t-text);
        font: inherit;
        font-weight: var(--t-weight-strong);
        cursor: pointer;
        touch-action: manipulation;
        user-select: none;
      }
      button:hover:not(:disabled, [aria-disabled="true"]) {
        background: var(--t-raised);
      }
      :host([kind="primary"]) button {
        border-color: var(--t-accent);
        background: var(--t-accent);
        color: var(--t-on-accent);
      }
      :host([kind="danger"]) button {
        border-color: var(--t-bad);
        background: var(--t-bad);
        color: var(--t-on-bad);
      }
      :host([kind="primary"]) button:hover:not(:disabled, [aria-disabled="true"]),
      :host([kind="danger"]) button:hover:not(:disabled, [aria-disabled="true"]) {
        box-shadow: inset 0 0 0 2px color-mix(in srgb, currentColor 45%, transparent);
      }
      :host([kind="quiet"]) button {
        border-color: transparent;
        background: transparent;
        padding-inline: var(--t-space-3);
      }
      :host([kind="quiet"]) button:hover:not(:disabled, [aria-disabled="true"]) {
        background: var(--t-raised);
      }
      button[aria-pressed="true"] {
        border-color: var(--t-accent);
        background: var(--t-raised);
        box-shadow: inset 0 0 0 1px var(--t-accent);
        color: var(--t-accent);
      }
      button[aria-disabled="true"],
      button:disabled {
        border-style: dashed;
        border-color: var(--t-edge);
        background: transparent;
        color: var(--t-muted);
        cursor: not-allowed;
      }
      :host([kind="primary"]) button:is(:disabled, [aria-disabled="true"]),
      :host([kind="danger"]) button:is(:disabled, [aria-disabled="true"]) {
        border-color: var(--t-edge);
        background: transparent;
        color: var(--t-muted);
      }
    `,
  ];

  @property({ reflect: true }) kind: ButtonKind = "plain";
  @property() type: "button" | "submit" = "button";
  @property({ type: Boolean, reflect: true }) disabled = false;
  /** Something is under way: it can not be pressed again, and says so. */
  @property({ type: Boolean, reflect: true }) busy = false;
  /** Name for screen readers, where the words alone do not say it. */
  @property() label = "";
  /** "true" or "false" makes it a toggle. */
  @property() pressed: "true" | "false" | "" = "";

  override render(): TemplateResult {
    return html`<button
      type="button"
      ?disabled=${this.disabled}
      aria-disabled=${this.busy ? "true" : nothing}
      aria-busy=${this.busy ? "true" : "false"}
      aria-label=${this.label || nothing}
      aria-pressed=${this.pressed || nothing}
      @click=${this.ignoreSecondPress}
    >
      <slot></slot>
    </button>`;
  }

  private readonly ignoreSecondPress = (event: Event): void => {
    // Not disabled while busy: that would take the focus away from whoever came by keyboard.
    if (this.busy) {
      event.stopImmediatePropagation();
      return;
    }
    if (this.type === "submit") this.closest("form")?.requestSubmit();
  };
}

declare global {
  interface HTMLElementTagNameMap {
    "t-button": Button;
  }
}
