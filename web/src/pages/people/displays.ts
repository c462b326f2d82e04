/** Displays: screens that show chosen sites and can do nothing else; each opens by an address of its own. */

import { consume } from "@lit/context";
import { msg, str } from "@lit/localize";
import { css, html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, query, queryAll, state } from "lit/decorators.js";
import { repeat } from "lit/directives/repeat.js";
import { ActionController } from "../../controllers/action.js";
import { LoadController } from "../../controllers/load.js";
import { OpenSubject } from "../../controllers/open-subject.js";
import { QuestionController } from "../../controllers/question.js";
import { ContextStoreController } from "../../controllers/context-store.js";
import { base } from "../../elements/base/base-style.js";
import { renderFormActions, renderShownOnce } from "../../elements/forms/form-parts.js";
import { renderQuestion } from "../../elements/feedback/question.js";
import { renderRows } from "../../elements/layout/rows.js";
import { sheets } from "../../elements/layout/page-sections.js";
import { apiContext, sitesContext } from "../../state/contexts.js";
import { AdminApi } from "../../wire/admin-api.js";
import type { DisplayShape } from "../../generated/api.js";
import type { HubApi } from "../../wire/hub-api.js";
import { renderAdvice, renderLoaded } from "../../elements/feedback/load-state.js";
import "../../elements/forms/button.js";
import "../../elements/forms/field.js";
import "../../elements/values/time.js";

@customElement("t-displays")
export class DisplaySection extends LitElement {
  static override styles = [
    base,
    sheets,
    css`
      fieldset {
        display: grid;
        gap: var(--t-space-2);
        margin: 0;
        padding: 0;
        border: 0;
      }
      label {
        display: flex;
        align-items: center;
        gap: var(--t-space-2);
        min-block-size: var(--t-touch);
      }
    `,
  ];

  @state() private made = "";
  @state() private wrong = "";
  @query("#name") private readonly name!: HTMLInputElement;
  @queryAll("fieldset input") private readonly boxes!: NodeListOf<HTMLInputElement>;

  @consume({ context: apiContext }) private readonly api!: HubApi;
  private readonly sites = new ContextStoreController(this, sitesContext);
  private readonly rows = new LoadController<readonly DisplayShape[]>(this);
  private readonly action = new ActionController(this);
  private readonly form = new OpenSubject<"new">(this);
  private readonly revoking = new QuestionController<DisplayShape>(this, (row, action) =>
    action.run(msg("revoke it", { id: "revoke-it.asked-display" }), () => new AdminApi(this.api).revokeDisplay(row.id)).finally(this.rows.invalidate),
  );

  override willUpdate(): void {
    this.rows.load("displays", () => new AdminApi(this.api).displays());
  }

  override render(): TemplateResult {
    return html`<div class="head">
        <div>
          <h2>${msg("Displays")}</h2>
          <p class="muted">${msg("A screen that shows some sites without anybody signing in. It commands, drives and stops nothing.")}</p>
        </div>
        <t-button ?hidden=${this.form.isOpen || this.made !== ""} @click=${this.form.opener("new")}>${msg("Add a display")}</t-button>
      </div>
      ${renderAdvice(this.action.problem)} ${this.made === "" ? nothing : this.renderShown()}
      ${this.form.isOpen ? this.renderForm() : nothing}
      ${renderLoaded(this.rows, msg("the list of displays"), (rows) => this.renderList(rows))}
      ${renderQuestion(this.revoking, ({ name }) => ({
        heading: msg(str`Revoke ${name}?`),
        action: msg("Revoke it", { id: "revoke-it.display" }),
        keep: msg("Keep it"),
        text: msg("Its screen goes dark at once. It cannot be taken back."),
      }))}`;
  }

  private renderForm(): TemplateResult {
    return html`<form class="fields" novalidate @submit=${this.onSubmit}>
      <t-field label=${msg("Name")} hint=${msg("Where the screen is")} error=${this.wrong}>
        <input id="name" autocomplete="off" maxlength="100" />
      </t-field>
      <fieldset>
        <legend>${msg("Sites that it shows")}</legend>
        ${repeat(
          this.sites.store?.list ?? [],
          ({ site }) => site,
          ({ site, name }) => html`<label><input type="checkbox" .value=${site} /> ${name}</label>`,
        )}
      </fieldset>
      ${renderFormActions({ submit: msg("Make it"), busy: this.action.busy, cancel: this.closeForm })}
    </form>`;
  }

  private renderShown(): TemplateResult {
    const secret = `${location.origin}/display#${this.made}`;
    return renderShownOnce(
      { label: msg("Address"), secret, done: msg("I have opened it"), onDone: this.closeSecret },
      msg(html`<strong>The display is made. Its address is not shown again:</strong> open it once in the screen's browser, which keeps it from then on. Whoever has the address can look, too.`),
    );
  }

  private renderList(rows: readonly DisplayShape[]): unknown {
    if (rows.length === 0) return this.form.isOpen ? nothing : html`<p class="muted">${msg("There are none.")}</p>`;
    const zone = this.sites.store?.zone ?? "UTC";
    return renderRows(
      rows,
      (row) => html`<li>
        <div>
          <span class="name">${row.name}</span>
          <div class="facts">
            <span>${msg(str`shows ${row.sites.join(", ")}`)}</span>
            <span>${msg(html`last opened <t-time .us=${row.used_us} .zone=${zone}></t-time>`)}</span>
          </div>
        </div>
        <t-button label=${msg(str`Revoke the display ${row.name}`)} @click=${this.revoking.opener(row)}>${msg("Revoke…")}</t-button>
      </li>`,
    );
  }

  private readonly onSubmit = (event: SubmitEvent): void => {
    event.preventDefault();
    const name = this.name.value.trim();
    const sites = [...this.boxes].filter((box) => box.checked).map((box) => box.value);
    this.wrong = name === "" ? msg("It needs a name.") : sites.length === 0 ? msg("Choose at least one site.") : "";
    if (this.wrong !== "") return;
    void this.action
      .run(msg("make the display"), async () => {
        this.made = (await new AdminApi(this.api).addDisplay(name, sites)).token;
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
    "t-displays": DisplaySection;
  }
}
