/** Which lines of a robot's log are shown, as the page's address and as the hub's question. Pure. */

import { queryTexts, textsQuery } from "../../format/filter-query.js";

export interface LogFilter {
  /** Each of its words stands in the line or in the node's name. */
  readonly text: string;
  /** The node's whole name; empty for all. */
  readonly node: string;
  /** From this level on, as ROS 2 counts them; empty for all. */
  readonly level: string;
  /** µs; null for no limit. */
  readonly fromUs: number | null;
  readonly toUs: number | null;
}

export const FILTER_KEYS = ["text", "node", "level"] as const;
export const NO_FILTER: LogFilter = { text: "", node: "", level: "", fromUs: null, toUs: null };
/** Lines of a page that is asked for. */
const PAGE = 100;
const LATEST_US = 2 ** 53;

export function readLogFilter(search: string): LogFilter {
  const asked = new URLSearchParams(search);
  const texts = queryTexts(asked, FILTER_KEYS);
  const readTime = (key: string): number | null => {
    const text = asked.get(key) ?? "";
    const us = text === "" ? Number.NaN : Number(text);
    return Number.isFinite(us) && us >= 0 && us <= LATEST_US ? Math.round(us) : null;
  };
  // What is no level would be refused by the hub.
  return { ...texts, level: /^\d{1,2}$/.test(texts.level) ? texts.level : "", fromUs: readTime("from"), toUs: readTime("to") };
}

/** For the address; empty for all. */
export function writeLogFilter(filter: LogFilter): string {
  const asked = textsQuery(filter, FILTER_KEYS);
  if (filter.fromUs !== null) asked.set("from", String(filter.fromUs));
  if (filter.toUs !== null) asked.set("to", String(filter.toUs));
  return asked.toString();
}

/** The hub's question for the lines behind a place; null: for the newest. */
export function logPageQuery(filter: LogFilter, before: string | null): string {
  const asked = textsQuery(filter, FILTER_KEYS);
  if (filter.fromUs !== null) asked.set("from_us", String(filter.fromUs));
  if (filter.toUs !== null) asked.set("to_us", String(filter.toUs));
  if (before !== null) asked.set("before", before);
  asked.set("limit", String(PAGE));
  return asked.toString();
}

/** Newer lines than those that are shown can fit: no end is set, or it is still to come. */
export function canGrow({ toUs }: LogFilter, nowUs: number): boolean {
  return toUs === null || toUs > nowUs;
}
