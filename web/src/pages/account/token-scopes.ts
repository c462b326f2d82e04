/** What a token may be given: the places where its maker has a right, and how much of it. Pure. */

import { ANY, EVERYWHERE, levelAt, levelRank, type AccessLevel, type AccessPlace } from "../../state/rights.js";
import type { DeviceSummary, PermissionShape } from "../../generated/api.js";

/** A place that a token can be given rights for. */
export interface TokenScope extends AccessPlace {
  readonly name: string;
  /** How deep it lies: the hub, a site, a device. */
  readonly depth: 0 | 1 | 2;
  /** The most that it can be given. A token never manages anything, so `admin` gives `use`. */
  readonly most: AccessLevel;
}

export function scopesOf(permissions: readonly PermissionShape[], devices: readonly DeviceSummary[]): readonly TokenScope[] {
  const scopes: TokenScope[] = [{ ...EVERYWHERE, name: "Every site", depth: 0, most: mostAt(permissions, EVERYWHERE) }];
  const sites = new Map(devices.map((row) => [row.site, row.site_name]));
  for (const [site, name] of sites) {
    scopes.push({ site, device: ANY, name, depth: 1, most: mostAt(permissions, { site, device: ANY }) });
    for (const row of devices.filter((row) => row.site === site)) {
      const place = { site, device: row.device };
      scopes.push({ ...place, name: row.name, depth: 2, most: mostAt(permissions, place) });
    }
  }
  return scopes.filter(({ most }) => most !== "none");
}

function mostAt(permissions: readonly PermissionShape[], place: AccessPlace): AccessLevel {
  const level = levelAt(permissions, place);
  return levelRank(level) > levelRank("use") ? "use" : level;
}
