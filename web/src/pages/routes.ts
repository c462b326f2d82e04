/** Every page: the tag that draws it, what it is called, and how its code is fetched. */

import { msg } from "@lit/localize";
import { seesOnlyPublic } from "../state/rights.js";
import { ADMIN_PAGES, type PageName } from "../state/router.js";
import type { Me } from "../generated/api.js";

export interface PageEntry {
  readonly tag: string;
  readonly title: string;
  readonly load: () => Promise<unknown>;
}

export const PAGES: Readonly<Record<PageName, PageEntry>> = {
  login: { tag: "t-page-sign-in", title: msg("Sign in"), load: () => import("./sign-in/page-sign-in.js") },
  logout: { tag: "t-page-logout", title: msg("Log out"), load: () => import("./logout/page-logout.js") },
  display: { tag: "t-page-display", title: msg("Display"), load: () => import("./display/page-display.js") },
  oidc: { tag: "t-page-oidc", title: msg("Sign in"), load: () => import("./sign-in/page-oidc.js") },
  setup: { tag: "t-page-setup", title: msg("Set up"), load: () => import("./setup/page-setup.js") },
  home: { tag: "t-page-home", title: msg("Home"), load: () => import("./home/page-home.js") },
  fleet: { tag: "t-page-fleet", title: msg("Fleet"), load: () => import("./fleet/page-fleet.js") },
  map: { tag: "t-page-map", title: msg("Map"), load: () => import("./map/page-map.js") },
  devices: { tag: "t-page-devices", title: msg("Devices"), load: () => import("./devices/page-devices.js") },
  device: { tag: "t-page-device", title: msg("Device"), load: () => import("./device/page-device.js") },
  public: { tag: "t-page-public", title: msg("Public data"), load: () => import("./public/page-public.js") },
  boards: { tag: "t-page-boards", title: msg("Boards"), load: () => import("./boards/page-boards.js") },
  board: { tag: "t-page-board", title: msg("Board"), load: () => import("./boards/page-board.js") },
  account: { tag: "t-page-account", title: msg("Account"), load: () => import("./account/page-account.js") },
  people: { tag: "t-page-people", title: msg("People"), load: () => import("./people/page-people.js") },
  roles: { tag: "t-page-roles", title: msg("Roles"), load: () => import("./roles/page-roles.js") },
  gateways: { tag: "t-page-gateways", title: msg("Gateways"), load: () => import("./gateways/page-gateways.js") },
  clients: { tag: "t-page-clients", title: msg("Clients"), load: () => import("./clients/page-clients.js") },
  storage: { tag: "t-page-storage", title: msg("Storage"), load: () => import("./storage/page-storage.js") },
  audit: { tag: "t-page-audit", title: msg("Audit log"), load: () => import("./audit/page-audit.js") },
  support: { tag: "t-page-support", title: msg("Support"), load: () => import("./support/page-support.js") },
  description: {
    tag: "t-page-description",
    title: msg("Description"),
    load: () => import("./description/page-description.js"),
  },
  live: { tag: "t-page-live", title: msg("Real-time"), load: () => import("./live/page-live.js") },
  topics: { tag: "t-page-topics", title: msg("Topics"), load: () => import("./topics/page-topics.js") },
  scene: { tag: "t-page-scene", title: msg("Scene"), load: () => import("./scene/page-scene.js") },
  history: { tag: "t-page-history", title: msg("History"), load: () => import("./history/page-history.js") },
  recordings: {
    tag: "t-page-recordings",
    title: msg("Recordings"),
    load: () => import("./recordings/page-recordings.js"),
  },
  missions: { tag: "t-page-missions", title: msg("Missions"), load: () => import("./missions/page-missions.js") },
  alarms: { tag: "t-page-alarms", title: msg("Alarms"), load: () => import("./alarms/page-alarms.js") },
  logbook: { tag: "t-page-logbook", title: msg("Logbook"), load: () => import("./logbook/page-logbook.js") },
  log: { tag: "t-page-log", title: msg("Robot's log"), load: () => import("./log/page-log.js") },
  notes: { tag: "t-page-notes", title: msg("Notes"), load: () => import("./notes/page-notes.js") },
  anomalies: { tag: "t-page-anomalies", title: msg("Anomalies"), load: () => import("./anomalies/page-anomalies.js") },
  cause: { tag: "t-page-cause", title: msg("Cause"), load: () => import("./cause/page-cause.js") },
  sightings: { tag: "t-page-sightings", title: msg("Sightings"), load: () => import("./sightings/page-sightings.js") },
  review: { tag: "t-page-review", title: msg("Review", { id: "review.page" }), load: () => import("./review/page-review.js") },
  zones: { tag: "t-page-zones", title: msg("Zones and lines"), load: () => import("./zones/page-zones.js") },
  ways: { tag: "t-page-ways", title: msg("Notification"), load: () => import("./notification-channels/page-notification-channels.js") },
  drive: { tag: "t-page-drive", title: msg("Actuate"), load: () => import("./drive/page-drive.js") },
  archive: { tag: "t-page-archive", title: msg("Archive"), load: () => import("./archive/page-archive.js") },
  cameras: { tag: "t-page-cameras", title: msg("Cameras"), load: () => import("./cameras/page-cameras.js") },
  night: { tag: "t-page-night", title: msg("Night"), load: () => import("./night/page-night.js") },
  forecast: { tag: "t-page-forecast", title: msg("Forecast"), load: () => import("./forecast/page-forecast.js") },
  requests: { tag: "t-page-requests", title: msg("Requests"), load: () => import("./requests/page-requests.js") },
  proposals: { tag: "t-page-proposals", title: msg("Proposals"), load: () => import("./proposals/page-proposals.js") },
  alertrules: { tag: "t-page-alert-rules", title: msg("Alert rules"), load: () => import("./alert-rules/page-alert-rules.js") },
  gallery: { tag: "t-page-gallery", title: msg("Gallery"), load: () => import("./gallery/page-gallery.js") },
  missing: { tag: "t-page-missing", title: msg("Not found"), load: () => import("./missing/page-missing.js") },
};

/** A page that can be opened by anyone, signed in or not. */
export function isOpen(page: PageName): boolean {
  return ["login", "logout", "oidc", "display", "setup", "gallery"].includes(page);
}

/** Whether the navigation leads a person there; the hub checks each thing once more. */
export function mayOpen(page: PageName, person: Me): boolean {
  if (ADMIN_PAGES.includes(page)) return person.admin;
  // Who sees only what is public has nothing to do there.
  if (page === "drive" || page === "alarms" || page === "logbook" || page === "log" || page === "cause" || page === "notes" || page === "night" || page === "forecast" || page === "fleet" || page === "missions") return !seesOnlyPublic(person);
  return true;
}

/** The page that a person begins at: who sees only what is public has all of it on one page. */
export function firstPage(person: Me): string {
  return seesOnlyPublic(person) ? "/public" : "/home";
}
