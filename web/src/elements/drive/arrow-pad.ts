/** Four arrow buttons to hold, and one that halts: the pad for those who do not drag. */

import { msg, str } from "@lit/localize";
import { css, html, LitElement, type TemplateResult } from "lit";
import { customElement, property } from "lit/decorators.js";
import { repeat } from "lit/directives/repeat.js";
import { base } from "../base/base-style.js";
import { heldButton } from "./held-style.js";
import { holdEvent, type HoldAct, type HoldStick } from "./hold-event.js";

interface Arrow {
  readonly id: string;
  readonly label: string;
  readonly key: string;
  readonly path: string;
  readonly stick: HoldStick;
}

const REST: HoldStick = { forward: 0, turn: 0 };

const ARROWS: readonly Arrow[] = [
  { id: "forward", label: msg("Forward"), key: "W", path: "M12 19V6M6 12l6-6 6 6", stick: { forward: 1, turn: 0 } },
  { id: "left", label: msg("Turn left"), key: "A", path: "M19 12H6M12 6l-6 6 6 6", stick: { forward: 0, turn: 1 } },
  { id: "right", label: msg("Turn right"), key: "D", path: "M5 12h13M12 6l6 6-6 6", stick: { forward: 0, turn: -1 } },
  { id: "backward", label: msg("Backward"), key: "X", path: "M12 5v13M6 12l6 6 6-6", stick: { forward: -1, turn: 0 } },
];

/** What the arrows are called where the wheels are steered. */
const STEERED: Readonly<Record<string, string>> = { left: msg("Steer left"), right: msg("Steer right") };

const ASIDE: readonly Arrow[] = [
  { id: "sideLeft", label: msg("Move left"), key: "Q", path: "M20 5v14M16 12H4M9 7l-5 5 5 5", stick: { forward: 0, turn: 0, side: 1 } },
  { id: "sideRight", label: msg("Move right"), key: "E", path: "M4 5v14M8 12h12M15 7l5 5-5 5", stick: { forward: 0, turn: 0, side: -1 } },
];

/**
 * @fires t-hold on press and release of an arrow
 * @fires t-halt the middle button
 */
@customElement("t-arrows")
export class ArrowPad extends LitElement {
  static override styles = [
    base,
    css`
      :host {
        display: block;
      }
      .cross {
        display: grid;
        grid-template-areas: "sideLeft forward sideRight" "left halt right" ". backward .";
        grid-template-columns: repeat(3, minmax(2.75rem, 1fr));
        grid-auto-rows: 1fr;
        gap: var(--t-space-1);
        aspect-ratio: 1;
      }
      button {
        position: relative;
        display: grid;
        place-content: center;
        min-inline-size: 2.75rem;
        min-block-size: 2.75rem;
        padding: 0;
        border: 1px solid var(--t-edge);
        border-radius: var(--t-radius-s);
        background: var(--t-surface);
        color: var(--t-text);
        font: inherit;
        touch-action: none;
        user-select: none;
        -webkit-user-select: none;
        -webkit-touch-callout: none;
        cursor: pointer;
      }
      .forward {
        grid-area: forward;
      }
      .left {
        grid-area: left;
      }
      .right {
        grid-area: right;
      }
      .backward {
        grid-area: backward;
      }
      .sideLeft {
        grid-area: sideLeft;
      }
      .sideRight {
        grid-area: sideRight;
      }
      .halt {
        grid-area: halt;
      }
      svg {
        inline-size: 1.6rem;
        block-size: 1.6rem;
      }
      /* Wider than the others: up from the letter of its key. */
      .sideLeft svg,
      .sideRight svg {
        inline-size: 1.35rem;
        block-size: 1.35rem;
        margin-block-end: 0.5rem;
      }
      .key {
        position: absolute;
        inset: auto 0.3rem 0.1rem auto;
        color: var(--t-muted);
        font-size: 0.6875rem;
      }
      button.held .key {
        color: inherit;
      }
      @media (pointer: coarse) {
        .key {
          display: none;
        }
        .sideLeft svg,
        .sideRight svg {
          margin-block-end: 0;
        }
      }
    `,
    heldButton,
  ];

  @property({ type: Boolean, reflect: true }) disabled = false;
  /** It also moves sideways. */
  @property({ type: Boolean }) sideways = false;
  /** Its wheels steer: left and right are angles. */
  @property({ type: Boolean }) steers = false;
  private readonly held = new Map<string, { readonly button: HTMLElement; readonly byKey: boolean }>();

  override disconnectedCallback(): void {
    super.disconnectedCallback();
    this.dropAll();
  }

  override updated(): void {
    if (this.disabled) this.dropAll();
  }

  override render(): TemplateResult {
    return html`<div class="cross" role="group" aria-label=${msg("Hold an arrow to drive")}>
      ${repeat(this.arrows, (arrow) => arrow.id, (arrow) => this.renderButton(arrow))}
      <button type="button" class="halt" aria-label=${msg("Halt")} title=${msg("Halt (S)")} ?disabled=${this.disabled} @click=${this.requestHalt}>
        <svg viewBox="0 0 24 24" aria-hidden="true"><path d="M7 7h10v10H7z" fill="currentColor"></path></svg>
        <span class="key" aria-hidden="true">S</span>
      </button>
    </div>`;
  }

  private get arrows(): readonly Arrow[] {
    const arrows = this.steers ? ARROWS.map((arrow) => ({ ...arrow, label: STEERED[arrow.id] ?? arrow.label })) : ARROWS;
    return this.sideways ? [...arrows, ...ASIDE] : arrows;
  }

  private renderButton(arrow: Arrow): TemplateResult {
    return html`<button
      type="button"
      class=${arrow.id}
      value=${arrow.id}
      aria-label=${arrow.label}
      title=${msg(str`${arrow.label} (hold; ${arrow.key})`)}
      ?disabled=${this.disabled}
      @pointerdown=${this.onPointerDown}
      @pointerup=${this.onRelease}
      @pointercancel=${this.onPressLost}
      @lostpointercapture=${this.onPressLost}
      @keydown=${this.onKeyDown}
      @keyup=${this.onKeyDown}
      @blur=${this.onFocusOut}
      @contextmenu=${this.onContextMenu}
    >
      <svg viewBox="0 0 24 24" aria-hidden="true">
        <path d=${arrow.path} fill="none" stroke="currentColor" stroke-width="2.5" stroke-linecap="round" stroke-linejoin="round"></path>
      </svg>
      <span class="key" aria-hidden="true">${arrow.key}</span>
    </button>`;
  }

  private readonly onPointerDown = (event: PointerEvent): void => {
    if (event.button !== 0) return;
    const button = event.currentTarget as HTMLButtonElement;
    this.press(button, false);
    button.setPointerCapture(event.pointerId);
  };

  private readonly onRelease = (event: Event): void => {
    this.endPress("release", event);
  };

  private readonly onPressLost = (event: Event): void => {
    this.endPress("cancel", event);
  };

  // Space and Enter hold the focused button.
  private readonly onKeyDown = (event: KeyboardEvent): void => {
    if (event.key !== " " && event.key !== "Enter") return;
    event.preventDefault();
    if (event.type === "keyup") this.endPress("release", event);
    else if (!event.repeat) this.press(event.currentTarget as HTMLButtonElement, true);
  };

  // A key held on a button that loses the focus is never seen let go; a finger is.
  private readonly onFocusOut = (event: Event): void => {
    const { value } = event.currentTarget as HTMLButtonElement;
    if (this.held.get(value)?.byKey === true) this.endPress("cancel", event);
  };

  // A long press on a phone would open a menu and take the finger away.
  private readonly onContextMenu = (event: Event): void => {
    event.preventDefault();
  };

  private press(button: HTMLButtonElement, byKey: boolean): void {
    const arrow = this.arrows.find((candidate) => candidate.id === button.value);
    if (this.disabled || !arrow || this.held.has(arrow.id)) return;
    this.held.set(arrow.id, { button, byKey });
    this.fireHold("press", arrow.id, arrow.stick);
    button.classList.add("held");
  }

  private endPress(act: "release" | "cancel", event: Event): void {
    const button = event.currentTarget as HTMLButtonElement;
    if (!this.held.delete(button.value)) return;
    button.classList.remove("held");
    this.fireHold(act, button.value, REST);
  }

  private dropAll(): void {
    for (const [id, { button }] of [...this.held]) {
      this.held.delete(id);
      button.classList.remove("held");
      this.fireHold("cancel", id, REST);
    }
  }

  private readonly requestHalt = (): void => {
    this.dispatchEvent(new CustomEvent("t-halt", { bubbles: true, composed: true }));
  };

  private fireHold(act: HoldAct, id: string, stick: HoldStick): void {
    this.dispatchEvent(holdEvent({ act, source: `arrow:${id}`, stick, kind: "digital" }));
  }
}

declare global {
  interface HTMLElementTagNameMap {
    "t-arrows": ArrowPad;
  }
}
