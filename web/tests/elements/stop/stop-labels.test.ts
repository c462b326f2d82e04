import { expect, test } from "vitest";
import { stopLabel, stopSteps } from "../../../src/elements/stop/stop-labels.js";

test("sent, latched and confirmed never look the same", () => {
  const phases = ["sent", "latched", "confirmed"] as const;
  expect(new Set(phases.map((phase) => stopLabel({ phase }, true))).size).toBe(3);
  expect(phases.map(stopSteps)).toEqual([[2, 1, 0], [2, 2, 1], [2, 2, 2]]);
});

test("an off-line site is never said to be clear", () => {
  expect(stopLabel({ phase: "clear" }, false)).toContain("Cannot be confirmed");
  expect(stopLabel({ phase: "unknown" }, false)).toContain("Cannot be confirmed");
  expect(stopLabel({ phase: "sent", waiting: 10 }, false)).toContain("no answer");
});
