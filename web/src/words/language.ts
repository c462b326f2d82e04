/** The language of the pages: what was chosen in this browser, or what the browser speaks. */

import { configureLocalization } from "@lit/localize";
import { catalogues } from "virtual:catalogues";
import { learnSentences } from "./hub-text.js";
import { ENGLISH, shownLanguage, useLanguage } from "./locale.js";

type Messages = Awaited<ReturnType<(typeof catalogues)[string]["first"]>>["templates"];

const KEY = "talaia.language";

/** The languages that there are: their codes. */
export const LANGUAGES: readonly string[] = [ENGLISH, ...Object.keys(catalogues).sort()];

/** What a language calls itself, with a capital letter as in a list. */
export function languageName(code: string): string {
  const name = new Intl.DisplayNames([code], { type: "language" }).of(code) ?? code;
  return name.charAt(0).toLocaleUpperCase(code) + name.slice(1);
}

/**
 * The language to begin with: what was chosen, if it is there still, else the first of the browser's
 * languages that is there, whatever country it names.
 */
export function languageFor(chosen: string | null, spoken: readonly string[], there: readonly string[] = LANGUAGES): string {
  const found = [chosen ?? "", ...spoken].flatMap((code) => {
    const wanted = code.toLowerCase();
    const find = (name: string | undefined): string | undefined => there.find((language) => language.toLowerCase() === name);
    return find(wanted) ?? find(wanted.split("-")[0]) ?? [];
  });
  return found[0] ?? ENGLISH;
}

let rest: Promise<unknown> = Promise.resolve();

/**
 * Gets the words of the first pages, and begins to get all others.
 *
 * Called before any page is imported: they have words in constants, too. Without the words, as when
 * the hub cannot be reached, the pages are in English.
 */
export async function startLanguage(): Promise<void> {
  const code = languageFor(chosenLanguage(), navigator.languages);
  const catalogue = catalogues[code];
  if (catalogue === undefined) return;
  // One object, so that words that come later are found without another look at the language.
  const templates: Record<string, Messages[string]> = {};
  const { setLocale } = configureLocalization({ sourceLocale: ENGLISH, targetLocales: [code], loadLocale: () => Promise.resolve({ templates }) });
  try {
    Object.assign(templates, (await catalogue.first()).templates);
    await setLocale(code);
  } catch {
    return;
  }
  useLanguage(code);
  document.documentElement.lang = code;
  rest = catalogue.rest().then(
    async (words) => {
      Object.assign(templates, words.templates);
      learnSentences((await import("../generated/hub-sentences.js")).SENTENCES);
    },
    () => undefined,
  );
}

/** Until the words of all pages are there; a page that is not among the first is imported after it. */
export async function allWords(): Promise<void> {
  await rest;
}

/** Shows the pages in another language: they are loaded anew. */
export function chooseLanguage(code: string): void {
  if (code === shownLanguage()) return;
  try {
    localStorage.setItem(KEY, code);
  } catch {
    // A browser that keeps nothing: it stays as the browser speaks.
  }
  location.reload();
}

function chosenLanguage(): string | null {
  try {
    return localStorage.getItem(KEY);
  } catch {
    return null;
  }
}
