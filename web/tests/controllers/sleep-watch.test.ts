import { expect, test } from "vitest";
import { SleepWatch } from "../../src/controllers/sleep-watch.js";

function watch(): { pass: (counted: number, passed: number) => ReturnType<SleepWatch["checkClocks"]> } {
  let now = 1000;
  let wall = 1_700_000_000_000;
  const sleep = new SleepWatch(() => now, () => wall);
  return {
    pass: (counted, passed) => {
      now += counted;
      wall += passed;
      return sleep.checkClocks();
    },
  };
}

test("a second that passes is no sleep, whatever a timer is late", () => {
  const { pass } = watch();
  expect(pass(1000, 1000).slept).toBe(false);
  expect(pass(2600, 2600).slept).toBe(false);
});

test("a clock that stood still while the device slept is told by how long", () => {
  const { pass } = watch();
  expect(pass(1000, 3_601_000)).toEqual({ slept: true, uncountedMs: 3_600_000 });
  expect(pass(1000, 1000)).toEqual({ slept: false, uncountedMs: 0 });
});

test("a clock that went on while timers stood still leaves ages as they are", () => {
  expect(watch().pass(60_000, 60_000)).toEqual({ slept: true, uncountedMs: 0 });
});

test("a wall clock that is set back says nothing", () => {
  expect(watch().pass(1000, -3_600_000)).toEqual({ slept: false, uncountedMs: 0 });
});
