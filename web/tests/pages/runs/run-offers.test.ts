import { expect, test } from "vitest";
import { alignRuns } from "../../../src/pages/runs/run-offers.js";

test("two runs meet at their starts, and the first one says how long is looked", () => {
  expect(alignRuns({ fromUs: 1000, toUs: 1600 }, { fromUs: 100, toUs: 200 })).toEqual({ span: { fromUs: 1000, toUs: 1600 }, shiftUs: 900 });
});

test("marks say no length: the other run's is taken, or five minutes", () => {
  const mark = { fromUs: 1000, toUs: 1000 };
  expect(alignRuns(mark, { fromUs: 100, toUs: 250 }).span).toEqual({ fromUs: 1000, toUs: 1150 });
  expect(alignRuns(mark, { fromUs: 2000, toUs: 2000 })).toEqual({ span: { fromUs: 1000, toUs: 1000 + 300e6 }, shiftUs: -1000 });
});
