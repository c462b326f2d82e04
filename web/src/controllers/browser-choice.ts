/** Small choices that a browser remembers: how a page is arranged, never anything of a robot. */

type ChoiceStorage = Pick<Storage, "getItem" | "setItem">;

/** What was chosen before, if it is still one of the options; else the first of them. */
export function readBrowserChoice<T extends string>(key: string, options: readonly [T, ...T[]], storage = browserStorage()): T {
  const kept = storage?.getItem(key);
  return options.find((option) => option === kept) ?? options[0];
}

export function saveBrowserChoice(key: string, choice: string, storage = browserStorage()): void {
  try {
    storage?.setItem(key, choice);
  } catch {
    // A full or forbidden storage: it is chosen for this page only.
  }
}

/** A browser that forbids storage throws at the mere mention of it. */
function browserStorage(): ChoiceStorage | null {
  try {
    return globalThis.localStorage;
  } catch {
    return null;
  }
}
