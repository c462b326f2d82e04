/** Permissions in words. */

interface GivenPermission {
  readonly right: string;
  readonly site: string;
  readonly device: string;
}

/** `view every site, use agv base`; `nothing` for none. */
export function permissionText(permissions: readonly GivenPermission[]): string {
  if (permissions.length === 0) return "nothing";
  return permissions.map((permission) => `${permission.right} ${placeText(permission)}`).join(", ");
}

export function placeText(place: { readonly site: string; readonly device: string }): string {
  const { site, device } = place;
  if (site === "*") return device === "*" ? "every site" : `${device} of every site`;
  return device === "*" ? `all of ${site}` : `${site} ${device}`;
}
