/** Many sites in order: found by words and tags, sorted, and under their groups. Pure. */

import { msg } from "@lit/localize";
import type { SiteSummary } from "../../generated/api.js";
import { foldedText } from "../../state/sites.js";
import { NO_TROUBLE, type SiteTrouble } from "../../tiles/site-trouble.js";

export const FLEET_ORDERS = [
  ["trouble", msg("Trouble first")],
  ["name", msg("Name")],
  ["battery", msg("Battery, emptiest first")],
  ["heard", msg("Last heard")],
] as const;

/** Made once: one for each comparison took most of a page's time with hundreds of sites. */
const byName = new Intl.Collator(undefined, { numeric: true });

export type FleetOrder = (typeof FLEET_ORDERS)[number][0];

export interface FleetQuery {
  readonly words: string;
  /** Empty for all. */
  readonly tag: string;
  readonly order: FleetOrder;
}

export interface FleetGroup {
  /** Empty for those that are in none. */
  readonly name: string;
  readonly rows: readonly SiteSummary[];
}

export function isFleetOrder(text: string): text is FleetOrder {
  return FLEET_ORDERS.some(([order]) => order === text);
}

/** Every tag that some site has, in the order of the alphabet. */
export function tagsOf(rows: readonly SiteSummary[]): string[] {
  return [...new Set(rows.flatMap(({ tags }) => tags))].sort((a, b) => byName.compare(a, b));
}

/** Those that fit, under their groups by name; the ones in no group come last. */
export function fleetGroups(rows: readonly SiteSummary[], query: FleetQuery, troubles: ReadonlyMap<string, SiteTrouble>): FleetGroup[] {
  const words = foldedText(query.words).split(/\s+/).filter(Boolean);
  const fitting = rows.filter((row) => (query.tag === "" || row.tags.includes(query.tag)) && fitsWords(row, words));
  const sorted = fitting.sort((a, b) => compareRows(a, b, query.order, troubles) || byName.compare(a.name, b.name) || byName.compare(a.site, b.site));
  const groups = new Map<string, SiteSummary[]>();
  for (const row of sorted) {
    const group = groups.get(row.group);
    if (group === undefined) groups.set(row.group, [row]);
    else group.push(row);
  }
  return [...groups].map(([name, found]) => ({ name, rows: found })).sort((a, b) => Number(a.name === "") - Number(b.name === "") || byName.compare(a.name, b.name));
}

function fitsWords(row: SiteSummary, words: readonly string[]): boolean {
  if (words.length === 0) return true;
  const text = foldedText([row.name, row.site, row.group, row.state, row.driver, row.online ? "online" : "offline", ...row.tags].join(" "));
  return words.every((word) => text.includes(word));
}

function compareRows(a: SiteSummary, b: SiteSummary, order: FleetOrder, troubles: ReadonlyMap<string, SiteTrouble>): number {
  switch (order) {
    case "trouble":
      return troubleRank(b, troubles) - troubleRank(a, troubles);
    case "battery":
      // What is not known is no emptier than what is.
      return (a.battery ?? Number.POSITIVE_INFINITY) - (b.battery ?? Number.POSITIVE_INFINITY) || 0;
    case "heard":
      return heardUs(b) - heardUs(a) || 0;
    case "name":
      return 0;
  }
}

const heardUs = (row: SiteSummary): number => (row.online ? Number.POSITIVE_INFINITY : row.last_seen_us);

function troubleRank(row: SiteSummary, troubles: ReadonlyMap<string, SiteTrouble>): number {
  const { bad, warn } = troubles.get(row.site) ?? NO_TROUBLE;
  if (bad > 0) return 3;
  if (!row.online) return 2;
  return warn > 0 ? 1 : 0;
}
