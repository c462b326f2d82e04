import { decimalsFor, formatNumber } from "../../src/format/number.js";
import { describe, expect, test } from "vitest";
import { formatWithUnit, spokenUnit } from "../../src/format/unit.js";

describe("numbers", () => {
  test.each([
    [0.1834, 2, "0.18"],
    [-1.5, 1, "−1.5"],
    [-0.0004, 2, "0.00"],
    [Number.NaN, 2, "–"],
    [Number.POSITIVE_INFINITY, 2, "∞"],
    [Number.NEGATIVE_INFINITY, 2, "−∞"],
    [9999, 0, "9999"],
    [1234567.5, 1, "1\u202f234\u202f567.5"],
    [0.1234567, 6, "0.123457"],
    [-2.5e12, 2, "−2.500e+12"],
  ])("%d with %d digits is written %s", (value, decimals, text) => {
    expect(formatNumber(value, decimals)).toBe(text);
  });

  test("the digits are the signal's own, or its unit's, or two", () => {
    expect([decimalsFor("m/s", 4), decimalsFor("rad"), decimalsFor("furlong")]).toEqual([4, 3, 2]);
  });

  test("a unit stands apart by a narrow space, a degree sign does not", () => {
    expect(formatWithUnit(21.46, "°C")).toBe("21.5\u202f°C");
    expect(formatWithUnit(41.3874, "°", 4)).toBe("41.3874°");
    expect(formatWithUnit(3, "", 0)).toBe("3");
  });

  test("a screen reader says a unit by its name", () => {
    expect(spokenUnit("m/s")).toBe("metre per second");
  });
});
