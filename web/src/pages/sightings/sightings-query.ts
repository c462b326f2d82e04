/** Which sightings are shown, as the page's address and as the hub's question. Pure. */

import { pageQuery, queryTexts, textsQuery } from "../../format/filter-query.js";
import { countText } from "../../format/object-names.js";
import type { SightingUpdate } from "../../generated/wire.js";
import type { SeenShape, SiteShape } from "../../generated/api.js";

export interface SightingFilter {
  /** What was looked for, as it was typed. */
  readonly what: string;
  /** The stream, `device/stream`; empty for all. */
  readonly camera: string;
  /** µs; null for no limit. */
  readonly fromUs: number | null;
  readonly toUs: number | null;
  /** Only what is visible now. */
  readonly open: boolean;
}

export const FILTER_KEYS = ["what", "camera"] as const;
export const NO_FILTER: SightingFilter = { what: "", camera: "", fromUs: null, toUs: null, open: false };
const LATEST_US = 2 ** 53;
/** Before and behind a sighting, so much is shown of the history (µs). */
const AROUND_US = 60e6;

export function readSightingFilter(search: string): SightingFilter {
  const asked = new URLSearchParams(search);
  const readTime = (key: string): number | null => {
    const us = Number(asked.get(key) ?? Number.NaN);
    return asked.get(key) !== "" && Number.isFinite(us) && us >= 0 && us <= LATEST_US ? Math.round(us) : null;
  };
  return { ...queryTexts(asked, FILTER_KEYS), fromUs: readTime("from"), toUs: readTime("to"), open: asked.get("open") === "true" };
}

/** For the address; empty for all. */
export function writeSightingFilter(filter: SightingFilter): string {
  const asked = textsQuery(filter, FILTER_KEYS);
  if (filter.fromUs !== null) asked.set("from", String(filter.fromUs));
  if (filter.toUs !== null) asked.set("to", String(filter.toUs));
  if (filter.open) asked.set("open", "true");
  return asked.toString();
}

/** The class that was meant: `Persons`, `pers` and `person` are one, where no other begins so. */
export function matchingLabel(what: string, labels: readonly string[]): string {
  const word = what.trim().toLowerCase();
  if (word === "") return "";
  const exact = labels.find((label) => label.toLowerCase() === word || countText(2, label.toLowerCase()) === `2 ${word}`);
  if (exact !== undefined) return exact;
  const near = labels.filter((label) => label.toLowerCase().includes(word));
  return near.length === 1 ? (near[0] ?? word) : word;
}

/** The hub's question for the page behind `before`; empty for the newest. */
export function sightingsPageQuery(filter: SightingFilter, labels: readonly string[], before: string, limit: number): string {
  const asked = new URLSearchParams();
  const label = matchingLabel(filter.what, labels);
  if (label !== "") asked.set("label", label);
  if (filter.camera !== "") asked.set("camera", filter.camera);
  if (filter.fromUs !== null) asked.set("from_us", String(filter.fromUs));
  if (filter.toUs !== null) asked.set("to_us", String(filter.toUs));
  if (filter.open) asked.set("open", "true");
  return pageQuery(asked, before, limit);
}

/** What the hub tells while it happens, put into a row that is shown; null where none is of it. */
export function withUpdate(rows: readonly SeenShape[], news: SightingUpdate): readonly SeenShape[] | null {
  const id = String(news.id);
  if (!rows.some((row) => row.id === id)) return null;
  const { many, confidence, began_us } = news;
  return rows.map((row) => (row.id === id ? { ...row, many, confidence, began_us, ended_us: news.ended_us === 0 ? null : news.ended_us } : row));
}

/** The history page's query for a sighting: around it, with the signal that counts such things. */
export function historyQuery(sighting: SeenShape, detail: SiteShape | undefined): string {
  const asked = new URLSearchParams();
  const address = `${sighting.camera}_${sighting.label.toLowerCase().replace(/[^a-z0-9]+/g, "_")}`;
  const signal = detail?.devices.flatMap(({ signals }) => signals).find((signal) => signal.address === address);
  for (const channel of signal?.channels.slice(0, 1) ?? []) asked.append("c", channel);
  asked.set("from", String(Math.round(sighting.began_us - AROUND_US)));
  asked.set("to", String(Math.round((sighting.ended_us ?? sighting.began_us) + AROUND_US)));
  // Films that are shown beside the charts begin there.
  asked.set("at", String(Math.round(sighting.began_us)));
  return asked.toString().replaceAll("%2F", "/");
}
