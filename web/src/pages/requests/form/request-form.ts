/** A request group as a form: read while it is typed, with what is wrong, how long it lasts and when it may be observed. */

import { consume } from "@lit/context";
import { msg, str } from "@lit/localize";
import { html, LitElement, nothing, type PropertyValues, type TemplateResult } from "lit";
import { customElement, property, state } from "lit/decorators.js";
import { ActionController } from "../../../controllers/action.js";
import { base } from "../../../elements/base/base-style.js";
import { focusInside } from "../../../elements/base/focus.js";
import { renderAdvice } from "../../../elements/feedback/load-state.js";
import { forms } from "../../../elements/forms/form-style.js";
import { sheets } from "../../../elements/layout/page-sections.js";
import { formatDuration } from "../../../format/duration.js";
import { plural } from "../../../words/plural.js";
import type { AbilitiesShape, GroupShape, ProposalShape } from "../../../generated/api.js";
import type { GeoPlace } from "../../../sky/coordinates.js";
import { targetPlace } from "../../../sky/target-place.js";
import { apiContext } from "../../../state/contexts.js";
import type { HubApi } from "../../../wire/hub-api.js";
import { ObservingApi } from "../../../wire/observing-api.js";
import { renderConstraints } from "./constraint-fields.js";
import { DraftEditor } from "./draft-editor.js";
import { movedToNow } from "./fill-draft.js";
import { formStyle } from "./form-style.js";
import { renderFraming } from "./framing-fields.js";
import type { FormView } from "./form-view.js";
import { renderFrames } from "./frame-fields.js";
import { renderPurpose, renderRequestList, requestTitle } from "./group-fields.js";
import { readGroup, type ReadGroup, type ReadRequest } from "./read-draft.js";
import { renderTarget } from "./target-fields.js";
import { TargetFinder } from "./target-finder.js";
import { renderCadence, renderWindows } from "./window-fields.js";
import "../../../elements/forms/button.js";
import "../request-outlook.js";
import "../visibility-chart.js";

/**
 * @fires t-saved detail is the group as the hub has it now
 * @fires t-cancel
 */
@customElement("t-request-form")
export class RequestForm extends LitElement {
  static override styles = [base, sheets, forms, formStyle];

  @property() site = "";
  @property({ attribute: false }) proposals: readonly ProposalShape[] = [];
  /** What the site can do; null while nobody knows. */
  @property({ attribute: false }) abilities: AbilitiesShape | null = null;
  @property({ attribute: false }) place: GeoPlace | null = null;
  @property() zone = "UTC";
  /** The draft that is changed, or what is asked once more; null for a new request. */
  @property({ attribute: false }) group: GroupShape | null = null;
  /** `group` is a pattern: what is written here becomes a group of its own. */
  @property({ type: Boolean }) again = false;
  @state() private tried = false;
  /** Framing is open: only then its stars are loaded. */
  @state() private framed = false;

  @consume({ context: apiContext }) private readonly api!: HubApi;
  private readonly action = new ActionController(this);
  private readonly editor: DraftEditor = new DraftEditor(
    this,
    (selector) => {
      void focusInside(this, selector);
    },
    () => {
      this.finder.forget();
    },
  );
  private readonly finder: TargetFinder = new TargetFinder(
    this,
    () => this.editor.request?.target ?? "",
    async (name) => (await this.api.searchSky(this.site, name)).objects,
    (change) => {
      this.editor.changeRequest(change);
    },
  );

  override willUpdate(changed: PropertyValues): void {
    if (this.hasUpdated && changed.has("zone")) this.editor.setZone(this.zone);
    if (!this.hasUpdated || changed.has("group") || changed.has("again")) this.beginDraft();
  }

  private beginDraft(): void {
    const nowUs = Math.ceil(Date.now() / 60_000) * 60e6;
    const own = this.proposals.filter(({ may_ask: may, active }) => may && active);
    if (this.group === null) {
      this.editor.begin(own.length === 1 ? (own[0]?.id ?? "") : "", this.zone, nowUs);
      return;
    }
    const group = this.again ? movedToNow(this.group, nowUs) : this.group;
    // Somebody may see what they cannot ask for.
    const isOwn = own.some(({ id }) => id === group.proposal);
    this.editor.open(this.again && !isOwn ? { ...group, proposal: "" } : group, this.zone, nowUs);
  }

  override render(): TemplateResult | typeof nothing {
    const { editor } = this;
    const { draft, at, request, opened } = editor;
    const read = this.readAll();
    const readRequest = read.requests[at];
    if (request === undefined || readRequest === undefined) return nothing;
    const { proposals, abilities, zone, tried } = this;
    const view: FormView = { draft, read, at, request, readRequest, proposals, abilities, zone, tried, opened };
    const cadence = renderCadence(view, editor.cadence, editor.readCadence, editor.cadenceTried, editor.makeVisits);
    return html`<form class="sheet" novalidate @submit=${this.onSubmit} @input=${editor.onInput}>
      <h2>${this.heading()}</h2>
      ${renderPurpose(view)} ${renderRequestList(view, editor)} ${renderTarget(view, this.finder)} ${renderAdvice(this.finder.problem)}
      ${renderFraming(view, editor, this.site, this.framed, this.onFraming)}
      ${renderFrames(view, editor)} ${renderConstraints(view)} ${renderWindows(view, editor, cadence)} ${this.renderOutlook(read, readRequest)}
      <p>${msg(str`Open shutter ${formatDuration(read.shutterS)}.`)} ${read.asked === null ? this.quotaText(draft.proposal) : ""}</p>
      ${tried && read.asked === null ? html`<p role="alert">${problemText(read)}</p>` : nothing} ${renderAdvice(this.action.problem)}
      <div class="actions">
        <t-button type="submit" kind="primary" ?busy=${this.action.runningKey === "draft"}>${msg("Keep as a draft")}</t-button>
        ${this.isNew ? html`<t-button ?busy=${this.action.runningKey === "submit"} @click=${this.onSubmitNow}>${msg("Submit at once")}</t-button>` : nothing}
        <t-button @click=${this.onCancel}>${msg("Cancel")}</t-button>
      </div>
    </form>`;
  }

  private get isNew(): boolean {
    return this.group === null || this.again;
  }

  private heading(): string {
    const { group } = this;
    if (group === null) return msg("New request");
    const name = group.name === "" ? group.id : group.name;
    return this.again ? msg(str`Ask again like ${name}`) : msg(str`Change request ${name}`);
  }

  private renderOutlook(read: ReadGroup, { target, constraints, windows }: ReadRequest): TemplateResult {
    // Planets, and sites whose position is not open to this page, only the hub works out.
    const isDrawnHere = target === null || (this.place !== null && targetPlace(target) !== null);
    const known = windows.filter(({ start_us: start, end_us: end }) => !Number.isNaN(start + end));
    const names = this.editor.draft.requests.map(requestTitle);
    return html`<section aria-labelledby="when">
      <h3 id="when">${msg("When it may be observed, and what it is charged")}</h3>
      ${isDrawnHere ? html`<t-visibility-chart .target=${target} .constraints=${constraints} .windows=${known} .place=${this.place} .zone=${this.zone}></t-visibility-chart>` : nothing}
      <t-request-outlook .site=${this.site} .asked=${read.asked} .names=${names} .at=${this.editor.at} .zone=${this.zone} ?curve=${!isDrawnHere}></t-request-outlook>
    </section>`;
  }

  private quotaText(proposal: string): string {
    const found = this.proposals.find(({ id }) => id === proposal);
    if (found === undefined) return "";
    const left = Math.max(0, found.hours_allocated * 3600 - found.used_s - found.promised_s);
    return msg(str`The proposal has ${formatDuration(left)} left of ${String(found.hours_allocated)} h.`);
  }

  private readAll(): ReadGroup {
    return readGroup(this.editor.draft, { momentOf: this.editor.momentOf, nowUs: Date.now() * 1000, abilities: this.abilities });
  }

  /** Shows the first field that needs another look. */
  private focusProblem(read: ReadGroup): void {
    const at = read.problems.size > 0 ? this.editor.at : read.requests.findIndex(({ problems }) => problems.size > 0);
    if (at !== this.editor.at) this.editor.show(at);
    void focusInside(this, 't-field[error]:not([error=""]) > :is(input, select)');
  }

  private readonly onFraming = (event: Event): void => {
    if (event.currentTarget instanceof HTMLDetailsElement) this.framed = event.currentTarget.open;
  };

  private readonly onSubmit = (event: Event): void => {
    event.preventDefault();
    void this.sendForm(true);
  };

  private readonly onSubmitNow = (): void => {
    void this.sendForm(false);
  };

  private async sendForm(draft: boolean): Promise<void> {
    this.tried = true;
    const read = this.readAll();
    const { asked } = read;
    if (asked === null) {
      this.focusProblem(read);
      return;
    }
    const api = new ObservingApi(this.api, this.site);
    const changed = this.isNew ? null : this.group;
    const saved: GroupShape[] = [];
    await this.action.run(
      draft ? msg("keep the draft") : msg("take the request"),
      async () => {
        saved.push(changed === null ? await api.addGroup({ ...asked, draft }) : await api.replaceGroup(changed.id, { ...asked, draft: true }));
      },
      "",
      draft ? "draft" : "submit",
    );
    for (const detail of saved) this.dispatchEvent(new CustomEvent("t-saved", { detail }));
  }

  private readonly onCancel = (): void => {
    this.dispatchEvent(new CustomEvent("t-cancel"));
  };
}

/** What is wrong, of all requests: the first few in words. */
function problemText(read: ReadGroup): string {
  const own = [...read.problems.values()];
  const others = read.requests.flatMap(({ problems }, i) => [...problems.values()].map((text) => (read.requests.length > 1 ? msg(str`Request ${String(i + 1)}: ${text}`) : text)));
  const all = [...own, ...others];
  return plural(all.length, msg(str`One field needs another look: ${all.slice(0, 3).join(" ")}`), msg(str`${String(all.length)} fields need another look: ${all.slice(0, 3).join(" ")}`));
}

declare global {
  interface HTMLElementTagNameMap {
    "t-request-form": RequestForm;
  }
  interface GlobalEventHandlersEventMap {
    "t-saved": CustomEvent<GroupShape>;
  }
}
