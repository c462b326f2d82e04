/** The matrix of roles: rows are places, columns are roles. Pure. */

import { msg } from "@lit/localize";
import {
  accessText,
  ANY,
  EVERYWHERE,
  EXTRA_RIGHTS,
  extraRightsOf,
  givesExtra,
  inheritedLevel,
  inheritsExtra,
  levelAt,
  ownLevel,
  placeKey,
  samePermissions,
  withExtra,
  withLevel,
  type AccessLevel,
  type AccessPlace,
  type ExtraRight,
} from "../../state/rights.js";
import type { DeviceSummary, PermissionShape, RoleShape } from "../../generated/api.js";

export interface MatrixLine extends AccessPlace {
  readonly name: string;
  /** 0: the hub, 1: a site, 2: a device. */
  readonly depth: 0 | 1 | 2;
  /** Something of it is public: who holds no right still sees that. */
  readonly open: boolean;
}

export interface MatrixCell {
  /** What was given for this very place. */
  readonly own: AccessLevel;
  /** What wider places give. */
  readonly inherited: AccessLevel;
  /** What holds. */
  readonly level: AccessLevel;
  /** Those that can be given beside the level. */
  readonly extras: readonly ExtraCell[];
}

export interface ExtraCell {
  readonly right: ExtraRight;
  /** It was given for this very place. */
  readonly own: boolean;
  /** It holds anyway. */
  readonly inherited: boolean;
}

/** A role as it is being edited. */
export interface RoleDraft {
  readonly role: RoleShape;
  readonly permissions: readonly PermissionShape[];
}

/** One cell that was changed, in words. */
export interface RoleChange {
  readonly role: string;
  readonly place: string;
  readonly before: string;
  readonly after: string;
}

/** The role that can do everything, always: nobody can lock everyone out. */
export function isFixed(role: RoleShape): boolean {
  return role.seeded && role.name === "admin";
}

/** Every place: the hub, its sites and devices, and what else a role names (a site that never came). */
export function matrixLines(devices: readonly DeviceSummary[], roles: readonly RoleShape[]): readonly MatrixLine[] {
  const lines: MatrixLine[] = [{ ...EVERYWHERE, name: msg("Every site"), depth: 0, open: false }];
  const given = roles.flatMap(({ permissions }) => permissions);
  const named = given.map(({ site }) => site).filter((site) => site !== ANY);
  const names = new Map(devices.map((row) => [row.site, row.site_name]));
  for (const site of new Set([...names.keys(), ...named])) {
    const here = devices.filter((row) => row.site === site);
    lines.push({ site, device: ANY, name: names.get(site) ?? site, depth: 1, open: here.some((row) => row.public) });
    const others = given.filter((permission) => permission.site === site && permission.device !== ANY).map(({ device }) => device);
    for (const device of new Set([...here.map((row) => row.device), ...others])) {
      const row = here.find((row) => row.device === device);
      lines.push({ site, device, name: row?.name ?? device, depth: 2, open: row?.public ?? false });
    }
  }
  return lines;
}

export function cellOf(permissions: readonly PermissionShape[], place: AccessPlace): MatrixCell {
  return {
    own: ownLevel(permissions, place),
    inherited: inheritedLevel(permissions, place),
    level: levelAt(permissions, place),
    extras: extraRightsOf(place).map((right) => ({
      right,
      own: givesExtra(permissions, place, right),
      inherited: inheritsExtra(permissions, place, right),
    })),
  };
}

export function draftsOf(roles: readonly RoleShape[]): readonly RoleDraft[] {
  return roles.map((role) => ({ role, permissions: role.permissions }));
}

/** Takes in what the hub says now, and keeps what is not saved yet. */
export function updatedDrafts(drafts: readonly RoleDraft[], roles: readonly RoleShape[]): readonly RoleDraft[] {
  return roles.map((role) => {
    const held = drafts.find((draft) => draft.role.id === role.id && isChanged(draft));
    return { role, permissions: held?.permissions ?? role.permissions };
  });
}

/** Choosing what a wider place gives already gives nothing of its own. */
export function withLevelEdited(drafts: readonly RoleDraft[], role: string, place: AccessPlace, level: AccessLevel): readonly RoleDraft[] {
  return drafts.map((draft) => {
    if (draft.role.id !== role || isFixed(draft.role)) return draft;
    const own = level === inheritedLevel(draft.permissions, place) ? "none" : level;
    return { ...draft, permissions: withLevel(draft.permissions, place, own) };
  });
}

/** Gives a right beside the level at a place, or takes it there. */
export function withExtraEdited(
  drafts: readonly RoleDraft[],
  role: string,
  place: AccessPlace,
  extra: { readonly right: ExtraRight; readonly given: boolean },
): readonly RoleDraft[] {
  return drafts.map((draft) =>
    draft.role.id !== role || isFixed(draft.role)
      ? draft
      : { ...draft, permissions: withExtra(draft.permissions, place, extra.right, extra.given) },
  );
}

export function isChanged(draft: RoleDraft): boolean {
  return !samePermissions(draft.permissions, draft.role.permissions);
}

/** Every place whose own rights were changed, in the order of the matrix. */
export function changesOf(drafts: readonly RoleDraft[], lines: readonly MatrixLine[]): readonly RoleChange[] {
  return drafts.flatMap(({ role, permissions }) =>
    lines
      .filter(
        (line) =>
          ownLevel(permissions, line) !== ownLevel(role.permissions, line) ||
          EXTRA_RIGHTS.some((right) => givesExtra(permissions, line, right) !== givesExtra(role.permissions, line, right)),
      )
      .map((line) => ({
        role: role.name,
        place: placeName(line, lines),
        before: accessText(role.permissions, line),
        after: accessText(permissions, line),
      })),
  );
}

function placeName(line: MatrixLine, lines: readonly MatrixLine[]): string {
  if (line.depth !== 2) return line.name;
  const site = lines.find((candidate) => candidate.depth === 1 && candidate.site === line.site);
  return `${site?.name ?? line.site}, ${line.name}`;
}

export function lineKey(line: MatrixLine): string {
  return placeKey(line);
}
