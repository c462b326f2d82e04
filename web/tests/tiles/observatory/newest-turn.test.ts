import { expect, test } from "vitest";
import { newestTurn } from "../../../src/tiles/observatory/newest-turn.js";

const NOON = 1_780_000_005_000;

test("the archive is asked once more after an exposure has ended and its picture had time to come", () => {
  const before = newestTurn(NOON, 0);
  expect(newestTurn(NOON + 1000, NOON)).toBe(before);
  const after = newestTurn(NOON + 4001, NOON);
  expect(after).not.toBe(before);
  expect(newestTurn(NOON + 6000, NOON)).toBe(after);
});

test("it is asked now and then, since others take pictures, too", () => {
  expect(new Set([0, 1, 2, 3].map((turn) => newestTurn(NOON + turn * 15_000, 0))).size).toBe(4);
});
