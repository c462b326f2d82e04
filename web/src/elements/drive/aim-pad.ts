/** Buttons that turn a camera while they are held: pan and tilt as a cross, zoom beside it. */

import { msg, str } from "@lit/localize";
import { css, html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, property } from "lit/decorators.js";
import { repeat } from "lit/directives/repeat.js";
import { base } from "../base/base-style.js";
import type { HoldStick } from "./hold-event.js";
import "./hold-button.js";

interface AimButton {
  readonly id: string;
  readonly axis: string;
  readonly push: 1 | -1;
  readonly label: string;
  readonly key: string;
  readonly path: string;
}

const BUTTONS: readonly AimButton[] = [
  { id: "up", axis: "tilt", push: 1, label: msg("Tilt up"), key: "W", path: "M12 19V6M6 12l6-6 6 6" },
  { id: "left", axis: "pan", push: -1, label: msg("Pan left"), key: "A", path: "M19 12H6M12 6l-6 6 6 6" },
  { id: "right", axis: "pan", push: 1, label: msg("Pan right"), key: "D", path: "M5 12h13M12 6l6 6-6 6" },
  { id: "down", axis: "tilt", push: -1, label: msg("Tilt down"), key: "X", path: "M12 5v13M6 12l6 6 6-6" },
  { id: "in", axis: "zoom", push: 1, label: msg("Zoom in"), key: "E", path: "M5 12h14M12 5v14" },
  { id: "out", axis: "zoom", push: -1, label: msg("Zoom out"), key: "Q", path: "M5 12h14" },
];

/**
 * @fires t-hold on press and release of a button; its stick has one push for each axis
 * @fires t-halt the middle button
 */
@customElement("t-aim-pad")
export class AimPad extends LitElement {
  static override styles = [
    base,
    css`
      :host {
        display: grid;
        grid-template-columns: auto auto;
        justify-content: space-evenly;
        align-items: center;
        gap: var(--t-space-4);
      }
      .cross,
      .zoom {
        display: grid;
        gap: var(--t-space-1);
      }
      .cross {
        grid-template: ". up ." 3rem "left halt right" 3rem ". down ." 3rem / 3rem 3rem 3rem;
      }
      .zoom {
        grid-auto-rows: 3rem;
      }
      .up {
        grid-area: up;
      }
      .left {
        grid-area: left;
      }
      .right {
        grid-area: right;
      }
      .down {
        grid-area: down;
      }
      t-hold-button {
        display: grid;
      }
      svg {
        display: block;
        margin: auto;
        inline-size: 1.25rem;
        block-size: 1.25rem;
      }
      .halt {
        grid-area: halt;
        display: grid;
        place-content: center;
        padding: 0;
        border: 1px solid var(--t-edge);
        border-radius: var(--t-radius-s);
        background: var(--t-surface);
        color: var(--t-text);
        cursor: pointer;
      }
      .halt:disabled {
        border-style: dashed;
        color: var(--t-muted);
        cursor: not-allowed;
        opacity: 0.6;
      }
    `,
  ];

  /** What the camera can: `pan`, `tilt`, `zoom`, in the order of the description. */
  @property({ attribute: false }) axes: readonly string[] = [];
  @property({ type: Boolean, reflect: true }) disabled = false;

  override render(): TemplateResult {
    const there = BUTTONS.filter(({ axis }) => this.axes.includes(axis));
    const cross = there.filter(({ axis }) => axis !== "zoom");
    const zoom = there.filter(({ axis }) => axis === "zoom");
    return html`${cross.length === 0
      ? nothing
      : html`<div class="cross" role="group" aria-label=${msg("Hold to turn the camera")}>
          ${repeat(cross, ({ id }) => id, (button) => this.renderButton(button))}
          <button type="button" class="halt" aria-label=${msg("Halt")} title=${msg("Halt (S)")} ?disabled=${this.disabled} @click=${this.requestHalt}>
            <svg viewBox="0 0 24 24" aria-hidden="true"><path d="M7 7h10v10H7z" fill="currentColor"></path></svg>
          </button>
        </div>`}
    ${zoom.length === 0 ? nothing : html`<div class="zoom" role="group" aria-label=${msg("Hold to zoom")}>${repeat(zoom, ({ id }) => id, (button) => this.renderButton(button))}</div>`}`;
  }

  private renderButton({ id, axis, push, label, key, path }: AimButton): TemplateResult {
    return html`<t-hold-button
      class=${id}
      ?disabled=${this.disabled}
      label=${label}
      title=${msg(str`${label} (hold; ${key})`)}
      name=${`aim:${id}`}
      .stick=${this.stickOf(axis, push)}
      ><svg viewBox="0 0 24 24" aria-hidden="true">
        <path d=${path} fill="none" stroke="currentColor" stroke-width="2.5" stroke-linecap="round" stroke-linejoin="round"></path></svg
    ></t-hold-button>`;
  }

  private stickOf(axis: string, push: number): HoldStick {
    return { forward: 0, turn: 0, joints: this.axes.map((candidate) => (candidate === axis ? push : 0)) };
  }

  private readonly requestHalt = (): void => {
    this.dispatchEvent(new CustomEvent("t-halt", { bubbles: true, composed: true }));
  };
}

declare global {
  interface HTMLElementTagNameMap {
    "t-aim-pad": AimPad;
  }
}
