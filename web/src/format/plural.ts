/** One of two texts by a number, as the language has it. */

import { intlLocale } from "./locale.js";

/** Between the forms of a translated text, for languages that have more than one and many. */
const BETWEEN = "||";

let rules: Intl.PluralRules | null = null;

/**
 * The text for a number: `one` where the language writes it as it writes one, else `other`.
 *
 * A translation of `other` may have several forms with `||` between them, in the order few, many,
 * other; a language that has not all three has as many forms as it has of these.
 */
export function plural<T>(many: number, one: T, other: T): T {
  rules ??= new Intl.PluralRules(intlLocale());
  const kind = rules.select(many);
  if (kind === "one") return one;
  if (typeof other !== "string" || !other.includes(BETWEEN)) return other;
  const forms = other.split(BETWEEN);
  const kinds = rules.resolvedOptions().pluralCategories;
  const own = (["two", "few", "many", "other"] as const).filter((each) => kinds.includes(each));
  return (forms[own.indexOf(kind as (typeof own)[number])] ?? forms.at(-1) ?? other) as T;
}
