/** How far STOP got, who pressed it, and the two steps to its release. */

import { msg, str } from "@lit/localize";
import { css, html, LitElement, nothing, svg, type PropertyValues, type SVGTemplateResult, type TemplateResult } from "lit";
import { customElement, property, query } from "lit/decorators.js";
import { base, plainList, quietText } from "../base/base-style.js";
import type { Button } from "../forms/button.js";
import "../forms/button.js";
import "../base/icon.js";
import "../values/time.js";
import { heldStopLabel, stopSteps, type HeldStop, type StopPhase } from "./stop-labels.js";

export type ReleaseStep = "none" | "asking" | "armed" | "releasing";

const MARKS: Readonly<Record<0 | 1 | 2, SVGTemplateResult>> = {
  0: svg`<circle cx="10" cy="10" r="7" fill="none" stroke="currentColor" stroke-width="1.6" stroke-dasharray="2.5 2"></circle>`,
  1: svg`<circle cx="10" cy="10" r="7" fill="none" stroke="currentColor" stroke-width="2"></circle><circle cx="10" cy="10" r="3" fill="currentColor"></circle>`,
  2: svg`<circle cx="10" cy="10" r="8" fill="currentColor"></circle><path d="m6.4 10.2 2.5 2.5 4.8-5" fill="none" stroke="var(--t-surface)" stroke-width="2"></path>`,
};
const SPOKEN = [msg("not yet"), msg("under way"), "done"] as const;

/**
 * @fires t-reset-ask first step of the release
 * @fires t-reset-go second step
 * @fires t-reset-keep the second step is called off
 */
@customElement("t-stop-state")
export class StopState extends LitElement {
  static override styles = [
    base,
    css`
      :host {
        display: grid;
        gap: var(--t-space-3);
      }
      ol {
        display: grid;
        grid-template-columns: repeat(3, 1fr);
        gap: var(--t-space-1);
        ${plainList}
      }
      li {
        display: grid;
        justify-items: center;
        gap: var(--t-space-1);
        padding: var(--t-space-2) var(--t-space-1);
        border-radius: var(--t-radius-s);
        background: var(--t-raised);
        ${quietText}
        line-height: 1.25;
        text-align: center;
      }
      li svg {
        inline-size: 1.25rem;
        block-size: 1.25rem;
      }
      li[data-done="2"] {
        color: var(--t-text);
        font-weight: var(--t-weight-strong);
      }
      li[data-done="1"] {
        color: var(--t-warn);
        font-weight: var(--t-weight-strong);
      }
      .note {
        display: grid;
        grid-template-columns: auto 1fr;
        gap: var(--t-space-2);
        ${quietText}
      }
      .note t-icon {
        margin-block-start: 0.1em;
      }
      .trouble {
        color: var(--t-bad);
        font-weight: var(--t-weight-strong);
      }
      .second {
        padding: var(--t-space-2) var(--t-space-3);
        border: 2px solid var(--t-warn);
        border-radius: var(--t-radius-s);
        color: var(--t-warn);
        font-weight: var(--t-weight-strong);
      }
      .second[data-sure] {
        border-color: var(--t-line);
        color: var(--t-text);
        font-weight: inherit;
      }
      .arm {
        display: grid;
        gap: var(--t-space-2);
        padding: var(--t-space-3);
        border: 2px solid var(--t-warn);
        border-radius: var(--t-radius-s);
      }
      .row {
        display: grid;
        grid-template-columns: 1fr 1fr;
        gap: var(--t-space-2);
      }
      progress {
        inline-size: 100%;
        block-size: 0.5rem;
        accent-color: var(--t-warn);
      }
    `,
  ];

  @property() phase: StopPhase = "unknown";
  @property() who = "";
  /** When it was latched: µs since the epoch. */
  @property({ type: Number }) time = 0;
  @property() zone = "UTC";
  /** From the press to the gateway's answer (ms); NaN: not pressed here. */
  @property({ type: Number }) answered = Number.NaN;
  @property() trouble = "";
  @property({ type: Boolean }) online = true;
  @property() step: ReleaseStep = "none";
  /** How long the second step stays open (ms). */
  @property({ type: Number }) armed = 0;
  /** Why this person cannot release it now; empty when they can. */
  @property() hindrance = "";

  /** At other gateways with the same key, which wait; null: there are none. */
  @property({ attribute: false }) held: HeldStop | null = null;

  @query("t-button") private readonly button!: Button | null;
  private hadFocus = false;

  override willUpdate(): void {
    this.hadFocus = this.renderRoot instanceof ShadowRoot && this.renderRoot.activeElement !== null;
  }

  /** The buttons of one step make way for those of the next; whoever came by keyboard goes with them. */
  protected override updated(changed: PropertyValues<this>): void {
    if (changed.has("step") && this.hadFocus) void this.keepFocus();
  }

  override render(): TemplateResult {
    return html`
      ${this.phase === "clear" || this.phase === "unknown" ? nothing : this.renderProgress()}
      ${this.renderHeld()}
      ${this.trouble === "" ? nothing : html`<p class="trouble" role="alert">${this.trouble}</p>`}
      ${this.online
        ? nothing
        : html`<p class="trouble">
            ${msg("The site is offline. STOP is sent as long as this page is open, but nothing can confirm it: use the stop on the robot.")}
          </p>`}
      ${this.phase === "latched" || this.phase === "confirmed" ? this.renderRelease() : nothing}
      <p class="note">
        <t-icon name="info"></t-icon>
        <span>${msg("No emergency stop: the robot needs a hardware stop.")}</span>
      </p>
    `;
  }

  private async keepFocus(): Promise<void> {
    await this.button?.updateComplete;
    this.button?.focus();
  }

  private renderProgress(): TemplateResult {
    const [sent, latched, confirmed] = stopSteps(this.phase);
    return html`
      <ol aria-label=${msg("How far STOP got")}>
        ${this.renderMark(sent, msg("Sent"))} ${this.renderMark(latched, msg("Latched at the gateway"))}
        ${this.renderMark(confirmed, msg("Confirmed by the robot"))}
      </ol>
      ${this.phase === "sent" ? nothing : html`<p>${this.renderLatchedBy()}</p>`}
    `;
  }

  private renderHeld(): TemplateResult | typeof nothing {
    const { held } = this;
    if (held === null) return nothing;
    const sure = held.confirmed === held.held;
    return html`<p class="second" role="status" ?data-sure=${sure}>${heldStopLabel(held)}</p>`;
  }

  private renderMark(done: 0 | 1 | 2, word: string): TemplateResult {
    return html`<li data-done=${done}>
      <svg viewBox="0 0 20 20" aria-hidden="true">${MARKS[done]}</svg>
      <span>${word}<span class="visually-hidden">: ${SPOKEN[done]}</span></span>
    </li>`;
  }

  private renderLatchedBy(): TemplateResult {
    const fast = Number.isFinite(this.answered)
      ? html`<span class="muted"> ${msg(str`Answered in ${this.answered.toFixed(0)}\u202fms.`)}</span>`
      : nothing;
    return html`${msg(html`Pressed by <strong>${this.who || msg("somebody")}</strong>, <t-time .us=${this.time} .zone=${this.zone} short></t-time>.`)}${fast}`;
  }

  private renderRelease(): TemplateResult {
    if (this.step === "armed") return this.renderSecondStep();
    const busy = this.step !== "none";
    return html`
      <t-button ?disabled=${this.hindrance !== ""} ?busy=${busy} @click=${this.fireReset}>
        ${busy ? msg("Asking the gateway…") : msg("Release STOP…")}
      </t-button>
      ${this.hindrance === "" ? nothing : html`<p class="muted">${this.hindrance}</p>`}
    `;
  }

  private renderSecondStep(): TemplateResult {
    const seconds = Math.ceil(this.armed / 1000);
    return html`<div class="arm">
      <p>${msg(html`<strong>Release STOP?</strong> Look at the robot first. Nothing moves by the release itself.`)}</p>
      <div class="row">
        <t-button @click=${this.fireKeepStopped}>${msg("Keep stopped")}</t-button>
        <t-button kind="primary" @click=${this.fireRelease}>${msg("Release now")}</t-button>
      </div>
      <progress max="10000" .value=${this.armed} aria-label=${msg("Time to decide")}></progress>
      <span class="muted">${msg(str`This question closes in ${seconds}\u202fs.`)}</span>
    </div>`;
  }

  private readonly fireReset = (): void => {
    if (this.hindrance === "" && this.step === "none") this.fireEvent("t-reset-ask");
  };

  private readonly fireRelease = (): void => {
    this.fireEvent("t-reset-go");
  };

  private readonly fireKeepStopped = (): void => {
    this.fireEvent("t-reset-keep");
  };

  private fireEvent(name: string): void {
    this.dispatchEvent(new CustomEvent(name, { bubbles: true, composed: true }));
  }
}

declare global {
  interface HTMLElementTagNameMap {
    "t-stop-state": StopState;
  }
}
