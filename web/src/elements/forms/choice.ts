import { css, html, LitElement, type TemplateResult } from "lit";
import { customElement, property } from "lit/decorators.js";
import { repeat } from "lit/directives/repeat.js";
import { base, quietText } from "../base/base-style.js";

export interface ChoiceOption {
  readonly id: string;
  readonly label: string;
}

/**
 * One of a few, side by side: native radio buttons, so the arrow keys work as everywhere.
 *
 * @fires t-choose detail is the id that was chosen
 */
@customElement("t-choice")
export class Choice extends LitElement {
  static override styles = [
    base,
    css`
      :host {
        display: inline-block;
        max-inline-size: 100%;
      }
      fieldset {
        display: flex;
        flex-wrap: wrap;
        gap: 2px;
        margin: 0;
        padding: 3px;
        border: 0;
        border-radius: var(--t-radius-s);
        background: var(--t-raised);
      }
      label {
        position: relative;
        flex: 1 1 var(--t-choice-basis, auto);
        display: grid;
        place-items: center;
        min-block-size: calc(var(--t-touch) - 6px);
        padding-inline: var(--t-space-2);
        border-radius: calc(var(--t-radius-s) - 2px);
        ${quietText}
        font-weight: var(--t-weight-strong);
        cursor: pointer;
      }
      input {
        position: absolute;
        inset: 0;
        margin: 0;
        opacity: 0;
        cursor: pointer;
      }
      label:has(:checked) {
        background: var(--t-surface);
        color: var(--t-text);
        box-shadow: inset 0 0 0 1px var(--t-edge);
      }
      label:hover {
        color: var(--t-text);
      }
      label:has(:focus-visible) {
        outline: 3px solid var(--t-accent);
        outline-offset: 1px;
      }
    `,
  ];

  /** What is chosen between, for screen readers. */
  @property() label = "";
  @property({ attribute: false }) options: readonly ChoiceOption[] = [];
  @property() chosen = "";

  override render(): TemplateResult {
    return html`<fieldset aria-label=${this.label} @change=${this.onChoose}>
      ${repeat(
        this.options,
        (option) => option.id,
        (option) => html`<label
          ><input type="radio" name="choice" .value=${option.id} .checked=${option.id === this.chosen} />${option.label}</label
        >`,
      )}
    </fieldset>`;
  }

  private readonly onChoose = (event: Event): void => {
    if (!(event.target instanceof HTMLInputElement)) return;
    this.chosen = event.target.value;
    this.dispatchEvent(new CustomEvent("t-choose", { detail: this.chosen }));
  };
}

declare global {
  interface HTMLElementTagNameMap {
    "t-choice": Choice;
  }
  interface GlobalEventHandlersEventMap {
    "t-choose": CustomEvent<string>;
  }
}
