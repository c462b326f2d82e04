import { expect, test } from "vitest";
import { childrenOf, fullText, listOf, matchingPaths, numberText, stampUs, valueNote, valueText } from "../../src/topics/topic-tree.js";

const MESSAGE = {
  header: { stamp: { sec: 1_780_000_000, nanosec: 500_000_000 }, frame_id: "base" },
  shelves: [{ number: 1, celsius: -1 }, { number: 2, celsius: 187.5 }],
  ranges: { $first: [0.1, { $number: "NaN" }], $of: 360 },
  text: { $text: "abc", $of: 3000 },
};

test("paths are those that a description takes", () => {
  const shelves = childrenOf(MESSAGE, "")?.[1];
  expect(shelves?.path).toBe("shelves");
  expect(childrenOf(shelves?.value, "shelves")?.map(({ path }) => path)).toEqual(["shelves[0]", "shelves[1]"]);
  expect(childrenOf({ celsius: 1 }, "shelves[1]")?.[0]?.path).toBe("shelves[1].celsius");
});

test("numbers, texts and arrays of them are written in a line", () => {
  for (const value of [1, "a", true, MESSAGE.ranges, MESSAGE.text, [], [1, 2], {}]) expect(childrenOf(value, "x")).toBeNull();
  expect(valueText(MESSAGE.ranges)).toBe("[0.1, NaN, …]");
  expect(valueText([])).toBe("[]");
  expect(valueText("a\n\"b\"")).toBe('"a\\n\\"b\\""');
  expect(valueText(MESSAGE.text)).toBe('"abc"…');
});

test("what is cut says how much there is", () => {
  expect(valueNote(MESSAGE.ranges)).toBe("360 entries, the first 2 shown");
  expect(valueNote(MESSAGE.text)).toBe("3,000 bytes");
  expect(valueNote([1])).toBe("1 entry");
  expect(listOf(MESSAGE.ranges).left).toBe(358);
  expect(fullText(MESSAGE.text)).toBe("abc…");
});

test("a stamp says which moment it means", () => {
  expect(stampUs(MESSAGE.header.stamp)).toBe(1_780_000_000_500_000);
  expect(valueNote(MESSAGE.header.stamp)).toBe("2026-05-28 20:26:40.500 UTC");
  expect(stampUs({ sec: 0, nanosec: 0 })).toBeNull();
  expect(stampUs({ sec: 1, nanosec: 0, more: 1 })).toBeNull();
});

test("a search finds paths and what leads to them", () => {
  expect(matchingPaths(MESSAGE, " ")).toBeNull();
  expect([...(matchingPaths(MESSAGE, "[1].CEL") ?? [])]).toEqual(["shelves", "shelves[1]", "shelves[1].celsius"]);
  expect(matchingPaths(MESSAGE, "nothing")?.size).toBe(0);
  expect(matchingPaths(Object.fromEntries(Array.from({ length: 900 }, (_, at) => [`a${String(at)}`, 1])), "a")?.size).toBe(500);
});

test("numbers have the digits that they came with", () => {
  expect(numberText(Math.fround(0.1))).toBe("0.1");
  expect(numberText(0.1)).toBe("0.1");
  expect(numberText(41.38506123456)).toBe("41.38506123456");
  expect(numberText(Math.fround(3.14159274))).toBe("3.1415927");
  expect(numberText(7)).toBe("7");
});
