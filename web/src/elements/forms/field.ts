import { css, html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, property } from "lit/decorators.js";
import { base, quietText } from "../base/base-style.js";

/**
 * Label, control and error. The control is a native one in the slot, so that forms, password
 * stores and phones' keyboards treat it as they always do. Enter submits the form around it.
 *
 * @slot - an `<input>`, `<select>` or `<textarea>`
 */
@customElement("t-field")
export class Field extends LitElement {
  static override styles = [
    base,
    css`
      :host {
        display: grid;
        grid-template-columns: minmax(0, 1fr);
        gap: var(--t-space-1);
        min-inline-size: 0;
      }
      .label {
        font-weight: var(--t-weight-strong);
        font-size: var(--t-size-s);
      }
      ::slotted(:is(input, select, textarea)) {
        inline-size: 100%;
        min-inline-size: 0;
        min-block-size: var(--t-touch);
        padding: var(--t-space-2) var(--t-space-3);
        border: 1px solid var(--t-edge);
        border-radius: var(--t-radius-s);
        background: var(--t-surface);
        color: var(--t-text);
        font: inherit;
      }
      ::slotted(:focus-visible) {
        outline: 3px solid var(--t-accent);
        outline-offset: 1px;
      }
      :host([error]:not([error=""])) ::slotted(:is(input, select, textarea)) {
        border-color: var(--t-bad);
        border-width: 2px;
      }
      ::slotted(:disabled) {
        border-style: dashed;
        color: var(--t-muted);
      }
      .hint {
        ${quietText}
      }
      /* Without an error it takes no room, not even a gap. */
      [role="alert"]:empty {
        position: absolute;
      }
      .error {
        color: var(--t-bad);
        font-size: var(--t-size-s);
        font-weight: var(--t-weight-strong);
      }
    `,
  ];

  @property() label = "";
  @property() hint = "";
  @property({ reflect: true }) error = "";

  override render(): TemplateResult {
    return html`
      <span class="label" aria-hidden="true" @click=${this.focusControl}>${this.label}</span>
      <slot @slotchange=${this.labelControl} @keydown=${this.submitOnEnter}></slot>
      ${this.hint === "" ? nothing : html`<span class="hint" aria-hidden="true">${this.hint}</span>`}
      <span role="alert">${this.error === "" ? nothing : html`<span class="error">${this.error}</span>`}</span>
    `;
  }

  override updated(): void {
    this.labelControl();
  }

  // A label of ours can not point at a control outside our shadow root, so the control is told.
  private readonly labelControl = (): void => {
    const control = this.control();
    if (control === null) return;
    control.ariaLabel = this.label;
    control.ariaInvalid = this.error === "" ? "false" : "true";
    control.setAttribute("aria-description", [this.hint, this.error].filter(Boolean).join(" "));
  };

  private readonly focusControl = (): void => {
    this.control()?.focus();
  };

  private control(): HTMLElement | null {
    return this.querySelector<HTMLElement>("input, select, textarea");
  }

  private readonly submitOnEnter = (event: KeyboardEvent): void => {
    if (event.key !== "Enter" || event.isComposing || !(event.target instanceof HTMLInputElement)) return;
    const form = this.closest("form");
    if (form === null) return;
    event.preventDefault();
    form.requestSubmit();
  };
}

declare global {
  interface HTMLElementTagNameMap {
    "t-field": Field;
  }
}
