/** A request as a form: read while it is typed, with what is wrong, how long it lasts and when it may be observed. */

import { consume } from "@lit/context";
import { css, html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, property, state } from "lit/decorators.js";
import { map } from "lit/directives/map.js";
import { ActionController } from "../../controllers/action.js";
import { base } from "../../elements/base/base-style.js";
import { settled } from "../../elements/base/stable-field.js";
import { renderAdvice } from "../../elements/feedback/load-state.js";
import { renderOptions, type SelectOption } from "../../elements/forms/form-parts.js";
import { forms } from "../../elements/forms/form-style.js";
import { sheets } from "../../elements/layout/page-sections.js";
import { formatDuration } from "../../format/duration.js";
import { URGENCY_WORDS } from "../../format/observing-words.js";
import { timeText, zoneName } from "../../format/time.js";
import type { GroupShape, ProposalShape } from "../../generated/api.js";
import { clockOf, DAY_US } from "../../series/zone-clock.js";
import type { GeoPlace } from "../../sky/coordinates.js";
import { targetPlace } from "../../sky/target-place.js";
import { apiContext } from "../../state/contexts.js";
import { catalogueTarget, ownTargets, type SkyTarget } from "../../tiles/observatory/sky-target.js";
import type { HubApi } from "../../wire/hub-api.js";
import { ObservingApi } from "../../wire/observing-api.js";
import { BODIES, coordinateTexts, draftOf, GUIDINGS, IMAGE_TYPES, NEW_CONFIGURATION, newDraft, readDraft, rowField, URGENCIES, type ConfigurationDraft, type DraftField, type ReadDraft, type RequestDraft } from "./request-draft.js";
import "../../elements/forms/button.js";
import "../../elements/forms/field.js";
import "./request-outlook.js";
import "./visibility-chart.js";

/** A window of a new request lasts so long. */
const WINDOW_US = 30 * DAY_US;
const WAYS: readonly SelectOption[] = [
  ["stars", "Among the stars"],
  ["body", "Moon or planet"],
  ["fixed", "Fixed above the horizon"],
  ["none", "None (dark, bias)"],
];

/**
 * @fires t-saved detail is the group as the hub has it now
 * @fires t-cancel
 */
@customElement("t-request-form")
export class RequestForm extends LitElement {
  static override styles = [
    base,
    sheets,
    forms,
    css`
      fieldset {
        display: grid;
        grid-template-columns: repeat(auto-fill, minmax(min(12rem, 100%), 1fr));
        gap: var(--t-space-3) var(--t-space-4);
        align-items: start;
        margin: 0;
        padding: var(--t-space-3) 0 0;
        border: 0;
        border-block-start: 1px solid var(--t-line);
        min-inline-size: 0;
      }
      legend {
        float: inline-start;
        inline-size: 100%;
        padding: 0;
        font-weight: var(--t-weight-strong);
        grid-column: 1 / -1;
      }
      legend ~ .wide {
        grid-column: 1 / -1;
      }
      .frames {
        display: grid;
        grid-template-columns: repeat(auto-fill, minmax(min(6.5rem, 45%), 1fr));
        gap: var(--t-space-2) var(--t-space-3);
        grid-column: 1 / -1;
        align-items: start;
        padding-block-end: var(--t-space-3);
        border-block-end: 1px dashed var(--t-line);
      }
      .find {
        display: grid;
        grid-template-columns: minmax(0, 1fr) auto;
        gap: var(--t-space-2);
        align-items: start;
        grid-column: 1 / -1;
      }
      /* Level with the control, below the height of its label. */
      .find t-button,
      .frames t-button {
        margin-block-start: calc(var(--t-size-s) * 1.45 + var(--t-space-1));
      }
    `,
  ];

  @property() site = "";
  @property({ attribute: false }) proposals: readonly ProposalShape[] = [];
  @property({ attribute: false }) place: GeoPlace | null = null;
  @property() zone = "UTC";
  /** The draft that is changed; null for a new request. */
  @property({ attribute: false }) group: GroupShape | null = null;
  @state() private draft: RequestDraft | null = null;
  @state() private found: readonly SkyTarget[] = [];
  @state() private findText = "";
  @state() private tried = false;

  @consume({ context: apiContext }) private readonly api!: HubApi;
  private readonly action = new ActionController(this);

  override willUpdate(): void {
    if (this.draft !== null || !this.hasUpdated) return;
    this.draft = this.firstDraft();
  }

  override firstUpdated(): void {
    this.draft = this.firstDraft();
  }

  private firstDraft(): RequestDraft {
    const clock = clockOf(this.zone);
    const nowUs = Math.ceil(Date.now() / 60_000) * 60e6;
    const window = { start: clock.toInput(nowUs), end: clock.toInput(nowUs + WINDOW_US) };
    const own = this.proposals.filter(({ may_ask: may, active }) => may && active);
    const made = this.group === null ? null : draftOf(this.group, (us) => clock.toInput(us));
    return made ?? newDraft(own.length === 1 ? (own[0]?.id ?? "") : "", window);
  }

  override render(): TemplateResult | typeof nothing {
    const { draft } = this;
    if (draft === null) return nothing;
    const read = readDraft(draft, (text) => clockOf(this.zone).fromInput(text), Date.now() * 1000);
    // Planets, and sites whose position is not open to this page, only the hub works out.
    const isDrawnHere = read.target === null || (this.place !== null && targetPlace(read.target) !== null);
    return html`<form class="sheet" novalidate @submit=${this.onSubmit} @input=${this.onInput}>
      <h2>${this.group === null ? "New request" : `Change request ${this.group.name === "" ? this.group.id : this.group.name}`}</h2>
      ${this.renderWho(draft, read)} ${this.renderTarget(draft, read)} ${this.renderFrames(draft, read)} ${this.renderConstraints(draft, read)}
      ${this.renderWindow(draft, read)}
      <section aria-labelledby="when">
        <h3 id="when">When it may be observed, and what it is charged</h3>
        ${isDrawnHere ? this.renderChart(read) : nothing}
        <t-request-outlook .site=${this.site} .asked=${read.asked} .zone=${this.zone} ?curve=${!isDrawnHere}></t-request-outlook>
      </section>
      <p>Open shutter ${formatDuration(read.shutterS)}. ${read.asked === null ? this.quotaText(draft) : ""}</p>
      ${this.tried && read.asked === null
        ? html`<p role="alert">${read.problems.size === 1 ? "One field needs" : `${String(read.problems.size)} fields need`} another look: ${[...read.problems.values()].slice(0, 3).join(" ")}</p>`
        : nothing}
      ${renderAdvice(this.action.problem)}
      <div class="actions">
        <t-button type="submit" kind="primary" ?busy=${this.action.runningKey === "draft"}>Keep as a draft</t-button>
        ${this.group === null ? html`<t-button ?busy=${this.action.runningKey === "submit"} @click=${this.onSubmitNow}>Submit at once</t-button>` : nothing}
        <t-button @click=${this.onCancel}>Cancel</t-button>
      </div>
    </form>`;
  }

  private renderChart({ target, constraints, window }: ReadDraft): TemplateResult {
    return html`<t-visibility-chart
      .target=${target}
      .constraints=${constraints}
      .windows=${Number.isNaN(window.startUs + window.endUs) ? [] : [{ start_us: window.startUs, end_us: window.endUs }]}
      .place=${this.place}
      .zone=${this.zone}
    ></t-visibility-chart>`;
  }

  private renderWho(draft: RequestDraft, read: ReadDraft): TemplateResult {
    const own = this.proposals.filter(({ may_ask: may, active, id }) => (may && active) || id === draft.proposal);
    const chosen = own.find(({ id }) => id === draft.proposal);
    const urgencies = URGENCIES.filter((urgency) => urgency === "NORMAL" || urgency === draft.urgency || chosen?.urgencies.includes(urgency) === true);
    return html`<fieldset>
      <legend>What it is for</legend>
      ${this.renderField("proposal", "Proposal", read, html`<select name="proposal">${renderOptions([["", "choose"], ...own.map(({ id, title }) => [id, title === "" ? id : `${id}: ${title}`] as const)], draft.proposal)}</select>`)}
      ${this.renderField("name", "Name", read, html`<input name="name" maxlength="200" autocomplete="off" .value=${settled(draft.name)} />`, "As you will find it again")}
      ${this.renderField("urgency", "Urgency", read, html`<select name="urgency">${renderOptions(urgencies.map((urgency) => [urgency, URGENCY_WORDS[urgency]] as const), draft.urgency)}</select>`)}
      ${this.renderField("priority", "Priority", read, this.numberInput("priority", draft.priority), chosen === undefined ? "" : `Up to ${String(chosen.max_priority)} in this proposal`)}
    </fieldset>`;
  }

  private renderTarget(draft: RequestDraft, read: ReadDraft): TemplateResult {
    return html`<fieldset>
      <legend>Target</legend>
      ${this.renderField("way", "Kind", read, html`<select name="way">${renderOptions(WAYS, draft.way)}</select>`)}
      ${draft.way === "stars" ? this.renderStars(draft, read) : nothing}
      ${draft.way === "body" ? this.renderField("body", "Body", read, html`<select name="body">${renderOptions(BODIES, draft.body)}</select>`) : nothing}
      ${draft.way === "fixed"
        ? html`${this.renderField("altitude", "Altitude (°)", read, this.numberInput("altitude", draft.altitude))}
          ${this.renderField("azimuth", "Azimuth (°)", read, this.numberInput("azimuth", draft.azimuth), "From north through east")}`
        : nothing}
    </fieldset>`;
  }

  private renderStars(draft: RequestDraft, read: ReadDraft): TemplateResult {
    return html`<div class="find">
        ${this.renderField("target", "Name", read, html`<input name="target" maxlength="100" autocomplete="off" spellcheck="false" .value=${settled(draft.target)} @keydown=${this.onFindKey} />`, "M 31, NGC 7000, Vega; Find looks it up without the network")}
        <t-button ?busy=${this.action.runningKey === "find"} @click=${this.findTarget}>Find</t-button>
      </div>
      ${this.findText === "" ? nothing : html`<p class="wide" role="status">${this.findText}</p>`}
      ${this.found.length < 2
        ? nothing
        : html`<div class="actions wide">${map(this.found.slice(0, 6), (target) => html`<t-button kind="quiet" @click=${this.chooser(target)}>${target.name} (${target.about})</t-button>`)}</div>`}
      ${this.renderField("ra", "Right ascension (J2000)", read, html`<input name="ra" maxlength="40" autocomplete="off" spellcheck="false" .value=${settled(draft.ra)} />`, "05:34:32, or 83.63°")}
      ${this.renderField("dec", "Declination (J2000)", read, html`<input name="dec" maxlength="40" autocomplete="off" spellcheck="false" .value=${settled(draft.dec)} />`, "−05:23:28, or −5.39")}`;
  }

  private renderFrames(draft: RequestDraft, read: ReadDraft): TemplateResult {
    return html`<fieldset>
      <legend>Frames, in this order</legend>
      ${map(draft.configurations, (row, i) => {
        const control = (name: string, value: string): TemplateResult => html`<input name=${`${name}-${String(i)}`} inputmode="decimal" autocomplete="off" .value=${settled(value)} />`;
        return html`<div class="frames" role="group" aria-label=${`Frames ${String(i + 1)}`}>
          <t-field label="Kind"><select name=${`type-${String(i)}`}>${renderOptions(IMAGE_TYPES.map((type) => [type, type.toLowerCase().replace("_", " ")] as const), row.type)}</select></t-field>
          <t-field label="Filter" hint="empty: any"><input name=${`filter-${String(i)}`} maxlength="40" autocomplete="off" .value=${settled(row.filter)} /></t-field>
          ${this.renderField(rowField("exposure", i), "Exposure (s)", read, control("exposure", row.exposure))} ${this.renderField(rowField("count", i), "Frames", read, control("count", row.count))}
          ${this.renderField(rowField("binning", i), "Binning", read, control("binning", row.binning))} ${this.renderField(rowField("dither", i), "Dither (″)", read, control("dither", row.dither))}
          <t-field label="Guiding"><select name=${`guiding-${String(i)}`}>${renderOptions(GUIDINGS.map((guiding) => [guiding, guiding.toLowerCase()] as const), row.guiding)}</select></t-field>
          <t-button kind="quiet" label=${`Remove frames ${String(i + 1)}`} ?disabled=${draft.configurations.length === 1} @click=${this.remover(i)}>Remove</t-button>
        </div>`;
      })}
      <div class="actions wide"><t-button @click=${this.addRow}>Add frames</t-button></div>
    </fieldset>`;
  }

  private renderConstraints(draft: RequestDraft, read: ReadDraft): TemplateResult {
    const limits: readonly (readonly [Exclude<DraftField & keyof RequestDraft, "configurations">, string, string])[] = [
      ["minAltitude", "Lowest altitude (°)", ""],
      ["maxAirmass", "Highest airmass", "empty: any"],
      ["moonDistance", "Distance from the Moon (°)", "while it is up"],
      ["moonLit", "Moon lit at most (%)", "while it is up; empty: any"],
      ["sunAltitude", "Sun at most (°)", "−18 night, −12 nautical, −6 civil"],
      ["hourAngle", "Hour angle at most (h)", "empty: any"],
      ["seeing", "Seeing at most (″)", "empty: any"],
      ["clouds", "Clouds at most (%)", "empty: any"],
    ];
    return html`<fieldset>
      <legend>What must hold</legend>
      ${map(limits, ([field, label, hint]) => this.renderField(field, label, read, this.numberInput(field, draft[field]), hint))}
    </fieldset>`;
  }

  private renderWindow(draft: RequestDraft, read: ReadDraft): TemplateResult {
    const nowUs = Date.now() * 1000;
    const utc = (us: number): string => (Number.isNaN(us) ? "" : timeText(us, "UTC", nowUs).utc);
    const zone = zoneName(nowUs, this.zone);
    return html`<fieldset>
      <legend>Window</legend>
      ${this.renderField("windowStart", `From (${zone})`, read, html`<input name="windowStart" type="datetime-local" .value=${settled(draft.windowStart)} />`, utc(read.window.startUs))}
      ${this.renderField("windowEnd", `To (${zone})`, read, html`<input name="windowEnd" type="datetime-local" .value=${settled(draft.windowEnd)} />`, utc(read.window.endUs))}
    </fieldset>`;
  }

  /** What is wrong in an untouched field is said once the person has tried to send it. */
  private renderField(field: DraftField, label: string, { problems }: ReadDraft, control: TemplateResult, hint = ""): TemplateResult {
    const unwritten = !this.tried && (field === "ra" || field === "dec" || field === "proposal") && (this.draft?.[field] ?? "") === "";
    return html`<t-field .label=${label} .hint=${hint} .error=${unwritten ? "" : (problems.get(field) ?? "")}>${control}</t-field>`;
  }

  private numberInput(name: string, value: string): TemplateResult {
    return html`<input name=${name} inputmode="decimal" autocomplete="off" .value=${settled(value)} />`;
  }

  private quotaText({ proposal }: RequestDraft): string {
    const found = this.proposals.find(({ id }) => id === proposal);
    if (found === undefined) return "";
    const left = Math.max(0, found.hours_allocated * 3600 - found.used_s - found.promised_s);
    return `The proposal has ${formatDuration(left)} left of ${String(found.hours_allocated)} h.`;
  }

  private changeDraft(change: Partial<RequestDraft>): void {
    if (this.draft !== null) this.draft = { ...this.draft, ...change };
  }

  private readonly onInput = (event: Event): void => {
    const field = event.target;
    if (!(field instanceof HTMLInputElement || field instanceof HTMLSelectElement) || this.draft === null) return;
    const row = /^(\w+)-(\d+)$/.exec(field.name);
    if (row === null) {
      if (field.name in this.draft) this.changeDraft({ [field.name]: field.value });
      return;
    }
    const [, name = "", at = ""] = row;
    const configurations = this.draft.configurations.map((before, i): ConfigurationDraft => (i === Number(at) ? { ...before, [name]: field.value } : before));
    this.changeDraft({ configurations });
  };

  private readonly addRow = (): void => {
    const rows = this.draft?.configurations ?? [];
    this.changeDraft({ configurations: [...rows, rows.at(-1) ?? NEW_CONFIGURATION] });
  };

  private remover(at: number): () => void {
    return () => {
      this.changeDraft({ configurations: (this.draft?.configurations ?? []).filter((_, i) => i !== at) });
    };
  }

  private chooser(target: SkyTarget): () => void {
    return () => {
      this.chooseTarget(target);
    };
  }

  private chooseTarget(target: SkyTarget): void {
    if (target.j2000 === null) {
      this.changeDraft({ way: "body", body: "moon", target: target.name });
      return;
    }
    this.findText = `${target.name}: ${target.about}.`;
    this.changeDraft({ target: target.name, ...coordinateTexts(target.j2000.ra * 15, target.j2000.dec) });
  }

  /** Enter in the name looks it up, instead of sending the form. */
  private readonly onFindKey = (event: KeyboardEvent): void => {
    if (event.key !== "Enter") return;
    event.preventDefault();
    event.stopPropagation();
    this.findTarget();
  };

  private readonly findTarget = (): void => {
    const name = this.draft?.target.trim() ?? "";
    if (name === "") {
      this.findText = "Write a name first.";
      return;
    }
    const own = ownTargets(name);
    void this.action.run(
      "search the catalogue",
      async () => {
        const { objects } = await this.api.searchSky(this.site, name);
        this.found = [...own, ...objects.map(catalogueTarget)];
        const [first] = this.found;
        if (first === undefined) this.findText = `Nothing goes by the name ${name}: write its coordinates.`;
        else this.chooseTarget(first);
      },
      "",
      "find",
    );
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
    if (this.draft === null) return;
    const { asked } = readDraft(this.draft, (text) => clockOf(this.zone).fromInput(text), Date.now() * 1000);
    if (asked === null) return;
    const api = new ObservingApi(this.api, this.site);
    const { group } = this;
    const saved: GroupShape[] = [];
    await this.action.run(
      draft ? "keep the draft" : "take the request",
      async () => {
        saved.push(group === null ? await api.addGroup({ ...asked, draft }) : await api.replaceGroup(group.id, { ...asked, draft: true }));
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

declare global {
  interface HTMLElementTagNameMap {
    "t-request-form": RequestForm;
  }
  interface GlobalEventHandlersEventMap {
    "t-saved": CustomEvent<GroupShape>;
  }
}
