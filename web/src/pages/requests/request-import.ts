/** Requests from another program's file: read by the hub, shown with what it could not read, then kept as drafts. */

import { consume } from "@lit/context";
import { msg, str } from "@lit/localize";
import { css, html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, property, state } from "lit/decorators.js";
import { map } from "lit/directives/map.js";
import { ActionController } from "../../controllers/action.js";
import { LoadController } from "../../controllers/load.js";
import { base } from "../../elements/base/base-style.js";
import { settled } from "../../elements/base/stable-field.js";
import { renderAdvice, renderLoaded } from "../../elements/feedback/load-state.js";
import { renderOptions } from "../../elements/forms/form-parts.js";
import { forms } from "../../elements/forms/form-style.js";
import { sheets } from "../../elements/layout/page-sections.js";
import { formatDuration } from "../../format/duration.js";
import { plural } from "../../words/plural.js";
import { zoneName } from "../../format/time.js";
import type { FileKind, GroupAsk, ImportAnswer, ImportAsk, ProposalShape } from "../../generated/api.js";
import { clockOf, DAY_US } from "../../series/zone-clock.js";
import { apiContext } from "../../state/contexts.js";
import type { HubApi } from "../../wire/hub-api.js";
import { ObservingApi } from "../../wire/observing-api.js";
import { FILE_KIND_WORDS, FILE_KINDS, groupTitle, guessKind, MOST_CHARACTERS, readText, shutterOf } from "./import-file.js";
import "../../elements/forms/button.js";
import "../../elements/forms/field.js";

/** The window of what says none lasts so long. */
const WINDOW_US = 30 * DAY_US;
/** Rows of what was read, and of what was not. */
const MOST_ROWS = 200;

interface ChosenFile {
  readonly name: string;
  readonly text: string;
  /** Tells one choice from the next, also of a file of the same name. */
  readonly number: number;
}

interface StandIn {
  readonly proposal: string;
  readonly kind: FileKind;
  readonly start: string;
  readonly end: string;
  readonly exposure: string;
  readonly count: string;
}

/**
 * @fires t-imported when all of it is kept
 * @fires t-cancel
 */
@customElement("t-request-import")
export class RequestImport extends LitElement {
  static override styles = [
    base,
    sheets,
    forms,
    css`
      .answer {
        display: grid;
        gap: var(--t-space-2);
      }
      .problems {
        margin: 0;
      }
      .problems code {
        font-weight: var(--t-weight-strong);
      }
      .scroll {
        max-block-size: 24rem;
        overflow-y: auto;
      }
    `,
  ];

  @property() site = "";
  @property({ attribute: false }) proposals: readonly ProposalShape[] = [];
  @property() zone = "UTC";
  @state() private file: ChosenFile | null = null;
  @state() private fileProblem = "";
  @state() private standIn: StandIn | null = null;
  /** Of the groups that were read: how many are kept already, when keeping failed in between. */
  @state() private kept = 0;

  @consume({ context: apiContext }) private readonly api!: HubApi;
  private readonly reading = new LoadController<ImportAnswer | null>(this);
  private readonly action = new ActionController(this);
  private question = "";

  override willUpdate(): void {
    this.standIn ??= this.firstStandIn();
    const asked = this.askedImport();
    const question = asked === null ? "" : JSON.stringify([{ ...asked, text: "" }, this.file?.number]);
    // Once some of it is kept the rest has to be what was read then.
    if (this.kept > 0) return;
    if (question !== this.question) this.action.clear();
    this.question = question;
    this.reading.load(question, async () => (asked === null ? null : new ObservingApi(this.api, this.site).importFile(asked)));
  }

  override render(): TemplateResult | typeof nothing {
    const { standIn } = this;
    if (standIn === null) return nothing;
    const own = this.proposals.filter(({ may_ask: may, active }) => may && active);
    const zone = zoneName(Date.now() * 1000, this.zone);
    const errors = this.standInProblems(standIn);
    const isHalf = this.kept > 0;
    return html`<section class="sheet" aria-labelledby="heading">
      <h2 id="heading">${msg("Import requests")}</h2>
      <p class="muted">${msg("Of a table, of Las Cumbres’ portal, of N.I.N.A. or of Ekos. What is read is shown first; it becomes drafts, which you submit one by one.")}</p>
      <form class="entry" novalidate @submit=${this.onSubmit} @change=${this.onChange}>
        <t-field label=${msg("File")} .error=${this.fileProblem}><input name="file" type="file" accept=".csv,.tsv,.txt,.json,.esl,.xml" ?disabled=${isHalf} /></t-field>
        <t-field label=${msg("Whose file it is")} hint=${msg("Guessed when a file is chosen")}><select name="kind" ?disabled=${isHalf}>${renderOptions(FILE_KINDS.map((kind) => [kind, FILE_KIND_WORDS[kind]] as const), standIn.kind)}</select></t-field>
        <t-field label=${msg("Proposal")} .error=${this.file === null ? "" : errors.proposal}>
          <select name="proposal" ?disabled=${isHalf}>${renderOptions([["", "choose"], ...own.map(({ id, title }) => [id, title === "" ? id : `${id}: ${title}`] as const)], standIn.proposal)}</select>
        </t-field>
        <h3 class="wide">${msg("Where the file says nothing")}</h3>
        <t-field label=${msg(str`From (${zone})`)} .error=${errors.start}><input name="start" type="text" autocomplete="off" placeholder="2026-03-29 14:05:09" maxlength="30" ?disabled=${isHalf} .value=${settled(standIn.start)} /></t-field>
        <t-field label=${msg(str`To (${zone})`)} .error=${errors.end}><input name="end" type="text" autocomplete="off" placeholder="2026-03-29 14:05:09" maxlength="30" ?disabled=${isHalf} .value=${settled(standIn.end)} /></t-field>
        <t-field label=${msg("Exposure (s)")} .error=${errors.exposure}><input name="exposure" inputmode="decimal" autocomplete="off" ?disabled=${isHalf} .value=${settled(standIn.exposure)} /></t-field>
        <t-field label=${msg("Frames")} .error=${errors.count}><input name="count" inputmode="numeric" autocomplete="off" ?disabled=${isHalf} .value=${settled(standIn.count)} /></t-field>
        ${this.file === null ? nothing : html`<div class="wide answer">${renderLoaded(this.reading, msg("what the file asks"), (answer) => (answer === null ? nothing : this.renderAnswer(answer)))}</div>`}
        ${renderAdvice(this.action.problem)} ${this.renderActions()}
      </form>
    </section>`;
  }

  private renderActions(): TemplateResult {
    const groups = this.readyGroups();
    const left = groups.length - this.kept;
    return html`<div class="actions">
      <t-button type="submit" kind="primary" ?disabled=${left === 0} ?busy=${this.action.busy}>${left === 0 ? msg("Keep as drafts") : msg(str`Keep as ${plural(left, msg("1 draft"), msg(str`${String(left)} drafts`))}`)}</t-button>
      <t-button @click=${this.onCancel}>${this.kept > 0 ? msg("Close") : msg("Cancel")}</t-button>
      ${this.kept > 0 ? html`<span role="status">${msg(str`${this.kept} of ${groups.length} are kept.`)}</span>` : nothing}
    </div>`;
  }

  private renderAnswer(answer: ImportAnswer): TemplateResult {
    const { groups, problems } = answer;
    return html`<p role="status"><strong>${readText(answer)}</strong></p>
      ${problems.length === 0
        ? nothing
        : html`<h3 id="wrong">${msg("What could not be read")}</h3>
            <div class="scroll" role="region" aria-labelledby="wrong" tabindex="0">
              <ul class="problems">${map(problems.slice(0, MOST_ROWS), ({ where, message }) => html`<li><code>${where}</code>: ${message}</li>`)}</ul>
              ${restText(problems.length)}
            </div>`}
      ${groups.length === 0
        ? nothing
        : html`<h3 id="read">${msg("What was read")}</h3>
            <div class="scroll" role="region" aria-labelledby="read" tabindex="0">
              <ul class="rows">${map(groups.slice(0, MOST_ROWS), (group) => renderGroup(group))}</ul>
              ${restText(groups.length)}
            </div>`}`;
  }

  private firstStandIn(): StandIn {
    const clock = clockOf(this.zone);
    const nowUs = Math.ceil(Date.now() / 60_000) * 60e6;
    const own = this.proposals.filter(({ may_ask: may, active }) => may && active);
    return { proposal: own.length === 1 ? (own[0]?.id ?? "") : "", kind: "csv", start: clock.toInput(nowUs), end: clock.toInput(nowUs + WINDOW_US), exposure: "60", count: "10" };
  }

  private standInProblems({ proposal, start, end, exposure, count }: StandIn): Record<Exclude<keyof StandIn, "kind">, string> {
    const [startUs, endUs] = [start, end].map((text) => clockOf(this.zone).fromInput(text)) as [number, number];
    const [seconds, frames] = [Number(exposure.replace(",", ".")), Number(count)];
    return {
      proposal: proposal === "" ? msg("Choose the proposal that pays for it.") : "",
      start: startUs > 0 ? "" : msg("Write a date and a time."),
      end: !(endUs > 0) ? msg("Write a date and a time.") : endUs <= startUs ? msg("The window ends before it begins.") : "",
      exposure: exposure.trim() !== "" && seconds >= 0 && seconds <= 86_400 ? "" : msg("Expected 0 to 86400."),
      count: Number.isInteger(frames) && frames >= 1 && frames <= 10_000 ? "" : msg("Expected a whole number, 1 to 10000."),
    };
  }

  /** Null while there is no file, or something stands in that is none. */
  private askedImport(): ImportAsk | null {
    const { file, standIn } = this;
    if (file === null || standIn === null || Object.values(this.standInProblems(standIn)).some((problem) => problem !== "")) return null;
    const clock = clockOf(this.zone);
    return {
      kind: standIn.kind,
      text: file.text,
      proposal: standIn.proposal,
      window: { start_us: clock.fromInput(standIn.start), end_us: clock.fromInput(standIn.end) },
      configurations: [{ exposure: Number(standIn.exposure.replace(",", ".")), count: Number(standIn.count) }],
    };
  }

  /** What was read of what stands in the form now. */
  private readyGroups(): readonly GroupAsk[] {
    const { result } = this.reading;
    return this.question !== "" && result.state === "ready" ? (result.value?.groups ?? []) : [];
  }

  private readonly onChange = (event: Event): void => {
    const field = event.target;
    if (!(field instanceof HTMLInputElement || field instanceof HTMLSelectElement) || this.standIn === null) return;
    if (field instanceof HTMLInputElement && field.type === "file") void this.readChosen(field.files?.[0]);
    else if (field.name in this.standIn) this.standIn = { ...this.standIn, [field.name]: field.value };
  };

  private async readChosen(chosen: File | undefined): Promise<void> {
    this.file = null;
    this.fileProblem = "";
    if (chosen === undefined) return;
    try {
      const text = await chosen.text();
      if (text.length > MOST_CHARACTERS) this.fileProblem = msg(str`It has ${String(Math.ceil(text.length / 1000))} thousand characters; at most ${String(MOST_CHARACTERS / 1000)} are read at once. Split it.`);
      else if (text.includes("\0")) this.fileProblem = msg("This is no text: choose the file that the program exports.");
      else {
        this.file = { name: chosen.name, text, number: performance.now() };
        if (this.standIn !== null) this.standIn = { ...this.standIn, kind: guessKind(chosen.name, text) };
      }
    } catch {
      this.fileProblem = msg("The browser could not read this file: choose it again.");
    }
  }

  private readonly onSubmit = (event: Event): void => {
    event.preventDefault();
    void this.keepDrafts();
  };

  /** One after the other; what is kept is not sent once more when a later one is refused. */
  private async keepDrafts(): Promise<void> {
    const groups = this.readyGroups();
    if (groups.length === this.kept) return;
    const api = new ObservingApi(this.api, this.site);
    const isDone = await this.action.run(msg("keep all drafts"), async () => {
      for (const group of groups.slice(this.kept)) {
        await api.addGroup({ ...group, draft: true });
        this.kept += 1;
      }
    });
    if (isDone) this.dispatchEvent(new CustomEvent("t-imported"));
  }

  private readonly onCancel = (): void => {
    this.dispatchEvent(new CustomEvent(this.kept > 0 ? "t-imported" : "t-cancel"));
  };
}

function renderGroup(group: GroupAsk): TemplateResult {
  return html`<li>
    <div>
      <span class="name">${groupTitle(group)}</span>
      <div class="facts"><span>${plural(group.requests.length, msg("1 request"), msg(str`${String(group.requests.length)} requests`))}</span><span>${msg(str`open shutter ${formatDuration(shutterOf(group))}`)}</span></div>
    </div>
  </li>`;
}

function restText(length: number): TemplateResult | typeof nothing {
  return length > MOST_ROWS ? html`<p class="muted">${msg(str`And ${length - MOST_ROWS} more.`)}</p>` : nothing;
}

declare global {
  interface HTMLElementTagNameMap {
    "t-request-import": RequestImport;
  }
}
