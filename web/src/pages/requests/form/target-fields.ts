/** Part of the form: what a request looks at. */

import { msg } from "@lit/localize";
import { html, nothing, type TemplateResult } from "lit";
import { map } from "lit/directives/map.js";
import { settled } from "../../../elements/base/stable-field.js";
import { renderOptions, type SelectOption } from "../../../elements/forms/form-parts.js";
import { BODIES } from "./draft.js";
import { numberInput, renderRequestField, type FormView } from "./form-view.js";
import type { TargetFinder } from "./target-finder.js";
import "../../../elements/forms/button.js";

const WAYS: readonly SelectOption[] = [
  ["stars", msg("Among the stars")],
  ["body", msg("Moon or planet")],
  ["fixed", msg("Fixed above the horizon")],
  ["none", msg("None (dark, bias, flat)")],
];

export function renderTarget(view: FormView, finder: TargetFinder): TemplateResult {
  const { request } = view;
  return html`<fieldset>
    <legend>${msg("Target")}</legend>
    ${renderRequestField(view, "way", msg("Kind"), html`<select name="way">${renderOptions(WAYS, request.way)}</select>`)}
    ${request.way === "stars" ? renderStars(view, finder) : nothing}
    ${request.way === "body" ? html`<t-field label=${msg("Body")}><select name="body">${renderOptions(BODIES, request.body)}</select></t-field>` : nothing}
    ${request.way === "fixed"
      ? html`${renderRequestField(view, "altitude", msg("Altitude (°)"), numberInput("altitude", request.altitude), msg("Above the horizon, 0 to 90"))}
        ${renderRequestField(view, "azimuth", msg("Azimuth (°)"), numberInput("azimuth", request.azimuth), msg("From north through east"))}`
      : nothing}
  </fieldset>`;
}

function renderStars(view: FormView, finder: TargetFinder): TemplateResult {
  const { request } = view;
  const place = (name: "ra" | "dec", label: string, hint: string): TemplateResult =>
    renderRequestField(view, name, label, html`<input name=${name} maxlength="40" autocomplete="off" spellcheck="false" .value=${settled(request[name])} />`, hint);
  return html`<div class="find">
      <t-field label=${msg("Name")} hint=${msg("M 31, NGC 7000, Vega; Find looks it up without the network")}
        ><input name="target" maxlength="100" autocomplete="off" spellcheck="false" .value=${settled(request.target)} @keydown=${finder.onKey}
      /></t-field>
      <t-button ?busy=${finder.busy} @click=${finder.find}>${msg("Find")}</t-button>
    </div>
    ${finder.text === "" ? nothing : html`<p class="wide" role="status">${finder.text}</p>`}
    ${finder.found.length < 2
      ? nothing
      : html`<div class="actions wide">${map(finder.found.slice(0, 6), (target) => html`<t-button kind="quiet" @click=${finder.chooser(target)}>${target.name} (${target.about})</t-button>`)}</div>`}
    ${place("ra", msg("Right ascension (J2000)"), msg("05:34:32, or 83.63°"))} ${place("dec", msg("Declination (J2000)"), msg("\u221205:23:28, or \u22125.39"))}
    <details class="wide" ?open=${view.opened.motion}>
      <summary>${msg("It moves among the stars")}</summary>
      <div class="inner">
        ${renderRequestField(view, "motionRa", msg("Proper motion in RA (mas/year)"), numberInput("motionRa", request.motionRa), msg("With the cosine of the declination, as Gaia has it; empty: none"))}
        ${renderRequestField(view, "motionDec", msg("Proper motion in dec (mas/year)"), numberInput("motionDec", request.motionDec), msg("Empty: none"))}
        ${renderRequestField(view, "epoch", msg("Epoch of the coordinates (year)"), numberInput("epoch", request.epoch), msg("2016 for Gaia's; empty: 2000"))}
      </div>
    </details>`;
}
