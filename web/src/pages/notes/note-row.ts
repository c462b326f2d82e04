/** One note as a line of a list. */

import { msg, str } from "@lit/localize";
import { html, nothing, type TemplateResult } from "lit";
import { formatDuration } from "../../format/duration.js";
import { timeText } from "../../format/time.js";
import type { QuestionController } from "../../controllers/question.js";
import { renderQuestion } from "../../elements/feedback/question.js";
import type { NoteShape, SiteShape } from "../../generated/api.js";
import { noteBoardPath, noteHistoryPath, subjectName } from "./notes-query.js";
import "../../elements/forms/button.js";
import "../../elements/values/time.js";

export interface NoteRowOptions {
  readonly site: string;
  readonly zone: string;
  readonly detail: SiteShape | undefined;
  readonly onChange: (event: Event) => void;
  readonly onRemove: (event: Event) => void;
}

/** An `<li>`. Changing it is offered to who may. */
export function renderNoteRow(note: NoteShape, { site, zone, detail, onChange, onRemove }: NoteRowOptions): TemplateResult {
  const about = subjectName(note, detail);
  const lasts = note.to_us > note.from_us;
  return html`<li data-note=${note.id}>
    <div>
      <div class="facts">
        <t-time .us=${note.from_us} .zone=${zone}></t-time>
        ${lasts ? html`<span>${msg(str`to ${timeText(note.to_us, zone, note.from_us).local}, ${formatDuration((note.to_us - note.from_us) / 1e6)}`)}</span>` : nothing}
        <span>${note.who}</span>
        ${about === "" ? nothing : html`<span>${about}</span>`}
      </div>
      <div class="name">${msg("note")}</div>
      <div class="message note">${note.text}</div>
      ${note.version > 1 ? html`<div class="facts"><span>${msg(str`changed by ${note.changed_by}`)}</span><t-time .us=${note.changed_us} .zone=${zone}></t-time></div>` : nothing}
    </div>
    <div class="ways">
      <a href=${noteHistoryPath(site, note, detail)}>${msg("Chart")}</a>
      <a href=${noteBoardPath(site, note)} title=${msg("See the board at that moment")}>${msg("Board then")}</a>
      ${note.may_change ? html`<t-button kind="quiet" label=${msg("Change the note")} @click=${onChange}>${msg("Change")}</t-button><t-button kind="quiet" label=${msg("Remove the note")} @click=${onRemove}>${msg("Remove")}</t-button>` : nothing}
    </div>
  </li>`;
}

/** Asked before a note goes. */
export function renderNoteQuestion(removing: QuestionController<NoteShape>): TemplateResult {
  return renderQuestion(removing, ({ who, text }) => ({ heading: msg("Remove the note?"), action: msg("Remove it"), text: msg(str`${who} wrote: ${text.slice(0, 200)}. What it said stays in the audit log.`) }));
}
