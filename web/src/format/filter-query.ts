/** What a page shows, as its form says it, as its address carries it and as the hub is asked for it. Pure. */

import { formText } from "./form-values.js";

/** The hub takes no longer words. */
const MOST_CHARACTERS = 200;

export type FilterTexts<K extends string> = Readonly<Record<K, string>>;

/** Texts of a form by the names of their fields. */
export function formTexts<K extends string>(said: FormData, keys: readonly K[]): FilterTexts<K> {
  return textsOf(keys, (key) => formText(said, key));
}

/** Texts of an address; empty where it says none. */
export function queryTexts<K extends string>(asked: URLSearchParams, keys: readonly K[]): FilterTexts<K> {
  return textsOf(keys, (key) => (asked.get(key) ?? "").slice(0, MOST_CHARACTERS));
}

/** The texts that say something, as a query. */
export function textsQuery<K extends string>(texts: FilterTexts<K>, keys: readonly K[]): URLSearchParams {
  return new URLSearchParams(keys.filter((key) => texts[key] !== "").map((key) => [key, texts[key]]));
}

/** Asks for one page of rows: those behind the row `before`, or the newest for an empty text. */
export function pageQuery(asked: URLSearchParams | string, before: string, limit: number): string {
  const page = new URLSearchParams(asked);
  if (before !== "") page.set("before", before);
  page.set("limit", String(limit));
  return page.toString();
}

function textsOf<K extends string>(keys: readonly K[], read: (key: K) => string): FilterTexts<K> {
  return Object.fromEntries(keys.map((key) => [key, read(key)])) as Record<K, string>;
}
