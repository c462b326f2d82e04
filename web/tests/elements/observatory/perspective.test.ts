import { expect, test } from "vitest";
import { edgePoints, groundPoint, stripPolygon } from "../../../src/elements/observatory/perspective.js";

test("north is behind, east to the right, south in front, west to the left", () => {
  expect(groundPoint(0, 1).y).toBeLessThan(0);
  expect(groundPoint(90, 1).x).toBeCloseTo(1);
  expect(groundPoint(180, 1).y).toBeGreaterThan(0);
  expect(groundPoint(270, 1).x).toBeCloseTo(-1);
});

test("a slit to the south is seen whole, and of one to the north the top only", () => {
  const seen = (azimuth: number): number => edgePoints(azimuth, 0).filter(({ front }) => front).length;
  expect(seen(180)).toBeGreaterThan(2 * seen(0));
  expect(stripPolygon(180, -0.2, 0.2).split(" ").length).toBeGreaterThan(stripPolygon(0, -0.2, 0.2).split(" ").length);
});
