import { css, html, LitElement, type PropertyValues, type TemplateResult } from "lit";
import { customElement, property, query } from "lit/decorators.js";
import { base, panelBox } from "../base/base-style.js";

/**
 * A question that must be answered before anything else. Escape closes it, unless it is a `lasting` one: that
 * covers the page, too, so that nothing of it can be read.
 *
 * @slot - what it says
 * @slot actions - its buttons; the careful one first
 * @fires t-close when it was closed, by whatever way
 */
@customElement("t-dialog")
export class Dialog extends LitElement {
  static override styles = [
    base,
    css`
      dialog {
        inline-size: min(30rem, calc(100vw - 2 * var(--t-space-4)));
        padding: var(--t-space-5);
        ${panelBox}
        color: var(--t-text);
        box-shadow: var(--t-shadow);
      }
      dialog::backdrop {
        background: rgb(0 0 0 / 55%);
      }
      :host([lasting]) dialog::backdrop {
        background: var(--t-bg);
      }
      .inside {
        display: grid;
        gap: var(--t-space-4);
      }
      .actions {
        display: flex;
        flex-wrap: wrap;
        justify-content: flex-end;
        gap: var(--t-space-2);
      }
    `,
  ];

  @property({ type: Boolean, reflect: true }) open = false;
  @property({ type: Boolean, reflect: true }) lasting = false;
  @property() heading = "";

  @query("dialog") private readonly dialog!: HTMLDialogElement;

  override render(): TemplateResult {
    return html`<dialog aria-labelledby="heading" @cancel=${this.onCancel} @close=${this.onClosed}>
      <div class="inside">
        <h2 id="heading">${this.heading}</h2>
        <div><slot></slot></div>
        <div class="actions"><slot name="actions"></slot></div>
      </div>
    </dialog>`;
  }

  override updated(changed: PropertyValues<this>): void {
    if (!changed.has("open")) return;
    if (this.open && !this.dialog.open) this.dialog.showModal();
    if (!this.open && this.dialog.open) this.dialog.close();
  }

  override disconnectedCallback(): void {
    super.disconnectedCallback();
    this.open = false;
  }

  private readonly onCancel = (event: Event): void => {
    if (this.lasting) event.preventDefault();
  };

  private readonly onClosed = (): void => {
    // The browser reports it a task later, when the next question may already be open.
    if (this.dialog.open) return;
    // A second Escape closes it without asking.
    if (this.lasting && this.open) {
      this.dialog.showModal();
      return;
    }
    this.open = false;
    this.dispatchEvent(new CustomEvent("t-close"));
  };
}

declare global {
  interface HTMLElementTagNameMap {
    "t-dialog": Dialog;
  }
}
