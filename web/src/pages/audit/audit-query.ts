/** What of the audit log is asked for, as the page's address and as the hub's question. Pure. */

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

const WORDS = ["who", "site", "device", "kind"] as const;

/** Reads the page's address; what makes no sense is as if it were not there. */
export function readAuditFilter(search: string): AuditFilter {
  const asked = new URLSearchParams(search);
  const text = (key: string): string => asked.get(key) ?? "";
  const good = text("good");
  return {
    who: text("who"),
    site: text("site"),
    device: text("device"),
    kind: text("kind"),
    good: good === "true" || good === "false" ? good : "",
    fromUs: microseconds(text("from_us")),
    toUs: microseconds(text("to_us")),
  };
}

/** The filter as a query, for the address and for the hub alike; empty for all. */
export function writeAuditFilter(filter: AuditFilter): string {
  const asked = new URLSearchParams();
  for (const key of WORDS) if (filter[key] !== "") asked.set(key, filter[key]);
  if (filter.good !== "") asked.set("good", filter.good);
  if (!Number.isNaN(filter.fromUs)) asked.set("from_us", String(Math.round(filter.fromUs)));
  if (!Number.isNaN(filter.toUs)) asked.set("to_us", String(Math.round(filter.toUs)));
  return asked.toString();
}

/** The hub's question for one page of rows. `before` is the last row of the page before; empty for the newest. */
export function auditPageQuery(filter: AuditFilter, before: string, limit: number): string {
  const asked = new URLSearchParams(writeAuditFilter(filter));
  if (before !== "") asked.set("before", before);
  asked.set("limit", String(limit));
  return asked.toString();
}

function microseconds(text: string): number {
  return /^\d{1,16}$/.test(text) ? Number(text) : Number.NaN;
}
