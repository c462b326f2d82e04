/** Light, dark, or red for the eyes of an observer at night. */

import { Store } from "./store.js";

export const THEMES = ["auto", "light", "dark", "night"] as const;
export type Theme = (typeof THEMES)[number];

const KEY = "talaia.theme";

export class ThemeChoice extends Store {
  private choice: Theme;

  constructor(
    private readonly root: { setAttribute(name: string, value: string): void; removeAttribute(name: string): void },
    private readonly storage: Pick<Storage, "getItem" | "setItem"> | null,
  ) {
    super();
    this.choice = THEMES.find((theme) => theme === storage?.getItem(KEY)) ?? "auto";
    this.applyTheme();
  }

  get theme(): Theme {
    return this.choice;
  }

  setTheme(theme: Theme): void {
    this.choice = theme;
    this.storage?.setItem(KEY, theme);
    this.applyTheme();
    this.notifyWatchers();
  }

  private applyTheme(): void {
    if (this.choice === "auto") this.root.removeAttribute("data-theme");
    else this.root.setAttribute("data-theme", this.choice);
  }
}
