/** Make a field of a raw topic a signal: what it is called, what becomes other in the description, and that it is applied. */

import { consume } from "@lit/context";
import { msg, str } from "@lit/localize";
import { css, html, LitElement, nothing, type PropertyValues, type TemplateResult } from "lit";
import { customElement, property, query, state } from "lit/decorators.js";
import { ActionController } from "../../controllers/action.js";
import { ContextStoreController } from "../../controllers/context-store.js";
import { LoadController } from "../../controllers/load.js";
import { base } from "../../elements/base/base-style.js";
import { renderAdvice, renderLoaded } from "../../elements/feedback/load-state.js";
import { renderOptions } from "../../elements/forms/form-parts.js";
import { forms } from "../../elements/forms/form-style.js";
import { formText } from "../../format/form-values.js";
import type { ChangeAnswer, DescriptionList, DescriptionText } from "../../generated/api.js";
import { apiContext, sitesContext } from "../../state/contexts.js";
import { DescriptionsApi } from "../../wire/descriptions-api.js";
import type { HubApi } from "../../wire/hub-api.js";
import { draftChange, sendDraft, type DraftChange } from "../description/draft-change.js";
import { isObject, type JsonObject } from "../description/json-schema.js";
import { refusalAdvice } from "../description/refusal-advice.js";
import { devicesOf, proposeSignal, signalOf, withSignal, type SignalWords, type TopicField } from "./new-signal.js";
import "../../elements/feedback/dialog.js";
import "../../elements/feedback/empty.js";
import "../../elements/feedback/problem.js";
import "../../elements/forms/button.js";
import "../../elements/forms/field.js";
import "../description/description-diff.js";
import "../description/description-problems.js";

/** Which version of the description the signal is added to. */
interface Described {
  readonly known: DescriptionList;
  readonly from: DescriptionText;
  readonly site: JsonObject;
}

/** @fires t-close when it was closed, by whatever way */
@customElement("t-signal-dialog")
export class SignalDialog extends LitElement {
  static override styles = [
    base,
    forms,
    css`
      code {
        overflow-wrap: anywhere;
      }
    `,
  ];

  @property() site = "";
  /** What is to become a signal; null while nothing is. */
  @property({ attribute: false }) wanted: TopicField | null = null;

  @state() private mistake = "";
  /** What was said before somebody went on, to go back to. */
  private words: SignalWords | null = null;
  /** What would be applied; null until the hub has checked it. */
  @state() private change: DraftChange | null = null;
  @state() private answer: ChangeAnswer | null = null;
  @query("form") private readonly form!: HTMLFormElement | null;

  @consume({ context: apiContext }) private readonly api!: HubApi;
  private readonly sites = new ContextStoreController(this, sitesContext);
  private readonly described = new LoadController<Described>(this);
  private readonly action = new ActionController(this);

  protected override willUpdate(changed: PropertyValues<this>): void {
    const { wanted } = this;
    if (wanted === null) return;
    if (changed.has("wanted")) {
      this.change = this.answer = null;
      this.mistake = "";
      this.words = null;
      this.action.clear();
    }
    // With each version that the site goes by.
    const edition = this.sites.store?.catalogueOf(this.site) ?? "";
    this.described.load(`${this.site} ${edition} ${wanted.topic} ${wanted.field}`, () => this.loadDescription());
  }

  override render(): TemplateResult {
    const { wanted } = this;
    return html`<t-dialog heading=${msg("Make it a signal")} ?open=${wanted !== null} @t-close=${this.closeDialog}>
      ${wanted === null ? nothing : renderLoaded(this.described, msg("the description"), (described) => this.renderDescribed(wanted, described))}
      <t-button slot="actions" @click=${this.closeDialog}>${this.isApplied() ? msg("Close") : msg("Cancel")}</t-button>
      ${wanted === null ? nothing : this.renderNext(wanted)}
    </t-dialog>`;
  }

  private renderDescribed(wanted: TopicField, { known, site }: Described): TemplateResult {
    const { change } = this;
    const already = signalOf(site, wanted);
    if (this.isApplied()) return html`<p role="status">${msg("The gateway has it: the signal is on the site’s pages, and is kept from now on.")}</p>`;
    if (already !== "") return html`<t-empty heading=${msg("It is a signal already")} icon="live"><p>${msg(str`It is called ${already}.`)}</p></t-empty>`;
    if (devicesOf(site).length === 0) return html`<t-problem what=${msg("The description has no device.")} how=${msg("Add one under Admin, Description, first.")}></t-problem>`;
    if (!known.editable) return this.renderClosed(known);
    return change === null ? this.renderForm(wanted, site) : this.renderChange(change);
  }

  private renderForm(wanted: TopicField, site: JsonObject): TemplateResult {
    const proposed = this.words ?? proposeSignal(site, wanted);
    return html`<form class="entry" novalidate @submit=${this.onSubmit}>
      <p class="wide">${msg(html`<code>${wanted.field}</code> of <code>${wanted.topic}</code> is then kept in the history, and can be shown, charted and watched by alarms.`)}</p>
      <t-field class="wide" label=${msg("Name")} .error=${this.mistake}><input name="name" type="text" autocomplete="off" maxlength="80" .value=${proposed.name} /></t-field>
      <t-field label=${msg("Device")}><select name="device">${renderOptions(devicesOf(site), proposed.device)}</select></t-field>
      ${wanted.text ? nothing : html`<t-field label=${msg("Unit")} hint=${msg("As °C, m/s or %. Empty: none.")}><input name="unit" type="text" autocomplete="off" maxlength="20" .value=${proposed.unit} /></t-field>`}
      ${renderAdvice(this.action.problem)}
    </form>`;
  }

  private renderChange(change: DraftChange): TemplateResult {
    const wrong = [...change.findings, ...(this.answer?.findings ?? [])];
    const refused = change.findings.length > 0 ? { what: msg("It cannot be applied like this."), how: msg("Go back, and change what is named here.") } : refusalAdvice(this.answer);
    return html`${change.findings.length > 0 ? nothing : html`<t-difference .parts=${change.parts} .lines=${change.lines}></t-difference>`}
      ${wrong.length === 0 ? nothing : html`<t-findings .findings=${wrong}></t-findings>`} ${renderAdvice(this.action.problem ?? refused)}`;
  }

  private renderClosed({ online }: DescriptionList): TemplateResult {
    if (!online) return html`<t-problem what=${msg("The site’s gateway is offline.")} how=${msg("A signal can be added when it is back.")}></t-problem>`;
    const how = msg("Start it with --accept-changes readings, or write the signal into its file there.");
    return html`<t-problem what=${msg("The gateway takes no changes from here.")} how=${how}></t-problem>`;
  }

  private renderNext(wanted: TopicField): TemplateResult | typeof nothing {
    const described = this.described.value;
    if (this.isApplied() || described?.known.editable !== true || signalOf(described.site, wanted) !== "") return nothing;
    const { change } = this;
    const { busy } = this.action;
    if (change === null) return html`<t-button slot="actions" kind="primary" ?busy=${busy} @click=${this.checkSignal}>${msg("Review")}</t-button>`;
    return html`<t-button slot="actions" kind="quiet" ?disabled=${busy} @click=${this.changeWords}>${msg("Back")}</t-button>
      <t-button slot="actions" kind="primary" ?busy=${busy} ?disabled=${change.findings.length > 0} @click=${this.applySignal}>${busy ? msg("The gateway changes over…") : msg("Apply")}</t-button>`;
  }

  private isApplied(): boolean {
    return this.answer?.phase === "applied";
  }

  private async loadDescription(): Promise<Described> {
    const api = new DescriptionsApi(this.api);
    const known = await api.listVersions(this.site);
    const from = await api.versionText(this.site, known.versions[0]?.number ?? 0);
    return { known, from, site: isObject(from.site) ? from.site : {} };
  }

  // ── what a person does ──

  private readonly onSubmit = (event: SubmitEvent): void => {
    event.preventDefault();
    this.checkSignal();
  };

  private readonly checkSignal = (): void => {
    const { form, wanted } = this;
    const described = this.described.value;
    if (form === null || wanted === null || described === undefined) return;
    const said = new FormData(form);
    const words = { device: formText(said, "device"), name: formText(said, "name"), unit: formText(said, "unit") };
    this.words = words;
    this.mistake = words.name === "" ? msg("Give it a name.") : "";
    if (words.name === "") return;
    void this.action.run(msg("check the signal"), async () => {
      this.change = await draftChange(this.api, this.site, described.from, withSignal(described.site, wanted, words));
    });
  };

  private readonly changeWords = (): void => {
    this.change = this.answer = null;
    this.action.clear();
  };

  private readonly applySignal = (): void => {
    const { change } = this;
    if (change === null) return;
    this.answer = null;
    void this.action.run(msg("apply the signal"), async () => {
      this.answer = await sendDraft(this.api, this.site, change);
    });
  };

  private readonly closeDialog = (): void => {
    this.dispatchEvent(new CustomEvent("t-close"));
  };
}

declare global {
  interface HTMLElementTagNameMap {
    "t-signal-dialog": SignalDialog;
  }
}
