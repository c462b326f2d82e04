import { describe, expect, test } from "vitest";
import { stateWord } from "../../src/format/state-label.js";

describe("states", () => {
  test("a state has its word, or at least its number", () => {
    expect([stateWord(["off", "on"], 1), stateWord(["off", "on"], 7), stateWord([], Number.NaN)]).toEqual(["on", "state 7", "–"]);
  });
});
