import { describe, expect, it } from "vitest";
import { changeItem, COLUMNS, firstFree, itemsOf, settle, type GridItem } from "../../src/boards/grid.js";

const item = (id: string, x: number, y: number, w: number, h: number): GridItem => ({ id, x, y, w, h });
const placeOf = (items: readonly GridItem[], id: string): readonly number[] => items.filter((found) => found.id === id).flatMap(({ x, y, w, h }) => [x, y, w, h]);

function overlapping(items: readonly GridItem[]): boolean {
  return items.some((a, i) => items.some((b, j) => i < j && a.x < b.x + b.w && b.x < a.x + a.w && a.y < b.y + b.h && b.y < a.y + a.h));
}

describe("a board's grid", () => {
  it("lets what is in the way give way downwards", () => {
    const moved = changeItem([item("a", 0, 0, 4, 2), item("b", 4, 0, 4, 2)], item("a", 4, 0, 4, 2), 12);
    expect(placeOf(moved, "a")).toEqual([4, 0, 4, 2]);
    expect(placeOf(moved, "b")).toEqual([4, 2, 4, 2]);
  });

  it("draws everything upwards where there is room", () => {
    expect(placeOf(settle([item("a", 0, 9, 4, 2), item("b", 0, 30, 4, 1)]), "b")).toEqual([0, 2, 4, 1]);
  });

  it("keeps what is moved within its columns, and no smaller than it may be", () => {
    const made = changeItem([item("a", 0, 0, 4, 3)], item("a", 11, -3, 1, 1), 12, [3, 2]);
    expect(placeOf(made, "a")).toEqual([9, 0, 3, 2]);
  });

  it("never lets two overlap, whatever is done", () => {
    let seed = 7;
    const next = (most: number): number => {
      seed = (seed * 48_271) % 2_147_483_647;
      return seed % most;
    };
    let items: readonly GridItem[] = Array.from({ length: 12 }, (_, i) => item(`t${String(i)}`, 0, i, 3, 2));
    for (let turn = 0; turn < 300; turn += 1) {
      items = changeItem(items, item(`t${String(next(12))}`, next(14), next(20), 1 + next(12), 1 + next(6)), 12);
      expect(overlapping(items)).toBe(false);
      expect(items.every(({ x, w }) => x >= 0 && x + w <= 12)).toBe(true);
    }
  });

  it("gives tiles without a place one: on a phone in the order in which the desktop is read", () => {
    const tiles = [
      { id: "low", desktop: { x: 0, y: 5, w: 3, h: 2 }, phone: null },
      { id: "new", desktop: null, phone: null },
      { id: "top", desktop: { x: 0, y: 0, w: 3, h: 5 }, phone: null },
    ];
    const size = (): readonly [number, number] => [4, 2];
    expect(placeOf(itemsOf(tiles, "desktop", size), "new")).toEqual([3, 0, 4, 2]);
    const phone = itemsOf(tiles, "phone", size);
    expect(phone.map(({ id }) => id)).toEqual(["top", "new", "low"]);
    expect(firstFree(phone, 9, 1, COLUMNS.phone)).toEqual({ x: 0, y: 6, w: 4, h: 1 });
  });
});
