/** The one-shot commands of a site's devices, tied to the connection. */

import { msg } from "@lit/localize";
import { css, html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, property } from "lit/decorators.js";
import { repeat } from "lit/directives/repeat.js";
import type { CommandClient } from "../../controllers/drive/command-client.js";
import { base, quietText } from "../../elements/base/base-style.js";
import "../../elements/layout/card.js";
import "./command-card.js";
import type { CommandShape, DeviceShape } from "../../generated/api.js";

@customElement("t-commands")
export class CommandList extends LitElement {
  static override styles = [
    base,
    css`
      :host {
        display: grid;
        gap: var(--t-space-3);
      }
      .list {
        display: grid;
        grid-template-columns: repeat(auto-fill, minmax(min(100%, 20rem), 1fr));
        gap: var(--t-space-3);
      }
      .without {
        ${quietText}
      }
      .without ul {
        margin: var(--t-space-1) 0 0;
        padding-inline-start: var(--t-space-5);
      }
      .device {
        ${quietText}
      }
    `,
  ];

  @property() site = "";
  @property({ attribute: false }) devices: readonly DeviceShape[] = [];
  @property({ attribute: false }) line: CommandClient | null = null;
  @property({ type: Boolean }) online = true;
  /** Empty: it stands below the name of its one device. */
  @property() heading = msg("Commands");
  /** Ids of commands that the page shows elsewhere. */
  @property({ attribute: false }) shownElsewhere: ReadonlySet<string> = new Set();


  override render(): TemplateResult | typeof nothing {
    const rows = this.devices.flatMap((device) =>
      device.commands.filter(({ id }) => !this.shownElsewhere.has(id)).map((command) => ({ device, command })),
    );
    const policies = this.devices.filter((device) => device.link_loss !== "");
    if (rows.length === 0 && policies.length === 0) return nothing;
    return html`
      ${rows.length === 0 || this.heading === "" ? nothing : html`<h2>${this.heading}</h2>`}
      <div class="list">
        ${repeat(
          rows,
          ({ device, command }) => `${device.id}/${command.id}`,
          ({ device, command }) => this.renderCard(device, command),
        )}
      </div>
      ${policies.length === 0
        ? nothing
        : html`<div class="without">
            ${msg(html`<strong>When the hub is out of reach</strong> the gateway acts by itself:`)}
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

  private renderCard(device: DeviceShape, command: CommandShape): TemplateResult {
    return html`<t-card>
      ${this.heading === "" ? nothing : html`<span class="device">${device.name}</span>`}
      <t-command-card
        .site=${this.site}
        .device=${device}
        .command=${command}
        .line=${this.line}
        .online=${this.online}
      ></t-command-card>
    </t-card>`;
  }
}

declare global {
  interface HTMLElementTagNameMap {
    "t-commands": CommandList;
  }
}
