/** The pages of a site: all of them in a row of their own, or, where there is no room, behind *More*. Pure. */

import { seesOnlyPublic } from "../../state/rights.js";
import { isPlanningPage, sitePath, type PageName } from "../../state/router.js";
import type { Me } from "../../generated/api.js";
import { mayOpen, PAGES } from "../routes.js";

export interface MorePlace {
  readonly page: PageName;
  readonly title: string;
  readonly path: string;
  /** It is here only where the window is too narrow for its place beside the others. */
  readonly spared: boolean;
}

const MORE = ["logbook", "log", "notes", "missions", "anomalies", "sightings", "review", "recordings", "cameras", "scene", "topics"] as const;

/** The pages behind *More* at a site; none without a site, and none for guests, who have all of theirs on one page. */
export function morePlaces(site: string, person: Me, { observing, archived }: { readonly observing: boolean; readonly archived: boolean }): readonly MorePlace[] {
  if (site === "" || seesOnlyPublic(person)) return [];
  const more = MORE.filter((page) => mayOpen(page, person)).map((page) => ({ page, title: PAGES[page].title, path: sitePath(site, page), spared: false }));
  // An observatory has the most places: on a phone these two give way to its night.
  const devices = { page: "devices", title: PAGES.devices.title, path: "/devices", spared: true } as const;
  const archive = { page: "archive", title: PAGES.archive.title, path: sitePath(site, "archive"), spared: true } as const;
  const boards = { page: "boards", title: PAGES.boards.title, path: "/boards", spared: true } as const;
  return [boards, ...(observing ? [devices] : []), ...(observing && archived ? [archive] : []), ...more];
}

/** What a site has, as far as the person may see it. */
export interface SiteOffer {
  /** Something to drive, command or stop. */
  readonly actuable: boolean;
  /** A telescope. */
  readonly observing: boolean;
  /** Pictures of exposures, or cameras that take them. */
  readonly archived: boolean;
}

/** In the order of use: what is now, then what was, then the raw matter. */
const SITE_ROW = ["live", "drive", "missions", "night", "cameras", "scene", "history", "logbook", "log", "notes", "sightings", "review", "anomalies", "recordings", "archive", "topics"] as const;
/** What is public of a site stands on these. */
const PUBLIC_ROW: readonly PageName[] = ["live", "history"];

/** Every page of a site that a person may open, in one row. */
export function sitePages(site: string, person: Me, { actuable, observing, archived }: SiteOffer): readonly Omit<MorePlace, "spared">[] {
  if (site === "") return [];
  const there: Partial<Record<PageName, boolean>> = { drive: actuable, missions: actuable, night: observing, archive: archived };
  return SITE_ROW.filter((page) => mayOpen(page, person) && there[page] !== false && (!seesOnlyPublic(person) || PUBLIC_ROW.includes(page))).map((page) => ({
    page, title: PAGES[page].title, path: sitePath(site, page),
  }));
}

/** The page of the row that another one belongs to. */
export function rowPageOf(page: PageName): PageName {
  if (page === "zones") return "cameras";
  return isPlanningPage(page) ? "night" : page;
}
