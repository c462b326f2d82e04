/** Commands as a row of buttons: what each became of, and why one is locked, stands below them. */

import { msg, str } from "@lit/localize";
import { css, html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, property, state } from "lit/decorators.js";
import { map } from "lit/directives/map.js";
import { repeat } from "lit/directives/repeat.js";
import type { CommandClient } from "../../controllers/drive/command-client.js";
import { isFinal, type CommandRequest } from "../../controllers/drive/command-machine.js";
import { ContextStoreController } from "../../controllers/context-store.js";
import { StoreController } from "../../controllers/store-controller.js";
import { base, plainList } from "../../elements/base/base-style.js";
import { PHASES } from "../../elements/command/command-phases.js";
import { lockText } from "../../format/interlock-reason.js";
import { interlocksContext } from "../../state/contexts.js";
import type { DeviceShape } from "../../generated/api.js";
import { renderInterruptDialog } from "./interrupt-dialog.js";
import type { CommandButton } from "../observatory/roles.js";
import "../../elements/forms/button.js";
import "../../elements/feedback/confirm.js";
import "../../elements/base/icon.js";
import "../../elements/feedback/status.js";

@customElement("t-deeds")
export class CommandButtons extends LitElement {
  static override styles = [
    base,
    css`
      :host {
        display: grid;
        gap: var(--t-space-2);
        min-inline-size: 0;
      }
      .row {
        display: flex;
        flex-wrap: wrap;
        gap: var(--t-space-2);
      }
      .row t-button {
        flex: 1 1 auto;
        min-inline-size: 6rem;
      }
      ul {
        display: grid;
        gap: var(--t-space-1);
        ${plainList}
      }
      li {
        display: flex;
        flex-wrap: wrap;
        align-items: baseline;
        gap: 0 var(--t-space-2);
        overflow-wrap: anywhere;
      }
      .locked {
        display: grid;
        grid-template-columns: auto minmax(0, 1fr);
        gap: var(--t-space-2);
        color: var(--t-warn);
        font-size: var(--t-size-s);
      }
      progress {
        flex: 1 0 100%;
        block-size: 0.5rem;
        accent-color: var(--t-accent);
      }
    `,
  ];

  @property() site = "";
  @property({ attribute: false }) device: DeviceShape | null = null;
  @property({ attribute: false }) line: CommandClient | null = null;
  @property({ attribute: false }) deeds: readonly CommandButton[] = [];
  @property({ type: Boolean }) online = true;

  @state() private asking: CommandButton | null = null;

  private readonly interlocks = new ContextStoreController(this, interlocksContext);
  private readonly watched = new StoreController(this);

  override willUpdate(): void {
    this.watched.setStore(this.line);
  }

  override render(): TemplateResult | typeof nothing {
    if (this.deeds.length === 0) return nothing;
    return html`<div class="row" role="group" aria-label=${msg("Commands")}>
        ${repeat(this.deeds, ({ label }) => label, (deed) => this.renderButton(deed))}
      </div>
      ${this.online ? nothing : html`<t-status kind="offline" word=${msg("not connected: nothing can be asked")}></t-status>`}
      <div role="status">
        <ul>
          ${repeat(this.recentRequests(), ({ id }) => id, (asked) => this.renderOutcome(asked))}
        </ul>
      </div>
      ${map(
        this.lockReasons(),
        ([why, names]) => html`<div class="locked"><t-icon name="lock"></t-icon><span>${names.join(", ")}: ${why}</span></div>`,
      )}
      ${this.renderDialog()}${renderInterruptDialog(this.recentRequests(), this.line)}`;
  }

  private renderButton(deed: CommandButton): TemplateResult {
    const lock = this.lockOf(deed);
    const asked = this.line?.desk.latestRequest(this.device?.id ?? "", deed.command.id) ?? null;
    // What is asked for again while it is under way is refused by nobody's mistake; STOP never waits.
    const busy = asked !== null && !isFinal(asked.phase) && deed.kind !== "danger" && deed.command.arguments.length !== 1;
    const sendCommand = (): void => {
      if (deed.command.confirm) this.asking = deed;
      else this.sendCommand(deed);
    };
    return html`<t-button kind=${deed.kind} ?disabled=${!this.online || lock !== ""} ?busy=${busy} @click=${sendCommand}
      >${lock === "" ? nothing : html`<t-icon name="lock"></t-icon>`}${deed.label}${deed.command.confirm ? "…" : ""}</t-button
    >`;
  }

  private lockOf({ command }: CommandButton): string {
    const lock = this.interlocks.store?.lockOf(this.site, this.device?.id ?? "", command.id) ?? null;
    return lock === null ? "" : lockText(lock);
  }

  /** Buttons by the reason that locks them: each reason is said once. */
  private lockReasons(): ReadonlyMap<string, readonly string[]> {
    const found = new Map<string, string[]>();
    for (const deed of this.online ? this.deeds : []) {
      const why = this.lockOf(deed);
      if (why !== "") found.set(why, [...(found.get(why) ?? []), deed.label]);
    }
    return found;
  }

  private recentRequests(): readonly CommandRequest[] {
    const ids = new Set(this.deeds.map(({ command }) => command.id));
    const asked = [...ids].map((id) => this.line?.desk.latestRequest(this.device?.id ?? "", id) ?? null);
    return asked.filter((request) => request !== null).sort((a, b) => b.since - a.since).slice(0, 3);
  }

  private renderOutcome(asked: CommandRequest): TemplateResult {
    const name = this.deeds.find(({ command }) => command.id === asked.command)?.command.name ?? asked.command;
    const { kind, word } = PHASES[asked.phase];
    return html`<li>
      <t-status kind=${kind} .word=${`${name}: ${word}`}></t-status>
      ${asked.message === "" ? nothing : html`<span>${asked.message}</span>`}
      ${asked.phase === "running" && asked.progress > 0
        ? html`<progress max="1" .value=${asked.progress} aria-label=${msg(str`Progress of ${name}`)}></progress>`
        : nothing}
    </li>`;
  }

  private renderDialog(): TemplateResult {
    const name = this.asking?.label ?? "";
    return html`<t-confirm
      heading="${name}?"
      action=${name}
      kind="primary"
      keep=${msg("Do not send")}
      ?open=${this.asking !== null}
      @t-close=${this.onCancel}
      @t-confirm=${this.onConfirm}
    >
      <p>${this.asking?.command.description || msg("This is sent to the robot once.")}</p>
    </t-confirm>`;
  }

  private readonly onCancel = (): void => {
    this.asking = null;
  };

  private readonly onConfirm = (): void => {
    const deed = this.asking;
    this.asking = null;
    // What was asked for a moment ago may be locked by now.
    if (deed !== null && this.online && this.lockOf(deed) === "") this.sendCommand(deed);
  };

  private sendCommand(deed: CommandButton): void {
    const units = deed.command.arguments.map(({ id, unit }) => [id, unit] as const);
    this.line?.sendCommand(this.device?.id ?? "", deed.command.id, deed.args, Object.fromEntries(units));
  }
}

declare global {
  interface HTMLElementTagNameMap {
    "t-deeds": CommandButtons;
  }
}
