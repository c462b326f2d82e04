/** Other hubs that leave signed heads of their audit logs here, where they cannot write over them. */

import { consume } from "@lit/context";
import { msg, str } from "@lit/localize";
import { html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, query, state } from "lit/decorators.js";
import { ActionController } from "../../controllers/action.js";
import { ContextStoreController } from "../../controllers/context-store.js";
import { LoadController } from "../../controllers/load.js";
import { OpenSubject } from "../../controllers/open-subject.js";
import { QuestionController } from "../../controllers/question.js";
import { base } from "../../elements/base/base-style.js";
import { renderAdvice, renderLoaded } from "../../elements/feedback/load-state.js";
import { renderQuestion } from "../../elements/feedback/question.js";
import { renderFormActions, renderShownOnce } from "../../elements/forms/form-parts.js";
import { sheets } from "../../elements/layout/page-sections.js";
import { renderRows } from "../../elements/layout/rows.js";
import type { WitnessedHubShape } from "../../generated/api.js";
import { apiContext, sitesContext } from "../../state/contexts.js";
import { AdminApi } from "../../wire/admin-api.js";
import { plural } from "../../words/plural.js";
import type { HubApi } from "../../wire/hub-api.js";
import { witnessState } from "./witness-state.js";
import "../../elements/feedback/problem.js";
import "../../elements/feedback/status.js";
import "../../elements/forms/button.js";
import "../../elements/forms/field.js";
import "../../elements/values/time.js";

@customElement("t-witnessed-hubs")
export class WitnessedHubs extends LitElement {
  static override styles = [base, sheets];

  @state() private made = "";
  @state() private wrong = "";
  @query("#name") private readonly name!: HTMLInputElement;
  @query("#days") private readonly days!: HTMLInputElement;

  @consume({ context: apiContext }) private readonly api!: HubApi;
  private readonly sites = new ContextStoreController(this, sitesContext);
  private readonly rows = new LoadController<readonly WitnessedHubShape[]>(this);
  private readonly action = new ActionController(this);
  private readonly form = new OpenSubject<"new">(this);
  private readonly removing = new QuestionController<WitnessedHubShape>(this, (row, action) =>
    action.run(msg("remove it"), () => new AdminApi(this.api).removeWitnessedHub(row.id)).finally(this.rows.invalidate),
  );

  override willUpdate(): void {
    this.rows.load("hubs", () => new AdminApi(this.api).witnessedHubs());
  }

  override render(): TemplateResult {
    return html`<div class="head">
        <div>
          <h2>${msg("Logs of other hubs")}</h2>
          <p class="muted">${msg("Another hub leaves the signed heads of its audit log here. Who makes that log anew cannot change them.")}</p>
        </div>
        <t-button ?hidden=${this.form.isOpen || this.made !== ""} @click=${this.form.opener("new")}>${msg("Add a hub")}</t-button>
      </div>
      ${renderAdvice(this.action.problem)} ${this.made === "" ? nothing : this.renderShown()}
      ${this.form.isOpen ? this.renderForm() : nothing}
      ${renderLoaded(this.rows, msg("the list of other hubs"), (rows) => this.renderList(rows))}
      ${renderQuestion(this.removing, ({ name, heads }) => ({
        heading: msg(str`Remove ${name}?`),
        action: msg("Remove it"),
        keep: msg("Keep it"),
        text: plural(heads, msg("Its head is deleted, and nothing here shows any more what its log was. Save it first."), msg(str`Its ${String(heads)} heads are deleted, and nothing here shows any more what its log was. Save them first.`)),
      }))}`;
  }

  private renderForm(): TemplateResult {
    return html`<form class="fields" novalidate @submit=${this.onSubmit}>
      <t-field label=${msg("Name of the other hub")} error=${this.wrong}>
        <input id="name" autocomplete="off" maxlength="100" />
      </t-field>
      <t-field label=${msg("Keep its heads for")} hint=${msg("Days: 7 to 3660. The newest stays.")}>
        <input id="days" type="number" min="7" max="3660" value="730" />
      </t-field>
      ${renderFormActions({ submit: msg("Make a token for it"), busy: this.action.busy, cancel: this.closeForm })}
    </form>`;
  }

  private renderShown(): TemplateResult {
    return renderShownOnce(
      { label: msg("Token"), secret: this.made, done: msg("I have kept it"), onDone: this.closeSecret },
      msg(html`<strong>The token is not shown again.</strong> Put it into a file on the other hub's machine, and name that file in its <code>--audit-hub</code> settings. It leaves heads here and opens nothing.`),
    );
  }

  private renderList(rows: readonly WitnessedHubShape[]): unknown {
    if (rows.length === 0) return this.form.isOpen ? nothing : html`<p class="muted">${msg("There are none.", { id: "there-are-none.hubs" })}</p>`;
    return renderRows(rows, (row) => this.renderRow(row));
  }

  private renderRow(row: WitnessedHubShape): TemplateResult {
    const zone = this.sites.store?.zone ?? "UTC";
    const { kind, word } = witnessState(row, Date.now() * 1000);
    return html`<li>
      <div>
        <span class="name">${row.name}</span>
        <t-status kind=${kind} word=${word}></t-status>
        <div class="facts">
          ${row.row === 0 ? nothing : html`<span>${msg(html`row ${row.row} at <t-time .us=${row.time_us} .zone=${zone}></t-time>`)}</span>`}
          <span>${msg(html`last heard <t-time .us=${row.heard_us} .zone=${zone}></t-time>`)}</span>
          <span>${msg(str`${row.heads} heads, each kept ${row.keep_days} days`)}</span>
          ${row.key === "" ? nothing : html`<span>${msg(str`key ${row.key}`)}</span>`}
        </div>
        ${row.problem === ""
          ? nothing
          : html`<t-problem
              what=${msg(str`What ${row.name} says of its log does not fit together: ${row.problem}.`)}
              how=${msg("Save its heads, and hold its log against them on its machine: talaia audit verify --heads FILE.")}
            ></t-problem>`}
      </div>
      <div class="actions">
        <a download href=${`/api/audit/hubs/${encodeURIComponent(row.id)}/heads`} aria-label=${msg(str`Save the heads of ${row.name}`)}>${msg("Save its heads")}</a>
        <t-button label=${msg(str`Remove ${row.name}`)} @click=${this.removing.opener(row)}>${msg("Remove…")}</t-button>
      </div>
    </li>`;
  }

  private readonly onSubmit = (event: SubmitEvent): void => {
    event.preventDefault();
    const name = this.name.value.trim();
    const days = Number(this.days.value);
    const possible = Number.isInteger(days) && days >= 7 && days <= 3660;
    this.wrong = name === "" ? msg("It needs a name.") : possible ? "" : msg("Days: a whole number from 7 to 3660.");
    if (this.wrong !== "") return;
    void this.action
      .run(msg("add the hub"), async () => {
        this.made = (await new AdminApi(this.api).addWitnessedHub(name, days)).token;
      })
      .then((done) => {
        if (done) this.form.close();
        this.rows.invalidate();
      });
  };

  private readonly closeForm = (): void => {
    this.form.close();
    this.action.clear();
  };

  private readonly closeSecret = (): void => {
    this.made = "";
  };
}

declare global {
  interface HTMLElementTagNameMap {
    "t-witnessed-hubs": WitnessedHubs;
  }
}
