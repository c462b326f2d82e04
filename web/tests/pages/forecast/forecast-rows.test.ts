import { expect, test } from "vitest";
import type { PlanBlockShape, WeekNightShape, WeekShape } from "../../../src/generated/api.js";
import { chanceRows, expectedShares, skyFacts } from "../../../src/pages/forecast/forecast-rows.js";

const HOUR_US = 3600e6;

function block(request: string, proposal: string, startUs: number, hours: number): PlanBlockShape {
  return { request, proposal, target: request, start_us: startUs, end_us: startUs + hours * HOUR_US, overhead_s: 0, reason: "", pauses: [] };
}

function night(blocks: readonly PlanBlockShape[], chances: Readonly<Record<string, number>>): WeekNightShape {
  const plan = { made_us: 0, night_start_us: 0, night_end_us: 10 * HOUR_US, method: "", value: 0, bound: null, blocks: [...blocks] };
  const listed = Object.entries(chances).map(([request, chance]) => ({ request, target: request, proposal: "A", chance }));
  return { start_us: 0, end_us: 10 * HOUR_US, planned: blocks.length, plan, chances: listed };
}

const NIGHTS = [
  night([block("M 31", "A", 0, 2), block("", "", 2 * HOUR_US, 4)], { "M 31": 0.7 }),
  night([block("M 42", "A", 0, 1)], { "M 42": 0.7, "M 31": 0.21 }),
];

test("each request has its chance in every night, the likeliest first", () => {
  expect(chanceRows(NIGHTS)).toEqual([
    { id: "M 31", target: "M 31", proposal: "A", chances: [0.7, 0.21], all: 0.9099999999999999 },
    { id: "M 42", target: "M 42", proposal: "A", chances: [0, 0.7], all: 0.7 },
  ]);
});

test("a proposal's hours are expected as often as its requests are done, beside all others'", () => {
  const week: WeekShape = { made_us: 0, renewing: false, open_share: 0.5, nights: NIGHTS };
  const [row] = expectedShares(week, [
    { id: "A", title: "", share: 0.4, hours_allocated: 10, used_s: 3600, active: true },
    { id: "B", title: "", share: 0, hours_allocated: 1, used_s: 0, active: false },
  ]);
  expect(row?.expectedS).toBeCloseTo((2 * 0.7 + 0.7) * 3600);
  expect(row?.got).toBeCloseTo(2.1 / (2.1 + 4 * 0.5));
  expect(row?.leftS).toBe(9 * 3600);
});

test("of a night it is said how long it is dark, and how long without the Moon", () => {
  const bands = [{ id: "astronomical", from: 0, to: 10 }, { id: "night", from: 10, to: 100 }, { id: "astronomical", from: 100, to: 110 }] as const;
  expect(skyFacts({ bands, moonUp: [{ from: 0, to: 30 }, { from: 90, to: 200 }], moonLit: 0.4 })).toEqual({ darkMs: 90, moonlessMs: 60, moonLit: 0.4 });
});
