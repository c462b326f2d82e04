/**
 * A language that nobody speaks, for tests: whatever is not in the catalogue stands out in it, and what has no room.
 *
 *     node catalogue/pseudo.mjs     the module of all its texts, in place of a real language's, on standard output
 *
 * It is no part of any build: a test gives it to its browser instead of the words of another language.
 */

import { compileCatalogue } from "./compile.mjs";
import { languages, plainText, readCatalogue } from "./xliff.mjs";

/** Texts grow so much from English to other languages: by a third of their letters. */
const LONGER = 0.3;
const ACCENTS = { a: "á", e: "é", i: "í", o: "ó", u: "ú", y: "ý", A: "Á", E: "É", I: "Í", O: "Ó", U: "Ú", Y: "Ý" };

/** Each text in brackets, with an accent on each vowel, and longer. */
export function pseudoUnits(units) {
  return units.map((unit) => ({ ...unit, target: ["⟦", ...unit.source.map((part) => (typeof part === "string" ? accented(part) : part)), padding(unit.source), "⟧"] }));
}

function accented(text) {
  return text.replace(/[aeiouy]/gi, (letter) => ACCENTS[letter] ?? letter);
}

/** Words of accented letters, so that lines break within it as within any text. */
function padding(source) {
  const letters = Math.ceil(plainText(source).replace(/\{\d+\}/g, "").length * LONGER);
  return letters < 2 ? "" : ` ${"ééé ".repeat(Math.ceil(letters / 4)).slice(0, letters - 1).trim()}`;
}

// Self-made tags: the module stands alone, and is served under the address of another.
const TAGS = 'const html = (strings, ...values) => ({ "_$litType$": 1, strings, values });\nconst str = (strings, ...values) => ({ strTag: true, strings, values });\n';

/** The module, with its own two tags in place of those that it imports. */
export function pseudoModule() {
  return TAGS + compileCatalogue(pseudoUnits(readCatalogue(languages()[0]))).replace(/^import .*\n/gm, "");
}

if (process.argv[1]?.endsWith("pseudo.mjs")) process.stdout.write(pseudoModule());
