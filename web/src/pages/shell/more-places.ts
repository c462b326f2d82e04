/** What of a site has no place of its own in the navigation, behind its last one: *More*. Pure. */

import { seesOnlyPublic } from "../../state/rights.js";
import { sitePath, type PageName } from "../../state/router.js";
import type { Me } from "../../generated/api.js";
import { mayOpen, PAGES } from "../routes.js";

export interface MorePlace {
  readonly page: PageName;
  readonly title: string;
  readonly path: string;
  /** It is here only where the window is too narrow for its place beside the others. */
  readonly spared: boolean;
}

const MORE = ["logbook", "notes", "missions", "anomalies", "sightings", "review", "recordings", "cameras", "scene", "topics"] as const;

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
