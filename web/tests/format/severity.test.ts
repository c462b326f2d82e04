import { expect, test } from "vitest";
import type { StateMeaning } from "../../src/generated/api.js";
import { messageLevel, stateLevel } from "../../src/format/severity.js";

test("a state is as grave as its meaning, whatever it is called", () => {
  const meanings: readonly StateMeaning[] = ["normal", "warning", "error", "unsafe", "unknown", "closed"];
  expect(meanings.map((_, value) => stateLevel({ meanings }, value))).toEqual(["", "warn", "bad", "bad", "", ""]);
  expect([Number.NaN, -1, 6].map((value) => stateLevel({ meanings }, value))).toEqual(["", "", ""]);
  expect(stateLevel({ meanings: [] }, 0)).toBe("");
});

test.each([
  ["[WARNING] dome is parked", "warn"], ["[WARN] low", "warn"], ["[ERROR] no answer", "bad"], ["[FATAL] gone", "bad"],
  ["[INFO] parked", ""], ["[error] not a log's word", ""], ["ERROR no answer", ""], ["no [ERROR]", ""], ["", ""],
])("the message “%s” has the level “%s”", (text, level) => {
  expect(messageLevel(text)).toBe(level);
});
