import { expect, test } from "vitest";
import { findEntry, PmtilesFile, readDirectory, tileNumber } from "../../../src/elements/map/pmtiles.js";

test("tiles are numbered as the specification's examples are, and no two alike", () => {
  expect([tileNumber(0, 0, 0), tileNumber(1, 0, 0), tileNumber(1, 0, 1), tileNumber(1, 1, 1), tileNumber(1, 1, 0), tileNumber(2, 0, 0)]).toEqual([0, 1, 2, 3, 4, 5]);
  expect(tileNumber(12, 3423, 1763)).toBe(19_078_479);
  const numbers = new Set<number>();
  for (let x = 0; x < 32; x++) for (let y = 0; y < 32; y++) numbers.add(tileNumber(5, x, y));
  expect([numbers.size, Math.min(...numbers), Math.max(...numbers)]).toEqual([1024, 341, 1364]);
});

test("a directory is read by its columns; a tile is found in a run, and not behind it", () => {
  // Two entries: tile 5 for three in turn, and tile 300 right behind its bytes.
  const entries = readDirectory(new Uint8Array([2, 5, 0xa7, 2, 3, 1, 10, 20, 8, 0]).buffer);
  expect(entries).toEqual([{ id: 5, offset: 7, length: 10, run: 3 }, { id: 300, offset: 17, length: 20, run: 1 }]);
  expect([4, 5, 7, 8, 300, 301].map((id) => findEntry(entries, id)?.id ?? null)).toEqual([null, 5, 5, null, 300, null]);
  expect(() => readDirectory(new Uint8Array([9, 1]).buffer)).toThrow(RangeError);
});

test("another file is refused", async () => {
  await expect(PmtilesFile.open(() => Promise.resolve(new ArrayBuffer(127)))).rejects.toThrow("no PMTiles file");
  await expect(PmtilesFile.open(() => Promise.resolve(new ArrayBuffer(3)))).rejects.toThrow(RangeError);
});
