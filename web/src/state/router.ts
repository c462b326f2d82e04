/** Where in the dashboard we are: the address bar as a value. */

import { Store } from "./store.js";

export type PageName =
  | "login"
  | "logout"
  | "display"
  | "oidc"
  | "setup"
  | "home"
  | "fleet"
  | "map"
  | "devices"
  | "public"
  | "boards"
  | "board"
  | "account"
  | "live"
  | "topics"
  | "anomalies"
  | "cause"
  | "scene"
  | "history"
  | "recordings"
  | "missions"
  | "drive"
  | "alarms"
  | "logbook"
  | "log"
  | "sightings"
  | "notes"
  | "zones"
  | "review"
  | "device"
  | "archive"
  | "cameras"
  | "night"
  | "forecast"
  | "requests"
  | "proposals"
  | "alertrules"
  | "people"
  | "roles"
  | "gateways"
  | "clients"
  | "storage"
  | "support"
  | "ways"
  | "audit"
  | "description"
  | "gallery"
  | "missing";

export interface Route {
  readonly page: PageName;
  /** Site id; empty on pages that have none. */
  readonly site: string;
  /** Device id; empty but on a device's page. */
  readonly device: string;
}

/** What is planned for a night; these pages belong to `night`. */
const PLANNING_PAGES = ["forecast", "requests", "proposals", "alertrules"] as const satisfies readonly PageName[];
const SITE_PAGES = [
  "live", "topics", "anomalies", "cause", "scene", "history", "recordings", "missions", "drive", "archive", "cameras",
  "logbook", "log", "notes", "sightings", "zones", "review", "night", ...PLANNING_PAGES,
] as const satisfies readonly PageName[];

/** A page that each site has at an address of its own. */
export type SitePageName = (typeof SITE_PAGES)[number];
const PLAIN: Readonly<Record<string, PageName>> = {
  "/": "home",
  "/home": "home",
  "/login": "login",
  "/logout": "logout",
  "/display": "display",
  "/oidc": "oidc",
  "/setup": "setup",
  "/map": "map",
  "/fleet": "fleet",
  "/devices": "devices",
  "/public": "public",
  "/boards": "boards",
  "/account": "account",
  "/alarms": "alarms",
  "/admin/ways": "ways",
  "/admin": "people",
  "/admin/people": "people",
  "/admin/roles": "roles",
  "/admin/gateways": "gateways",
  "/admin/clients": "clients",
  "/admin/storage": "storage",
  "/admin/audit": "audit",
  "/admin/support": "support",
  "/admin/description": "description",
  "/gallery": "gallery",
};

/** The pages that only an admin of the whole hub may open. */
export const ADMIN_PAGES: readonly PageName[] = ["people", "roles", "gateways", "clients", "ways", "storage", "description", "audit", "support"];

/** Reads a path. Anything unknown is the `missing` page, not an error. */
export function routeOf(path: string): Route {
  const plain = PLAIN[path.length > 1 ? path.replace(/\/$/, "") : path];
  if (plain !== undefined) return { page: plain, site: "", device: "" };
  if (boardKeyOf(path) !== "") return { page: "board", site: "", device: "" };
  const match = /^\/sites\/([^/]+)\/([a-z]+)(?:\/([^/]+))?\/?$/.exec(path);
  const site = decodedPart(match?.[1] ?? "");
  const device = decodedPart(match?.[3] ?? "");
  if (site !== "" && device !== "" && match?.[2] === "devices") return { page: "device", site, device };
  const page = match?.[3] === undefined ? SITE_PAGES.find((name) => name === match?.[2]) : undefined;
  return page === undefined || site === "" ? { page: "missing", site: "", device: "" } : { page, site, device: "" };
}

/** How the key of a board that is made of a description begins; behind it is the site, and the device where it is for one. */
export const TEMPLATE_KEY = "template:";

/** The path of the board that is made of a site's description. */
export function templatePath(site: string): string {
  return boardPath(`${TEMPLATE_KEY}${site}`);
}

/** The path of a board. */
export function boardPath(key: string): string {
  return `/boards/${encodeURIComponent(key)}`;
}

/** The key of the board that a path is of; empty where it is of none. */
export function boardKeyOf(path: string): string {
  const match = /^\/boards\/([^/?]+)\/?(?:\?|$)/.exec(path);
  return decodedPart(match?.[1] ?? "");
}

/** The path of a site's page. */
export function sitePath(site: string, page: SitePageName): string {
  return `/sites/${encodeURIComponent(site)}/${page}`;
}

/** Whether a page is one of those of a night's planning. */
export function isPlanningPage(page: PageName): boolean {
  return PLANNING_PAGES.some((name) => name === page);
}

/** The page of another site to go to from a page: the same, or its first one. */
export function pageAtOtherSite(page: PageName): SitePageName {
  // Planning is of observatories only.
  return (isPlanningPage(page) ? undefined : SITE_PAGES.find((name) => name === page)) ?? "live";
}

/**
 * The path of a site's raw topics at one of them.
 *
 * @param signal the field that is to become a signal there; empty for none
 */
export function topicPagePath(site: string, topic: string, signal = ""): string {
  return `${sitePath(site, "topics")}?${new URLSearchParams({ topic, ...(signal === "" ? {} : { signal }) }).toString()}`;
}

/** A path with a query behind it, if there is one. */
export function withQuery(path: string, query: string): string {
  return query === "" ? path : `${path}?${query}`;
}

/** The path of the pictures that one camera took. */
export function archivePath(site: string, device: string): string {
  return `${sitePath(site, "archive")}?device=${encodeURIComponent(device)}`;
}

/** The path of the page of alarms at one of them. */
export function alarmPath(alarm: { readonly site: string; readonly alarm: string }): string {
  return `/alarms?alarm=${encodeURIComponent(alarm.site)}/${encodeURIComponent(alarm.alarm)}`;
}

/** The path of a device's own page. */
export function devicePath(site: string, device: string): string {
  return `/sites/${encodeURIComponent(site)}/devices/${encodeURIComponent(device)}`;
}

/** The path of the page on which a camera's zones and lines are drawn. */
export function zonesPath(site: string, camera: string): string {
  return `${sitePath(site, "zones")}?${new URLSearchParams({ camera }).toString().replaceAll("%2F", "/")}`;
}

/** Where to go after signing in. Only a path on this very hub is believed. */
export function returnPath(search: string, origin: string): string {
  const asked = new URLSearchParams(search).get("return") ?? "";
  if (!asked.startsWith("/") || !URL.canParse(asked, origin)) return "/home";
  const url = new URL(asked, origin);
  if (url.origin !== origin || isSignInPage(routeOf(url.pathname).page)) return "/home";
  return url.pathname + url.search;
}

function isSignInPage(page: PageName): boolean {
  return page === "login" || page === "logout";
}

/** Path of an address when it is a page of ours; null when the browser should load it by itself. */
export function localPath(href: string, origin: string): string | null {
  if (!URL.canParse(href)) return null;
  const url = new URL(href);
  const ours = url.origin === origin && !/^\/(api|assets|ws)\b/.test(url.pathname);
  return ours ? url.pathname + url.search : null;
}

function decodedPart(text: string): string {
  try {
    return decodeURIComponent(text);
  } catch {
    return "";
  }
}

/** What the router needs of a window. */
export interface BrowserAddress {
  readonly location: { readonly pathname: string; readonly search: string; readonly hash: string; readonly origin: string };
  readonly history: Pick<History, "pushState" | "replaceState">;
  addEventListener(type: "popstate", listener: () => void): void;
}

export class Router extends Store {
  constructor(private readonly address: BrowserAddress) {
    super();
    address.addEventListener("popstate", () => {
      this.notifyWatchers();
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

  navigate(path: string): void {
    if (path === this.path) return;
    this.address.history.pushState(null, "", path);
    this.notifyWatchers();
  }

  /** Like `go`, but the way back does not lead here. */
  replace(path: string): void {
    this.address.history.replaceState(null, "", path);
    this.notifyWatchers();
  }
}
