/** Colours of points from a share of 0 to 1. Pure. */

import type { CloudColour, PointCloud } from "./cloud.js";
import { spread } from "./cloud.js";

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

/** Red, green and blue of each point, 0 to 1: by what was chosen, or by height where the points have none of it. */
export function cloudColours(cloud: PointCloud, by: CloudColour, night: boolean): Float32Array {
  const count = cloud.positions.length / 3;
  const found = new Float32Array(count * 3);
  if (by === "rgb" && cloud.rgb !== null && !night) {
    for (let i = 0; i < found.length; i++) found[i] = (cloud.rgb[i] ?? 0) / 255;
    return found;
  }
  const shares = by === "intensity" && cloud.intensity !== null ? cloud.intensity : spread(heightsOf(cloud.positions));
  for (let i = 0; i < count; i++) found.set(ramp(shares[i] ?? 0, night), 3 * i);
  return found;
}

function heightsOf(positions: Float32Array): Float32Array {
  const found = new Float32Array(positions.length / 3);
  for (let i = 0; i < found.length; i++) found[i] = positions[3 * i + 2] ?? 0;
  return found;
}
