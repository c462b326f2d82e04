import { expect, test } from "vitest";
import { GamepadGrip, GamepadPresses, padsFound, pushOf, type PadReading } from "../../../src/controllers/drive/gamepad.js";

function pad(grip: boolean, axes: number[] = [0, 0], pressed: number[] = []): PadReading {
  const buttons = Array.from({ length: 17 }, (_, i) => ({
    pressed: pressed.includes(i) || (grip && i === 4),
  }));
  return { axes, buttons };
}

test("the stick drives only while a shoulder button is held", () => {
  const grip = new GamepadGrip();
  expect(grip.readChange(pad(false, [0, -1]))).toBe("none");
  expect(grip.readChange(pad(true, [0, -1]))).toBe("press");
  expect(grip.readChange(pad(true, [0, -0.5]))).toBe("move");
  expect(grip.readChange(pad(false, [0, -0.5]))).toBe("release");
  expect(grip.readChange(pad(false, [0, -0.5]))).toBe("none");
});

test("a shoulder button that was held before we looked does not count", () => {
  const grip = new GamepadGrip();
  expect(grip.readChange(pad(true))).toBe("none");
  grip.readChange(pad(false));
  expect(grip.readChange(pad(true))).toBe("press");
});

test("a drifting stick is at rest", () => {
  expect(pushOf(pad(true, [0.1, -0.14]))).toEqual({ forward: 0, turn: 0 });
});

test("stick and cross push alike: up is forward, left is left", () => {
  expect(pushOf(pad(true, [0, -1]))).toEqual({ forward: 1, turn: 0 });
  expect(pushOf(pad(true, [-1, 0]))).toEqual({ forward: 0, turn: 1 });
  expect(pushOf(pad(true, [0, 0], [13, 15]))).toEqual({ forward: -1, turn: -1 });
  expect(pushOf(pad(true, [0, -1], [12])).forward).toBe(1);
});

test("a pad without axes or buttons is at rest", () => {
  expect(pushOf({ axes: [], buttons: [] })).toEqual({ forward: 0, turn: 0 });
  expect(new GamepadGrip().readChange({ axes: [Number.NaN], buttons: [] })).toBe("none");
});

test("a button counts once for each press", () => {
  const presses = new GamepadPresses();
  expect(presses.readPresses(pad(false, [], [1]))).toEqual([]);
  expect(presses.readPresses(pad(false))).toEqual([]);
  expect(presses.readPresses(pad(false, [], [0, 1]))).toEqual(["halt", "STOP"]);
  expect(presses.readPresses(pad(false, [], [0, 1, 3]))).toEqual(["faster"]);
  expect(presses.readPresses({ axes: [], buttons: [] })).toEqual([]);
});

test("whether there is a pad to drive by goes by its layout", () => {
  expect([padsFound([]), padsFound([""]), padsFound(["", "standard"])]).toEqual(["none", "other", "ready"]);
});
