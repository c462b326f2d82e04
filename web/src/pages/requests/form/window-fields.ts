/** Part of the form: when a request may be observed, once or again and again. */

import { html, nothing, type TemplateResult } from "lit";
import { map } from "lit/directives/map.js";
import { settled } from "../../../elements/base/stable-field.js";
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
    <legend>${windows.length === 1 ? "Window" : "Windows: in one of them it is observed"}</legend>
    ${map(windows, (window, i) => {
      const read = view.readRequest.windows[i];
      const field = (name: "start" | "end", label: string, us: number | undefined): TemplateResult =>
        renderRequestField(view, rowField(name, i), `${label} (${zone})`, html`<input name=${`${name}-${String(i)}`} type="text" autocomplete="off" placeholder="2026-03-29 14:05:09" maxlength="30" .value=${settled(window[name])} />`, utc(us));
      const remove = (): void => {
        removeWindow(i);
      };
      return html`<div class="window" role="group" aria-label=${`Window ${String(i + 1)}`}>
        ${field("start", "From", read?.start_us)} ${field("end", "To", read?.end_us)}
        <t-button kind="quiet" label=${`Remove window ${String(i + 1)}`} ?disabled=${windows.length === 1} @click=${remove}>Remove</t-button>
      </div>`;
    })}
    ${wrong === undefined ? nothing : html`<p class="wide wrong" role="alert">${wrong}</p>`}
    <div class="actions wide"><t-button @click=${addWindow}>Add a window</t-button></div>
    ${cadence}
  </fieldset>`;
}

/** @param act makes a request of each visit */
export function renderCadence(view: FormView, draft: CadenceDraft, read: ReadCadence, tried: boolean, act: () => void): TemplateResult {
  const zone = zoneName(Date.now() * 1000, view.zone);
  const field = (name: CadenceField, label: string, control: TemplateResult, hint: string): TemplateResult =>
    html`<t-field .label=${label} .hint=${hint} .error=${tried ? (read.problems.get(name) ?? "") : ""}>${control}</t-field>`;
  return html`<details class="wide">
    <summary>Again and again (cadence)</summary>
    <div class="inner">
      ${field("first", `First visit about (${zone})`, html`<input name="cadence.first" type="text" autocomplete="off" placeholder="2026-03-29 14:05:09" maxlength="30" .value=${settled(draft.first)} />`, "The middle of its window")}
      ${field("every", "Hours between visits", numberInput("cadence.every", draft.every), "24: each night")}
      ${field("within", "Hours earlier or later", numberInput("cadence.within", draft.within), "How far each visit may be off")}
      ${field("visits", "Visits", numberInput("cadence.visits", draft.visits), "Each is charged")}
    </div>
    <div class="actions">
      <t-button @click=${act}>${read.windows.length === 0 ? "Make a request of each visit" : `Make ${String(read.windows.length)} requests`}</t-button>
      ${read.windows.length === 0 ? nothing : html`<span class="muted small">From this one, each with its own window; the last about ${timeText(read.windows.at(-1)?.start_us ?? 0, view.zone, 0).local}.</span>`}
    </div>
  </details>`;
}
