/** Which tile servers pages may ask, said by an admin: what that tells them stands in the form. */

import { msg, str } from "@lit/localize";
import { html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, property, query, state } from "lit/decorators.js";
import { ActionController } from "../../controllers/action.js";
import { LoadController } from "../../controllers/load.js";
import { OpenSubject } from "../../controllers/open-subject.js";
import { QuestionController } from "../../controllers/question.js";
import { base } from "../../elements/base/base-style.js";
import { renderAdvice, renderLoaded } from "../../elements/feedback/load-state.js";
import { renderQuestion } from "../../elements/feedback/question.js";
import { renderFormActions, renderOptions } from "../../elements/forms/form-parts.js";
import { sheets } from "../../elements/layout/page-sections.js";
import { renderRows } from "../../elements/layout/rows.js";
import { loadOffer } from "../../elements/map/map-offer.js";
import type { MapOffer, MapSourceAsk, MapSourceShape, SourceKind } from "../../generated/api.js";
import type { HubApi } from "../../wire/hub-api.js";
import "../../elements/forms/button.js";
import "../../elements/forms/field.js";

const KINDS = [
  ["tiles", msg("Tile server (pictures)")],
  ["google", msg("Google Maps, by your key")],
] as const;

@customElement("t-map-sources")
export class MapSourcesSection extends LitElement {
  static override styles = [base, sheets];

  @property({ attribute: false }) api: HubApi | null = null;
  @state() private wrong = "";
  @state() private changed = false;
  @state() private kind: SourceKind = "tiles";
  @query("#name") private readonly name!: HTMLInputElement;
  @query("#address") private readonly address!: HTMLInputElement | null;
  @query("#attribution") private readonly attribution!: HTMLInputElement | null;
  @query("#zoom") private readonly zoom!: HTMLInputElement | null;
  @query("#key") private readonly key!: HTMLInputElement | null;
  @query("#agreed") private readonly agreed!: HTMLInputElement;

  private readonly offer = new LoadController<MapOffer>(this);
  private readonly action = new ActionController(this);
  private readonly form = new OpenSubject<"new">(this);
  private readonly removing = new QuestionController<MapSourceShape>(this, (row, action) =>
    action
      .run(msg("remove it"), async () => {
        await this.api?.request("DELETE", `/api/maps/sources/${encodeURIComponent(row.id)}`);
        this.changed = true;
      })
      .finally(this.offer.invalidate),
  );

  override willUpdate(): void {
    const { api } = this;
    if (api !== null) this.offer.load("maps", () => loadOffer(api));
  }

  override render(): TemplateResult {
    return html`<div class="head">
        <div>
          <h2>${msg("Maps")}</h2>
          <p class="muted">${msg(html`The coarse world and files of the hub’s <code>--maps</code> folder ask nobody. A tile server is asked by each browser that shows its map.`)}</p>
        </div>
        <t-button ?hidden=${this.form.isOpen} @click=${this.form.opener("new")}>${msg("Allow a tile server")}</t-button>
      </div>
      ${renderAdvice(this.action.problem)}
      ${this.changed ? html`<p role="status">${msg("Pages that are loaded from now on go by this.")} <a href="/map" data-native @click=${this.onReload}>${msg("Load this page anew")}</a></p>` : nothing}
      ${this.form.isOpen ? this.renderForm() : nothing} ${renderLoaded(this.offer, msg("the list of maps"), (offer) => this.renderList(offer))}
      ${renderQuestion(this.removing, ({ name, host }) => ({
        heading: msg(str`Remove ${name}?`),
        action: msg("Remove it"),
        keep: msg("Keep it"),
        text: msg(str`No page asks ${host} any more. Maps on that ground fall back to the world that the hub brings.`),
      }))}`;
  }

  private renderForm(): TemplateResult {
    const google = this.kind === "google";
    return html`<form class="fields" novalidate @submit=${this.onSubmit}>
      <t-field label=${msg("Name")} error=${this.wrong}><input id="name" autocomplete="off" maxlength="100" /></t-field>
      <t-field label=${msg("Kind")}><select id="kind" @change=${this.onKind}>${renderOptions(KINDS, this.kind)}</select></t-field>
      ${google
        ? html`<t-field label=${msg("Key")} hint=${msg("Of the Map Tiles API. Every browser that shows the map gets it: limit it to this hub’s address and that API.")}>
            <input id="key" autocomplete="off" maxlength="200" />
          </t-field>`
        : html`<t-field label=${msg("Address")} hint="https://tiles.example.org/{z}/{x}/{y}.png"><input id="address" autocomplete="off" maxlength="500" /></t-field>
            <t-field label=${msg("Attribution")} hint=${msg("What its makers ask to be shown")}><input id="attribution" autocomplete="off" maxlength="200" /></t-field>
            <t-field label=${msg("Greatest zoom")}><input id="zoom" type="number" min="0" max="24" value="19" /></t-field>`}
      <t-field
        label=${msg("I allow that for everyone at this hub")}
        hint=${google
          ? msg("Google learns from each browser its address and, by the tiles, where your robots are. Its terms hold.")
          : msg("The server learns from each browser its address and, by the tiles, where your robots are. Pages may ask that host for pictures, and no other.")}
      >
        <input id="agreed" type="checkbox" />
      </t-field>
      ${renderFormActions({ submit: msg("Allow it"), busy: this.action.busy, cancel: this.closeForm })}
    </form>`;
  }

  private renderList({ files, sources }: MapOffer): unknown {
    return html`${files.length === 0 ? nothing : html`<p>${msg("Files:")} ${files.map(({ name }) => name).join(", ")}</p>`}
    ${sources.length === 0
      ? html`<p class="muted">${msg("No tile server is allowed.")}</p>`
      : renderRows(
          sources,
          (row) => html`<li>
            <div>
              <span class="name">${row.name}</span>
              <div class="facts"><span>${msg(str`asks ${row.host}`)}</span>${row.attribution === "" ? nothing : html`<span>${row.attribution}</span>`}</div>
            </div>
            <div class="actions"><t-button label=${msg(str`Remove ${row.name}`)} @click=${this.removing.opener(row)}>${msg("Remove…")}</t-button></div>
          </li>`,
        )}`;
  }

  private readonly onKind = (event: Event): void => {
    if (event.target instanceof HTMLSelectElement) this.kind = event.target.value === "google" ? "google" : "tiles";
  };

  private readonly onReload = (event: Event): void => {
    event.preventDefault();
    location.reload();
  };

  private readonly onSubmit = (event: SubmitEvent): void => {
    event.preventDefault();
    const asked: MapSourceAsk = {
      name: this.name.value.trim(),
      kind: this.kind,
      address: this.address?.value.trim() ?? "",
      attribution: this.attribution?.value.trim() ?? "",
      most_zoom: Number(this.zoom?.value ?? "19"),
      key: this.key?.value.trim() ?? "",
    };
    this.wrong = asked.name === "" ? msg("It needs a name.") : this.agreed.checked ? "" : msg("Say first that you allow what this tells others.");
    if (this.wrong !== "") return;
    void this.action
      .run(msg("allow it"), async () => {
        await this.api?.request("POST", "/api/maps/sources", asked);
        this.changed = true;
      })
      .then((done) => {
        if (done) this.form.close();
        this.offer.invalidate();
      });
  };

  private readonly closeForm = (): void => {
    this.form.close();
    this.action.clear();
  };
}

declare global {
  interface HTMLElementTagNameMap {
    "t-map-sources": MapSourcesSection;
  }
}
