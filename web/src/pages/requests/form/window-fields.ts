/** Part of the form: when a request may be observed, once or again and again. */

import { msg, str } from "@lit/localize";
import { html, nothing, type TemplateResult } from "lit";
import { map } from "lit/directives/map.js";
import { settled } from "../../../elements/base/stable-field.js";
import { plural } from "../../../words/plural.js";
import { timeText, zoneName } from "../../../format/time.js";
import { rowField } from "./draft.js";
import type { CadenceDraft, CadenceField, ReadCadence } from "./cadence.js";
import { numberInput, renderRequestField, type FormView } from "./form-view.js";
import "../../../elements/forms/button.js";

/** What is done to the rows; a `DraftEditor` does it. */
export interface WindowActions {
  readonly addWindow: () => void;
  readonly removeWindow: (row: number) => void;
}

export function renderWindows(view: FormView, { addWindow, removeWindow }: WindowActions, cadence: TemplateResult): TemplateResult {
  const nowUs = Date.now() * 1000;
  const zone = zoneName(nowUs, view.zone);
  const { windows } = view.request;
  const utc = (us: number | undefined): string => (us === undefined || Number.isNaN(us) ? "" : timeText(us, "UTC", nowUs).utc);
  const wrong = view.readRequest.problems.get("windows");
  return html`<fieldset>
    <legend>${plural(windows.length, msg("Window"), msg("Windows: in one of them it is observed"))}</legend>
    ${map(windows, (window, i) => {
      const read = view.readRequest.windows[i];
      const field = (name: "start" | "end", label: string, us: number | undefined): TemplateResult =>
        renderRequestField(view, rowField(name, i), `${label} (${zone})`, html`<input name=${`${name}-${String(i)}`} type="text" autocomplete="off" placeholder="2026-03-29 14:05:09" maxlength="30" .value=${settled(window[name])} />`, utc(us));
      const remove = (): void => {
        removeWindow(i);
      };
      return html`<div class="window" role="group" aria-label=${msg(str`Window ${String(i + 1)}`)}>
        ${field("start", msg("From", { id: "from.time" }), read?.start_us)} ${field("end", msg("To", { id: "to.time" }), read?.end_us)}
        <t-button kind="quiet" label=${msg(str`Remove window ${String(i + 1)}`)} ?disabled=${windows.length === 1} @click=${remove}>${msg("Remove")}</t-button>
      </div>`;
    })}
    ${wrong === undefined ? nothing : html`<p class="wide wrong" role="alert">${wrong}</p>`}
    <div class="actions wide"><t-button @click=${addWindow}>${msg("Add a window")}</t-button></div>
    ${cadence}
  </fieldset>`;
}

/** @param act makes a request of each visit */
export function renderCadence(view: FormView, draft: CadenceDraft, read: ReadCadence, tried: boolean, act: () => void): TemplateResult {
  const zone = zoneName(Date.now() * 1000, view.zone);
  const field = (name: CadenceField, label: string, control: TemplateResult, hint: string): TemplateResult =>
    html`<t-field .label=${label} .hint=${hint} .error=${tried ? (read.problems.get(name) ?? "") : ""}>${control}</t-field>`;
  return html`<details class="wide">
    <summary>${msg("Again and again (cadence)")}</summary>
    <div class="inner">
      ${field("first", msg(str`First visit about (${zone})`), html`<input name="cadence.first" type="text" autocomplete="off" placeholder="2026-03-29 14:05:09" maxlength="30" .value=${settled(draft.first)} />`, msg("The middle of its window"))}
      ${field("every", msg("Hours between visits"), numberInput("cadence.every", draft.every), msg("24: each night"))}
      ${field("within", msg("Hours earlier or later"), numberInput("cadence.within", draft.within), msg("How far each visit may be off"))}
      ${field("visits", msg("Visits"), numberInput("cadence.visits", draft.visits), msg("Each is charged"))}
    </div>
    <div class="actions">
      <t-button @click=${act}>${read.windows.length === 0 ? msg("Make a request of each visit") : msg(str`Make ${String(read.windows.length)} requests`)}</t-button>
      ${read.windows.length === 0 ? nothing : html`<span class="muted small">${msg(str`From this one, each with its own window; the last about ${timeText(read.windows.at(-1)?.start_us ?? 0, view.zone, 0).local}.`)}</span>`}
    </div>
  </details>`;
}
