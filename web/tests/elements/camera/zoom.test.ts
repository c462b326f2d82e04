import { expect, test } from "vitest";
import { MOST_ZOOM, movedZoom, wheelFactor, WHOLE, zoomedAt } from "../../../src/elements/camera/zoom.js";

test("what is under the finger stays there", () => {
  const once = zoomedAt(WHOLE, 2, 0.25, 0.75);
  expect(once).toEqual({ scale: 2, x: -0.25, y: -0.75 });
  const twice = zoomedAt(once, 2, 0.25, 0.75);
  expect((0.25 - twice.x) / twice.scale).toBeCloseTo(0.25);
  expect((0.75 - twice.y) / twice.scale).toBeCloseTo(0.75);
});

test("nothing but picture stays in view, and it is never smaller than the view", () => {
  expect(movedZoom(zoomedAt(WHOLE, 2, 0.5, 0.5), 5, -5)).toEqual({ scale: 2, x: 0, y: -1 });
  expect(zoomedAt(zoomedAt(WHOLE, 3, 1, 0), 0.01, 0, 0)).toEqual(WHOLE);
  expect(zoomedAt(WHOLE, 1000, 0.5, 0.5).scale).toBe(MOST_ZOOM);
  expect(movedZoom(WHOLE, 0.3, 0.3)).toEqual(WHOLE);
});

test("a wheel's notch there and back changes nothing, however its driver counts", () => {
  expect(wheelFactor(100) * wheelFactor(-100)).toBeCloseTo(1);
  expect(wheelFactor(-10_000)).toBe(wheelFactor(-100));
  expect(wheelFactor(-3)).toBeGreaterThan(1);
});
