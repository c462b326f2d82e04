/** The coarse world that is drawn where there is no other map, so that no map is ever empty. Pure. */

import { BORDERS, LAND } from "./world-outline.js";

/** Longitude and latitude (°) in turn. */
export type OutlineLine = Float64Array;

export interface WorldOutline {
  readonly land: readonly OutlineLine[];
  readonly borders: readonly OutlineLine[];
}

/** Tenths of a degree are what the outline has. */
const STEPS = 10;

/** @param text lines with `;` between; each is a first place and the steps from there */
export function readOutline(text: string): OutlineLine[] {
  return text.split(";").map((line) => {
    const steps = line.split(" ").map(Number);
    const places = new Float64Array(steps.length);
    let [lon, lat] = [0, 0];
    for (let i = 0; i + 1 < steps.length; i += 2) {
      lon += steps[i] ?? 0;
      lat += steps[i + 1] ?? 0;
      places[i] = lon / STEPS;
      places[i + 1] = lat / STEPS;
    }
    return places;
  });
}

let kept: WorldOutline | null = null;

/** Read once: maps come and go. */
export function worldOutline(): WorldOutline {
  kept ??= { land: readOutline(LAND), borders: readOutline(BORDERS) };
  return kept;
}
