import { expect, test } from "vitest";
import { arrowHead, markCount, nameSpot, pointsText, viewPoints } from "../../../src/elements/camera/mark-shapes.js";
import { WHOLE } from "../../../src/elements/camera/zoom.js";

test("corners lie on the picture where it is shown whole in a wider view, and move with its zoom", () => {
  const view = { width: 800, height: 300 };
  const picture = { width: 640, height: 480 };
  expect(pointsText(viewPoints([[0, 0], [1, 1]], view, picture, WHOLE))).toBe("200.0,0.0 600.0,300.0");
  expect(pointsText(viewPoints([[0.5, 0.5]], view, picture, { scale: 2, x: -0.5, y: -0.5 }))).toBe("400.0,150.0");
});

test("a zone is named in its middle, a line in the middle of its way and not of its corners", () => {
  const square = [{ x: 0, y: 0 }, { x: 4, y: 0 }, { x: 4, y: 4 }, { x: 0, y: 4 }];
  expect(nameSpot("zone", square)).toEqual({ x: 2, y: 2 });
  expect(nameSpot("line", [{ x: 0, y: 0 }, { x: 1, y: 0 }, { x: 10, y: 0 }])).toEqual({ x: 5, y: 0 });
  expect(nameSpot("line", [{ x: 3, y: 3 }, { x: 3, y: 3 }])).toEqual({ x: 3, y: 3 });
  expect(nameSpot("line", [])).toEqual({ x: 0, y: 0 });
});

test("a count says what it counts, and one that is not known is a dash and never zero", () => {
  expect(markCount("count", "person", 2)).toBe("2 persons");
  expect(markCount("dwell", "person", 72)).toBe("longest 1 min 12 s");
  expect(markCount("left", "person", 3)).toBe("left 3");
  expect(["count", "dwell", "right"].map((measure) => markCount(measure, "person", null))).toEqual(["\u2013 person", "longest \u2013", "right \u2013"]);
});

test("the arrow stands at a line's end and points along its last step", () => {
  expect(arrowHead([{ x: 0, y: 0 }, { x: 20, y: 0 }, { x: 20, y: 0 }], 10)).toEqual([{ x: 10, y: 5 }, { x: 20, y: 0 }, { x: 10, y: -5 }]);
  expect(arrowHead([{ x: 1, y: 1 }], 10)).toEqual([]);
});
