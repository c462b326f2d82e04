import { expect, test } from "vitest";
import { channelGroups } from "../../../src/state/past/channel-groups.js";

test("the signals of a board are one question, and as few as there may be where they are many", () => {
  const names = (count: number, letters: number): string[] => Array.from({ length: count }, (_, i) => `d/${String(i)}`.padEnd(letters, "x"));
  expect(channelGroups([])).toEqual([]);
  expect(channelGroups(names(50, 12))).toEqual([names(50, 12)]);
  expect(channelGroups(names(250, 8)).map(({ length }) => length)).toEqual([100, 100, 50]);
  const long = channelGroups(names(60, 150));
  expect(long.map(({ length }) => length)).toEqual([26, 26, 8]);
  expect(long.flat()).toEqual(names(60, 150));
  // One that is too long by itself is asked for all the same: the hub says what is wrong with it.
  expect(channelGroups(names(2, 5000)).map(({ length }) => length)).toEqual([1, 1]);
});
