/** The commands of many devices: a section of each, which opens; what stops stands outside it. */

import { msg, str } from "@lit/localize";
import { css, html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, property, state } from "lit/decorators.js";
import { repeat } from "lit/directives/repeat.js";
import type { CommandClient } from "../../controllers/drive/command-client.js";
import { isFinal } from "../../controllers/drive/command-machine.js";
import { StoreController } from "../../controllers/store-controller.js";
import { base, quietText, raisedBox } from "../../elements/base/base-style.js";
import { PHASES } from "../../elements/command/command-phases.js";
import { control } from "../../elements/forms/input-style.js";
import "../../elements/base/icon.js";
import "../../elements/feedback/status.js";
import type { CommandShape, DeviceShape } from "../../generated/api.js";
import { plural } from "../../words/plural.js";
import { groupCommands, isLongList, type CommandGroups } from "./command-groups.js";
import "./command-buttons.js";
import "./command-list.js";

@customElement("t-command-sections")
export class CommandSections extends LitElement {
  static override styles = [
    base,
    control,
    css`
      :host {
        display: grid;
        grid-template-columns: minmax(0, 1fr);
        gap: var(--t-space-3);
      }
      .search {
        display: flex;
        flex-wrap: wrap;
        align-items: center;
        gap: var(--t-space-2) var(--t-space-4);
      }
      .search input {
        flex: 0 1 24rem;
      }
      .quiet {
        ${quietText}
      }
      .device {
        display: grid;
        grid-template-columns: minmax(0, 1fr);
        padding: var(--t-space-2) var(--t-space-4);
        ${raisedBox}
      }
      .head {
        display: flex;
        flex-wrap: wrap;
        align-items: start;
        gap: var(--t-space-2) var(--t-space-4);
      }
      h2 {
        flex: 1 1 14rem;
        min-inline-size: 0;
        align-self: center;
        overflow-wrap: anywhere;
      }
      .opens {
        display: flex;
        flex-wrap: wrap;
        align-items: center;
        gap: 0 var(--t-space-3);
        inline-size: 100%;
        min-block-size: var(--t-touch);
        padding: 0;
        border: 0;
        background: none;
        color: inherit;
        font: inherit;
        text-align: start;
        cursor: pointer;
      }
      .opens t-icon {
        color: var(--t-muted);
      }
      .opens[aria-expanded="true"] t-icon {
        rotate: 180deg;
      }
      summary {
        min-block-size: var(--t-touch);
        align-content: center;
        font-weight: var(--t-weight-strong);
        cursor: pointer;
      }
      .list {
        padding-block: var(--t-space-2) var(--t-space-3);
      }
      @media (max-width: 45rem) {
        .search input,
        .head t-deeds {
          flex: 1 1 100%;
        }
      }
    `,
  ];

  @property() site = "";
  @property({ attribute: false }) devices: readonly DeviceShape[] = [];
  @property({ attribute: false }) line: CommandClient | null = null;
  @property({ type: Boolean }) online = true;

  @state() private search = "";
  /** What somebody has opened or closed, by device. */
  private readonly chosen = new Map<string, boolean>();
  private readonly watched = new StoreController(this);

  override willUpdate(): void {
    this.watched.setStore(this.line);
  }

  override render(): TemplateResult {
    const long = isLongList(this.devices);
    const groups = groupCommands(this.devices, long ? this.search : "");
    return html`
      ${long ? this.renderSearch(groups) : nothing}
      ${repeat(
        groups,
        ({ device }) => device.id,
        (group, at) => this.renderDevice(group, !long || at === 0),
      )}
    `;
  }

  private renderSearch(groups: readonly CommandGroups[]): TemplateResult {
    const found = groups.reduce((sum, group) => sum + countCommands(group), 0);
    return html`<div class="search">
      <input type="search" aria-label=${msg("Search commands")} placeholder=${msg("Search commands")} .value=${this.search} @input=${this.onSearch} />
      <span class="quiet" role="status">${this.isSearched ? (found === 0 ? msg("Nothing matches.") : countText(found)) : nothing}</span>
    </div>`;
  }

  private renderDevice(group: CommandGroups, first: boolean): TemplateResult {
    const { device, urgent } = group;
    const open = this.isSearched || (this.chosen.get(device.id) ?? first);
    const inside = group.first.length + group.more.length;
    const buttons = urgent.map((command) => ({ command, args: {}, label: command.name, kind: "plain" as const }));
    return html`<section class="device" aria-label=${device.name}>
      <div class="head">
        <h2>
          ${inside === 0
            ? device.name
            : html`<button class="opens" type="button" aria-expanded=${open ? "true" : "false"} data-device=${device.id} ?disabled=${this.isSearched} @click=${this.onToggle}>
                <t-icon name="down"></t-icon><span>${device.name}</span><span class="quiet">${countText(inside)}</span>${this.renderUnderWay(device)}
              </button>`}
        </h2>
        ${urgent.length === 0
          ? nothing
          : html`<t-deeds
              .site=${this.site}
              .device=${device}
              .line=${this.line}
              .deeds=${buttons}
              .online=${this.online}
            ></t-deeds>`}
      </div>
      ${open && inside > 0 ? this.renderLists(group) : nothing}
    </section>`;
  }

  private renderLists({ device, first, more }: CommandGroups): TemplateResult {
    // What the gateway does by itself stands below the first list, and once.
    const besides = { ...device, link_loss: "" };
    return html`<div class="list">${this.renderList(device, first)}</div>
      ${more.length === 0
        ? nothing
        : html`<details class="more">
            <summary>${msg(str`More commands (${String(more.length)})`)}</summary>
            <div class="list">${this.renderList(besides, more)}</div>
          </details>`}`;
  }

  private renderList(device: DeviceShape, commands: readonly CommandShape[]): TemplateResult {
    const others = new Set(device.commands.filter((command) => !commands.includes(command)).map(({ id }) => id));
    return html`<t-commands heading="" .site=${this.site} .devices=${[device]} .line=${this.line} .online=${this.online} .shownElsewhere=${others}></t-commands>`;
  }

  /** What was asked for in a section is told of where it is closed, too. */
  private renderUnderWay(device: DeviceShape): TemplateResult | typeof nothing {
    const going = device.commands
      .map((command) => ({ command, asked: this.line?.desk.latestRequest(device.id, command.id) ?? null }))
      .find(({ asked }) => asked !== null && !isFinal(asked.phase));
    if (!going?.asked) return nothing;
    const { kind, word } = PHASES[going.asked.phase];
    return html` <t-status kind=${kind} .word=${`${going.command.name}: ${word}`}></t-status>`;
  }

  private get isSearched(): boolean {
    return this.search.trim() !== "";
  }

  private readonly onSearch = (event: Event): void => {
    this.search = (event.target as HTMLInputElement).value;
  };

  private readonly onToggle = (event: Event): void => {
    const button = event.currentTarget as HTMLButtonElement;
    this.chosen.set(button.dataset["device"] ?? "", button.getAttribute("aria-expanded") !== "true");
    this.requestUpdate();
  };
}

function countCommands({ urgent, first, more }: CommandGroups): number {
  return urgent.length + first.length + more.length;
}

function countText(count: number): string {
  return plural(count, msg("1 command"), msg(str`${String(count)} commands`));
}

declare global {
  interface HTMLElementTagNameMap {
    "t-command-sections": CommandSections;
  }
}
