/** One gateway: how it stands, the way to it and to its devices, and the end of its key. */

import { consume } from "@lit/context";
import { msg, str } from "@lit/localize";
import { css, html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, property } from "lit/decorators.js";
import { repeat } from "lit/directives/repeat.js";
import { ActionController } from "../../controllers/action.js";
import { QuestionController } from "../../controllers/question.js";
import { base, quietText } from "../../elements/base/base-style.js";
import { renderQuestion } from "../../elements/feedback/question.js";
import { sheets } from "../../elements/layout/page-sections.js";
import { apiContext } from "../../state/contexts.js";
import { devicePath } from "../../state/router.js";
import type { DeviceSummary, GatewayShape } from "../../generated/api.js";
import { AdminApi } from "../../wire/admin-api.js";
import type { HubApi } from "../../wire/hub-api.js";
import { renderAdvice } from "../../elements/feedback/load-state.js";
import "../../elements/forms/button.js";
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
        ${quietText}
      }
      dd {
        margin: 0;
        overflow-wrap: anywhere;
      }
    `,
  ];

  @property({ attribute: false }) row: GatewayShape | null = null;
  @property({ attribute: false }) devices: readonly DeviceSummary[] = [];
  @property({ attribute: "site-name" }) siteName = "";
  @property() zone = "UTC";

  @consume({ context: apiContext }) private readonly api!: HubApi;
  private readonly action = new ActionController(this);
  private readonly revoking = new QuestionController<GatewayShape>(this, (row, action) =>
    this.runAction(action, msg("revoke the key"), () => new AdminApi(this.api).revokeGateway(row.id)),
  );

  private readonly replacing = new QuestionController<GatewayShape>(this, (row, action) =>
    this.runAction(action, msg("let the other take over"), () => new AdminApi(this.api).settleSecondGateway(row.id, "held")),
  );

  override render(): TemplateResult | typeof nothing {
    const { row } = this;
    if (row === null) return nothing;
    const { problem, doneText: done } = this.action;
    const revoked = row.revoked_us > 0;
    return html`<div class="head">
        <h2>${row.name === "" ? msg(str`Gateway of ${this.siteName}`) : row.name}</h2>
        ${revoked
          ? html`<t-status kind="offline" word=${msg("revoked")}></t-status>`
          : html`<t-status kind=${row.online ? "online" : "offline"}></t-status>`}
      </div>
      <dl>
        <div><dt>${msg("Site")}</dt><dd>${this.siteName} <span class="muted">${row.site}</span></dd></div>
        <div><dt>${row.online ? msg("Linked from") : msg("Last linked from")}</dt><dd>${row.address === "" ? "–" : row.address}</dd></div>
        <div><dt>${msg("Version")}</dt><dd>${row.version === "" ? msg("not told") : row.version}</dd></div>
        <div>
          <dt>${revoked ? msg("Revoked") : msg("Last seen")}</dt>
          <dd>
            ${row.online
              ? msg("now")
              : html`<t-time .us=${revoked ? row.revoked_us : row.seen_us} .zone=${this.zone}></t-time>`}
          </dd>
        </div>
        <div><dt>${msg("Enrolled")}</dt><dd><t-time .us=${row.created_us} .zone=${this.zone}></t-time></dd></div>
      </dl>
      ${row.held.length === 0 ? nothing : this.renderSecond(row)}
      ${renderAdvice(problem)} ${revoked ? nothing : this.renderActions(row, done)}
      ${renderQuestion(this.revoking, ({ name }) => ({
        heading: msg(str`Revoke the key of ${name === "" ? this.siteName : name}?`),
        action: msg("Revoke it", { id: "revoke-it.gateway" }),
        keep: msg("Keep it"),
        text: msg(str`Its link is closed at once: nothing more is seen of ${this.siteName}, and nothing there can be driven or stopped from here. A vehicle that is being driven comes to rest by itself. To come back, it has to be enrolled anew.`),
      }))}`;
  }

  /** Another gateway with the same key waits: which of the two stays? */
  private renderSecond(row: GatewayShape): TemplateResult {
    return html`<h3>${msg("A second gateway has this key, and waits")}</h3>
      <ul class="rows">
        ${repeat(
          row.held,
          (held) => html`<li>
            <div>
              <span class="name">${held.address}</span>
              <div class="facts">
                <span>${msg(str`version ${held.version === "" ? msg("not told") : held.version}`)}</span>
                <span>${msg(html`since <t-time .us=${held.since_us} .zone=${this.zone}></t-time>`)}</span>
              </div>
            </div>
          </li>`,
        )}
      </ul>
      <p class="muted">
        ${msg("Its key was copied, or a machine was forgotten. Nothing is taken from the one that waits, and STOP reaches both. If you know neither, revoke the key and enrol the robot anew.")}
      </p>
      <div class="actions">
        <t-button ?busy=${this.action.runningKey === msg("keep the one that is linked")} @click=${this.keepLinked}
          >${msg("Keep the one that is linked")}</t-button
        >
        <t-button @click=${this.replacing.opener(row)}>${msg("Let the other take over…")}</t-button>
      </div>
      ${renderQuestion(this.replacing, () => ({
        heading: msg("Let the gateway that waits take over?"),
        action: msg("Let it take over"),
        keep: msg("Leave it as it is"),
        text: msg(str`The one that is linked to ${this.siteName} now is sent away and waits in its place. A vehicle that is being driven comes to rest.`),
      }))}`;
  }

  private readonly keepLinked = (): void => {
    const id = this.row?.id ?? "";
    void this.runAction(
      this.action,
      msg("keep the one that is linked"),
      () => new AdminApi(this.api).settleSecondGateway(id, "linked"),
      msg("It stays; the other one goes on waiting."),
    );
  };

  private renderActions(row: GatewayShape, done: string): TemplateResult {
    return html`<div class="actions">
        <t-button ?disabled=${!row.online} ?busy=${this.action.runningKey === msg("close the link")} @click=${this.reconnectGateway}
          >${msg("Reconnect it")}</t-button
        >
        <t-button @click=${this.revoking.opener(row)}>${msg("Revoke…")}</t-button>
        <span class="said" role="status">${done}</span>
      </div>
      ${this.devices.length === 0
        ? nothing
        : html`<details>
            <summary>${msg(str`Its devices (${this.devices.length})`)}</summary>
            <ul class="rows">
              ${repeat(this.devices, ({ device }) => device, (device) => this.renderDevice(row, device))}
            </ul>
          </details>`}`;
  }

  private renderDevice(row: GatewayShape, device: DeviceSummary): TemplateResult {
    const onReconnect = (): void => {
      const api = new AdminApi(this.api);
      const done = msg(str`${device.name}: the gateway connects to it anew.`);
      void this.action.run(msg(str`connect ${device.name} anew`), () => api.reconnect(row.id, device.device), done, device.device);
    };
    const late = device.stale === 0 ? msg("all signals fresh") : msg(str`${String(device.stale)} of ${String(device.signals)} signals stale`);
    return html`<li>
      <div>
        <a class="name" href=${devicePath(device.site, device.device)}>${device.name}</a>
        <div class="facts"><span>${device.signals === 0 ? msg("no signals") : late}</span></div>
      </div>
      <t-button
        label=${msg(str`Connect ${device.name} anew`)}
        ?disabled=${!row.online}
        ?busy=${this.action.runningKey === device.device}
        @click=${onReconnect}
        >${msg("Reconnect")}</t-button
      >
    </li>`;
  }

  private readonly reconnectGateway = (): void => {
    const id = this.row?.id ?? "";
    void this.runAction(this.action, msg("close the link"), () => new AdminApi(this.api).reconnect(id), msg("The link is closed; the gateway dials again."));
  };

  private async runAction(action: ActionController, asked: string, perform: () => Promise<void>, done = ""): Promise<boolean> {
    const succeeded = await action.run(asked, perform, done);
    if (succeeded) this.dispatchEvent(new CustomEvent("t-changed"));
    return succeeded;
  }
}

declare global {
  interface HTMLElementTagNameMap {
    "t-gateway-sheet": GatewaySection;
  }
}
