/** One command for a group: chosen, shown who would do it, sent to each, and what became of it there. */

import { msg, str } from "@lit/localize";
import { css, html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, property, state } from "lit/decorators.js";
import { repeat } from "lit/directives/repeat.js";
import { ContextStoreController } from "../../controllers/context-store.js";
import type { CommandArguments } from "../../controllers/drive/command-client.js";
import { isFinal } from "../../controllers/drive/command-machine.js";
import type { GroupCommandClient } from "../../controllers/drive/group-command-client.js";
import { StoreController } from "../../controllers/store-controller.js";
import { base } from "../../elements/base/base-style.js";
import { PHASES } from "../../elements/command/command-phases.js";
import { renderOptions } from "../../elements/forms/form-parts.js";
import { control } from "../../elements/forms/input-style.js";
import { lockText } from "../../format/interlock-reason.js";
import type { SharedCommandShape, SiteSummary } from "../../generated/api.js";
import { deviceHoldersContext, interlocksContext, reachContext, sitesContext } from "../../state/contexts.js";
import { devicePath } from "../../state/router.js";
import type { Reachability } from "../../state/device-reachability.js";
import { consume } from "@lit/context";
import { commandKey, commandsOf, nameList, previewGroup, type GroupFacts, type GroupMember } from "./group-preview.js";
import { groupRows } from "./group-rows-style.js";
import "../../elements/command/command-form.js";
import "../../elements/feedback/empty.js";
import "../../elements/feedback/status.js";
import "../../elements/forms/button.js";

@customElement("t-fleet-command")
export class FleetCommand extends LitElement {
  static override styles = [
    base,
    groupRows,
    control,
    css`
      :host {
        display: grid;
        --t-word: 9rem;
        gap: var(--t-space-4);
        min-inline-size: 0;
      }
      select {
        inline-size: 100%;
        max-inline-size: 32rem;
      }
      label {
        display: grid;
        gap: var(--t-space-1);
        font-weight: var(--t-weight-strong);
      }
    `,
  ];

  @property({ attribute: false }) chosen: readonly SiteSummary[] = [];
  @property({ attribute: false }) commands: readonly SharedCommandShape[] = [];
  @property({ attribute: false }) line: GroupCommandClient | null = null;
  @state() private key = "";

  @consume({ context: reachContext, subscribe: true }) private readonly reach?: Reachability;
  private readonly interlocks = new ContextStoreController(this, interlocksContext);
  private readonly sites = new ContextStoreController(this, sitesContext);
  private readonly holders = new ContextStoreController(this, deviceHoldersContext);
  private readonly watched = new StoreController(this);
  private readonly reached = new StoreController(this);

  override willUpdate(): void {
    this.watched.setStore(this.line);
    this.reached.setStore(this.reach ?? null);
  }

  override render(): TemplateResult {
    if (this.chosen.length === 0) return html`<p class="text">${msg("Choose the sites first.")} ${this.renderResults()}</p>`;
    const offered = commandsOf(this.chosen, this.commands);
    if (offered.length === 0) return html`<t-empty heading=${msg("No command is open to you at these sites")} icon="devices"></t-empty>`;
    const command = this.chosenCommand(offered);
    const options = offered.map((shared) => {
      const count = this.chosen.filter(({ site }) => shared.sites.includes(site)).length;
      return [commandKey(shared), msg(str`${shared.device_name}: ${shared.command.name} (${String(count)} of ${String(this.chosen.length)})`)] as const;
    });
    return html`
      <label>${msg("Command")}<select @change=${this.onCommand}>${renderOptions([["", msg("Choose a command")], ...options], this.key)}</select></label>
      ${command === undefined ? nothing : this.renderChosen(command)} ${this.renderResults()}
    `;
  }

  private chosenCommand(offered: readonly SharedCommandShape[]): SharedCommandShape | undefined {
    return offered.find((shared) => commandKey(shared) === this.key);
  }

  private renderChosen(command: SharedCommandShape): TemplateResult {
    const members = this.preview(command);
    const able = members.filter(({ why }) => why === "");
    const names = nameList(able.map(({ name }) => name));
    const shape = {
      ...command.command,
      confirm: true,
      description: msg(str`${command.command.description} To ${String(able.length)} of ${String(members.length)}: ${names || msg("nobody")}. Each robot decides by its own interlocks.`).trim(),
    };
    return html`
      <div class="head"><h3>${msg("Who will do it")}</h3><span role="status">${msg(str`${able.length} of ${members.length}`)}</span></div>
      <ul aria-label=${msg("Who will do it")}>
        ${repeat(members, ({ site }) => site, renderMember)}
      </ul>
      <t-command .command=${shape} .allowed=${able.length > 0} @t-ask=${this.onAsk}></t-command>
    `;
  }

  private renderResults(): unknown {
    const rows = this.line?.rows ?? [];
    if (rows.length === 0) return nothing;
    const ended = rows.filter(({ phase }) => isFinal(phase)).length;
    const good = rows.filter(({ phase }) => phase === "succeeded").length;
    return html`
      <div class="head">
        <h3>${msg("What became of it")}</h3>
        <span role="status">${msg(str`${ended} of ${rows.length} ended, ${good} succeeded`)}</span>
        ${ended === rows.length ? nothing : html`<t-button @click=${this.onCancel}>${msg("Cancel those under way")}</t-button>`}
      </div>
      <ul aria-label=${msg("What became of it")}>
        ${repeat(
          rows,
          ({ site }) => site,
          ({ site, device, phase, message, progress }) => {
            const { kind, word } = PHASES[phase];
            // Others may be chosen by now.
            const name = this.sites.store?.siteRow(site)?.name ?? site;
            return html`<li>
              <span class="name">${name}</span>
              <t-status kind=${kind} .word=${phase === "running" && progress > 0 ? `${word}, ${(progress * 100).toFixed(0)} %` : word}></t-status>
              <span class="text">${message}</span>
              <a href=${devicePath(site, device)} aria-label=${msg(str`Open ${name}`)}>${msg("Open", { id: "open.verb" })}</a>
            </li>`;
          },
        )}
      </ul>
    `;
  }

  private preview(command: SharedCommandShape): readonly GroupMember[] {
    const facts: GroupFacts = {
      lockText: (site, device, id) => {
        const lock = this.interlocks.store?.lockOf(site, device, id) ?? null;
        return lock === null ? "" : lockText(lock);
      },
      unreachableText: (site, device) => {
        const away = this.reach?.unreachableSince(site, device);
        return away === undefined ? "" : msg(str`Its gateway does not reach the device: ${away.why || msg("no answer")}.`);
      },
      holderText: (site, device) => this.holders.store?.holdersOf(site, device)[0]?.words ?? "",
    };
    return previewGroup(this.chosen, command, this.commands, facts);
  }

  private send(command: SharedCommandShape, args: CommandArguments): void {
    const sites = this.preview(command).filter(({ why }) => why === "").map(({ site }) => site);
    const units = Object.fromEntries(command.command.arguments.map(({ id, unit }) => [id, unit] as const));
    this.line?.sendCommand(sites, { device: command.device, command: command.command.id, args, units });
  }

  private readonly onAsk = (event: CustomEvent<CommandArguments>): void => {
    const command = this.chosenCommand(commandsOf(this.chosen, this.commands));
    if (command !== undefined) this.send(command, event.detail);
  };

  private readonly onCommand = (event: Event): void => {
    if (event.target instanceof HTMLSelectElement) this.key = event.target.value;
  };

  private readonly onCancel = (): void => {
    this.line?.cancelRunning();
  };
}

function renderMember({ name, why, note }: GroupMember): TemplateResult {
  return html`<li>
    <span class="name">${name}</span>
    <t-status kind=${why === "" ? (note === "" ? "ok" : "warn") : "unknown"} .word=${why === "" ? msg("is asked") : msg("is not asked")}></t-status>
    <span class="text">${why || note}</span>
  </li>`;
}

declare global {
  interface HTMLElementTagNameMap {
    "t-fleet-command": FleetCommand;
  }
}
