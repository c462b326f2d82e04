/** One run of a mission: each step with what became of it, and what may be done while it goes on. */

import { msg } from "@lit/localize";
import { css, html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, property } from "lit/decorators.js";
import { map } from "lit/directives/map.js";
import { base, plainList, quietText } from "../../elements/base/base-style.js";
import type { StatusKind } from "../../elements/feedback/status.js";
import { fixedText } from "../../format/number.js";
import type { MissionRunShape, RunActAsk } from "../../generated/api.js";
import "../../elements/feedback/status.js";
import "../../elements/forms/button.js";
import "../../elements/values/time.js";

const STATES: Readonly<Record<string, readonly [StatusKind, string]>> = {
  waiting: ["unknown", msg("not begun")],
  skipped: ["unknown", msg("left out")],
  running: ["busy", msg("running")],
  paused: ["warn", msg("paused")],
  succeeded: ["ok", msg("succeeded")],
  failed: ["bad", msg("failed")],
  refused: ["warn", msg("refused")],
  cancelled: ["warn", msg("cancelled")],
  stopped: ["bad", msg("ended by STOP")],
  interrupted: ["bad", msg("interrupted")],
  missed: ["bad", msg("missed, not done")],
  unknown: ["warn", msg("outcome unknown")],
};

/** How a run or a step stands: its shape and word. */
export function runStatus(state: string): TemplateResult {
  const [kind, word] = STATES[state] ?? (["unknown", state] as const);
  return html`<t-status kind=${kind} .word=${word}></t-status>`;
}

/** @fires t-act detail is what is to become of it */
@customElement("t-mission-run")
export class MissionRunView extends LitElement {
  static override styles = [
    base,
    css`
      :host {
        display: grid;
        gap: var(--t-space-3);
        min-inline-size: 0;
      }
      .head,
      .actions {
        display: flex;
        flex-wrap: wrap;
        align-items: center;
        gap: var(--t-space-2) var(--t-space-4);
      }
      ol {
        display: grid;
        ${plainList}
      }
      li {
        display: grid;
        grid-template-columns: 1.5rem minmax(8rem, 2fr) 9rem minmax(0, 3fr);
        align-items: center;
        gap: 0 var(--t-space-3);
        padding-block: var(--t-space-2);
        border-block-start: 1px solid var(--t-line);
        overflow-wrap: anywhere;
      }
      @media (max-width: 45rem) {
        li {
          grid-template-columns: 1.5rem minmax(0, 1fr) auto;
        }
        .text {
          grid-column: 2 / -1;
        }
      }
      .text,
      .facts {
        ${quietText}
      }
    `,
  ];

  @property({ attribute: false }) run: MissionRunShape | null = null;
  @property() zone = "UTC";
  /** This person may pause, resume and cancel it. */
  @property({ type: Boolean }) allowed = false;
  /** Its name, state and reason stand above it already. */
  @property({ type: Boolean }) listed = false;

  override render(): TemplateResult | typeof nothing {
    const { run } = this;
    if (run === null) return nothing;
    const goesOn = run.state === "running" || run.state === "paused";
    return html`
      <div class="head">
        ${this.listed ? nothing : html`<strong>${run.name}</strong> ${runStatus(run.state)}`}
        <span class="facts">${msg(html`with the rights of ${run.who}, begun by ${run.begun_by === "schedule" ? msg("its schedule") : run.begun_by} <t-time short .us=${run.began_us} .zone=${this.zone}></t-time>`)}</span>
      </div>
      ${run.why === "" || this.listed ? nothing : html`<p>${run.why}</p>`}
      ${goesOn && this.allowed
        ? html`<div class="actions">
            ${run.state === "running" ? html`<t-button @click=${this.pause}>${msg("Pause after this step")}</t-button>` : html`<t-button kind="primary" @click=${this.resume}>${msg("Go on")}</t-button>`}
            <t-button @click=${this.cancel}>${msg("Cancel the mission")}</t-button>
          </div>`
        : nothing}
      <ol aria-label=${msg("Steps")}>
        ${map(run.steps, (step, at) => html`<li><span class="facts">${at + 1}</span><span>${step.name}</span>${runStatus(step.state)}<span class="text">${step.message}${spanText(step.began_us, step.ended_us)}</span></li>`)}
      </ol>
    `;
  }

  private readonly pause = (): void => {
    this.fireAct("pause");
  };

  private readonly resume = (): void => {
    this.fireAct("resume");
  };

  private readonly cancel = (): void => {
    this.fireAct("cancel");
  };

  private fireAct(act: RunActAsk["act"]): void {
    this.dispatchEvent(new CustomEvent<RunActAsk["act"]>("t-act", { detail: act }));
  }
}

function spanText(beganUs: number, endedUs: number): string {
  return beganUs > 0 && endedUs > 0 ? ` (${fixedText((endedUs - beganUs) / 1e6, 1)} s)` : "";
}

declare global {
  interface HTMLElementTagNameMap {
    "t-mission-run": MissionRunView;
  }
  interface GlobalEventHandlersEventMap {
    "t-act": CustomEvent<RunActAsk["act"]>;
  }
}
