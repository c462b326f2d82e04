import { expect, test } from "vitest";
import { wallColumns } from "../../src/boards/wall-columns.js";

test("pictures of a wall are as large as they can be, whatever its form", () => {
  // Beside each other where it is wide, below each other on a phone.
  expect(wallColumns(2, { width: 1400, height: 400 })).toBe(2);
  expect(wallColumns(2, { width: 350, height: 460 })).toBe(1);
  expect(wallColumns(6, { width: 1200, height: 600 })).toBe(3);
  expect(wallColumns(4, { width: 800, height: 600 })).toBe(2);
});

test("one camera, and a wall that was not measured yet, have one column", () => {
  expect([wallColumns(1, { width: 900, height: 100 }), wallColumns(5, { width: 0, height: 0 })]).toEqual([1, 1]);
});
