/** What a role or a person may do: one level for each site and device, and beside it raw topics. Pure. */

import type { PermissionShape, Right } from "../generated/api.js";

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
    .reduce<AccessLevel>((level, { right }) => higherLevel(level, levelOf(right)), "none");
}

/** The level that a right gives; the one to raw topics stands beside all levels. */
function levelOf(right: Right): AccessLevel {
  return right === "tap" ? "none" : right;
}

function reaches(permission: PermissionShape, place: AccessPlace): boolean {
  return (
    (permission.site === ANY || permission.site === place.site) &&
    (permission.device === ANY || permission.device === place.device)
  );
}

function isAt(permission: PermissionShape, place: AccessPlace): boolean {
  return permission.site === place.site && permission.device === place.device;
}

/** The level that holds at a place: its own, or a wider place's where that is higher. */
export function levelAt(permissions: readonly PermissionShape[], place: AccessPlace): AccessLevel {
  return higherLevel(ownLevel(permissions, place), inheritedLevel(permissions, place));
}

/** The level that wider places give; `none` for the whole hub, above which nothing is. */
export function inheritedLevel(permissions: readonly PermissionShape[], place: AccessPlace): AccessLevel {
  return permissions
    .filter((permission) => !isAt(permission, place) && reaches(permission, place))
    .reduce<AccessLevel>((level, { right }) => higherLevel(level, levelOf(right)), "none");
}

/** Whether raw topics were opened for this very place, whatever wider places give. */
export function givesTap(permissions: readonly PermissionShape[], place: AccessPlace): boolean {
  return permissions.some((permission) => permission.right === "tap" && isAt(permission, place));
}

/** Whether raw topics are open at a place without `givesTap`: by a wider place, or as a part of `admin`. */
export function inheritsTap(permissions: readonly PermissionShape[], place: AccessPlace): boolean {
  return permissions.some(
    (permission) =>
      (permission.right === "admin" && reaches(permission, place)) ||
      (permission.right === "tap" && !isAt(permission, place) && reaches(permission, place)),
  );
}

/** The permissions after raw topics were opened for a place, or shut. */
export function withTap(permissions: readonly PermissionShape[], place: AccessPlace, open: boolean): readonly PermissionShape[] {
  const rest = permissions.filter((permission) => permission.right !== "tap" || !isAt(permission, place));
  return open ? [...rest, { right: "tap", site: place.site, device: place.device }] : rest;
}

/** What holds at a place, in words. */
export function accessText(permissions: readonly PermissionShape[], place: AccessPlace): string {
  const level = levelAt(permissions, place);
  if (level === "admin" || !(givesTap(permissions, place) || inheritsTap(permissions, place))) return level;
  return level === "none" ? "tap" : `${level}, tap`;
}

/** The permissions after one place was given another level. One permission for a place says it all, but for raw topics. */
export function withLevel(permissions: readonly PermissionShape[], place: AccessPlace, level: AccessLevel): readonly PermissionShape[] {
  const rest = permissions.filter((permission) => permission.right === "tap" || !isAt(permission, place));
  return level === "none" ? rest : [...rest, { right: level, site: place.site, device: place.device }];
}

/** Whether two lists give the same, in whatever order. */
export function samePermissions(a: readonly PermissionShape[], b: readonly PermissionShape[]): boolean {
  const places = [...a, ...b];
  return places.every((place) => ownLevel(a, place) === ownLevel(b, place) && givesTap(a, place) === givesTap(b, place));
}

/** Whether somebody may use a device; without one, the whole site. The hub checks it once more. */
export function mayUse(person: { readonly permissions: readonly PermissionShape[] } | null | undefined, site: string, device: string): boolean {
  return levelRank(levelAt(person?.permissions ?? [], { site, device: device || ANY })) >= levelRank("use");
}

/** Whether somebody holds no right at all, and so sees what is public only. */
export function seesOnlyPublic(person: { readonly admin: boolean; readonly permissions: readonly PermissionShape[] }): boolean {
  return !person.admin && person.permissions.length === 0;
}
