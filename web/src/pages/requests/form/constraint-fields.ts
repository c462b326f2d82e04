/** Part of the form: what must hold all the time that a request is observed. */

import { msg, str } from "@lit/localize";
import { html, nothing, type TemplateResult } from "lit";
import { map } from "lit/directives/map.js";
import { settled } from "../../../elements/base/stable-field.js";
import { parseMoment } from "../../../format/julian-date.js";
import { timeText } from "../../../format/time.js";
import type { RequestDraft } from "./draft.js";
import { numberInput, renderRequestField, type FormView } from "./form-view.js";

type LimitField = Exclude<keyof RequestDraft, "windows" | "frames">;

const LIMITS: readonly (readonly [field: LimitField, label: string, hint: string])[] = [
  ["minAltitude", msg("Lowest altitude (°)"), msg("30° is an airmass of 2")],
  ["maxAirmass", msg("Highest airmass"), msg("empty: any")],
  ["moonDistance", msg("Distance from the Moon (°)"), msg("while it is up")],
  ["moonLit", msg("Moon lit at most (%)"), msg("while it is up; empty: any")],
  ["sunAltitude", msg("Sun at most (°)"), msg("\u221218 night, \u221212 nautical, \u22126 civil")],
  ["hourAngle", msg("Hour angle at most (h)"), msg("before and after the meridian; empty: any")],
  ["seeing", msg("Seeing at most (″)"), msg("as measured last; empty: any")],
  ["clouds", msg("Clouds at most (%)"), msg("as measured last; empty: any")],
];

export function renderConstraints(view: FormView): TemplateResult {
  const { request } = view;
  const epoch = parseMoment(request.phaseEpoch);
  const isPhased = [request.phasePeriod, request.phaseEpoch, request.phaseStart, request.phaseEnd].some((text) => text !== "");
  return html`<fieldset>
    <legend>${msg("What must hold")}</legend>
    ${map(LIMITS, ([field, label, hint]) =>
      isMeasured(field, view) || request[field] !== "" ? renderRequestField(view, field, label, numberInput(field, request[field]), hint) : nothing,
    )}
    <details class="wide" ?open=${view.opened.phase}>
      <summary>${msg("Only in a part of a period (variable stars, transits)")}</summary>
      <div class="inner">
        ${renderRequestField(view, "phasePeriod", msg("Period (days)"), numberInput("phasePeriod", request.phasePeriod))}
        ${renderRequestField(
          view,
          "phaseEpoch",
          msg("Phase 0 at (UTC)"),
          html`<input name="phaseEpoch" maxlength="40" autocomplete="off" spellcheck="false" .value=${settled(request.phaseEpoch)} />`,
          Number.isNaN(epoch) ? msg("JD 2460000.5, MJD 60000 or 2026-12-04 21:30") : msg(str`${timeText(epoch, "UTC", 0).utc}; as seen here: light time to the Sun is not taken off`),
        )}
        ${renderRequestField(view, "phaseStart", msg("From phase"), numberInput("phaseStart", request.phaseStart), msg("0 to 1"))}
        ${renderRequestField(view, "phaseEnd", msg("To phase"), numberInput("phaseEnd", request.phaseEnd), msg("less than the first: through 0"))}
      </div>
      ${isPhased ? nothing : html`<p class="muted">${msg("All four fields are empty: the phase does not matter.")}</p>`}
    </details>
  </fieldset>`;
}

/** A limit on what the site does not measure would hold nothing back, so it is not offered. */
function isMeasured(field: LimitField, { abilities }: FormView): boolean {
  if (field === "seeing") return abilities?.measures_seeing ?? true;
  return field === "clouds" ? (abilities?.measures_clouds ?? true) : true;
}
