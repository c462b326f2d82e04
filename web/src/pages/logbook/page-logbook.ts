/** The logbook of a site: commands, alarms, sightings, interlocks, connections; who and why. */

import { consume } from "@lit/context";
import { msg, str } from "@lit/localize";
import { css, html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, property } from "lit/decorators.js";
import { eventWords } from "../../format/kinds/event-kinds.js";
import { boardAtPath } from "../../boards/board-query.js";
import { InfiniteList } from "../../controllers/infinite-list.js";
import { FilterForm } from "../../controllers/filter-form.js";
import { ConnectionStateController } from "../../controllers/connection-state.js";
import { LoadController } from "../../controllers/load.js";
import { QuestionController } from "../../controllers/question.js";
import { ContextStoreController } from "../../controllers/context-store.js";
import { base } from "../../elements/base/base-style.js";
import { renderOptions } from "../../elements/forms/form-parts.js";
import { forms } from "../../elements/forms/form-style.js";
import { settled } from "../../elements/base/stable-field.js";
import { renderPageHead } from "../../elements/layout/page-head.js";
import { sheets } from "../../elements/layout/page-sections.js";
import { formTexts } from "../../format/filter-query.js";
import { apiContext, routerContext, sessionContext, sitesContext } from "../../state/contexts.js";
import { sitePath, withQuery } from "../../state/router.js";
import { AlarmsApi } from "../../wire/alarms-api.js";
import type { EventShape, NoteShape, RecordingShape, SiteShape } from "../../generated/api.js";
import type { HubApi } from "../../wire/hub-api.js";
import { RecordingsApi } from "../../wire/recordings-api.js";
import { sightingPicturePath } from "../../wire/sightings-api.js";
import { newSensorOf, newSensorPath } from "../description/new-sensor.js";
import { renderInfiniteList } from "../infinite-list-view.js";
import { NotesApi } from "../notes/notes-api.js";
import { renderNoteQuestion, renderNoteRow } from "../notes/note-row.js";
import { noteStyle } from "../notes/note-style.js";
import { isNoteEvent, NoteWriter } from "../notes/note-writer.js";
import { draftAt, draftOf } from "../notes/notes-query.js";
import { causeQuery } from "../cause/cause-words.js";
import { historyQuery } from "../sightings/sightings-query.js";
import {
  FILTER_KEYS,
  KINDS,
  momentQuery,
  NO_FILTER,
  readLogbookFilter,
  recordingAt,
  showsCurrentSightings,
  writeLogbookFilter,
  type LogbookFilter,
} from "./logbook-query.js";
import { readLogbookPage, type LogbookRow } from "./logbook-rows.js";
import "../../elements/forms/button.js";
import "../../elements/feedback/empty.js";
import "../../elements/forms/field.js";
import "../../elements/feedback/status.js";
import "../../elements/values/time.js";
import "./current-sightings.js";

const ROWS = 50;

@customElement("t-page-logbook")
export class PageLogbook extends LitElement {
  static override styles = [
    base,
    sheets,
    forms,
    noteStyle,
    css`
      .message {
        overflow-wrap: anywhere;
      }
      .seen {
        inline-size: 8rem;
        aspect-ratio: 4 / 3;
        object-fit: contain;
        border-radius: var(--t-radius-s);
        background: #000;
        filter: var(--t-still-filter, none);
      }
    `,
  ];

  @property() site = "";

  @consume({ context: apiContext }) private readonly api!: HubApi;
  private readonly router = new ContextStoreController(this, routerContext);
  private readonly session = new ContextStoreController(this, sessionContext);
  private readonly sites = new ContextStoreController(this, sitesContext);
  private readonly detail = new LoadController<SiteShape>(this);
  private readonly recordings = new LoadController<readonly RecordingShape[]>(this);
  /** Begins the list anew when a note has changed: it may stand elsewhere, or be gone. */
  private edition = 0;
  private readonly writer = new NoteWriter(this, () => this.site, () => {
    this.edition += 1;
    this.requestUpdate();
  });
  private readonly removing = new QuestionController<NoteShape>(this, (note, action) =>
    action.run(msg("remove the note"), () => new NotesApi(this.api, this.site).removeNote(note.id)),
  );
  private readonly list: InfiniteList<LogbookRow> = new InfiniteList<LogbookRow>(this, async (before) => {
    const last = this.list.rows.find(({ id }) => id === before);
    return readLogbookPage({ events: new AlarmsApi(this.api), notes: new NotesApi(this.api, this.site) }, this.site, this.filter(), last, ROWS);
  });
  private readonly form = new FilterForm<LogbookFilter>(
    this,
    (said) => ({ ...formTexts(said, FILTER_KEYS), bad: said.has("bad") }),
    (filter) => {
      this.router.store?.replace(withQuery(sitePath(this.site, "logbook"), writeLogbookFilter(filter)));
    },
    NO_FILTER,
  );

  constructor() {
    super();
    new ConnectionStateController(this, (connection) => [
      connection.onMessage("event", (news) => {
        if (news.site !== this.site || isNoteEvent(news)) return;
        this.list.scheduleRefresh();
        // One that has come to the hub is linked from what it holds.
        if (news.kind.startsWith("recording")) this.recordings.invalidate();
      }),
    ]);
  }

  override willUpdate(): void {
    const sites = this.sites.store;
    if (sites !== undefined) this.detail.load(`${this.site} ${sites.catalogueOf(this.site)}`, () => sites.loadDetail(this.site));
    // Who may not see them has no links to them, and that is all.
    this.recordings.load(this.site, async () => (await new RecordingsApi(this.api).listRecordings(this.site)).recordings);
    this.list.load(`${this.site}\n${writeLogbookFilter(this.filter())}\n${String(this.edition)}`);
  }

  override render(): TemplateResult {
    const filter = this.filter();
    return html`${renderPageHead(
        msg("Logbook"),
        msg(str`What happened at ${this.sites.store?.siteRow(this.site)?.name ?? this.site}, who did it and why; newest first.`),
        html`<div class="actions">
          ${this.mayWrite ? html`<t-button @click=${this.writeNote}>${msg("Write a note")}</t-button>` : nothing}
          <a href=${sitePath(this.site, "notes")}>${msg("Notes")}</a>
          <a href="/alarms">${msg("Alarms")}</a>
          <a href=${sitePath(this.site, "sightings")}>${msg("Sightings")}</a>
          <a href=${sitePath(this.site, "history")}>${msg("History")}</a>
        </div>`,
      )}
      <section class="sheet" aria-label=${msg("Filter")}>
        <form class="filter" novalidate @submit=${this.form.onSubmit} @input=${this.form.onInput}>
          <t-field label=${msg("Search")}><input name="text" type="search" maxlength="200" autocomplete="off" .value=${settled(filter.text)} /></t-field>
          <t-field label=${msg("What")}>
            <select name="kind">${renderOptions(KINDS.map(({ kind, name }) => [kind, name]), filter.kind)}</select>
          </t-field>
          <t-field label=${msg("Who")}><input name="who" maxlength="200" autocomplete="off" .value=${settled(filter.who)} /></t-field>
          <t-field label=${msg("Device")}>
            <select name="device">
              ${renderOptions([["", msg("All", { id: "all.devices" })], ...(this.detail.value?.devices ?? []).map(({ id, name }) => [id, name] as const)], filter.device)}
            </select>
          </t-field>
          <label class="tick"><input name="bad" type="checkbox" .checked=${filter.bad} /> ${msg("Only what went wrong")}</label>
          <t-button kind="quiet" ?disabled=${writeLogbookFilter(filter) === ""} @click=${this.form.clearFilter}>${msg("Clear")}</t-button>
        </form>
      </section>
      ${showsCurrentSightings(filter) ? html`<t-in-sight .site=${this.site} .zone=${this.sites.store?.zoneOf(this.site) ?? "UTC"}></t-in-sight>` : nothing}
      ${renderInfiniteList(this.list, {
        label: msg("Events"),
        what: msg("the logbook"),
        row: (row) => ("note" in row ? this.renderNote(row.note) : this.renderRow(row)),
        nothing: () => this.renderEmpty(filter),
      })}
      ${this.writer.renderDialog(this.site, this.sites.store?.zoneOf(this.site) ?? "UTC", this.detail.value ?? null)} ${renderNoteQuestion(this.removing)}`;
  }

  private renderEmpty(filter: LogbookFilter): TemplateResult {
    const all = writeLogbookFilter(filter) === "";
    return html`<t-empty heading=${msg("No matches")} icon="logbook">
      <p>${all ? msg("Nothing has happened yet.") : msg("Nothing in the logbook is like this.")}</p>
      ${all ? nothing : html`<t-button @click=${this.form.clearFilter}>${msg("Show everything")}</t-button>`}
    </t-empty>`;
  }

  private get mayWrite(): boolean {
    return this.detail.value?.devices.some(({ rights }) => rights.includes("use")) === true;
  }

  private renderNote(note: NoteShape): TemplateResult {
    const zone = this.sites.store?.zoneOf(this.site) ?? "UTC";
    return renderNoteRow(note, { site: this.site, zone, detail: this.detail.value, onChange: this.writer.draft.opener(draftOf(note)), onRemove: this.removing.opener(note) });
  }

  private renderRow(row: EventShape): TemplateResult {
    const zone = this.sites.store?.zoneOf(this.site) ?? "UTC";
    const seen = row.sighting ?? null;
    const device = this.detail.value?.devices.find(({ id }) => id === row.device);
    const signals = device?.signals.filter(({ primary }) => primary) ?? [];
    const channels = (signals.length > 0 ? signals : (device?.signals ?? [])).flatMap((signal) => signal.channels);
    const added = newSensorOf(this.site, row);
    const recording = recordingAt(this.recordings.value ?? [], row.time_us);
    return html`<li>
      <div>
        <div class="facts">
          <t-time .us=${row.time_us} .zone=${zone}></t-time>
          ${row.who === "" ? nothing : html`<span>${row.who}</span>`}
          ${row.device === "" ? nothing : html`<span>${device?.name ?? row.device}</span>`}
        </div>
        <div class="name">${row.good ? nothing : html`<t-status kind="bad" word=${msg("look")}></t-status> `}${eventWords(row.kind)}</div>
        ${row.message === "" ? nothing : html`<div class="message">${row.message}</div>`}
        ${seen?.picture === true
          ? html`<img class="seen" src=${sightingPicturePath(this.site, seen.id)} alt=${msg(str`${seen.label} on the picture of ${seen.camera}`)} loading="lazy" decoding="async" />`
          : nothing}
      </div>
      <div class="ways">
        <a href=${`${sitePath(this.site, "history")}?${seen === null ? momentQuery(row.time_us, channels) : historyQuery(seen, undefined)}`}>${msg("Chart")}</a>
        <a href=${boardAtPath(this.site, row.time_us)} title=${msg("See the board at that moment")}>${msg("Board then")}</a>
        ${recording === undefined ? nothing : html`<a href=${`${sitePath(this.site, "recordings")}?at=${String(row.time_us)}`}>${msg("Recording")}</a>`}
        ${row.kind.startsWith("sighting") ? html`<a href=${sitePath(this.site, "sightings")}>${msg("Sightings")}</a>` : nothing}
        ${added === null || this.session.store?.person?.admin !== true ? nothing : html`<a href=${newSensorPath(added)}>${msg("Add it")}</a>`}
        ${row.kind.startsWith("anomaly") || row.kind.startsWith("alarm") ? html`<a href=${`${sitePath(this.site, "cause")}?${causeQuery(row.time_us)}`}>${msg("Cause")}</a>` : nothing}
        ${row.kind.startsWith("alarm") ? html`<a href="/alarms">${msg("Alarms")}</a>` : nothing}
        ${device?.rights.includes("use") === true || (row.device === "" && this.mayWrite)
          ? html`<t-button kind="quiet" label=${msg(str`Note on ${eventWords(row.kind)}`)} @click=${this.writer.draft.opener(draftAt(row.time_us, undefined, row.device))}>${msg("Note")}</t-button>`
          : nothing}
      </div>
    </li>`;
  }

  /** At the moment of the press; the dialog takes any other. */
  private readonly writeNote = (event: Event): void => {
    this.writer.draft.opener(draftAt(Date.now() * 1000))(event);
  };

  private filter(): LogbookFilter {
    return readLogbookFilter(this.router.store?.search ?? "");
  }
}

declare global {
  interface HTMLElementTagNameMap {
    "t-page-logbook": PageLogbook;
  }
}
