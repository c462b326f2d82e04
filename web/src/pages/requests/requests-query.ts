/** Which requests are shown, as the page's address and as the hub's question. Pure. */

import type { RequestState } from "../../generated/api.js";
import { REQUEST_WORDS } from "../../format/observing-words.js";
import { pageQuery, queryTexts, textsQuery } from "../../format/filter-query.js";

export interface RequestsFilter {
  readonly text: string;
  readonly proposal: string;
  readonly state: string;
  /** Only those that the person asked for. */
  readonly mine: boolean;
  /** Only those that wait to be approved. */
  readonly waiting: boolean;
}

export const FILTER_KEYS = ["text", "proposal", "state"] as const;
export const NO_FILTER: RequestsFilter = { text: "", proposal: "", state: "", mine: false, waiting: false };
export const STATES = Object.keys(REQUEST_WORDS) as readonly RequestState[];

/** A state that there is not counts as none: the hub would refuse it. */
export function readRequestsFilter(search: string): RequestsFilter {
  const asked = new URLSearchParams(search);
  const texts = queryTexts(asked, FILTER_KEYS);
  const state = STATES.find((known) => known === texts.state) ?? "";
  return { ...texts, state, mine: asked.get("mine") === "true", waiting: asked.get("waiting") === "true" };
}

export function writeRequestsFilter(filter: RequestsFilter): string {
  const asked = textsQuery(filter, FILTER_KEYS);
  if (filter.mine) asked.set("mine", "true");
  if (filter.waiting) asked.set("waiting", "true");
  return asked.toString();
}

export function requestsPageQuery(filter: RequestsFilter, before: string, limit: number): string {
  return pageQuery(writeRequestsFilter(filter), before, limit);
}
