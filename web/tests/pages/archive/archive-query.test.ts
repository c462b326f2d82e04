import { describe, expect, test } from "vitest";
import { formatFileSize, frameQuery, NO_FILTER, placeInDegrees, placeProblem, readArchiveFilter, shownRa, skyPlace, writeArchiveFilter } from "../../../src/pages/archive/archive-query.js";

describe("the archive's question", () => {
  test("is the same after a turn through the address bar", () => {
    const filter = { ...NO_FILTER, night: "2026-11-20", target: "M 31 & co", ra: "10.68", dec: "-5", radius: "2" };
    expect(readArchiveFilter(`?${writeArchiveFilter(filter)}`)).toEqual(filter);
  });

  test("leaves a place out that makes no sense, and says why", () => {
    const wrong = { ...NO_FILTER, target: "M 31", ra: "400", dec: "1" };
    expect(frameQuery(wrong, 48)).toBe("target=M+31&limit=48");
    expect(placeProblem(wrong)?.text).toContain("0 to 360");
    expect(placeProblem({ ...NO_FILTER, ra: "1" })?.text).toContain("both");
    expect(placeProblem({ ...NO_FILTER, ra: "1", dec: "95" })?.text).toContain("-90 to 90");
    expect(placeProblem({ ...NO_FILTER, ra: "1", dec: "5", radius: "0" })?.text).toContain("Radius");
    expect(placeProblem({ ...NO_FILTER, ra: "1", dec: "5" })).toBeNull();
  });
});

describe("a place on the sky", () => {
  test("is said in hours and degrees", () => {
    expect(skyPlace(10.68479, 41.26906)).toBe("00h 42m 44s +41° 16′ 09″");
    expect(skyPlace(0, -0.5)).toBe("00h 00m 00s −00° 30′ 00″");
  });

  test("never shows sixty seconds", () => {
    expect(skyPlace(359.9999999, 59.99999999)).toBe("00h 00m 00s +60° 00′ 00″");
  });
});

test("sizes are said in the unit that fits", () => {
  expect([formatFileSize(900), formatFileSize(2_630_000), formatFileSize(3.2e9)]).toEqual(["1 kB", "2.6 MB", "3.20 GB"]);
});

describe("a place to search at", () => {
  test("is written in hours or with its unit, and stands in the address in degrees", () => {
    const degreesOf = (ra: string, dec: string): [string, string] => {
      const found = placeInDegrees({ ...NO_FILTER, ra, dec });
      return [found.ra, found.dec];
    };
    expect(degreesOf("05:34:32", "−05:23:28")).toEqual(["83.633333", "-5.391111"]);
    expect(degreesOf("83.63°", "-5.39")).toEqual(["83.63", "-5.39"]);
    expect(degreesOf("5.5", "")).toEqual(["82.5", ""]);
    expect(shownRa({ ...NO_FILTER, ra: "83.633333" })).toBe("05:34:32.00");
  });

  test("is not guessed where a number can be no hours", () => {
    const found = placeInDegrees({ ...NO_FILTER, ra: "83.6", dec: "1" });
    expect(placeProblem(found)?.field).toBe("ra");
    expect(shownRa(found)).toBe("83.6h");
  });
});
