import { describe, expect, it } from "vitest";
import type { PointContent } from "../../../src/elements/scene/point-layer.js";
import { drawPoints, redrawPoints, shownCount } from "../../../src/elements/scene/point-layer.js";

const PAINTS = { scan: "#d7263d", night: false, cloudBy: "height" } as const;

function scan(...positions: number[]): PointContent {
  return { shape: "scan", positions: new Float32Array(positions) };
}

function cloud(...positions: number[]): PointContent {
  return { shape: "cloud", every: 1, cloud: { timeUs: 0, frame: "base_link", positions: new Float32Array(positions), intensity: null, rgb: null } };
}

describe("points of a scan or a cloud", () => {
  it("keep their object, its paint and its memory from message to message", () => {
    const points = drawPoints(cloud(0, 0, 0, 1, 1, 1, 2, 2, 2), PAINTS);
    const before = [points.material, points.geometry, points.geometry.getAttribute("position"), points.geometry.getAttribute("color")];
    expect(redrawPoints(points, cloud(5, 5, 5, 6, 6, 7), PAINTS)).toBe(true);
    const now = [points.material, points.geometry, points.geometry.getAttribute("position"), points.geometry.getAttribute("color")];
    now.forEach((part, at) => {
      expect(part).toBe(before[at]);
    });
    expect([...points.geometry.getAttribute("position").array].slice(0, 6)).toEqual([5, 5, 5, 6, 6, 7]);
  });

  it("show those of the message, however many there were before", () => {
    const points = drawPoints(scan(0, 0, 0, 1, 1, 1, 2, 2, 2), PAINTS);
    redrawPoints(points, scan(5, 5, 5), PAINTS);
    expect(shownCount(points.geometry)).toBe(1);
    const more = Array.from({ length: 300 }, (_, at) => at);
    redrawPoints(points, scan(...more), PAINTS);
    expect(shownCount(points.geometry)).toBe(100);
    expect([...points.geometry.getAttribute("position").array].slice(0, 300)).toEqual(more);
    redrawPoints(points, scan(), PAINTS);
    expect(shownCount(points.geometry)).toBe(0);
  });

  it("are not put into what shows something else", () => {
    expect(redrawPoints(drawPoints(scan(0, 0, 0), PAINTS), cloud(0, 0, 0), PAINTS)).toBe(false);
  });
});
