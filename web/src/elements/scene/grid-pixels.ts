/** An occupancy grid as pixels. Pure. */

import type { OccupancyGrid } from "../../scene/messages.js";

/** Of cells of which nothing is known: the floor below them is seen. */
const UNKNOWN_OPACITY = 60;

interface GridColours {
  readonly floor: string;
  readonly wall: string;
  readonly unknown: string;
}

/** Red, green, blue and opacity of each cell, rows as in the message. Colours as `#rrggbb`. */
export function gridPixels({ width, height, cells }: OccupancyGrid, colours: GridColours): Uint8Array<ArrayBuffer> {
  const found = new Uint8Array(width * height * 4);
  const [floor, wall, unknown] = [partsOf(colours.floor), partsOf(colours.wall), partsOf(colours.unknown)];
  for (let i = 0; i < width * height; i++) {
    const cell = cells[i] ?? 255;
    const known = cell <= 100;
    const share = cell / 100;
    for (const part of [0, 1, 2] as const) found[4 * i + part] = known ? floor[part] + share * (wall[part] - floor[part]) : unknown[part];
    found[4 * i + 3] = known ? 255 : UNKNOWN_OPACITY;
  }
  return found;
}

function partsOf(colour: string): readonly [number, number, number] {
  // Built pages write `#ffffff` as `#fff`.
  const whole = colour.trim().replace(/^#(.)(.)(.)$/, "#$1$1$2$2$3$3");
  const digits = /^#([0-9a-f]{2})([0-9a-f]{2})([0-9a-f]{2})$/i.exec(whole);
  const part = (at: 1 | 2 | 3): number => Number.parseInt(digits?.[at] ?? "80", 16);
  return [part(1), part(2), part(3)];
}
