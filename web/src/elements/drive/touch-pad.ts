/** A round pad for thumb or mouse: hold and push where the vehicle should go. */

import { msg } from "@lit/localize";
import { css, html, LitElement, type TemplateResult } from "lit";
import { customElement, property, query } from "lit/decorators.js";
import { base } from "../base/base-style.js";
import { holdEvent, type HoldAct, type HoldStick } from "./hold-event.js";

const REST: HoldStick = { forward: 0, turn: 0 };

/**
 * @fires t-hold on press, on each move while held, on release, and when the press was taken away
 */
@customElement("t-pad")
export class TouchPad extends LitElement {
  static override styles = [
    base,
    css`
      :host {
        display: block;
      }
      .pad {
        position: relative;
        inline-size: 100%;
        aspect-ratio: 1;
        border: 2px solid var(--t-edge);
        border-radius: 50%;
        background: var(--t-raised);
        touch-action: none;
        user-select: none;
        -webkit-user-select: none;
        -webkit-touch-callout: none;
        cursor: grab;
      }
      .pad.held {
        border-color: var(--t-accent);
        box-shadow: inset 0 0 0 3px var(--t-accent);
        cursor: grabbing;
      }
      .pad[aria-disabled="true"] {
        border-style: dashed;
        cursor: not-allowed;
        opacity: 0.6;
      }
      .pad > svg {
        position: absolute;
        inset: 0;
        inline-size: 100%;
        block-size: 100%;
        color: var(--t-muted);
        pointer-events: none;
      }
      .knob {
        position: absolute;
        inset: 34%;
        border: 2px solid var(--t-edge);
        border-radius: 50%;
        background: var(--t-surface);
        box-shadow: var(--t-shadow);
        pointer-events: none;
        transition: transform 90ms ease-out;
      }
      .held .knob {
        border-color: var(--t-accent);
        background: var(--t-accent);
        transition: none;
      }
    `,
  ];

  @property({ type: Boolean, reflect: true }) disabled = false;
  /** Turns a point from the middle (px right, px down, radius) into a push. */
  @property({ attribute: false }) stickOf: (right: number, down: number, radius: number) => HoldStick = () => REST;

  @query(".pad") private readonly pad!: HTMLElement;
  @query(".knob") private readonly knob!: HTMLElement;
  private pointer: number | null = null;
  /** Where the pad lay when it was pressed: should the page shift, the push does not. */
  private box = new DOMRect();

  override disconnectedCallback(): void {
    super.disconnectedCallback();
    this.endPress("cancel");
  }

  override updated(): void {
    if (this.disabled) this.endPress("cancel");
  }

  override render(): TemplateResult {
    return html`<div
      class="pad"
      role="application"
      tabindex=${this.disabled ? "-1" : "0"}
      aria-disabled=${this.disabled ? "true" : "false"}
      aria-roledescription=${msg("drive pad")}
      aria-label=${msg("Hold and push to drive; let go to halt. With the keyboard hold the arrow keys or W, A, D, X.")}
      @pointerdown=${this.onPointerDown}
      @pointermove=${this.onPointerMove}
      @pointerup=${this.onPointerUp}
      @pointercancel=${this.onPointerCancel}
      @lostpointercapture=${this.onPointerCancel}
      @contextmenu=${this.onContextMenu}
    >
      <svg viewBox="0 0 100 100" aria-hidden="true">
        <g fill="none" stroke="currentColor" stroke-width="0.8" opacity="0.7">
          <circle cx="50" cy="50" r="32"></circle>
          <path d="M50 20v12M50 68v12M20 50h12M68 50h12"></path>
        </g>
        <g fill="none" stroke="currentColor" stroke-width="3" stroke-linecap="round" stroke-linejoin="round">
          <path d="m44 12 6-6 6 6M44 88l6 6 6-6M12 44l-6 6 6 6M88 44l6 6-6 6"></path>
        </g>
      </svg>
      <div class="knob"></div>
    </div>`;
  }

  private readonly onPointerDown = (event: PointerEvent): void => {
    if (this.disabled || this.pointer !== null || event.button !== 0) return;
    this.pointer = event.pointerId;
    this.box = this.pad.getBoundingClientRect();
    this.fireHold("press", this.readStick(event));
    this.pad.setPointerCapture(event.pointerId);
    this.pad.classList.add("held");
    this.pad.focus({ preventScroll: true });
  };

  private readonly onPointerMove = (event: PointerEvent): void => {
    if (event.pointerId === this.pointer) this.fireHold("move", this.readStick(event));
  };

  private readonly onPointerUp = (event: PointerEvent): void => {
    if (event.pointerId === this.pointer) this.endPress("release");
  };

  private readonly onPointerCancel = (event: PointerEvent): void => {
    if (event.pointerId === this.pointer) this.endPress("cancel");
  };

  // A long press on a phone would open a menu and take the pointer away.
  private readonly onContextMenu = (event: Event): void => {
    event.preventDefault();
  };

  private endPress(act: "release" | "cancel"): void {
    if (this.pointer === null) return;
    this.pointer = null;
    this.fireHold(act, REST);
    this.pad.classList.remove("held");
    this.knob.style.transform = "";
  }

  private readStick(event: PointerEvent): HoldStick {
    const { box } = this;
    const radius = box.width / 2;
    const right = event.clientX - box.left - radius;
    const down = event.clientY - box.top - radius;
    const far = Math.max(1, Math.hypot(right, down) / (radius * 0.66));
    this.knob.style.transform = `translate(${(right / far).toFixed(1)}px, ${(down / far).toFixed(1)}px)`;
    return this.stickOf(right, down, radius * 0.9);
  }

  private fireHold(act: HoldAct, stick: HoldStick): void {
    this.dispatchEvent(holdEvent({ act, source: "pad", stick, kind: "analog" }));
  }
}

declare global {
  interface HTMLElementTagNameMap {
    "t-pad": TouchPad;
  }
}
