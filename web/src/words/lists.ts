/** Lists in words, as the page's language writes them. */

import { intlLocale } from "./locale.js";

/** `a`, `a or b`, `a, b or c`. */
export function eitherText(names: readonly string[]): string {
  return new Intl.ListFormat(intlLocale(), { type: "disjunction" }).format(names);
}

/** `a`, `a and b`, `a, b and c`. */
export function togetherText(names: readonly string[]): string {
  return new Intl.ListFormat(intlLocale(), { type: "conjunction" }).format(names);
}
