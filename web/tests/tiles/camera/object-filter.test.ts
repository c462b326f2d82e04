import { expect, test } from "vitest";
import type { DetectedObject } from "../../../src/generated/wire.js";
import { AS_DESCRIBED } from "../../../src/state/objects-choice.js";
import { objectOptions, countObjects, framedObjects, minimumConfidence } from "../../../src/tiles/camera/object-filter.js";

const DETECTS = { classes: ["person", "dog"], confidence: 0.5 };
const thing = (label: string, score: number): DetectedObject => ({ t: "thing", label, score, left: 0, top: 0, right: 1, bottom: 1 });
const THINGS = [thing("person", 0.9), thing("chair", 0.8), thing("dog", 0.5), thing("person", 0.45), thing("person", 0.6)];
const names = (things: readonly DetectedObject[]): string[] => things.map(({ label, score }) => `${label} ${String(score)}`);

test("without a choice, what the site description counts is framed", () => {
  expect(names(framedObjects(THINGS, AS_DESCRIBED, DETECTS))).toEqual(["person 0.9", "dog 0.5", "person 0.6"]);
});

test("a person may see other classes, and less sure ones, but none below 30 %", () => {
  expect(names(framedObjects(THINGS, { on: true, classes: ["chair"], confidence: null }, DETECTS))).toEqual(["chair 0.8"]);
  expect(names(framedObjects(THINGS, { on: true, classes: null, confidence: 0.4 }, DETECTS))).toHaveLength(4);
  expect(framedObjects(THINGS, { on: true, classes: [], confidence: null }, DETECTS)).toEqual([]);
  expect(minimumConfidence(AS_DESCRIBED, { classes: [], confidence: 0.1 })).toBe(0.3);
});

test("what is framed is counted, the most first", () => {
  expect(countObjects(framedObjects(THINGS, AS_DESCRIBED, DETECTS))).toEqual([{ label: "person", many: 2 }, { label: "dog", many: 1 }]);
});

test("classes of the description come first, then what was seen or chosen, each once", () => {
  const choice = { on: true, classes: ["dog", "kite"], confidence: null };
  expect(objectOptions(DETECTS, new Set(["chair", "person"]), choice).map(({ label, wanted, described }) => [label, wanted, described])).toEqual([
    ["person", false, true], ["dog", true, true], ["chair", false, false], ["kite", true, false],
  ]);
});
