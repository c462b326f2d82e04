/** What of the audit log is asked for, as the page's address and as the hub's question. Pure. */

import { pageQuery, queryTexts, textsQuery } from "../../format/filter-query.js";

export interface AuditFilter {
  readonly who: string;
  readonly site: string;
  readonly device: string;
  /** Begin of the kind: `command` finds all about commands. */
  readonly kind: string;
  /** Empty for both. */
  readonly good: "" | "true" | "false";
  /** µs since the epoch, UTC; NaN for no limit. */
  readonly fromUs: number;
  readonly toUs: number;
}

export const NO_FILTER: AuditFilter = {
  who: "",
  site: "",
  device: "",
  kind: "",
  good: "",
  fromUs: Number.NaN,
  toUs: Number.NaN,
};

export const FILTER_KEYS = ["who", "site", "device", "kind"] as const;

/** Reads the page's address; what makes no sense is as if it were not there. */
export function readAuditFilter(search: string): AuditFilter {
  const asked = new URLSearchParams(search);
  const good = asked.get("good");
  return {
    ...queryTexts(asked, FILTER_KEYS),
    good: good === "true" || good === "false" ? good : "",
    fromUs: microseconds(asked.get("from_us") ?? ""),
    toUs: microseconds(asked.get("to_us") ?? ""),
  };
}

/** The filter as a query, for the address and for the hub alike; empty for all. */
export function writeAuditFilter(filter: AuditFilter): string {
  const asked = textsQuery(filter, FILTER_KEYS);
  if (filter.good !== "") asked.set("good", filter.good);
  if (!Number.isNaN(filter.fromUs)) asked.set("from_us", String(Math.round(filter.fromUs)));
  if (!Number.isNaN(filter.toUs)) asked.set("to_us", String(Math.round(filter.toUs)));
  return asked.toString();
}

/** The hub's question for one page of rows. `before` is the last row of the page before; empty for the newest. */
export function auditPageQuery(filter: AuditFilter, before: string, limit: number): string {
  return pageQuery(writeAuditFilter(filter), before, limit);
}

function microseconds(text: string): number {
  return /^\d{1,16}$/.test(text) ? Number(text) : Number.NaN;
}
