/** Permissions in words. */

import { msg, str } from "@lit/localize";
import type { PermissionShape } from "../generated/api.js";

/** `view every site, use agv base`; `nothing` for none. */
export function permissionText(permissions: readonly PermissionShape[]): string {
  if (permissions.length === 0) return msg("nothing");
  return permissions.map((permission) => `${permission.right} ${placeText(permission)}`).join(", ");
}

export function placeText(place: { readonly site: string; readonly device: string }): string {
  const { site, device } = place;
  if (site === "*") return device === "*" ? msg("every site") : msg(str`${device} of every site`);
  return device === "*" ? msg(str`all of ${site}`) : `${site} ${device}`;
}
