/** One gateway: how it stands, the way to it and to its devices, and the end of its key. */

import { consume } from "@lit/context";
import { css, html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, property, state } from "lit/decorators.js";
import { repeat } from "lit/directives/repeat.js";
import { ActionController } from "../../controllers/action.js";
import { base } from "../../elements/base/base-style.js";
import { sheets } from "../../elements/layout/page-sections.js";
import { apiContext } from "../../state/contexts.js";
import { devicePath } from "../../state/router.js";
import type { GatewayRow } from "../../wire/admin-types.js";
import { AdminApi } from "../../wire/admin-api.js";
import type { DeviceRow } from "../../wire/api-types.js";
import type { HubApi } from "../../wire/hub-api.js";
import { renderAdvice } from "../../elements/feedback/load-state.js";
import "../../elements/forms/button.js";
import "../../elements/feedback/confirm.js";
import "../../elements/feedback/status.js";
import "../../elements/values/time.js";

/** @fires t-changed something was done: the list is old */
@customElement("t-gateway-sheet")
export class GatewaySection extends LitElement {
  static override styles = [
    base,
    sheets,
    css`
      dl {
        display: grid;
        grid-template-columns: repeat(auto-fit, minmax(min(13rem, 100%), 1fr));
        gap: var(--t-space-3);
        margin: 0;
      }
      dt {
        color: var(--t-muted);
        font-size: var(--t-size-s);
      }
      dd {
        margin: 0;
        overflow-wrap: anywhere;
      }
      summary {
        min-block-size: var(--t-touch);
        align-content: center;
        font-weight: var(--t-weight-strong);
        cursor: pointer;
      }
    `,
  ];

  @property({ attribute: false }) row: GatewayRow | null = null;
  @property({ attribute: false }) devices: readonly DeviceRow[] = [];
  @property({ attribute: "site-name" }) siteName = "";
  @property() zone = "UTC";
  @state() private asking = false;

  @consume({ context: apiContext }) private readonly api!: HubApi;
  private readonly action = new ActionController(this);

  override render(): TemplateResult | typeof nothing {
    const { row } = this;
    if (row === null) return nothing;
    const { problem, doneText: done } = this.action;
    const revoked = row.revoked_us > 0;
    return html`<div class="head">
        <h2>${row.name === "" ? `Gateway of ${this.siteName}` : row.name}</h2>
        ${revoked
          ? html`<t-status kind="offline" word="revoked"></t-status>`
          : html`<t-status kind=${row.online ? "online" : "offline"}></t-status>`}
      </div>
      <dl>
        <div><dt>Site</dt><dd>${this.siteName} <span class="muted">${row.site}</span></dd></div>
        <div><dt>${row.online ? "Linked from" : "Last linked from"}</dt><dd>${row.address === "" ? "–" : row.address}</dd></div>
        <div><dt>Version</dt><dd>${row.version === "" ? "not told" : row.version}</dd></div>
        <div>
          <dt>${revoked ? "Revoked" : "Last seen"}</dt>
          <dd>
            ${row.online
              ? "now"
              : html`<t-time .us=${revoked ? row.revoked_us : row.seen_us} .zone=${this.zone}></t-time>`}
          </dd>
        </div>
        <div><dt>Enrolled</dt><dd><t-time .us=${row.created_us} .zone=${this.zone}></t-time></dd></div>
      </dl>
      ${problem === null || this.asking
        ? nothing
        : renderAdvice(problem)}
      ${revoked ? nothing : this.renderActions(row, done)} ${this.renderQuestion(row)}`;
  }

  private renderActions(row: GatewayRow, done: string): TemplateResult {
    return html`<div class="actions">
        <t-button ?disabled=${!row.online} ?busy=${this.action.runningKey === "link"} @click=${this.reconnectGateway}
          >Reconnect it</t-button
        >
        <t-button @click=${this.openQuestion}>Revoke…</t-button>
        <span class="said" role="status">${done}</span>
      </div>
      ${this.devices.length === 0
        ? nothing
        : html`<details>
            <summary>Its devices (${this.devices.length})</summary>
            <ul class="rows">
              ${repeat(
                this.devices,
                ({ device }) => device,
                (device) => this.renderDevice(row, device),
              )}
            </ul>
          </details>`}`;
  }

  private renderDevice(row: GatewayRow, device: DeviceRow): TemplateResult {
    const onReconnect = (): void => {
      const api = new AdminApi(this.api);
      const done = `${device.name}: the gateway connects to it anew.`;
      void this.action.run(`connect ${device.name} anew`, () => api.reconnect(row.id, device.device), done, device.device);
    };
    const late = device.stale === 0 ? "all signals fresh" : `${String(device.stale)} of ${String(device.signals)} signals stale`;
    return html`<li>
      <div>
        <a class="name" href=${devicePath(device.site, device.device)}>${device.name}</a>
        <div class="facts"><span>${device.signals === 0 ? "no signals" : late}</span></div>
      </div>
      <t-button
        label=${`Connect ${device.name} anew`}
        ?disabled=${!row.online}
        ?busy=${this.action.runningKey === device.device}
        @click=${onReconnect}
        >Reconnect</t-button
      >
    </li>`;
  }

  private renderQuestion(row: GatewayRow): TemplateResult {
    const name = row.name === "" ? this.siteName : row.name;
    return html`<t-confirm
      heading=${`Revoke the key of ${name}?`}
      action="Revoke it"
      keep="Keep it"
      ?open=${this.asking}
      ?busy=${this.action.busy}
      .problem=${this.asking ? this.action.problem : null}
      @t-confirm=${this.revoke}
      @t-close=${this.closeQuestion}
      ><p>
        Its link is closed at once: nothing more is seen of ${this.siteName}, and nothing there can be driven or stopped
        from here. A vehicle that is being driven comes to rest by itself. To come back, it has to be enrolled anew.
      </p></t-confirm
    >`;
  }

  private readonly openQuestion = (): void => {
    this.action.clear();
    this.asking = true;
  };

  private readonly closeQuestion = (): void => {
    this.asking = false;
    this.action.clear();
  };

  private readonly reconnectGateway = (): void => {
    const id = this.row?.id ?? "";
    void this.runAction("close the link", () => new AdminApi(this.api).reconnect(id), "The link is closed; the gateway dials again.", "link");
  };

  private readonly revoke = (): void => {
    const id = this.row?.id ?? "";
    void this.runAction("revoke the key", () => new AdminApi(this.api).revokeGateway(id), "");
  };

  private async runAction(asked: string, action: () => Promise<void>, done: string, key = asked): Promise<void> {
    if (!(await this.action.run(asked, action, done, key))) return;
    this.asking = false;
    this.dispatchEvent(new CustomEvent("t-changed"));
  }
}

declare global {
  interface HTMLElementTagNameMap {
    "t-gateway-sheet": GatewaySection;
  }
}
