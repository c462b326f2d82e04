/** Part of the form: the frames of a request, row by row, with what its site has to choose from. */

import { msg, str } from "@lit/localize";
import { html, nothing, type TemplateResult } from "lit";
import { map } from "lit/directives/map.js";
import { settled } from "../../../elements/base/stable-field.js";
import { renderOptions, type SelectOption } from "../../../elements/forms/form-parts.js";
import type { AbilitiesShape, SettingRangeShape } from "../../../generated/api.js";
import { GUIDING_WORDS, GUIDINGS, IMAGE_TYPES, IMAGE_WORDS, rowField, type FramesDraft } from "./draft.js";
import { numberInput, renderRequestField, type FormView } from "./form-view.js";
import "../../../elements/forms/button.js";

/** What is done to the rows; a `DraftEditor` does it. */
export interface FrameActions {
  readonly addFrames: () => void;
  readonly removeFrames: (row: number) => void;
}

export function renderFrames(view: FormView, { addFrames, removeFrames }: FrameActions): TemplateResult {
  const { frames } = view.request;
  const wrong = view.readRequest.problems.get("frames");
  return html`<fieldset>
    <legend>${msg("Frames, in this order")}</legend>
    ${map(frames, (row, i) => {
      const label = String(i + 1);
      const remove = (): void => {
        removeFrames(i);
      };
      return html`<div class="frames" role="group" aria-label=${msg(str`Frames ${label}`)}>
        ${renderRow(view, row, i)}
        <t-button kind="quiet" label=${msg(str`Remove frames ${label}`)} ?disabled=${frames.length === 1} @click=${remove}>${msg("Remove")}</t-button>
      </div>`;
    })}
    ${wrong === undefined ? nothing : html`<p class="wide wrong" role="alert">${wrong}</p>`}
    <div class="actions wide"><t-button @click=${addFrames}>${msg("Add frames")}</t-button></div>
  </fieldset>`;
}

function renderRow(view: FormView, row: FramesDraft, i: number): TemplateResult {
  const { abilities } = view;
  const number = (name: "exposure" | "count" | "binning" | "gain" | "dither", label: string, hint: string): TemplateResult =>
    renderRequestField(view, rowField(name, i), label, numberInput(`${name}-${String(i)}`, row[name]), hint);
  const isSky = row.type === "LIGHT" || row.type === "SKY_FLAT";
  const types = IMAGE_TYPES.filter((type) => type === row.type || abilities === null || abilities.types.includes(type));
  // What cannot be chosen is shown only where something is written.
  const binning = abilities !== null && abilities.binning === null && row.binning === "1" ? nothing : number("binning", msg("Binning"), rangeText(abilities?.binning ?? null, msg("of both axes")));
  const gain = abilities !== null && abilities.gain === null && row.gain === "" ? nothing : number("gain", msg("Gain"), rangeText(abilities?.gain ?? null, msg("empty: as it is")));
  return html`${renderRequestField(view, rowField("type", i), msg("Kind"), html`<select name=${`type-${String(i)}`}>${renderOptions(types.map((type) => [type, IMAGE_WORDS[type]] as const), row.type)}</select>`)}
    ${isSky || row.filter !== "" ? renderRequestField(view, rowField("filter", i), msg("Filter", { id: "filter.optical" }), filterControl(row, i, abilities), abilities?.filters == null ? msg("empty: any") : "") : nothing}
    ${number("exposure", msg("Exposure (s)"), exposureHint(row))} ${number("count", msg("Frames"), "")} ${binning} ${gain}
    ${row.type === "LIGHT" || row.dither !== "0" ? number("dither", msg("Dither (″)"), msg("at most, between frames")) : nothing}
    ${row.type === "LIGHT" || row.guiding === "ON" ? renderGuiding(view, row, i) : nothing}`;
}

function filterControl({ filter }: FramesDraft, i: number, abilities: AbilitiesShape | null): TemplateResult {
  const name = `filter-${String(i)}`;
  const known = abilities?.filters ?? null;
  if (known === null) return html`<input name=${name} maxlength="40" autocomplete="off" .value=${settled(filter)} />`;
  const own: readonly SelectOption[] = filter === "" || known.includes(filter) ? [] : [[filter, msg(str`${filter} (not there)`)]];
  return html`<select name=${name}>${renderOptions([["", msg("any")], ...known, ...own], filter)}</select>`;
}

function renderGuiding(view: FormView, row: FramesDraft, i: number): TemplateResult {
  const some = GUIDINGS.filter((guiding) => guiding !== "ON" || row.guiding === "ON" || view.abilities === null || view.abilities.guides);
  return renderRequestField(view, rowField("guiding", i), msg("Guiding"), html`<select name=${`guiding-${String(i)}`}>${renderOptions(some.map((guiding) => [guiding, GUIDING_WORDS[guiding]] as const), row.guiding)}</select>`);
}

function exposureHint({ type }: FramesDraft): string {
  if (type === "SKY_FLAT") return msg("the first; the sky's level decides");
  return type === "BIAS" ? msg("0: as short as it can") : msg("of each");
}

function rangeText(range: SettingRangeShape | null, otherwise: string): string {
  if (range?.low == null || range.high === null) return otherwise;
  return msg(str`${String(range.low)} to ${String(range.high)}, ${otherwise}`);
}
