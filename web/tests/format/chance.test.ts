import { expect, test } from "vitest";
import { formatChance } from "../../src/format/chance.js";

test.each([
  [0, "none"],
  [0.004, "below 1 %"],
  [0.654, "65 %"],
  [0.9997, "over 99 %"],
  [Number.NaN, "–"],
])("a chance of %d reads %s", (chance, text) => {
  expect(formatChance(chance)).toBe(text);
});
