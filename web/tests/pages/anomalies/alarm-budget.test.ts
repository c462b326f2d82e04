import { describe, expect, it } from "vitest";
import type { BudgetShape } from "../../../src/generated/api.js";
import { reasonOf, sentenceOf } from "../../../src/pages/anomalies/alarm-budget.js";

const DAY_S = 86_400;
const BUDGET: BudgetShape = { a_week: 1, described: 0, by_person: true, basis: "counted", seen_s: 30 * DAY_S, needed_s: 21 * DAY_S, reading: 0, kept: 5, others: 0, may_change: true };

describe("how often detectors may cry", () => {
  it("is said in words, with whose word it is", () => {
    expect(sentenceOf(BUDGET)).toBe("About one false alarm a week for this site.");
    expect(sentenceOf({ ...BUDGET, a_week: 0.25 })).toBe("About one false alarm in 4 weeks for this site.");
    expect(sentenceOf({ ...BUDGET, a_week: 3, by_person: false, described: 3 })).toBe("About 3 false alarms a week for this site (as described).");
    expect(sentenceOf({ ...BUDGET, described: 2 })).toBe("About one false alarm a week for this site (the description says 2 a week).");
    expect(sentenceOf({ ...BUDGET, a_week: 0 })).toContain("its own bar");
  });

  it("says plainly where it has seen too little", () => {
    expect(reasonOf({ ...BUDGET, basis: "learning", seen_s: 3600 })).toBe("It has seen one hour. Before a day nothing is set, and each detector goes by its own bar.");
    expect(reasonOf({ ...BUDGET, basis: "short", seen_s: 8 * DAY_S })).toContain("It has seen 8 days, too short to count so few: 21 days are needed.");
    expect(reasonOf(BUDGET)).toBe("By 30 days of this site's past, and set anew as time passes.");
  });

  it("says where it holds for no detector, and where nothing was seen", () => {
    expect(reasonOf({ ...BUDGET, kept: 0, others: 2 })).toContain("No detector at work here can be kept to it");
    expect(reasonOf({ ...BUDGET, basis: "learning", seen_s: 5 })).toContain("It has seen nothing yet.");
  });

  it("says what is still being read, and what goes by its own bar", () => {
    expect(reasonOf({ ...BUDGET, reading: 1 })).toContain("The stored history of 1 detector is still being looked at.");
    expect(reasonOf({ ...BUDGET, others: 2 })).toContain("2 detectors go by bars of their own, and their anomalies come on top.");
  });
});
