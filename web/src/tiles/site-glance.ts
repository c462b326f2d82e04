/** A site in a line or two: state, battery, alarms, who drives, where it is. */

import { msg, str } from "@lit/localize";
import { html, nothing, type TemplateResult } from "lit";
import { formatNumber } from "../format/number.js";
import { plural } from "../words/plural.js";
import type { SiteSummary } from "../generated/api.js";
import type { LinkState } from "../wire/connection.js";
import "../elements/feedback/status.js";
import "../elements/values/time.js";

/** Below this a battery is worth a word in colour (%). */
const LOW_BATTERY = 20;

/** Whether its gateway is there; without the hub nobody knows. */
export function renderStanding({ online }: Pick<SiteSummary, "online">, link: LinkState): TemplateResult {
  return html`<t-status kind=${link === "lost" ? "unknown" : online ? "online" : "offline"}></t-status>`;
}

/** `bad` and `warn` count alarms that nobody has settled. Classes `facts`, `bad` and `warn` are the caller's. */
export function renderGlance(row: SiteSummary, { bad, warn }: { readonly bad: number; readonly warn: number }): TemplateResult {
  const parts = [
    bad > 0 ? html`<span class="bad">${plural(bad, msg("1 critical alarm"), msg(str`${String(bad)} critical alarms`))}</span>` : nothing,
    warn > 0 ? html`<span class="warn">${plural(warn, msg("1 warning"), msg(str`${String(warn)} warnings`))}</span>` : nothing,
    row.state === "" ? nothing : row.state,
    row.battery === null ? nothing : html`<span class=${row.battery < LOW_BATTERY ? "warn" : ""}>${msg(str`battery ${formatNumber(row.battery, 0)} %`)}</span>`,
    row.driver === "" ? nothing : html`${msg(str`driven by ${row.driver}`)}`,
    row.moving && row.latitude !== null && row.longitude !== null ? html`<a href=${`/map?site=${encodeURIComponent(row.site)}`}>${placeText(row.latitude, row.longitude)}</a>` : nothing,
    row.online || row.last_seen_us === 0 ? nothing : msg(html`last heard of <t-time .us=${row.last_seen_us} .zone=${row.zone}></t-time>`),
  ].filter((part) => part !== nothing);
  return html`<p class="facts">${parts.length === 0 ? msg("No alarm") : parts.map((part, i) => html`${i === 0 ? nothing : " · "}${part}`)}</p>
    ${row.tags.length === 0 ? nothing : html`<p class="facts">${row.tags.map((tag) => `#${tag}`).join(" ")}</p>`}`;
}

/** `41.38741° N, 2.16863° E`: about a metre. */
export function placeText(latitude: number, longitude: number): string {
  const part = (value: number, plus: string, minus: string): string => `${formatNumber(Math.abs(value), 5)}° ${value < 0 ? minus : plus}`;
  return `${part(latitude, msg("N"), msg("S"))}, ${part(longitude, msg("E"), msg("W"))}`;
}
