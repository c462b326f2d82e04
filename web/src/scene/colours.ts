/** Colours of points from a share of 0 to 1. Pure. */

import type { CloudColour, PointCloud } from "./cloud.js";
import { spanOf } from "./cloud.js";

/** Dark violet to yellow, near enough to matplotlib's viridis: told apart by those who see few colours, too. */
const STOPS: readonly (readonly [number, number, number])[] = [
  [0.27, 0.0, 0.33], [0.23, 0.32, 0.55], [0.13, 0.57, 0.55], [0.37, 0.79, 0.38], [0.99, 0.91, 0.14],
];
/** For eyes that are used to the dark: red alone. */
const RED: readonly (readonly [number, number, number])[] = [
  [0.3, 0.0, 0.0], [1.0, 0.1, 0.05],
];

export function ramp(share: number, night: boolean): readonly [number, number, number] {
  const stops = night ? RED : STOPS;
  const place = Math.min(1, Math.max(0, share)) * (stops.length - 1);
  const at = Math.min(stops.length - 2, Math.floor(place));
  const [low, high] = [stops[at] ?? [0, 0, 0], stops[at + 1] ?? [0, 0, 0]];
  const mix = (i: 0 | 1 | 2): number => low[i] + (place - at) * (high[i] - low[i]);
  return [mix(0), mix(1), mix(2)];
}

/** A ramp in steps that no eye tells apart, each as the four bytes of a point's colour. */
const STEPS = 256;
const ramps = new Map<boolean, Uint32Array>();

function rampBytes(night: boolean): Uint32Array {
  let found = ramps.get(night);
  if (found === undefined) {
    const bytes = new Uint8Array(4 * STEPS);
    for (let step = 0; step < STEPS; step++) bytes.set([...ramp(step / (STEPS - 1), night).map((part) => Math.round(255 * part)), 255], 4 * step);
    found = new Uint32Array(bytes.buffer);
    ramps.set(night, found);
  }
  return found;
}

/** Red, green, blue and 255 of each point: by what was chosen, or by height where the points have none of it. */
export function cloudColours(cloud: PointCloud, by: CloudColour, night: boolean): Uint8Array {
  const count = cloud.positions.length / 3;
  const found = new Uint8Array(4 * count).fill(255);
  if (by === "rgb" && cloud.rgb !== null && !night) {
    for (let i = 0; i < count; i++) for (let part = 0; part < 3; part++) found[4 * i + part] = cloud.rgb[3 * i + part] ?? 0;
    return found;
  }
  const [values, first, stride] = by === "intensity" && cloud.intensity !== null ? [cloud.intensity, 0, 1] : [cloud.positions, 2, 3];
  const [least, most] = spanOf(values, first, stride);
  const [whole, table] = [new Uint32Array(found.buffer), rampBytes(night)];
  const scale = most > least ? (STEPS - 1) / (most - least) : 0;
  const middle = most > least ? 0.5 : (STEPS - 1) / 2;
  for (let i = 0, at = first; i < count; i++, at += stride) whole[i] = table[Math.floor(((values[at] ?? 0) - least) * scale + middle)] ?? 0;
  return found;
}
