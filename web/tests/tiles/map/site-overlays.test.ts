import { describe, expect, test } from "vitest";
import { flatPosition } from "../../../src/elements/map/geodesy.js";
import { gridPixels } from "../../../src/elements/scene/grid-pixels.js";
import { cornersOf, drawnZones, frameOf, gridCorners, upsideDown } from "../../../src/tiles/map/site-overlays.js";
import { scaleOf, sharesAt, trailOnEarth } from "../../../src/tiles/map/trail-shares.js";

const FRAME = { lat: 41, lon: 2, heading: 90 };
const place = (at: { lat: number; lon: number }): number[] => {
  const { x, y } = flatPosition(at, FRAME);
  return [x, y].map((part) => Math.round(part * 1e3) / 1e3 + 0);
};

test("a plan stands on its lower left corner, and turns about it", () => {
  const upright = cornersOf({ x: 1, y: 2, turn: 0, width: 10, height: 5 }, FRAME);
  expect(upright.map(place)).toEqual([[1, 7], [11, 7], [1, 2]]);
  const turned = cornersOf({ x: 1, y: 2, turn: Math.PI / 2, width: 10, height: 5 }, FRAME);
  expect(turned.map(place)).toEqual([[-4, 2], [-4, 12], [1, 2]]);
});

test("a robot's grid stands on the corner of its first cell, its first row below", () => {
  // Two cells wide and three high, 0.5 m each; the map's x axis points north of the site's frame.
  const half = Math.SQRT1_2;
  const grid = { width: 2, height: 3, resolution: 0.5, origin: { at: [4, -1, 0], turn: [0, 0, 0, 1] }, cells: new Uint8Array([100, 0, 0, 0, 0, 255]) } as const;
  expect(gridCorners(grid, FRAME).map(place)).toEqual([[4, 0.5], [5, 0.5], [4, -1]]);
  const turned = { ...grid, origin: { at: [4, -1, 0], turn: [0, 0, half, half] } } as const;
  expect(gridCorners(turned, FRAME).map(place)).toEqual([[2.5, -1], [2.5, 0], [4, -1]]);

  const shown = upsideDown(gridPixels({ ...grid, stamp: 0, frame: "map" } as never, { floor: "#ffffff", wall: "#000000", unknown: "#808080" }), grid.width);
  const red = [0, 1, 2, 3, 4, 5].map((pixel) => shown[4 * pixel]);
  // The wall is the first cell: lower left. What nobody knows is the last one: upper right.
  expect(red).toEqual([255, 128, 255, 255, 0, 255]);
});

test("a zone is drawn by the alarm and the interlock that it names", () => {
  const zone = { id: "z", name: "Yard", kind: "fence", type: "Polygon", lines: [{ latitudes: [1, 2], longitudes: [3, 4] }], alarm: "out", interlock: "away" } as const;
  const drawn = (phase: string, severity: string, locked: boolean): unknown =>
    drawnZones("agv", [zone], { find: () => ({ phase, severity }) as never }, { interlockOf: () => ({ news: { locked } }) as never })[0]?.trouble;
  expect(drawn("active", "critical", false)).toBe("bad");
  expect(drawn("acknowledged", "warning", false)).toBe("warn");
  expect(drawn("normal", "critical", true)).toBe("warn");
  expect(drawn("normal", "critical", false)).toBe("");
  expect(drawnZones("agv", [zone], undefined, undefined)[0]?.lines).toEqual([[{ lat: 1, lon: 3 }, { lat: 2, lon: 4 }]]);
});

test("a site without an origin has no frame on Earth", () => {
  expect(frameOf(null)).toBeNull();
  expect(frameOf({ origin: null, zones: [], plans: [], grid: "" })).toBeNull();
});

describe("a trail coloured by a signal", () => {
  const samples = [{ timeUs: 10, value: 0 }, { timeUs: 20, value: 5 }, { timeUs: 30, value: 10 }];

  test("has the last value at each moment, on the scale of what was seen", () => {
    expect(sharesAt([5, 10, 25, 30], samples, scaleOf(samples, null, null))).toEqual([Number.NaN, 0, 0.5, 1]);
  });

  test("goes by the limits of the description where it has some", () => {
    expect(scaleOf(samples, -10, 90)).toEqual({ least: -10, most: 90 });
    expect(scaleOf([], null, null)).toBeNull();
    expect(scaleOf([{ timeUs: 1, value: 3 }], null, null)).toBeNull();
  });

  test("says nothing of moments long after the last value", () => {
    expect(sharesAt([30 + 11e6], samples, { least: 0, most: 10 })).toEqual([Number.NaN]);
  });

  test("is broken where nothing is known of the way", () => {
    const trail = trailOnEarth([{ x: 0, y: 0, timeUs: 0 }, { x: 1, y: 0, timeUs: 1e6 }, { x: 9, y: 0, timeUs: 60e6 }], FRAME, [0, 1, 1]);
    expect(trail.map(({ apart }) => apart)).toEqual([false, false, true]);
    expect(place(trail[2] ?? FRAME)).toEqual([9, 0]);
  });
});
