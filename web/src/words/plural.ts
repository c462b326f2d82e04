/** One of two texts by a number, as the language has it. */

import { shownLanguage } from "./locale.js";

/** Between the forms of a translated text. */
const BETWEEN = "||";
const ORDER = ["zero", "one", "two", "few", "many", "other"] as const;

/**
 * The text for a number: `one` for exactly 1, else `other`.
 *
 * A translation of `other` may have several forms with `||` between them: one for each kind of
 * number that its language tells apart, in the order zero, one, two, few, many, other, as far as
 * it has them. Russian has four, French three; one form alone is for all numbers.
 */
export function plural<T>(many: number, one: T, other: T): T {
  if (many === 1) return one;
  if (typeof other !== "string" || !other.includes(BETWEEN)) return other;
  const forms = other.split(BETWEEN);
  const rules = new Intl.PluralRules(shownLanguage());
  const own = ORDER.filter((kind) => rules.resolvedOptions().pluralCategories.includes(kind));
  return (forms[own.indexOf(rules.select(many))] ?? forms.at(-1) ?? other) as T;
}
