import { css, html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, property, query, state } from "lit/decorators.js";
import { base, raisedBox } from "../base/base-style.js";
import "../base/icon.js";

/**
 * A button that unfolds a small panel. Escape, a press outside, and leaving it with the focus close it.
 *
 * @slot label - what the button shows
 * @slot - the panel
 */
@customElement("t-menu")
export class Menu extends LitElement {
  static override styles = [
    base,
    css`
      :host {
        position: relative;
        display: inline-block;
      }
      button {
        display: inline-flex;
        align-items: center;
        gap: var(--t-space-1);
        min-block-size: var(--t-touch);
        padding-inline: var(--t-space-2);
        border: 1px solid transparent;
        border-radius: var(--t-radius-s);
        background: transparent;
        color: inherit;
        font: inherit;
        cursor: pointer;
      }
      button:hover,
      button[aria-expanded="true"] {
        background: var(--t-raised);
      }
      /* At the lower edge of the window there is room above only. */
      :host([up]) .panel {
        inset-block: auto calc(100% + var(--t-space-1));
      }
      .panel {
        position: absolute;
        inset-block-start: calc(100% + var(--t-space-1));
        inset-inline-end: 0;
        z-index: 30;
        display: grid;
        gap: var(--t-space-3);
        min-inline-size: var(--t-menu-width, 19rem);
        max-inline-size: calc(100vw - 2 * var(--t-space-3));
        padding: var(--t-space-4);
        ${raisedBox}
      }
    `,
  ];

  /** Name of the button for screen readers. */
  @property() label = "";
  /** The panel unfolds upwards. */
  @property({ type: Boolean, reflect: true }) up = false;
  @state() private open = false;
  @query("button") private readonly button!: HTMLButtonElement;

  override connectedCallback(): void {
    super.connectedCallback();
    document.addEventListener("pointerdown", this.onOutsidePress);
  }

  override disconnectedCallback(): void {
    super.disconnectedCallback();
    document.removeEventListener("pointerdown", this.onOutsidePress);
  }

  override render(): TemplateResult {
    return html`
      <button
        part="button"
        type="button"
        aria-label=${this.label || nothing}
        aria-expanded=${this.open ? "true" : "false"}
        aria-controls="panel"
        @click=${this.toggle}
      >
        <slot name="label"></slot><t-icon name="down"></t-icon>
      </button>
      <div id="panel" class="panel" ?hidden=${!this.open} @keydown=${this.onEscapeKey} @focusout=${this.onFocusOut}>
        <slot></slot>
      </div>
    `;
  }

  /** Folds it again. */
  close(): void {
    this.open = false;
  }

  private readonly onOutsidePress = (event: Event): void => {
    if (!event.composedPath().includes(this)) this.close();
  };

  private readonly toggle = (): void => {
    this.open = !this.open;
  };

  private readonly onEscapeKey = (event: KeyboardEvent): void => {
    if (event.key !== "Escape") return;
    this.close();
    this.button.focus();
  };

  private readonly onFocusOut = (event: FocusEvent): void => {
    const to = event.relatedTarget;
    if (to instanceof Node && !this.contains(to) && to !== this) this.close();
  };
}

declare global {
  interface HTMLElementTagNameMap {
    "t-menu": Menu;
  }
}
