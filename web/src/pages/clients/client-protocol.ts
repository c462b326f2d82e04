/** One client protocol: open or shut, where it is served, the origins that are let in. */

import { consume } from "@lit/context";
import { msg, str } from "@lit/localize";
import { html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, property } from "lit/decorators.js";
import { map } from "lit/directives/map.js";
import { ActionController } from "../../controllers/action.js";
import { OpenSubject } from "../../controllers/open-subject.js";
import { base } from "../../elements/base/base-style.js";
import { renderFormActions } from "../../elements/forms/form-parts.js";
import { sheets } from "../../elements/layout/page-sections.js";
import { formText, submittedForm } from "../../format/form-values.js";
import { hubText } from "../../words/hub-text.js";
import { plural } from "../../words/plural.js";
import { apiContext } from "../../state/contexts.js";
import type { BrokerShape, ClientProtocolShape } from "../../generated/api.js";
import { AdminApi } from "../../wire/admin-api.js";
import type { HubApi } from "../../wire/hub-api.js";
import { renderAdvice } from "../../elements/feedback/load-state.js";
import { clientAddress } from "./client-address.js";
import "../../elements/feedback/status.js";
import "../../elements/forms/button.js";
import "../../elements/forms/copy-text.js";
import "../../elements/forms/field.js";
import "../../elements/values/time.js";

/** @fires t-changed it was opened, shut or changed: the list is old */
@customElement("t-client-protocol")
export class ClientProtocol extends LitElement {
  static override styles = [base, sheets];

  @property({ attribute: false }) row: ClientProtocolShape | null = null;
  @property({ attribute: false }) sites: readonly string[] = [];

  @consume({ context: apiContext }) private readonly api!: HubApi;
  private readonly action = new ActionController(this);
  private readonly form = new OpenSubject<"origins">(this);

  override render(): TemplateResult | typeof nothing {
    const { row } = this;
    if (row === null) return nothing;
    return html`<div class="head">
        <div>
          <h2>${hubText(row.title)}</h2>
          <span class="muted">${hubText(row.tools)}</span>
        </div>
        <t-status kind=${row.open ? "online" : "offline"} word=${row.open ? openWords(row) : msg("shut")}></t-status>
      </div>
      ${row.open ? this.renderAddresses(row) : nothing}
      <div class="facts">
        ${row.path === "" ? nothing : html`<span>${row.origins.length === 0 ? msg("No web page is let in; programs are.") : msg(str`Web pages of ${row.origins.join(", ")} are let in.`)}</span>`}
        ${row.changed_by === "" ? nothing : html`<span>${msg(str`last set by ${row.changed_by}`)}</span>`}
      </div>
      ${this.form.isOpen ? this.renderOrigins(row) : this.renderActions(row)} ${renderAdvice(this.action.problem)}`;
  }

  private renderAddresses(row: ClientProtocolShape): TemplateResult {
    if (row.path === "") {
      return html`<p class="muted">${aboutFile(row)}</p>
        ${row.brokers.length === 0 ? html`<p class="muted">${msg("It was started without such a file.")}</p>` : map(row.brokers, renderBroker)}`;
    }
    return html`${map(
        this.sites,
        (site) => html`<t-copy label=${msg(str`Address for ${site}`)} .text=${clientAddress(row, site, window.location.origin)}></t-copy>`,
      )}
      <p class="muted">${msg("Each person makes a token of their own under Account and puts it in the place of TOKEN.")}</p>`;
  }

  private renderActions(row: ClientProtocolShape): TemplateResult {
    const toggle = (): void => {
      void this.save(row, !row.open, row.origins);
    };
    return html`<div class="actions">
      <t-button kind=${row.open ? "plain" : "primary"} label=${row.open ? msg(str`Shut it: ${hubText(row.title)}`) : msg(str`Open it: ${hubText(row.title)}`)} ?busy=${this.action.busy} @click=${toggle}
        >${row.open ? msg("Shut it") : msg("Open it")}</t-button
      >
      ${row.path === "" ? nothing : html`<t-button label=${msg(str`Web pages… that may use ${hubText(row.title)}`)} @click=${this.form.opener("origins")}>${msg("Web pages…")}</t-button>`}
    </div>`;
  }

  private renderOrigins(row: ClientProtocolShape): TemplateResult {
    return html`<form class="fields" novalidate @submit=${this.onSubmit}>
      <t-field label=${msg("Origins of web pages that are let in")} hint=${msg("One a line, like https://app.foxglove.dev; empty: none")}>
        <textarea name="origins" rows="4" spellcheck="false" maxlength="10000" .value=${row.origins.join("\n")}></textarea>
      </t-field>
      ${renderFormActions({ submit: msg("Save"), busy: this.action.busy, cancel: this.form.close })}
    </form>`;
  }

  private readonly onSubmit = (event: Event): void => {
    const data = submittedForm(event);
    if (data === undefined || this.row === null) return;
    const origins = formText(data, "origins").split(/\s+/).filter((origin) => origin !== "");
    void this.save(this.row, this.row.open, origins).then((done) => {
      if (done) this.form.close();
    });
  };

  private async save(row: ClientProtocolShape, open: boolean, origins: readonly string[]): Promise<boolean> {
    const asked = row.open === open ? msg("save the origins") : open ? msg("open it") : msg("shut it");
    const done = await this.action.run(asked, () => new AdminApi(this.api).setClientProtocol(row.protocol, open, origins));
    this.dispatchEvent(new CustomEvent("t-changed"));
    return done;
  }
}

/** What the file says by which the hub was started. */
function aboutFile(row: ClientProtocolShape): TemplateResult {
  return row.protocol === "alpaca"
    ? msg(html`The hub answers at the address that the file of <code>talaia hub --alpaca</code> names. Alpaca has no sign-in: whoever reaches that address reads what the file's token may see.`)
    : msg(html`The hub connects to the broker that the file of <code>talaia hub --mqtt</code> names, and publishes what that file and its token allow.`);
}

/** How one broker stands; who has lost it looks here first. */
function renderBroker(broker: BrokerShape): TemplateResult {
  const lost = broker.why !== "";
  const word = broker.connected ? msg("connected") : lost ? msg("lost") : msg("not connected");
  return html`<div class="facts">
      <t-status kind=${broker.connected ? "online" : lost ? "bad" : "offline"} word=${word}></t-status>
      <span>${broker.address}</span>
      ${broker.since_us === 0 ? nothing : html`<span>${msg(html`since <t-time .us=${broker.since_us} .zone=${ownZone()}></t-time>`)}</span>`}
      ${broker.connected || lost ? nothing : html`<span>${msg("nothing is to be published: its token is not good, or nobody may")}</span>`}
    </div>
    ${lost ? html`<p class="muted">${msg(str`${broker.why}. It is tried again by itself.`)}</p>` : nothing}
    ${map(broker.refused, (what) => html`<p class="muted">${msg(str`The broker refuses: ${what}. Its access list decides that.`)}</p>`)}`;
}

/** A broker is of no site, so its times are those of whoever looks. */
function ownZone(): string {
  return Intl.DateTimeFormat().resolvedOptions().timeZone;
}

function openWords({ path, connected }: ClientProtocolShape): string {
  // Where the hub connects, its broker says below how that stands.
  if (path === "") return msg("open", { id: "open.clients" });
  if (connected === 0) return msg("open, nobody is connected");
  return plural(connected, msg("open, 1 client is connected"), msg(str`open, ${String(connected)} clients are connected`));
}

declare global {
  interface HTMLElementTagNameMap {
    "t-client-protocol": ClientProtocol;
  }
}
