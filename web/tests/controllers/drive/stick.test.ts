import { expect, test } from "vitest";
import { CENTRE, curvedPush, combinedStick, padStick, PUSH } from "../../../src/controllers/drive/stick.js";

test("up on the pad is forward, left is a turn to the left", () => {
  expect(padStick(0, -100, 100)).toEqual({ forward: 1, turn: 0 });
  expect(padStick(-100, 0, 100)).toEqual({ forward: 0, turn: 1 });
  expect(padStick(0, 100, 100)).toEqual({ forward: -1, turn: 0 });
});

test("the middle of the pad is rest", () => {
  expect(padStick(5, -8, 100)).toEqual(CENTRE);
});

test("beyond the edge is no more than the edge", () => {
  expect(padStick(0, -900, 100)).toEqual(padStick(0, -100, 100));
  const corner = padStick(-900, -900, 100);
  expect(Math.hypot(corner.forward, corner.turn)).toBeLessThanOrEqual(1);
});

test("half way out is much less than half, for fine control", () => {
  expect(padStick(0, -50, 100).forward).toBeLessThan(0.3);
  expect(padStick(0, -50, 100).forward).toBeGreaterThan(0.1);
});

test("a pad without a size is at rest", () => {
  expect(padStick(10, 10, 0)).toEqual(CENTRE);
  expect(padStick(Number.NaN, 10, 100)).toEqual(CENTRE);
});

test("pushes add up to one at most, opposites cancel", () => {
  expect(combinedStick([PUSH.forward, PUSH.forward, PUSH.left])).toEqual({ forward: 1, turn: 1 });
  expect(combinedStick([PUSH.left, PUSH.right])).toEqual(CENTRE);
  expect(combinedStick([])).toEqual(CENTRE);
});

test("a turn on the spot is a full one, a turn under way is a curve", () => {
  expect(curvedPush(PUSH.left)).toEqual(PUSH.left);
  expect(curvedPush({ forward: 1, turn: 1 }).turn).toBeLessThan(0.5);
});
