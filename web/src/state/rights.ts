/** What a role or a person may do: one level for each site and device, and rights beside it. Pure. */

import { msg } from "@lit/localize";
import type { PermissionShape, Right } from "../generated/api.js";

/** Stands for every site, or every device of a site. */
export const ANY = "*";

/** Each includes the ones before it. */
export const LEVELS = ["none", "view", "use", "admin"] as const;
export type AccessLevel = (typeof LEVELS)[number];

/** Rights that stand beside the levels: each is had by itself, or as a part of `admin`. */
export const EXTRA_RIGHTS = ["tap", "metrics", "request", "approve", "arm", "unblurred"] as const satisfies readonly Right[];
export type ExtraRight = (typeof EXTRA_RIGHTS)[number];

/** What each of them opens, for people. */
export const EXTRA_RIGHT_NAMES: Readonly<Record<ExtraRight, string>> = {
  tap: msg("raw topics"),
  metrics: "metrics",
  request: msg("ask for observations"),
  approve: msg("approve observations"),
  arm: msg("arm the night"),
  unblurred: msg("faces unblurred"),
};

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

function isExtra(right: Right): right is ExtraRight {
  return (EXTRA_RIGHTS as readonly Right[]).includes(right);
}

/** The level that a right gives; some stand beside all levels. */
function levelOf(right: Right): AccessLevel {
  return isExtra(right) ? "none" : right;
}

/** Which of the rights beside the levels can be given for a place: figures and nights are a whole site's, a camera is a device's. */
export function extraRightsOf(place: AccessPlace): readonly ExtraRight[] {
  return EXTRA_RIGHTS.filter((right) => right === "tap" || right === "unblurred" || place.device === ANY);
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

/** Whether a right beside the levels was given for this very place, whatever wider places give. */
export function givesExtra(permissions: readonly PermissionShape[], place: AccessPlace, right: ExtraRight): boolean {
  return permissions.some((permission) => permission.right === right && isAt(permission, place));
}

/** Whether it holds at a place without `givesExtra`: by a wider place, or as a part of `admin`. */
export function inheritsExtra(permissions: readonly PermissionShape[], place: AccessPlace, right: ExtraRight): boolean {
  return permissions.some(
    (permission) =>
      (permission.right === "admin" && reaches(permission, place)) ||
      (permission.right === right && !isAt(permission, place) && reaches(permission, place)),
  );
}

/** The permissions after such a right was given for a place, or taken. */
export function withExtra(
  permissions: readonly PermissionShape[],
  place: AccessPlace,
  right: ExtraRight,
  given: boolean,
): readonly PermissionShape[] {
  const rest = permissions.filter((permission) => permission.right !== right || !isAt(permission, place));
  return given ? [...rest, { right, site: place.site, device: place.device }] : rest;
}

/** What holds at a place, in words. */
export function accessText(permissions: readonly PermissionShape[], place: AccessPlace): string {
  const level = levelAt(permissions, place);
  if (level === "admin") return level;
  const extras = extraRightsOf(place).filter(
    (right) => givesExtra(permissions, place, right) || inheritsExtra(permissions, place, right),
  );
  return level === "none" && extras.length > 0 ? extras.join(", ") : [level, ...extras].join(", ");
}

/** The permissions after one place was given another level; the rights beside it stay. */
export function withLevel(permissions: readonly PermissionShape[], place: AccessPlace, level: AccessLevel): readonly PermissionShape[] {
  const rest = permissions.filter((permission) => isExtra(permission.right) || !isAt(permission, place));
  return level === "none" ? rest : [...rest, { right: level, site: place.site, device: place.device }];
}

/** Whether two lists give the same, in whatever order. */
export function samePermissions(a: readonly PermissionShape[], b: readonly PermissionShape[]): boolean {
  const places = [...a, ...b];
  return places.every(
    (place) => ownLevel(a, place) === ownLevel(b, place) && EXTRA_RIGHTS.every((right) => givesExtra(a, place, right) === givesExtra(b, place, right)),
  );
}

/** Whether somebody may use a device; without one, the whole site. The hub checks it once more. */
export function mayUse(person: { readonly permissions: readonly PermissionShape[] } | null | undefined, site: string, device: string): boolean {
  return levelRank(levelAt(person?.permissions ?? [], { site, device: device || ANY })) >= levelRank("use");
}

/** Whether somebody is an admin of a whole site. The hub checks it once more. */
export function isSiteAdmin(person: { readonly admin: boolean; readonly permissions: readonly PermissionShape[] } | null | undefined, site: string): boolean {
  return person?.admin === true || levelAt(person?.permissions ?? [], { site, device: ANY }) === "admin";
}

/** Whether somebody holds no right at all, and so sees what is public only. */
export function seesOnlyPublic(person: { readonly admin: boolean; readonly permissions: readonly PermissionShape[] }): boolean {
  return !person.admin && person.permissions.length === 0;
}
