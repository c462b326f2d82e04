/** The grid over a site, held against the place of the pole and against the coordinates it is named by. */

import { describe, expect, it } from "vitest";
import { separation, toEquatorial } from "../../src/sky/coordinates.js";
import { skyGrid } from "../../src/sky/sky-grid.js";

const MS = Date.parse("2026-11-23T22:00:00Z");
const NORTH = { latitude: 42.0517, longitude: 0.7297 };
const SOUTH = { latitude: -30.2407, longitude: -70.7366 };
/** Of date and of J2000, whose lines stand by that much apart (°). */
const PRECESSION = 0.45;

describe("the grid over a site", () => {
  it("has each parallel at its distance from the pole, and the equator a quarter of a turn away", () => {
    const { lines, equator } = skyGrid(NORTH, MS);
    const pole = { alt: NORTH.latitude, az: 0 };
    for (const [name, distance] of [["+60°", 30], ["+30°", 60], ["−30°", 120]] as const) {
      const points = lines.filter((line) => line.name === name).flatMap((line) => line.points);
      expect(points.length).toBeGreaterThan(3);
      for (const point of points) expect(Math.abs(separation(point, pole) - distance)).toBeLessThan(PRECESSION);
    }
    for (const point of equator.flatMap((line) => line.points)) expect(Math.abs(separation(point, pole) - 90)).toBeLessThan(PRECESSION);
  });

  it("has each hour circle where its right ascension is", () => {
    const circles = skyGrid(SOUTH, MS).lines.filter(({ name }) => name.endsWith(" h"));
    expect(new Set(circles.map(({ name }) => name)).size).toBeGreaterThan(8);
    for (const { name, points } of circles)
      for (const point of points) {
        const away = Math.abs(toEquatorial(point, SOUTH, MS).ra - Number.parseFloat(name));
        expect(Math.min(away, 24 - away)).toBeLessThan(0.1);
      }
  });

  it("is cut into pieces that go no further below the horizon than the chart needs, and names what is up", () => {
    for (const place of [NORTH, SOUTH]) {
      const { lines, equator, names } = skyGrid(place, MS);
      for (const { points } of [...lines, ...equator]) for (const { alt } of points) expect(alt).toBeGreaterThanOrEqual(-6);
      expect(names.length).toBeGreaterThan(6);
      for (const { at } of names) expect(at.alt).toBeGreaterThan(0);
    }
  });

  it("names each parallel at the meridian", () => {
    const named = skyGrid(NORTH, MS).names.find(({ name }) => name === "+30°");
    expect(named?.at.alt).toBeCloseTo(90 - NORTH.latitude + 30, 0);
    expect(Math.abs((named?.at.az ?? 0) - 180)).toBeLessThan(2);
  });
});
