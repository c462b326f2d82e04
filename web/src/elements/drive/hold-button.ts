/** One button that says what it pushes while it is held: by pointer, Space or Enter. */

import { msg, str } from "@lit/localize";
import { css, html, LitElement, type TemplateResult } from "lit";
import { customElement, property, query } from "lit/decorators.js";
import { base } from "../base/base-style.js";
import { heldButton } from "./held-style.js";
import { holdEvent, type HoldAct, type HoldStick } from "./hold-event.js";

const REST: HoldStick = { forward: 0, turn: 0 };

/** @fires t-hold on press and release, and when the press was taken away */
@customElement("t-hold-button")
export class HoldButton extends LitElement {
  static override styles = [
    base,
    css`
      :host {
        display: block;
      }
      button {
        min-inline-size: 2.75rem;
        min-block-size: 2.75rem;
        border: 1px solid var(--t-edge);
        border-radius: var(--t-radius-s);
        background: var(--t-surface);
        color: var(--t-text);
        font: inherit;
        font-size: var(--t-size-l);
        touch-action: none;
        user-select: none;
        -webkit-user-select: none;
        -webkit-touch-callout: none;
        cursor: pointer;
      }
    `,
    heldButton,
  ];

  /** Names what is held. */
  @property() name = "";
  @property() label = "";
  @property({ attribute: false }) stick: HoldStick = REST;
  @property({ type: Boolean, reflect: true }) disabled = false;

  @query("button") private readonly button!: HTMLButtonElement;
  private held: "pointer" | "key" | null = null;

  override disconnectedCallback(): void {
    super.disconnectedCallback();
    this.endPress("cancel");
  }

  override updated(): void {
    if (this.disabled) this.endPress("cancel");
  }

  override render(): TemplateResult {
    return html`<button
      type="button"
      aria-label=${this.label}
      title=${msg(str`${this.label} (hold)`)}
      ?disabled=${this.disabled}
      @pointerdown=${this.onPointerDown}
      @pointerup=${this.onRelease}
      @pointercancel=${this.onPressLost}
      @lostpointercapture=${this.onPressLost}
      @keydown=${this.onKey}
      @keyup=${this.onKey}
      @blur=${this.onFocusOut}
      @contextmenu=${this.onContextMenu}
    >
      <slot></slot>
    </button>`;
  }

  private readonly onPointerDown = (event: PointerEvent): void => {
    if (event.button !== 0) return;
    this.press("pointer");
    this.button.setPointerCapture(event.pointerId);
  };

  private readonly onRelease = (): void => {
    this.endPress("release");
  };

  private readonly onPressLost = (): void => {
    if (this.held === "pointer") this.endPress("cancel");
  };

  private readonly onKey = (event: KeyboardEvent): void => {
    if (event.key !== " " && event.key !== "Enter") return;
    event.preventDefault();
    if (event.type === "keyup") this.endPress("release");
    else if (!event.repeat) this.press("key");
  };

  // A key held on a button that loses the focus is never seen let go; a finger is.
  private readonly onFocusOut = (): void => {
    if (this.held === "key") this.endPress("cancel");
  };

  // A long press on a phone would open a menu and take the finger away.
  private readonly onContextMenu = (event: Event): void => {
    event.preventDefault();
  };

  private press(by: "pointer" | "key"): void {
    if (this.disabled || this.held !== null) return;
    this.held = by;
    this.fireHold("press", this.stick);
    this.button.classList.add("held");
  }

  private endPress(act: "release" | "cancel"): void {
    if (this.held === null) return;
    this.held = null;
    this.button.classList.remove("held");
    this.fireHold(act, REST);
  }

  private fireHold(act: HoldAct, stick: HoldStick): void {
    this.dispatchEvent(holdEvent({ act, source: this.name, stick, kind: "digital" }));
  }
}

declare global {
  interface HTMLElementTagNameMap {
    "t-hold-button": HoldButton;
  }
}
