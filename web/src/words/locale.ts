/** In which language the page is, and so how words, numbers, dates and times are written: the one place that decides it. */

/** The language that the code is written in. */
export const ENGLISH = "en";

let shown = ENGLISH;

/** Called once, before anything is written. */
export function useLanguage(code: string): void {
  shown = code;
}

/** The code of the page's language: `en`, `ca`, `pt-BR`. */
export function shownLanguage(): string {
  return shown;
}

/** What `Intl` is asked with. English is written as in Europe: day before month, 24 hours. */
export function intlLocale(): string {
  return shown === ENGLISH ? "en-GB" : shown;
}
