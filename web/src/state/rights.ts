/** What a role or a person may do, as one level for each site and device. Pure. */

import type { PermissionShape } from "../generated/api.js";

/** Stands for every site, or every device of a site. */
export const ANY = "*";

/** Each includes the ones before it. */
export const LEVELS = ["none", "view", "use", "admin"] as const;
export type AccessLevel = (typeof LEVELS)[number];

/** A place that a right can be given for. */
export interface AccessPlace {
  readonly site: string;
  readonly device: string;
}

export const EVERYWHERE: AccessPlace = { site: ANY, device: ANY };

export function placeKey(place: AccessPlace): string {
  return `${place.site}\n${place.device}`;
}

export function levelRank(level: AccessLevel): number {
  return LEVELS.indexOf(level);
}

export function higherLevel(a: AccessLevel, b: AccessLevel): AccessLevel {
  return levelRank(a) >= levelRank(b) ? a : b;
}

/** The level that was given for this very place, whatever wider places give. */
export function ownLevel(permissions: readonly PermissionShape[], place: AccessPlace): AccessLevel {
  return permissions
    .filter(({ site, device }) => site === place.site && device === place.device)
    .reduce<AccessLevel>((level, { right }) => higherLevel(level, right), "none");
}

/** The level that holds at a place: its own, or a wider place's where that is higher. */
export function levelAt(permissions: readonly PermissionShape[], place: AccessPlace): AccessLevel {
  return higherLevel(ownLevel(permissions, place), inheritedLevel(permissions, place));
}

/** The level that wider places give; `none` for the whole hub, above which nothing is. */
export function inheritedLevel(permissions: readonly PermissionShape[], place: AccessPlace): AccessLevel {
  return permissions
    .filter((permission) => !(permission.site === place.site && permission.device === place.device))
    .filter(({ site, device }) => (site === ANY || site === place.site) && (device === ANY || device === place.device))
    .reduce<AccessLevel>((level, { right }) => higherLevel(level, right), "none");
}

/** The permissions after one place was given another level. One permission for a place says it all. */
export function withLevel(permissions: readonly PermissionShape[], place: AccessPlace, level: AccessLevel): readonly PermissionShape[] {
  const rest = permissions.filter(({ site, device }) => site !== place.site || device !== place.device);
  return level === "none" ? rest : [...rest, { right: level, site: place.site, device: place.device }];
}

/** Whether two lists give the same, in whatever order. */
export function samePermissions(a: readonly PermissionShape[], b: readonly PermissionShape[]): boolean {
  const places = [...a, ...b];
  return places.every((place) => ownLevel(a, place) === ownLevel(b, place));
}

/** Whether somebody may use a device; without one, the whole site. The hub checks it once more. */
export function mayUse(person: { readonly permissions: readonly PermissionShape[] } | null | undefined, site: string, device: string): boolean {
  return levelRank(levelAt(person?.permissions ?? [], { site, device: device || ANY })) >= levelRank("use");
}

/** Whether somebody holds no right at all, and so sees what is public only. */
export function seesOnlyPublic(person: { readonly admin: boolean; readonly permissions: readonly PermissionShape[] }): boolean {
  return !person.admin && person.permissions.length === 0;
}
