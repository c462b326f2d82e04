/** What a new password has to be, as rules that one can see kept or not; never a score. */

import { msg, str } from "@lit/localize";

export interface PasswordRule {
  readonly words: string;
  readonly kept: boolean;
  /** It has to be kept; the others are advice. */
  readonly must: boolean;
}

const SHORTEST = 8;
const ADVISED = 15;

/**
 * @param name whose password it is
 * @param again the password, typed once more
 */
export function passwordRules(password: string, name: string, again: string): readonly PasswordRule[] {
  // People count characters, not the pieces that an emoji is made of.
  const length = Array.from(password).length;
  const plain = password.toLowerCase();
  return [
    { words: msg(str`${String(SHORTEST)} characters or more`), kept: length >= SHORTEST, must: true },
    { words: msg("Not your name"), kept: length > 0 && plain !== name.trim().toLowerCase(), must: true },
    { words: msg("The same, typed twice"), kept: length > 0 && again === password, must: true },
    { words: msg(str`${String(ADVISED)} characters or more: a sentence is easy to keep in mind`), kept: length >= ADVISED, must: false },
  ];
}

/** What stands in the way; empty when nothing that can be told without the hub. */
export function passwordProblem(rules: readonly PasswordRule[]): string {
  const broken = rules.find(({ kept, must }) => must && !kept);
  return broken === undefined ? "" : msg(str`It has to be: ${broken.words.charAt(0).toLowerCase()}${broken.words.slice(1)}.`);
}
