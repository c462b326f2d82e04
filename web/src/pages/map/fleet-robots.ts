/** All robots of the fleet as they stand on one map. Pure. */

import type { MapRobot } from "../../elements/map/geo-painter.js";
import type { SiteSummary } from "../../generated/api.js";
import { NO_TROUBLE, type SiteTrouble } from "../../tiles/site-trouble.js";

/** Each site where its robot is, or where it is itself; those of which neither is known are left out. */
export function fleetRobots(rows: readonly SiteSummary[], troubles: ReadonlyMap<string, SiteTrouble>): MapRobot[] {
  return rows.flatMap((row): MapRobot[] => {
    const { site, name, latitude, longitude, heading } = row;
    if (latitude === null || longitude === null) return [];
    const { bad, warn } = troubles.get(site) ?? NO_TROUBLE;
    return [
      {
        id: site,
        name,
        place: { lat: latitude, lon: longitude },
        heading: row.moving ? (heading ?? Number.NaN) : Number.NaN,
        // Where an offline site is described to be is no place of a robot now.
        stale: !row.online || !row.moving,
        trouble: bad > 0 ? "bad" : warn > 0 ? "warn" : "",
      },
    ];
  });
}
