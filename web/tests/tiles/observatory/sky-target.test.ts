import { expect, test } from "vitest";
import { catalogueTarget, ownTargets, refusalOf, typedTarget, type SkyTarget } from "../../../src/tiles/observatory/sky-target.js";
import { sunFrom } from "../../../src/sky/sun-and-moon.js";

const NIGHT = Date.parse("2026-11-21T22:00:00Z");
const NOON = Date.parse("2026-11-21T12:00:00Z");
const MONTSEC = { latitude: 42.0517, longitude: 0.7297 };

test("a star is found by its name, the beginning of it, or its letter", () => {
  expect(ownTargets("vega")[0]?.name).toBe("Vega");
  expect(ownTargets("Betel")[0]?.name).toBe("Betelgeuse");
  expect(ownTargets("α Lyr")[0]?.name).toBe("Vega");
  expect(ownTargets("alpha lyr")[0]?.name).toBe("Vega");
  expect(ownTargets("")).toEqual([]);
});

test("a star's place of date is not that of its catalogue", () => {
  const vega = ownTargets("vega")[0];
  expect(vega?.at(NIGHT).ra).toBeCloseTo(18.6304, 3);
  expect(vega?.at(NIGHT).dec).toBeCloseTo(38.809, 2);
});

test("the Moon is a target that moves", () => {
  const moon = ownTargets("Moon")[0];
  expect(moon?.j2000).toBeNull();
  expect(moon?.at(NIGHT).ra).not.toBeCloseTo(moon?.at(NIGHT + 86_400_000).ra ?? 0, 1);
});

test("something of the catalogue is called by its Messier number", () => {
  const found = { name: "NGC0224", also: ["M031", "Andromeda Galaxy"], kind: "Galaxy", constellation: "And", ra_deg: 10.685, dec_deg: 41.269, magnitude: 3.44 };
  expect(catalogueTarget(found)).toMatchObject({ name: "M 31", about: "NGC 224, Andromeda Galaxy, Galaxy in And, magnitude 3.4" });
});

test("coordinates of date are taken as they are, those of J2000 are carried to the date", () => {
  const dated = typedTarget("5:34:32", "-5 23 28", true) as SkyTarget;
  const carried = typedTarget("5:34:32", "-5 23 28", false) as SkyTarget;
  if (typeof dated === "string" || typeof carried === "string") throw new Error("they are places");
  expect(dated.at(NIGHT).dec).toBeCloseTo(-5.3911, 4);
  expect(carried.at(NIGHT).ra).toBeCloseTo(5.5977, 3);
});

test("what is no place says which part of it, and how it is written", () => {
  expect(typedTarget("M31", "1", true)).toMatchObject({ field: "ra", text: expect.stringMatching(/^Right ascension: write/) as string });
  expect(typedTarget("5", "100", true)).toMatchObject({ field: "dec", text: expect.stringMatching(/^Declination: write/) as string });
});

test("too low and too near to the Sun are said before anything is sent", () => {
  const limits = { horizon: 15, sun: 30 };
  expect(refusalOf({ alt: 10, az: 0 }, MONTSEC, NIGHT, limits)).toContain("may not look below 15°");
  expect(refusalOf({ alt: 50, az: 0 }, MONTSEC, NIGHT, limits)).toBe("");
  const sun = sunFrom(MONTSEC, NOON);
  expect(refusalOf({ alt: sun.alt + 10, az: sun.az }, MONTSEC, NOON, limits)).toContain("from the Sun; at least 30°");
});
