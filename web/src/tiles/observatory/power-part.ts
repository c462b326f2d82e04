/** Outlets as switches. One whose state is not known has two buttons in its place. */

import { msg, str } from "@lit/localize";
import { css, html, nothing, type TemplateResult } from "lit";
import { customElement, property, state } from "lit/decorators.js";
import { map } from "lit/directives/map.js";
import { repeat } from "lit/directives/repeat.js";
import { isFinal } from "../../controllers/drive/command-machine.js";
import { ContextStoreController } from "../../controllers/context-store.js";
import { StoreController } from "../../controllers/store-controller.js";
import { base, plainList } from "../../elements/base/base-style.js";
import { PHASES } from "../../elements/command/command-phases.js";
import { lockText } from "../../format/interlock-reason.js";
import { interlocksContext } from "../../state/contexts.js";
import type { SignalShape } from "../../generated/api.js";
import { NO_DEVICE, DevicePart, partStyle } from "./device-part.js";
import { outletsOf, type CommandButton, type Outlet } from "./roles.js";
import "../../elements/forms/button.js";
import "../../elements/feedback/confirm.js";
import "../../elements/base/icon.js";
import "../../elements/feedback/status.js";
import "../signal-value.js";

@customElement("t-part-power")
export class PowerPart extends DevicePart {
  static override styles = [
    base,
    partStyle,
    css`
      ul {
        display: grid;
        grid-template-columns: repeat(auto-fill, minmax(min(19rem, 100%), 1fr));
        gap: var(--t-space-3);
        ${plainList}
      }
      li {
        display: grid;
        grid-template-columns: minmax(0, 1fr) auto;
        align-items: center;
        gap: var(--t-space-1) var(--t-space-3);
        padding: var(--t-space-3) var(--t-space-4);
        border: 1px solid var(--t-line);
        border-radius: var(--t-radius-s);
      }
      li.unknown {
        border-style: dashed;
        border-color: var(--t-stale);
      }
      .name {
        font-weight: var(--t-weight-strong);
        overflow-wrap: anywhere;
      }
      .on {
        color: var(--t-ok);
        font-weight: var(--t-weight-strong);
      }
      button {
        position: relative;
        inline-size: 4rem;
        block-size: var(--t-touch);
        padding: 0;
        border: 0;
        background: transparent;
        cursor: pointer;
        touch-action: manipulation;
      }
      .track {
        position: absolute;
        inset: 0.35rem 0;
        border: 2px solid var(--t-edge);
        border-radius: 2rem;
        background: var(--t-surface);
      }
      .knob {
        position: absolute;
        inset-block: 3px;
        inset-inline-start: 3px;
        aspect-ratio: 1;
        border-radius: 50%;
        background: var(--t-edge);
        transition: translate 0.15s;
      }
      [aria-checked="true"] .track {
        border-color: var(--t-accent);
        background: var(--t-accent);
      }
      [aria-checked="true"] .knob {
        translate: 1.75rem 0;
        background: var(--t-on-accent);
      }
      button[aria-busy="true"] .track {
        animation: wait 0.8s ease-in-out infinite alternate;
      }
      button:disabled {
        cursor: not-allowed;
      }
      button:disabled .track {
        border-style: dashed;
        background: transparent;
      }
      button:disabled .knob {
        background: var(--t-muted);
      }
      @keyframes wait {
        to {
          opacity: 0.35;
        }
      }
      .both {
        display: flex;
        gap: var(--t-space-1);
      }
      .said {
        grid-column: 1 / -1;
        font-size: var(--t-size-s);
        overflow-wrap: anywhere;
      }
      .locked {
        color: var(--t-warn);
      }
    `,
  ];

  /** What stands beside the outlets: power, voltage, current, charge. */
  @property({ attribute: false }) readings: readonly SignalShape[] = [];
  @state() private asking: CommandButton | null = null;

  private readonly interlocks = new ContextStoreController(this, interlocksContext);
  private readonly watched = new StoreController(this);

  override willUpdate(): void {
    const outlets = outletsOf(this.device ?? NO_DEVICE);
    this.observeSignals(...outlets.map(({ signal }) => signal));
    this.watched.setStore(this.line);
  }

  override render(): TemplateResult | typeof nothing {
    const { device } = this;
    if (device === null) return nothing;
    const outlets = outletsOf(device);
    const states = outlets.map(({ signal }) => this.isOn(signal));
    const unknown = states.filter((on) => on === null).length;
    return html`<div class="card" role="group" aria-labelledby="outlets">
      <div class="readings">
        <div>
          <h2 id="outlets">${msg("Outlets")}</h2>
          <p class="note">
            ${unknown === 0 ? msg(str`${states.filter((on) => on === true).length} of ${outlets.length} on`) : msg(str`${states.filter((on) => on === true).length} of ${outlets.length} on, ${String(unknown)} unknown`)}
          </p>
        </div>
        ${map(this.readings, (signal) => html`<t-signal-value size="l" .site=${this.site} .signal=${signal}></t-signal-value>`)}
      </div>
      ${this.renderLookOnly()}
      <ul>
        ${repeat(outlets, ({ signal }) => signal.id, (outlet) => this.renderRow(outlet))}
      </ul>
      <t-confirm
        heading="${this.asking?.label ?? ""}?"
        action=${msg("Switch")}
        ?open=${this.asking !== null}
        @t-confirm=${this.onConfirm}
        @t-close=${this.onCancel}
      >
        <p>${this.asking?.command.description || msg("What hangs on this outlet gains or loses its power at once.")}</p>
      </t-confirm>
    </div>`;
  }

  private renderRow(outlet: Outlet): TemplateResult {
    const on = this.isOn(outlet.signal);
    const word = on === null ? msg("unknown") : on ? msg("on", { id: "on.outlet" }) : msg("off", { id: "off.outlet" });
    return html`<li class=${on === null ? "unknown" : ""}>
      <div>
        <div class="name">${outlet.signal.name}</div>
        <span class=${on === true ? "on" : "muted"}>${word}</span>
      </div>
      ${this.renderControl(outlet, on)} ${this.renderOutcome(outlet)}
    </li>`;
  }

  private renderControl({ signal, on: turnOn, off: turnOff }: Outlet, on: boolean | null): unknown {
    if (!this.mayUse || (turnOn === undefined && turnOff === undefined)) return nothing;
    if (on === null) {
      return html`<div class="both">
        ${map([turnOn, turnOff], (deed) =>
          deed === undefined
            ? nothing
            : html`<t-button label=${deed.label} ?disabled=${!this.isAllowed(deed)} @click=${this.switchAction(deed)}
                >${deed === turnOn ? msg("On") : msg("Off")}</t-button
              >`,
        )}
      </div>`;
    }
    const next = on ? turnOff : turnOn;
    if (next === undefined) return nothing;
    const busy = this.isBusy(next);
    return html`<button
      type="button"
      role="switch"
      aria-label=${signal.name}
      aria-checked=${on ? "true" : "false"}
      aria-busy=${busy ? "true" : "false"}
      ?disabled=${!this.isAllowed(next)}
      @click=${this.switchAction(next)}
    >
      <span class="track"><span class="knob"></span></span>
    </button>`;
  }

  private renderOutcome({ on, off }: Outlet): unknown {
    const deeds = [on, off].filter((button) => button !== undefined);
    const asked = deeds.map(({ command }) => this.line?.desk.latestRequest(this.device?.id ?? "", command.id) ?? null).filter((request) => request !== null);
    const last = asked.sort((a, b) => b.since - a.since)[0];
    const lock = deeds.map((deed) => this.lockReason(deed)).find((why) => why !== "") ?? "";
    if (lock !== "") return html`<span class="said locked"><t-icon name="lock"></t-icon> ${lock}</span>`;
    if (last === undefined || last.phase === "succeeded") return nothing;
    const { kind, word } = PHASES[last.phase];
    return html`<span class="said" role="status"><t-status kind=${kind} .word=${word}></t-status> ${last.message}</span>`;
  }

  private isBusy({ command }: CommandButton): boolean {
    const asked = this.line?.desk.latestRequest(this.device?.id ?? "", command.id) ?? null;
    return asked !== null && !isFinal(asked.phase);
  }

  private lockReason({ command }: CommandButton): string {
    const lock = this.interlocks.store?.lockOf(this.site, this.device?.id ?? "", command.id) ?? null;
    return lock === null ? "" : lockText(lock);
  }

  private isAllowed(deed: CommandButton): boolean {
    return this.online && this.lockReason(deed) === "";
  }

  private switchAction(deed: CommandButton): () => void {
    return () => {
      if (this.isBusy(deed)) return;
      if (deed.command.confirm) this.asking = deed;
      else this.line?.sendCommand(this.device?.id ?? "", deed.command.id, deed.args);
    };
  }

  private readonly onConfirm = (): void => {
    const deed = this.asking;
    this.asking = null;
    if (deed !== null && this.isAllowed(deed)) this.line?.sendCommand(this.device?.id ?? "", deed.command.id, deed.args);
  };

  private readonly onCancel = (): void => {
    this.asking = null;
  };
}

declare global {
  interface HTMLElementTagNameMap {
    "t-part-power": PowerPart;
  }
}
