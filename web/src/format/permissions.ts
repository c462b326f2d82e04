/** Permissions in words. */

interface Given {
  readonly right: string;
  readonly site: string;
  readonly device: string;
}

/** `view every site, use agv base`; `nothing` for none. */
export function permissionWords(permissions: readonly Given[]): string {
  if (permissions.length === 0) return "nothing";
  return permissions.map((one) => `${one.right} ${placeWords(one)}`).join(", ");
}

export function placeWords(place: { readonly site: string; readonly device: string }): string {
  const { site, device } = place;
  if (site === "*") return device === "*" ? "every site" : `${device} of every site`;
  return device === "*" ? `all of ${site}` : `${site} ${device}`;
}
