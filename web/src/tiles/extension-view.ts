/** What a tile of the administrator's folder is given. Pure. */

/** Of what a component is given and of the keys in `tile.json`; the hub knows the same number. */
export const TILE_API_VERSION = 1;

/** How far a value is to be believed: `live`, too old, out of its range, or not known at all. */
export type TileFreshness = "live" | "stale" | "outside" | "unknown";

/** One signal as a component is given it. Public: within a version fields are added, none goes. */
export interface TileReading {
  readonly id: string;
  readonly name: string;
  /** As in the site description; empty where it has none. */
  readonly unit: string;
  /** NaN where it is not known. */
  readonly value: number;
  /** The word of a state, or a text; empty for numbers. */
  readonly text: string;
  readonly freshness: TileFreshness;
  /** Since it was measured (s); NaN where it is not known. */
  readonly ageS: number;
}

/** What a component's `update` is called with. Public, as `TileReading` is. */
export interface TileView {
  readonly api: number;
  readonly site: string;
  readonly device: { readonly id: string; readonly name: string; readonly kind: string };
  /** By the names in `tile.json`. */
  readonly readings: Readonly<Record<string, TileReading>>;
}
