import { expect, test } from "vitest";
import { isNear, sessionTimeLeft } from "../../src/state/session-time-left.js";

const NOW = 1_780_000_000_000_000;
const ends = (idle: number, whole: number): { idle_ends_us: number; ends_us: number } => ({
  idle_ends_us: NOW + idle * 1e6,
  ends_us: NOW + whole * 1e6,
});

test("the end that comes first is told", () => {
  expect(sessionTimeLeft(ends(60, 600), NOW)).toMatchObject({ kind: "idle", seconds: 60 });
  expect(sessionTimeLeft(ends(600, 60), NOW)).toMatchObject({ kind: "whole", seconds: 60 });
  expect(sessionTimeLeft(ends(60, 60), NOW).kind).toBe("whole");
  expect(sessionTimeLeft(ends(-5, 600), NOW).seconds).toBe(0);
});

test("a warning comes five minutes before either end", () => {
  expect(isNear(sessionTimeLeft(ends(301, 9999), NOW))).toBe(false);
  expect(isNear(sessionTimeLeft(ends(300, 9999), NOW))).toBe(true);
  expect(isNear(sessionTimeLeft(ends(9999, 301), NOW))).toBe(false);
  expect(isNear(sessionTimeLeft(ends(9999, 300), NOW))).toBe(true);
});
