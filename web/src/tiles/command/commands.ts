/** The one-shot commands of a site's devices, tied to the connection. */

import { css, html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, property } from "lit/decorators.js";
import { repeat } from "lit/directives/repeat.js";
import type { Arguments, CommandLine } from "../../controllers/drive/command-line.js";
import { StoreController } from "../../controllers/store.js";
import { base } from "../../elements/base.js";
import "../../elements/card.js";
import "../../elements/command/command.js";
import { lockWords } from "../../format/interlock.js";
import { interlocksContext } from "../../state/contexts.js";
import type { CommandInfo, DeviceInfo } from "../../wire/api.js";

@customElement("t-commands")
export class Commands extends LitElement {
  static override styles = [
    base,
    css`
      :host {
        display: grid;
        gap: var(--t-space-3);
      }
      .list {
        display: grid;
        grid-template-columns: repeat(auto-fit, minmax(min(100%, 20rem), 1fr));
        gap: var(--t-space-3);
      }
      .without {
        color: var(--t-muted);
        font-size: var(--t-size-s);
      }
      .without ul {
        margin: var(--t-space-1) 0 0;
        padding-inline-start: var(--t-space-5);
      }
      .device {
        color: var(--t-muted);
        font-size: var(--t-size-s);
      }
    `,
  ];

  @property() site = "";
  @property({ attribute: false }) devices: readonly DeviceInfo[] = [];
  @property({ attribute: false }) line: CommandLine | null = null;
  @property({ type: Boolean }) online = true;

  private readonly interlocks = new StoreController(this, interlocksContext);
  private watched: CommandLine | null = null;
  private stop: (() => void) | null = null;

  override willUpdate(): void {
    if (this.watched === this.line) return;
    this.stop?.();
    this.watched = this.line;
    this.stop =
      this.line?.watch(() => {
        this.requestUpdate();
      }) ?? null;
  }

  override disconnectedCallback(): void {
    super.disconnectedCallback();
    this.stop?.();
    this.stop = null;
    this.watched = null;
  }

  override connectedCallback(): void {
    super.connectedCallback();
    this.requestUpdate();
  }

  override render(): TemplateResult | typeof nothing {
    const rows = this.devices.flatMap((device) => device.commands.map((command) => ({ device, command })));
    const policies = this.devices.filter((device) => device.link_loss !== "");
    if (rows.length === 0 && policies.length === 0) return nothing;
    return html`
      <h2>Commands</h2>
      <div class="list">
        ${repeat(
          rows,
          ({ device, command }) => `${device.id}/${command.id}`,
          ({ device, command }) => this.card(device, command),
        )}
      </div>
      ${policies.length === 0
        ? nothing
        : html`<div class="without">
            <strong>When the hub is out of reach</strong> the gateway acts by itself:
            <ul>
              ${repeat(
                policies,
                (device) => device.id,
                (device) => html`<li>${device.name}: ${device.link_loss}.</li>`,
              )}
            </ul>
          </div>`}
    `;
  }

  private card(device: DeviceInfo, command: CommandInfo): TemplateResult {
    const asked = this.line?.desk.latest(device.id, command.id) ?? null;
    const ask = (event: CustomEvent<Arguments>): void => {
      const units = command.arguments.map(({ id, unit }) => [id, unit] as const);
      this.line?.ask(device.id, command.id, event.detail, Object.fromEntries(units));
    };
    const cancel = (): void => {
      this.line?.cancel(device.id, command.id);
    };
    const lock = this.interlocks.store?.lockOf(this.site, device.id, command.id) ?? null;
    return html`<t-card>
      <span class="device">${device.name}</span>
      <t-command
        .command=${command}
        .asked=${asked}
        .online=${this.online}
        .locked=${lock ? lockWords(lock) : ""}
        .allowed=${device.rights.includes("use")}
        @t-ask=${ask}
        @t-cancel=${cancel}
      ></t-command>
    </t-card>`;
  }
}

declare global {
  interface HTMLElementTagNameMap {
    "t-commands": Commands;
  }
}
