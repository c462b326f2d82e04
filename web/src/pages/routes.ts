/** Every page: the tag that draws it, what it is called, and how its code is fetched. */

import { seesOnlyPublic } from "../state/rights.js";
import { ADMIN_PAGES, type PageName } from "../state/router.js";
import type { Me } from "../generated/api.js";

export interface PageEntry {
  readonly tag: string;
  readonly title: string;
  readonly load: () => Promise<unknown>;
}

export const PAGES: Readonly<Record<PageName, PageEntry>> = {
  login: { tag: "t-page-sign-in", title: "Sign in", load: () => import("./sign-in/page-sign-in.js") },
  logout: { tag: "t-page-logout", title: "Log out", load: () => import("./logout/page-logout.js") },
  display: { tag: "t-page-display", title: "Display", load: () => import("./display/page-display.js") },
  oidc: { tag: "t-page-oidc", title: "Sign in", load: () => import("./sign-in/page-oidc.js") },
  setup: { tag: "t-page-setup", title: "Set up", load: () => import("./setup/page-setup.js") },
  home: { tag: "t-page-home", title: "Home", load: () => import("./home/page-home.js") },
  fleet: { tag: "t-page-fleet", title: "Fleet", load: () => import("./fleet/page-fleet.js") },
  map: { tag: "t-page-map", title: "Map", load: () => import("./map/page-map.js") },
  devices: { tag: "t-page-devices", title: "Devices", load: () => import("./devices/page-devices.js") },
  device: { tag: "t-page-device", title: "Device", load: () => import("./device/page-device.js") },
  public: { tag: "t-page-public", title: "Public data", load: () => import("./public/page-public.js") },
  boards: { tag: "t-page-boards", title: "Boards", load: () => import("./boards/page-boards.js") },
  board: { tag: "t-page-board", title: "Board", load: () => import("./boards/page-board.js") },
  account: { tag: "t-page-account", title: "Account", load: () => import("./account/page-account.js") },
  people: { tag: "t-page-people", title: "People", load: () => import("./people/page-people.js") },
  roles: { tag: "t-page-roles", title: "Roles", load: () => import("./roles/page-roles.js") },
  gateways: { tag: "t-page-gateways", title: "Gateways", load: () => import("./gateways/page-gateways.js") },
  clients: { tag: "t-page-clients", title: "Clients", load: () => import("./clients/page-clients.js") },
  storage: { tag: "t-page-storage", title: "Storage", load: () => import("./storage/page-storage.js") },
  support: { tag: "t-page-support", title: "Support", load: () => import("./support/page-support.js") },
  audit: { tag: "t-page-audit", title: "Audit log", load: () => import("./audit/page-audit.js") },
  description: {
    tag: "t-page-description",
    title: "Description",
    load: () => import("./description/page-description.js"),
  },
  live: { tag: "t-page-live", title: "Real-time", load: () => import("./live/page-live.js") },
  topics: { tag: "t-page-topics", title: "Topics", load: () => import("./topics/page-topics.js") },
  scene: { tag: "t-page-scene", title: "Scene", load: () => import("./scene/page-scene.js") },
  history: { tag: "t-page-history", title: "History", load: () => import("./history/page-history.js") },
  recordings: {
    tag: "t-page-recordings",
    title: "Recordings",
    load: () => import("./recordings/page-recordings.js"),
  },
  missions: { tag: "t-page-missions", title: "Missions", load: () => import("./missions/page-missions.js") },
  alarms: { tag: "t-page-alarms", title: "Alarms", load: () => import("./alarms/page-alarms.js") },
  logbook: { tag: "t-page-logbook", title: "Logbook", load: () => import("./logbook/page-logbook.js") },
  notes: { tag: "t-page-notes", title: "Notes", load: () => import("./notes/page-notes.js") },
  anomalies: { tag: "t-page-anomalies", title: "Anomalies", load: () => import("./anomalies/page-anomalies.js") },
  cause: { tag: "t-page-cause", title: "Cause", load: () => import("./cause/page-cause.js") },
  sightings: { tag: "t-page-sightings", title: "Sightings", load: () => import("./sightings/page-sightings.js") },
  review: { tag: "t-page-review", title: "Review", load: () => import("./review/page-review.js") },
  zones: { tag: "t-page-zones", title: "Zones and lines", load: () => import("./zones/page-zones.js") },
  ways: { tag: "t-page-ways", title: "Notification", load: () => import("./notification-channels/page-notification-channels.js") },
  drive: { tag: "t-page-drive", title: "Actuate", load: () => import("./drive/page-drive.js") },
  archive: { tag: "t-page-archive", title: "Archive", load: () => import("./archive/page-archive.js") },
  cameras: { tag: "t-page-cameras", title: "Cameras", load: () => import("./cameras/page-cameras.js") },
  night: { tag: "t-page-night", title: "Night", load: () => import("./night/page-night.js") },
  forecast: { tag: "t-page-forecast", title: "Forecast", load: () => import("./forecast/page-forecast.js") },
  requests: { tag: "t-page-requests", title: "Requests", load: () => import("./requests/page-requests.js") },
  proposals: { tag: "t-page-proposals", title: "Proposals", load: () => import("./proposals/page-proposals.js") },
  alertrules: { tag: "t-page-alert-rules", title: "Alert rules", load: () => import("./alert-rules/page-alert-rules.js") },
  gallery: { tag: "t-page-gallery", title: "Gallery", load: () => import("./gallery/page-gallery.js") },
  missing: { tag: "t-page-missing", title: "Not found", load: () => import("./missing/page-missing.js") },
};

/** A page that can be opened by anyone, signed in or not. */
export function isOpen(page: PageName): boolean {
  return ["login", "logout", "oidc", "display", "setup", "gallery"].includes(page);
}

/** Whether the navigation leads a person there; the hub checks each thing once more. */
export function mayOpen(page: PageName, person: Me): boolean {
  if (ADMIN_PAGES.includes(page)) return person.admin;
  // Who sees only what is public has nothing to do there.
  if (page === "drive" || page === "alarms" || page === "logbook" || page === "cause" || page === "notes" || page === "night" || page === "forecast" || page === "fleet" || page === "missions") return !seesOnlyPublic(person);
  return true;
}

/** The page that a person begins at: who sees only what is public has all of it on one page. */
export function firstPage(person: Me): string {
  return seesOnlyPublic(person) ? "/public" : "/home";
}
