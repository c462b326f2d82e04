import { expect, test } from "vitest";
import { countText, objectKind, confidenceText, storyFacts } from "../../src/format/object-names.js";

test("how many there are is said in words that people use", () => {
  const said = (["person", "dog", "sheep", "bus", "knife", "wine glass", "mouse", "teddy bear", "bench", "baby"] as const).map((label) => countText(2, label));
  expect(said).toEqual(["2 persons", "2 dogs", "2 sheep", "2 buses", "2 knives", "2 wine glasses", "2 mice", "2 teddy bears", "2 benches", "2 babies"]);
  expect(countText(1, "person")).toBe("1 person");
});

test("people, animals and vehicles are told apart from things", () => {
  expect(["Person", "dog", "truck", "chair", ""].map(objectKind)).toEqual(["person", "animal", "vehicle", "thing", "thing"]);
});

test("how sure it is stands in whole percent", () => {
  expect(confidenceText(0.874)).toBe("87\u00a0%");
});

test("what a thing did is said by zone, line and side, and nothing of what is not known", () => {
  const story = {
    stays: [{ zone: "Mat", entries: 2, dwell_s: 12.4 }, { zone: "Hall", entries: 1, dwell_s: 70 }],
    crossings: [{ line: "Door", left: 2, right: 1 }],
    speed: 1.24,
  };
  expect(storyFacts(story)).toEqual([
    "12 s in Mat, came twice", "1 min 10 s in Hall", "crossed Door to the left twice", "crossed Door to the right", "1.2\u202fm/s",
  ]);
  expect(storyFacts({ stays: [], crossings: [], speed: null })).toEqual([]);
  expect(storyFacts(null)).toEqual([]);
});
