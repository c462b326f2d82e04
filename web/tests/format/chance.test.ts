import { expect, test } from "vitest";
import { formatChance } from "../../src/format/chance.js";

test.each([
  [0, "none"],
  [0.004, "below 1\u00a0%"],
  [0.654, "65\u00a0%"],
  [0.9997, "over\u00a099\u00a0%"],
  [Number.NaN, "–"],
])("a chance of %d reads %s", (chance, text) => {
  expect(formatChance(chance)).toBe(text);
});
