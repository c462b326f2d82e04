/** Permissions in words. */

import type { PermissionShape } from "../generated/api.js";

/** `view every site, use agv base`; `nothing` for none. */
export function permissionText(permissions: readonly PermissionShape[]): string {
  if (permissions.length === 0) return "nothing";
  return permissions.map((permission) => `${permission.right} ${placeText(permission)}`).join(", ");
}

export function placeText(place: { readonly site: string; readonly device: string }): string {
  const { site, device } = place;
  if (site === "*") return device === "*" ? "every site" : `${device} of every site`;
  return device === "*" ? `all of ${site}` : `${site} ${device}`;
}
