/** Notes and runs: the dialogs in which they are written and chosen. */

import { html, type TemplateResult } from "lit";
import { draftAt, draftOf, type NoteDraft } from "../notes/notes-query.js";
import type { GalleryEntry } from "./entry.js";
import "../../elements/forms/button.js";
import "../notes/note-dialog.js";
import "../runs/compare-runs.js";

const NOON_US = 1_780_000_000_000_000;
const SPAN_US = 60e6;

function renderDialog(draft: NoteDraft): TemplateResult {
  const open = (event: Event): void => {
    const dialog = event.currentTarget instanceof HTMLElement ? event.currentTarget.parentElement?.querySelector("t-note-dialog") : null;
    if (dialog) dialog.draft = draft;
  };
  const close = (event: Event): void => {
    const dialog = event.currentTarget;
    if (dialog instanceof HTMLElement && "draft" in dialog) dialog.draft = null;
  };
  return html`<div><t-button @click=${open}>Open</t-button><t-note-dialog site="yard" zone="Europe/Madrid" @t-close=${close}></t-note-dialog></div>`;
}

export const entries: readonly GalleryEntry[] = [
  {
    tag: "t-note-dialog",
    states: [
      { name: "a new note at a moment", show: () => renderDialog(draftAt(NOON_US)) },
      { name: "a new note over a span", show: () => renderDialog(draftAt(NOON_US, NOON_US + SPAN_US)) },
      {
        name: "a note that is changed",
        show: () => renderDialog(draftOf({ id: "7", device: "", signal: "", from_us: NOON_US, to_us: NOON_US, text: "The wheel slipped.", who: "Marta", created_us: NOON_US, changed_us: NOON_US, changed_by: "Marta", version: 2, may_change: true })),
      },
    ],
  },
  {
    tag: "t-compare-runs",
    states: [{ name: "two runs are chosen", show: () => html`<t-compare-runs site="yard" zone="Europe/Madrid" .span=${{ fromUs: NOON_US, toUs: NOON_US + SPAN_US }}></t-compare-runs>` }],
  },
];
