/** Clients: the protocols by which other tools connect, and who may drive by them. */

import { consume } from "@lit/context";
import { msg, str } from "@lit/localize";
import { html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement } from "lit/decorators.js";
import { repeat } from "lit/directives/repeat.js";
import { ActionController } from "../../controllers/action.js";
import { LoadController } from "../../controllers/load.js";
import { OpenSubject } from "../../controllers/open-subject.js";
import { ContextStoreController } from "../../controllers/context-store.js";
import { TickerController } from "../../controllers/ticker.js";
import { base } from "../../elements/base/base-style.js";
import { renderFormActions, renderOptions } from "../../elements/forms/form-parts.js";
import { renderPageHead } from "../../elements/layout/page-head.js";
import { sheets } from "../../elements/layout/page-sections.js";
import { renderRowSheet } from "../../elements/layout/rows.js";
import { formText, submittedForm } from "../../format/form-values.js";
import { apiContext, sitesContext } from "../../state/contexts.js";
import type { ClientDriverShape, ClientProtocolList, DeviceShape, PersonShape } from "../../generated/api.js";
import { AdminApi } from "../../wire/admin-api.js";
import type { HubApi } from "../../wire/hub-api.js";
import { renderAdvice, renderLoaded } from "../../elements/feedback/load-state.js";
import "../../elements/feedback/empty.js";
import "../../elements/forms/button.js";
import "../../elements/forms/field.js";
import "../admin-tabs.js";
import "./client-protocol.js";

/** A client that comes or goes is seen this soon (s). */
const AGAIN_S = 3;

@customElement("t-page-clients")
export class PageClients extends LitElement {
  static override styles = [base, sheets];

  @consume({ context: apiContext }) private readonly api!: HubApi;
  private readonly sites = new ContextStoreController(this, sitesContext);
  private readonly known = new LoadController<ClientProtocolList>(this);
  private readonly people = new LoadController<readonly PersonShape[]>(this);
  private readonly devices = new LoadController<readonly DrivenDevice[]>(this);
  private readonly action = new ActionController(this);
  private readonly form = new OpenSubject<"driver">(this);

  constructor() {
    super();
    new TickerController(this);
  }

  override willUpdate(): void {
    const turn = Math.floor(Date.now() / (AGAIN_S * 1000));
    this.known.load(String(turn), () => new AdminApi(this.api).clientProtocols());
    if (!this.form.isOpen) return;
    this.people.load("people", () => new AdminApi(this.api).people());
    const sites = this.sites.store?.list.map(({ site }) => site) ?? [];
    this.devices.load(sites.join(" "), async () => {
      const described = await Promise.all(sites.map((site) => this.api.site(site)));
      return described.flatMap(({ site, devices }) => devices.filter(isDriven).map(({ id }) => ({ site, device: id })));
    });
  }

  override render(): TemplateResult {
    return html`<t-admin-tabs page="clients"></t-admin-tabs>
      ${renderPageHead(
        msg("Clients"),
        msg("Other tools connect by these protocols, with a token and by its rights. Each is shut until you open it."),
        html`<t-button ?hidden=${this.form.isOpen} @click=${this.form.opener("driver")}>${msg("Let somebody drive")}</t-button>`,
      )}
      ${this.form.isOpen ? this.renderForm() : renderAdvice(this.action.problem)}
      ${renderLoaded(this.known, msg("the client protocols"), (value) => this.renderContent(value))}`;
  }

  private renderContent({ protocols, drivers }: ClientProtocolList): TemplateResult {
    const sites = this.sites.store?.list.map(({ site }) => site) ?? [];
    return html`${repeat(
        protocols,
        ({ protocol }) => protocol,
        (row) => html`<t-client-protocol class="sheet" .row=${row} .sites=${sites} @t-changed=${this.known.invalidate}></t-client-protocol>`,
      )}
      ${drivers.length === 0
        ? nothing
        : renderRowSheet(
            msg("Who may drive by such clients"),
            drivers.map((driver) => ({ ...driver, id: `${driver.person} ${driver.site} ${driver.device}` })),
            (driver) => this.renderDriver(driver),
          )}`;
  }

  private renderDriver(driver: ClientDriverShape): TemplateResult {
    const key = `${driver.person} ${driver.site} ${driver.device}`;
    const onWithdraw = (): void => {
      void this.action.run(msg("withdraw it"), () => new AdminApi(this.api).setClientDriver(driver, false), "", key).then(this.known.invalidate);
    };
    return html`<li>
      <div>
        <span class="name">${msg(str`${driver.name} may drive ${driver.device}`)}</span>
        <div class="facts"><span>${driver.site}</span><span>${msg(str`permitted by ${driver.given_by}`)}</span></div>
      </div>
      <t-button label=${msg(str`${driver.name} may drive ${driver.device} no more`)} ?busy=${this.action.runningKey === key} @click=${onWithdraw}>${msg("Withdraw")}</t-button>
    </li>`;
  }

  private renderForm(): TemplateResult {
    return html`<section class="sheet" aria-labelledby="driver">
      <h2 id="driver">${msg("Let somebody drive by other tools")}</h2>
      <p class="muted">
        ${msg("Such a tool cannot tell how old its line makes its messages. Each moves the device for 250 ms, at half of its greatest speed at the most; then it is stopped. STOP needs no permission.")}
      </p>
      <form class="fields" novalidate @submit=${this.onSubmit}>
        <t-field label=${msg("Person")}>
          <select name="person">${renderOptions((this.people.value ?? []).map(({ id, name }) => [id, name] as const), "")}</select>
        </t-field>
        <t-field label=${msg("Device")}>
          <select name="device">
            ${renderOptions((this.devices.value ?? []).map(({ site, device }) => [`${site}/${device}`, `${device} (${site})`] as const), "")}
          </select>
        </t-field>
        ${renderAdvice(this.action.problem)} ${renderFormActions({ submit: msg("Permit it"), busy: this.action.busy, cancel: this.form.close })}
      </form>
    </section>`;
  }

  private readonly onSubmit = (event: Event): void => {
    const data = submittedForm(event);
    if (data === undefined) return;
    const [site = "", device = ""] = formText(data, "device").split("/");
    const driver = { person: formText(data, "person"), site, device };
    void this.action
      .run(msg("permit it"), () => new AdminApi(this.api).setClientDriver(driver, true))
      .then((done) => {
        if (done) this.form.close();
        this.known.invalidate();
      });
  };
}

interface DrivenDevice {
  readonly site: string;
  readonly device: string;
}

function isDriven({ drive }: DeviceShape): boolean {
  return drive !== null;
}

declare global {
  interface HTMLElementTagNameMap {
    "t-page-clients": PageClients;
  }
}
