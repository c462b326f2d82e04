import { expect, test } from "vitest";
import { isInView, placeOf, PLATE_PX, labelPlace } from "../../../src/elements/camera/picture-fit.js";
import { WHOLE, zoomedAt } from "../../../src/elements/camera/zoom.js";

const VIEW = { width: 400, height: 300 };
const QUARTER = { left: 0.5, top: 0.5, right: 1, bottom: 1 };

test("a box lies where the picture does when both have one shape", () => {
  expect(placeOf(QUARTER, VIEW, { width: 640, height: 480 }, WHOLE)).toEqual({ x: 200, y: 150, width: 200, height: 150 });
});

test("bars beside or above the picture count for its boxes, too", () => {
  expect(placeOf(QUARTER, VIEW, { width: 100, height: 100 }, WHOLE)).toEqual({ x: 200, y: 150, width: 150, height: 150 });
  expect(placeOf({ left: 0, top: 0, right: 1, bottom: 1 }, VIEW, { width: 160, height: 60 }, WHOLE)).toEqual({ x: 0, y: 75, width: 400, height: 150 });
});

test("who looks closer sees the box at the same part of the picture", () => {
  const zoom = zoomedAt(WHOLE, 2, 1, 1);
  expect(placeOf(QUARTER, VIEW, { width: 640, height: 480 }, zoom)).toEqual({ x: 0, y: 0, width: 400, height: 300 });
  const corner = placeOf({ left: 0, top: 0, right: 0.1, bottom: 0.1 }, VIEW, { width: 640, height: 480 }, zoom);
  expect(isInView(corner, VIEW)).toBe(false);
});

test("the words of a box stay in sight: above it, inside below the buttons, or below a low box", () => {
  const box = { x: 50, y: 120, width: 80, height: 100 };
  expect(labelPlace(box)).toEqual({ x: 0, y: -PLATE_PX });
  expect(labelPlace({ ...box, y: 70 })).toEqual({ x: 0, y: 0 });
  expect(labelPlace({ ...box, y: -300, height: 600, x: -40 })).toEqual({ x: 40, y: 360 });
  expect(labelPlace({ ...box, y: 10, height: 30 })).toEqual({ x: 0, y: 30 });
});
