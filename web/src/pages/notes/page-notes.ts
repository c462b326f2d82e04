/** The notes that people wrote about a site: found by words, author, device and time; written, changed and removed. */

import { consume } from "@lit/context";
import { msg, str } from "@lit/localize";
import { css, html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, property, state } from "lit/decorators.js";
import type { ActionController } from "../../controllers/action.js";
import { ContextStoreController } from "../../controllers/context-store.js";
import { FilterForm } from "../../controllers/filter-form.js";
import { InfiniteList } from "../../controllers/infinite-list.js";
import { LoadController } from "../../controllers/load.js";
import { QuestionController } from "../../controllers/question.js";
import { base } from "../../elements/base/base-style.js";
import { settled } from "../../elements/base/stable-field.js";
import { renderOptions } from "../../elements/forms/form-parts.js";
import { forms } from "../../elements/forms/form-style.js";
import { renderPageHead } from "../../elements/layout/page-head.js";
import { sheets } from "../../elements/layout/page-sections.js";
import { formTexts } from "../../format/filter-query.js";
import { formText } from "../../format/form-values.js";
import { knownZone } from "../../format/time.js";
import type { NoteShape, SiteShape } from "../../generated/api.js";
import { clockOf, momentProblem, type ZoneClock } from "../../series/zone-clock.js";
import { apiContext, routerContext, sitesContext } from "../../state/contexts.js";
import { sitePath, withQuery } from "../../state/router.js";
import type { HubApi } from "../../wire/hub-api.js";
import { NotesApi, notesExportPath } from "./notes-api.js";
import { renderInfiniteList } from "../infinite-list-view.js";
import { noteStyle } from "./note-style.js";
import { renderNoteQuestion, renderNoteRow } from "./note-row.js";
import { NoteWriter } from "./note-writer.js";
import { draftAt, draftOf, NO_SEARCH, notesPageQuery, readNoteSearch, SEARCH_KEYS, writeNoteSearch, type NoteSearch } from "./notes-query.js";
import "../../elements/feedback/empty.js";
import "../../elements/forms/button.js";
import "../../elements/forms/field.js";

const ROWS = 50;

@customElement("t-page-notes")
export class PageNotes extends LitElement {
  static override styles = [base, sheets, forms, noteStyle, css`
    .actions {
      align-items: center;
    }
  `];

  @property() site = "";
  /** What is written as a time and is none, by field: nothing is filtered by it. */
  @state() private wrongTimes: Readonly<Record<string, string>> = {};

  @consume({ context: apiContext }) private readonly api!: HubApi;
  private readonly router = new ContextStoreController(this, routerContext);
  private readonly sites = new ContextStoreController(this, sitesContext);
  private readonly detail = new LoadController<SiteShape>(this);
  private edition = 0;
  private readonly writer = new NoteWriter(this, () => this.site, () => {
    // Anew, for a note that was changed may stand elsewhere, or not fit any more.
    this.edition += 1;
    this.requestUpdate();
  });
  private readonly removing = new QuestionController<NoteShape>(this, (note, action) => this.removeNote(note, action));
  private readonly list = new InfiniteList<NoteShape>(this, async (before) => {
    const { notes, more } = await new NotesApi(this.api, this.site).findNotes(notesPageQuery(this.search(), before, ROWS));
    return { rows: notes, more };
  });
  private readonly form = new FilterForm<NoteSearch>(
    this,
    (said) => this.readForm(said),
    (search) => {
      if (search === NO_SEARCH) this.wrongTimes = {};
      this.router.store?.replace(withQuery(sitePath(this.site, "notes"), writeNoteSearch(search)));
    },
    NO_SEARCH,
  );

  override willUpdate(): void {
    const sites = this.sites.store;
    if (sites === undefined || this.site === "") return;
    this.detail.load(`${this.site} ${sites.catalogueOf(this.site)}`, () => sites.loadDetail(this.site));
    this.list.load(`${this.site}\n${writeNoteSearch(this.search())}\n${String(this.edition)}`);
  }

  override render(): TemplateResult {
    const zone = this.sites.store?.zoneOf(this.site) ?? "UTC";
    const search = this.search();
    const span = { fromUs: search.fromUs ?? 0, toUs: search.toUs ?? 2 ** 53 };
    return html`${renderPageHead(
        msg("Notes"),
        msg(str`What people wrote about moments and spans of ${this.sites.store?.siteRow(this.site)?.name ?? this.site}; the last to begin first.`),
        html`<div class="actions">
          ${this.mayWrite ? html`<t-button kind="primary" @click=${this.writeNote}>${msg("Write a note")}</t-button>` : nothing}
          <a href=${notesExportPath(this.site, span)} download>${msg("Export CSV")}</a>
          <a href=${sitePath(this.site, "logbook")}>${msg("Logbook")}</a>
          <a href=${sitePath(this.site, "history")}>${msg("History")}</a>
        </div>`,
      )}
      ${this.renderSearch(search)}
      ${renderInfiniteList(this.list, {
        label: msg("Notes"),
        what: msg("the notes"),
        row: (note) => renderNoteRow(note, { site: this.site, zone, detail: this.detail.value, onChange: this.writer.draft.opener(draftOf(note)), onRemove: this.removing.opener(note) }),
        nothing: () => this.renderEmpty(search),
      })}
      ${this.writer.renderDialog(this.site, zone, this.detail.value ?? null)}
      ${renderNoteQuestion(this.removing)}`;
  }

  private renderSearch(search: NoteSearch): TemplateResult {
    const clock = this.clock();
    const shown = (us: number | null): string => (us === null ? "" : clock.toInput(us));
    const time = (name: "from" | "to", label: string, us: number | null): TemplateResult =>
      html`<t-field class="time" label=${`${label} (${clock.zone})`} .error=${momentProblem(this.wrongTimes[name] ?? "", Number.NaN)}><input name=${name} type="text" autocomplete="off" placeholder="2026-03-29 14:05:09" maxlength="30" .value=${settled(this.wrongTimes[name] ?? shown(us))} /></t-field>`;
    return html`<section class="sheet" aria-label=${msg("Search")}>
      <form class="filter" novalidate @submit=${this.form.onSubmit} @input=${this.form.onInput}>
        <t-field label=${msg("Words")}><input name="text" type="search" maxlength="200" autocomplete="off" .value=${settled(search.text)} /></t-field>
        <t-field label=${msg("Author")}><input name="who" maxlength="200" autocomplete="off" .value=${settled(search.who)} /></t-field>
        <t-field label=${msg("Device")}>
          <select name="device">${renderOptions([["", msg("All", { id: "all.devices" })], ...(this.detail.value?.devices ?? []).map(({ id, name }) => [id, name] as const)], search.device)}</select>
        </t-field>
        ${time("from", msg("From", { id: "from.time" }), search.fromUs)}${time("to", msg("To", { id: "to.time" }), search.toUs)}
        <t-button kind="quiet" ?disabled=${writeNoteSearch(search) === ""} @click=${this.form.clearFilter}>${msg("Clear")}</t-button>
      </form>
    </section>`;
  }

  private renderEmpty(search: NoteSearch): TemplateResult {
    if (writeNoteSearch(search) !== "") {
      return html`<t-empty heading=${msg("No matches")} icon="logbook"><p>${msg("No note is like this.")}</p><t-button @click=${this.form.clearFilter}>${msg("Show everything")}</t-button></t-empty>`;
    }
    return html`<t-empty heading=${msg("No notes yet")} icon="logbook">
      <p>${this.mayWrite ? msg("Write one here, on a past board’s bar, or over a span of a chart.") : msg("Who may use a device of the site can write some.")}</p>
    </t-empty>`;
  }

  /** At the newest moment; the dialog takes any other. */
  private readonly writeNote = (event: Event): void => {
    this.writer.draft.opener(draftAt(Date.now() * 1000, undefined, this.search().device))(event);
  };

  private get mayWrite(): boolean {
    return this.detail.value?.devices.some(({ rights }) => rights.includes("use")) === true;
  }

  private removeNote(note: NoteShape, action: ActionController): Promise<boolean> {
    return action.run(msg("remove the note"), async () => {
      await new NotesApi(this.api, this.site).removeNote(note.id);
      this.list.updateRows((rows) => rows.filter(({ id }) => id !== note.id));
    });
  }

  private clock(): ZoneClock {
    return clockOf(knownZone(this.sites.store?.zoneOf(this.site) ?? "UTC"));
  }

  private search(): NoteSearch {
    return readNoteSearch(this.router.store?.search ?? "");
  }

  private readForm(said: FormData): NoteSearch {
    const time = (name: "from" | "to"): number | null => {
      const text = formText(said, name);
      const us = this.clock().fromInput(text);
      const others = Object.entries(this.wrongTimes).filter(([other]) => other !== name);
      this.wrongTimes = Object.fromEntries(momentProblem(text, us) === "" ? others : [...others, [name, text]]);
      return Number.isNaN(us) ? null : us;
    };
    return { ...formTexts(said, SEARCH_KEYS), fromUs: time("from"), toUs: time("to") };
  }
}

declare global {
  interface HTMLElementTagNameMap {
    "t-page-notes": PageNotes;
  }
}
