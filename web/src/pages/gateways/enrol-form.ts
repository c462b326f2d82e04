/** Enrol a gateway: for which site, then the command with its one-time code, until it is used or too old. */

import { consume } from "@lit/context";
import { msg, str } from "@lit/localize";
import { css, html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, property, query, state } from "lit/decorators.js";
import { map } from "lit/directives/map.js";
import { ActionController } from "../../controllers/action.js";
import { TickerController } from "../../controllers/ticker.js";
import { base } from "../../elements/base/base-style.js";
import { focusInside } from "../../elements/base/focus.js";
import { renderFormActions } from "../../elements/forms/form-parts.js";
import { sheets } from "../../elements/layout/page-sections.js";
import { formatDuration } from "../../format/duration.js";
import { apiContext } from "../../state/contexts.js";
import type { CodeShape, GatewayShape } from "../../generated/api.js";
import { AdminApi } from "../../wire/admin-api.js";
import type { HubApi } from "../../wire/hub-api.js";
import { renderAdvice } from "../../elements/feedback/load-state.js";
import "../../elements/forms/button.js";
import "../../elements/forms/copy-text.js";
import "../../elements/forms/field.js";
import "../../elements/values/qr-code.js";
import "../../elements/feedback/status.js";

const SITE_ID = /^[a-z][a-z0-9_]{0,62}$/;

/**
 * @fires t-changed a code was made: the list is old
 * @fires t-close
 */
@customElement("t-enrol")
export class EnrolForm extends LitElement {
  static override styles = [
    base,
    sheets,
    css`
      .made {
        display: flex;
        flex-wrap: wrap;
        gap: var(--t-space-5);
      }
      .made > div {
        flex: 1 1 20rem;
        display: grid;
        align-content: start;
        gap: var(--t-space-3);
        min-inline-size: 0;
      }
      .left {
        font-size: var(--t-size-l);
        font-weight: var(--t-weight-strong);
        font-variant-numeric: tabular-nums;
      }
    `,
  ];

  /** Sites that have a gateway already, to choose from. */
  @property({ attribute: false }) sites: readonly string[] = [];
  @property({ attribute: false }) gateways: readonly GatewayShape[] = [];
  @property() zone = "UTC";
  @state() private made: CodeShape | null = null;
  @state() private wrong = "";
  @query("#site") private readonly site!: HTMLInputElement;
  @query("#name") private readonly name!: HTMLInputElement;

  @consume({ context: apiContext }) private readonly api!: HubApi;
  private readonly action = new ActionController(this);
  private known: ReadonlySet<string> = new Set();

  constructor() {
    super();
    new TickerController(this);
  }

  override firstUpdated(): void {
    void focusInside(this, "input");
  }

  override render(): TemplateResult {
    return this.made === null ? this.renderForm() : this.renderCode(this.made);
  }

  private renderForm(): TemplateResult {
    const { problem, busy } = this.action;
    return html`<h2>${msg("Enrol a gateway")}</h2>
      <form class="fields" novalidate @submit=${this.onSubmit}>
        <t-field label=${msg("Site")} hint=${msg("As its site description calls it: small letters, digits and _")} error=${this.wrong}>
          <input id="site" list="sites" autocomplete="off" autocapitalize="none" spellcheck="false" maxlength="63" />
        </t-field>
        <datalist id="sites">${map(this.sites, (site) => html`<option value=${site}></option>`)}</datalist>
        <t-field label=${msg("Name")} hint=${msg("What people call this gateway; may stay empty")}>
          <input id="name" autocomplete="off" maxlength="100" />
        </t-field>
        ${renderAdvice(problem)} ${renderFormActions({ submit: msg("Make a code"), busy, cancel: this.closeForm })}
      </form>`;
  }

  private renderCode(made: CodeShape): TemplateResult {
    const left = Math.max(0, made.expires_us / 1e6 - Date.now() / 1000);
    const came = this.gateways.find((row) => !this.known.has(row.id) && row.revoked_us === 0);
    if (came !== undefined) {
      return html`<h2>${msg("It is enrolled")}</h2>
        <p>
          <t-status kind=${came.online ? "online" : "busy"} word=${came.online ? msg("online") : msg("has its key, not linked yet")}></t-status>
          ${msg(str`${came.name === "" ? came.site : came.name} has a key of its own now; the code is used up.`)}
        </p>
        <div class="actions"><t-button kind="primary" @click=${this.closeForm}>${msg("Done")}</t-button></div>`;
    }
    if (left === 0) {
      return html`<h2>${msg("The code is too old")}</h2>
        <p>${msg("It was not used in time and has expired; make another.")}</p>
        <div class="actions">
          <t-button kind="primary" @click=${this.resetForm}>${msg("Make another")}</t-button><t-button @click=${this.closeForm}>${msg("Close")}</t-button>
        </div>`;
    }
    return html`<div class="head">
        <h2>${msg("Run this beside the robot")}</h2>
        <span class="left" role="timer">${msg(str`${formatDuration(left)} left`)}</span>
      </div>
      <div class="made">
        <div>
          <t-copy label=${msg("Command")} .text=${made.command}></t-copy>
          <t-copy label=${msg("Code alone")} .text=${made.code}></t-copy>
          ${made.fingerprint === ""
            ? nothing
            : html`<p class="muted">
                ${msg("The code carries the fingerprint of this hub's certificate, and the gateway believes no other:")}
                <code style="overflow-wrap: anywhere">${made.fingerprint}</code>
              </p>`}
          <p class="muted">${msg("The code works once and is not shown again. This page says when the gateway has used it.")}</p>
        </div>
        ${made.qr === "" ? nothing : html`<t-qr .svg=${made.qr} label=${msg("QR code of the command")}></t-qr>`}
      </div>
      <div class="actions">
        <t-status kind="busy" word=${msg("waiting for the gateway")}></t-status>
        <t-button @click=${this.closeForm}>${msg("Close")}</t-button>
      </div>`;
  }

  private readonly onSubmit = (event: SubmitEvent): void => {
    event.preventDefault();
    const site = this.site.value.trim();
    this.wrong = SITE_ID.test(site) ? "" : msg("It begins with a small letter; small letters, digits and _ follow.");
    if (this.wrong !== "") return;
    const name = this.name.value.trim();
    this.known = new Set(this.gateways.map(({ id }) => id));
    void this.action
      .run(msg("make a code"), async () => {
        this.made = await new AdminApi(this.api).makeCode(site, name);
      })
      .then((done) => {
        if (done) this.dispatchEvent(new CustomEvent("t-changed"));
      });
  };

  private readonly resetForm = (): void => {
    this.made = null;
  };

  private readonly closeForm = (): void => {
    this.dispatchEvent(new CustomEvent("t-close"));
  };
}

declare global {
  interface HTMLElementTagNameMap {
    "t-enrol": EnrolForm;
  }
}
