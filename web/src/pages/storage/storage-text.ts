/** What the forecast says, in sentences. */

import { msg, str } from "@lit/localize";
import { formatBytes } from "../../format/bytes.js";
import { fixedText } from "../../format/number.js";
import { plural } from "../../words/plural.js";
import { formatDate } from "../../format/time.js";
import type { OutlookShape, StorageShape } from "../../generated/api.js";

const YEAR_DAYS = 365.25;
const LONG_DAYS = 730;

/** `12 days`, `3.1 years`. */
export function durationText(days: number): string {
  if (days >= LONG_DAYS) return msg(str`${fixedText(days / YEAR_DAYS, 1)} years`);
  const hours = Math.max(1, Math.round(days * 24));
  if (days < 2) return plural(hours, msg("1 hour"), msg(str`${String(hours)} hours`));
  return msg(str`${String(Math.round(days))} days`);
}

/** How long a signal is kept; 0 is for good. */
export function keepText(days: number): string {
  if (days === 0) return msg("for good");
  const shown = Number(days.toFixed(2));
  return plural(shown, msg(str`${String(shown)} day`), msg(str`${String(shown)} days`));
}

/** When the room is used up, and what is kept then. */
export function forecastText(use: StorageShape, zone: string): string {
  const { full_us: full, limit_bytes: limit, oldest_us: oldest, kept_days: kept } = use;
  if (use.blocks_bytes === 0) return msg("How fast it grows is known once the first samples are put together in blocks.");
  if (use.day_bytes === 0) return msg("Nothing came in the last week, so nothing fills up.");
  if (full === null) {
    if (use.free_bytes === null && limit === 0) return msg("The disk of the database server is not the hub's to see: watch it there, or set a limit.");
    return msg("At the last week's rate there is room for a hundred years and more.");
  }
  const then = oldest === null ? "" : msg(str` The oldest sample is of ${formatDate(oldest, zone)} then.`);
  if (!use.by_limit) {
    return msg(str`At the last week's rate the disk is full on ${formatDate(full, zone)}.${then} On a full disk nothing is stored until there is room: set a limit in time.`);
  }
  const long = kept === null ? "" : msg(str` About ${durationText(kept)} are kept at this rate.`);
  if (use.blocks_bytes >= limit) return msg(str`The limit of ${formatBytes(limit)} is reached: the oldest samples go as new ones come.${long}`);
  return msg(str`At the last week's rate the limit of ${formatBytes(limit)} is reached on ${formatDate(full, zone)}.${then} From then on the oldest go.${long}`);
}

export interface StorageWarningText {
  readonly kind: "info" | "warn" | "bad";
  readonly text: string;
}

/** What an admin is told on every page; null while there is nothing to tell. */
export function warningOf({ trouble, files_trouble: files, warn, full_us: full, free_bytes: free }: OutlookShape, zone: string): StorageWarningText | null {
  if (trouble !== "") return { kind: "bad", text: msg(str`The hub cannot store samples now (${trouble}). Gateways keep theirs until it can.`) };
  if (files !== "") return { kind: "bad", text: msg(str`Recordings and pictures cannot be stored or shown now: ${files}. Gateways keep theirs until they can.`) };
  const left = free === null ? "" : msg(str` Only ${formatBytes(free)} are free.`);
  const day = full === null ? "" : formatDate(full, zone);
  switch (warn) {
    case "full":
      return { kind: "bad", text: msg(str`The hub's disk is nearly full.${left} On a full disk nothing is stored.`) };
    case "soon":
      return { kind: "warn", text: msg(str`At the last week's rate the hub's disk is full on ${day}.`) };
    case "limit":
      return { kind: "info", text: msg(str`The history reaches its limit on ${day}; from then on the oldest samples go.`) };
    case "":
      return null;
  }
}
