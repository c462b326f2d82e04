import { expect, test } from "vitest";
import { heldStopLabel, stopLabel, stopSteps } from "../../../src/elements/stop/stop-labels.js";

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

test("of a second gateway that waits, silent, latched and confirmed never sound the same", () => {
  const reached = [[0, 0], [1, 0], [1, 1]] as const;
  const said = reached.map(([latched, confirmed]) => heldStopLabel({ held: 1, latched, confirmed }));
  expect(new Set(said).size).toBe(3);
  expect(said[0]).toContain("not answered");
  expect(said[1]).toContain("not confirmed");
  expect(heldStopLabel({ held: 3, latched: 2, confirmed: 2 })).toContain("1 of them has not answered");
});
