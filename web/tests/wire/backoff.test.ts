import { expect, test } from "vitest";
import { backoffMs } from "../../src/wire/backoff.js";

test("the delay doubles with each failed attempt", () => {
  expect([0, 1, 2, 3].map((attempt) => backoffMs(attempt, 0))).toEqual([125, 250, 500, 1000]);
});

test("the delay stays within half and all of two seconds, however long the hub is away", () => {
  expect(backoffMs(5000, 0)).toBe(1000);
  expect(backoffMs(5000, 0.999)).toBeLessThan(2000);
});
