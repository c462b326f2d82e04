/** Which tiles of the administrator's folder a device has, and what each is given. Pure. */

import type { DeviceInfo, SignalInfo } from "../wire/api-types.js";
import type { TileShape } from "../generated/api.js";

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

/** The signals that a tile reads of a device, by the tile's own names; null where one is missing. */
export function signalsFor(tile: TileShape, device: DeviceInfo): ReadonlyMap<string, SignalInfo> | null {
  if (tile.device !== "" && tile.device !== device.kind) return null;
  const found = new Map<string, SignalInfo>();
  for (const wanted of tile.signals) {
    const fits = device.signals.find(
      ({ id, type, unit }) =>
        (wanted.id === "" || wanted.id === id) && (wanted.type === "" || wanted.type === type) && (wanted.unit === "" || wanted.unit === unit),
    );
    if (fits === undefined) return null;
    found.set(wanted.name, fits);
  }
  return found;
}
