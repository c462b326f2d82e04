/** Where in the dashboard we are: the address bar as a value. */

import { Store } from "./store.js";

export type PageName = "login" | "setup" | "home" | "live" | "history" | "drive" | "gallery" | "missing";

export interface Route {
  readonly page: PageName;
  /** Site id; empty on pages that have none. */
  readonly site: string;
}

const SITE_PAGES: readonly PageName[] = ["live", "history", "drive"];
const PLAIN: Readonly<Record<string, PageName>> = {
  "/": "home",
  "/home": "home",
  "/login": "login",
  "/setup": "setup",
  "/gallery": "gallery",
};

/** Reads a path. Anything unknown is the `missing` page, not an error. */
export function routeOf(path: string): Route {
  const plain = PLAIN[path.length > 1 ? path.replace(/\/$/, "") : path];
  if (plain !== undefined) return { page: plain, site: "" };
  const match = /^\/sites\/([^/]+)\/([a-z]+)\/?$/.exec(path);
  const page = SITE_PAGES.find((name) => name === match?.[2]);
  const site = decoded(match?.[1] ?? "");
  return page === undefined || site === "" ? { page: "missing", site: "" } : { page, site };
}

/** The path of a site's page. */
export function sitePath(site: string, page: "live" | "history" | "drive"): string {
  return `/sites/${encodeURIComponent(site)}/${page}`;
}

/** Where to go after signing in. Only a path on this very hub is believed. */
export function returnPath(search: string, origin: string): string {
  const asked = new URLSearchParams(search).get("return") ?? "";
  if (!asked.startsWith("/") || !URL.canParse(asked, origin)) return "/home";
  const url = new URL(asked, origin);
  if (url.origin !== origin || routeOf(url.pathname).page === "login") return "/home";
  return url.pathname + url.search;
}

/** Path of an address when it is a page of ours; null when the browser should load it by itself. */
export function localPath(href: string, origin: string): string | null {
  if (!URL.canParse(href)) return null;
  const url = new URL(href);
  const ours = url.origin === origin && !/^\/(api|assets|ws)\b/.test(url.pathname);
  return ours ? url.pathname + url.search : null;
}

function decoded(text: string): string {
  try {
    return decodeURIComponent(text);
  } catch {
    return "";
  }
}

/** What the router needs of a window. */
export interface Address {
  readonly location: { readonly pathname: string; readonly search: string; readonly hash: string; readonly origin: string };
  readonly history: Pick<History, "pushState" | "replaceState">;
  addEventListener(type: "popstate", listener: () => void): void;
}

export class Router extends Store {
  constructor(private readonly address: Address) {
    super();
    address.addEventListener("popstate", () => {
      this.changed();
    });
  }

  get route(): Route {
    return routeOf(this.address.location.pathname);
  }

  get path(): string {
    return this.address.location.pathname + this.address.location.search;
  }

  get search(): string {
    return this.address.location.search;
  }

  get hash(): string {
    return this.address.location.hash;
  }

  get origin(): string {
    return this.address.location.origin;
  }

  go(path: string): void {
    if (path === this.path) return;
    this.address.history.pushState(null, "", path);
    this.changed();
  }

  /** Like `go`, but the way back does not lead here. */
  replace(path: string): void {
    this.address.history.replaceState(null, "", path);
    this.changed();
  }
}
