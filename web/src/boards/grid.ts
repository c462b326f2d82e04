/** Tiles on a grid: moved and resized without overlapping, drawn upwards where there is room. Pure. */

import type { BoardPlaceShape } from "../generated/api.js";

export interface GridItem extends BoardPlaceShape {
  readonly id: string;
}

export type GridName = "desktop" | "phone";

export const COLUMNS: Readonly<Record<GridName, number>> = { desktop: 12, phone: 4 };
export const MOST_ROWS = 40;

/** Least width and height, in columns and rows. */
export type LeastSize = readonly [w: number, h: number];

function overlaps(a: GridItem, b: GridItem): boolean {
  return a.x < b.x + b.w && b.x < a.x + a.w && a.y < b.y + b.h && b.y < a.y + a.h;
}

function byPlace(a: GridItem, b: GridItem): number {
  return a.y - b.y || a.x - b.x || a.id.localeCompare(b.id);
}

function isFree(item: GridItem, placed: readonly GridItem[]): boolean {
  return !placed.some((other) => overlaps(item, other));
}

/** Within the columns; neither smaller than `least` nor higher than a tile may be. */
export function clampItem(item: GridItem, columns: number, [leastW, leastH]: LeastSize = [1, 1]): GridItem {
  const w = Math.min(columns, Math.max(Math.min(leastW, columns), Math.round(item.w)));
  const h = Math.min(MOST_ROWS, Math.max(leastH, Math.round(item.h)));
  return { ...item, w, h, x: Math.min(columns - w, Math.max(0, Math.round(item.x))), y: Math.max(0, Math.round(item.y)) };
}

/** Every item as far up as those above it let it; what overlapped is pushed down. */
export function settle(items: readonly GridItem[]): readonly GridItem[] {
  const placed: GridItem[] = [];
  for (const item of [...items].sort(byPlace)) {
    let y = item.y;
    while (!isFree({ ...item, y }, placed)) y += 1;
    while (y > 0 && isFree({ ...item, y: y - 1 }, placed)) y -= 1;
    placed.push({ ...item, y });
  }
  return placed;
}

/** One item at another place or of another size; the others give way downwards. */
export function changeItem(items: readonly GridItem[], changed: GridItem, columns: number, least: LeastSize = [1, 1]): readonly GridItem[] {
  const item = clampItem(changed, columns, least);
  const placed: GridItem[] = [item];
  for (const other of items.filter(({ id }) => id !== item.id).sort(byPlace)) {
    let { y } = other;
    while (!isFree({ ...other, y }, placed)) y += 1;
    placed.push({ ...other, y });
  }
  return settle(placed);
}

/** The first place, from the top, where an item of this size fits. */
export function firstFree(items: readonly GridItem[], w: number, h: number, columns: number): BoardPlaceShape {
  const width = Math.min(w, columns);
  for (let y = 0; ; y += 1) {
    for (let x = 0; x + width <= columns; x += 1) {
      if (isFree({ id: "", x, y, w: width, h }, items)) return { x, y, w: width, h };
    }
  }
}

interface PlacedTile {
  readonly id: string;
  readonly desktop: BoardPlaceShape | null;
  readonly phone: BoardPlaceShape | null;
}

/**
 * The items of one of a board's grids. Tiles without a place there get one after the others: on a phone
 * in the order in which they are read on the desktop.
 */
export function itemsOf<T extends PlacedTile>(
  tiles: readonly T[],
  grid: GridName,
  sizeOf: (tile: T, grid: GridName) => readonly [w: number, h: number],
): readonly GridItem[] {
  const columns = COLUMNS[grid];
  const order = grid === "phone" ? readingOrder(tiles, sizeOf) : tiles;
  const placed: GridItem[] = [];
  for (const tile of tiles) {
    const place = tile[grid];
    if (place !== null) placed.push(clampItem({ id: tile.id, ...place }, columns));
  }
  for (const tile of order) {
    if (tile[grid] !== null) continue;
    const [w, h] = sizeOf(tile, grid);
    placed.push({ id: tile.id, ...firstFree(placed, w, h, columns) });
  }
  return settle(placed);
}

function readingOrder<T extends PlacedTile>(tiles: readonly T[], sizeOf: (tile: T, grid: GridName) => readonly [w: number, h: number]): readonly T[] {
  const places = new Map(itemsOf(tiles, "desktop", sizeOf).map((item) => [item.id, item]));
  return [...tiles].sort((a, b) => {
    const [one, other] = [places.get(a.id), places.get(b.id)];
    return one === undefined || other === undefined ? 0 : byPlace(one, other);
  });
}
