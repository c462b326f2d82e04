/** How a device stands, and whether a filter shows it. Pure. */

import { msg, str } from "@lit/localize";
import type { DeviceSummary } from "../../generated/api.js";

export type DeviceStatus = "online" | "stale" | "unreached" | "offline";

/**
 * Stale: its site is linked, and yet signals have not come for longer than they may.
 * @param away its gateway does not reach it
 */
export function deviceStatus(row: DeviceSummary, away = false): DeviceStatus {
  if (!row.online) return "offline";
  if (away) return "unreached";
  return row.stale > 0 ? "stale" : "online";
}

export const STANDING_WORDS: Readonly<Record<DeviceStatus, (row: DeviceSummary) => string>> = {
  online: () => msg("online"),
  stale: (row) => msg(str`${String(row.stale)} of ${String(row.signals)} stale`),
  unreached: () => msg("not reached"),
  offline: () => msg("offline"),
};

/** @param words all of them have to be found in the device's names, its kind, or its rights */
export function matchesSearch(row: DeviceSummary, words: string, chosen: DeviceStatus | "", away = false): boolean {
  if (chosen !== "" && deviceStatus(row, away) !== chosen) return false;
  const text = [row.name, row.device, row.site, row.site_name, row.kind, ...row.rights, row.public ? "public" : ""];
  const all = text.join(" ").toLowerCase();
  return words.toLowerCase().split(/\s+/).every((word) => all.includes(word));
}
