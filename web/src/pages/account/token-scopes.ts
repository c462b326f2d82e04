/** What a token may be given: the places where its maker has a right, and how much of it. Pure. */

import { msg } from "@lit/localize";
import {
  ANY,
  EVERYWHERE,
  extraRightsOf,
  givesExtra,
  inheritsExtra,
  levelAt,
  levelRank,
  type AccessLevel,
  type AccessPlace,
  type ExtraRight,
} from "../../state/rights.js";
import type { DeviceSummary, PermissionShape } from "../../generated/api.js";

/** A place that a token can be given rights for. */
export interface TokenScope extends AccessPlace {
  readonly name: string;
  /** How deep it lies: the hub, a site, a device. */
  readonly depth: 0 | 1 | 2;
  /** The most that it can be given. A token never manages anything, so `admin` gives `use`. */
  readonly most: AccessLevel;
  /** Which rights beside the levels it can be given. */
  readonly extras: readonly ExtraRight[];
}

export function scopesOf(permissions: readonly PermissionShape[], devices: readonly DeviceSummary[]): readonly TokenScope[] {
  const scopes: TokenScope[] = [{ ...EVERYWHERE, name: msg("Every site"), depth: 0, ...givenAt(permissions, EVERYWHERE) }];
  const sites = new Map(devices.map((row) => [row.site, row.site_name]));
  for (const [site, name] of sites) {
    const whole = { site, device: ANY };
    scopes.push({ ...whole, name, depth: 1, ...givenAt(permissions, whole) });
    for (const row of devices.filter((row) => row.site === site)) {
      const place = { site, device: row.device };
      scopes.push({ ...place, name: row.name, depth: 2, ...givenAt(permissions, place) });
    }
  }
  return scopes.filter(({ most, extras }) => most !== "none" || extras.length > 0);
}

function givenAt(permissions: readonly PermissionShape[], place: AccessPlace): Pick<TokenScope, "most" | "extras"> {
  const level = levelAt(permissions, place);
  const extras = extraRightsOf(place).filter(
    (right) => givesExtra(permissions, place, right) || inheritsExtra(permissions, place, right),
  );
  return { most: levelRank(level) > levelRank("use") ? "use" : level, extras };
}
