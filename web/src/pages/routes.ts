/** Every page: the tag that draws it, what it is called, and how its code is fetched. */

import type { PageName } from "../state/router.js";

export interface PageEntry {
  readonly tag: string;
  readonly title: string;
  readonly load: () => Promise<unknown>;
}

export const PAGES: Readonly<Record<PageName, PageEntry>> = {
  login: { tag: "t-page-sign-in", title: "Sign in", load: () => import("./sign-in/page-sign-in.js") },
  setup: { tag: "t-page-setup", title: "Set up", load: () => import("./setup/page-setup.js") },
  home: { tag: "t-page-home", title: "Home", load: () => import("./home/page-home.js") },
  live: { tag: "t-page-live", title: "Real-time", load: () => import("./live/page-live.js") },
  history: { tag: "t-page-history", title: "History", load: () => import("./history/page-history.js") },
  drive: { tag: "t-page-drive", title: "Actuate", load: () => import("./drive/page-drive.js") },
  gallery: { tag: "t-page-gallery", title: "Gallery", load: () => import("./gallery/page-gallery.js") },
  missing: { tag: "t-page-missing", title: "Not found", load: () => import("./missing/page-missing.js") },
};

/** A page that can be opened by anyone, signed in or not. */
export function isOpen(page: PageName): boolean {
  return page === "login" || page === "setup" || page === "gallery";
}
