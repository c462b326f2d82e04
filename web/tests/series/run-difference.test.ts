import { expect, test } from "vitest";
import { compareRuns, type RunSamples } from "../../src/series/run-difference.js";

const ALL = { fromUs: -Infinity, toUs: Infinity };

function runOf(points: readonly (readonly [us: number, value: number])[], allowedUs = 100): RunSamples {
  return { times: points.map(([us]) => us), values: points.map(([, value]) => value), allowedUs };
}

test("a run is no way from itself, however much later it is", () => {
  const points = Array.from({ length: 50 }, (_, at) => [at * 10, Math.sin(at)] as const);
  const later = points.map(([us, value]) => [us + 1e9, value] as const);
  expect(compareRuns(runOf(later), runOf(points), 1e9, ALL)).toEqual({ rms: 0, mean: 0, greatest: 0, count: 50 });
});

test("the second run is read between its samples, so that other moments of sampling are no difference", () => {
  const line = (from: number, step: number): RunSamples => runOf(Array.from({ length: 40 }, (_, at) => [from + at * step, 3 * (from + at * step)] as const));
  const { rms, count } = compareRuns(line(3, 7), line(0, 10), 0, ALL);
  expect(count).toBe(40);
  expect(rms).toBeLessThan(1e-9);
});

test("what is added everywhere is the difference, with its sign in the mean alone", () => {
  const one = runOf([[0, 1], [10, 2], [20, 3]]);
  const other = runOf([[0, 3], [10, 4], [20, 5]]);
  expect(compareRuns(one, other, 0, ALL)).toEqual({ rms: 2, mean: -2, greatest: 2, count: 3 });
});

test("in gaps, outside the span and where a value is not known nothing is compared", () => {
  const one = runOf([[0, 1], [50, 1], [500, 1], [1000, 1], [1100, NaN]]);
  const other = runOf([[0, 0], [1000, 0], [1100, 0]]);
  expect(compareRuns(one, other, 0, ALL).count).toBe(2);
  expect(compareRuns(one, other, 0, { fromUs: 1, toUs: 999 })).toMatchObject({ count: 0, rms: NaN });
  expect(compareRuns(one, runOf([]), 0, ALL).count).toBe(0);
});
