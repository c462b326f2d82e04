import { expect, test } from "vitest";
import { readCadence, visitsOf } from "../../../../src/pages/requests/form/cadence.js";
import { newRequest } from "../../../../src/pages/requests/form/draft.js";

const momentOf = (text: string): number => Date.parse(`${text}Z`) * 1000;
const textOf = (us: number): string => new Date(us / 1000).toISOString().slice(0, 19);
const WEEK = { first: "2026-12-01T22:00", every: "24", within: "1.5", visits: "7" };

test("a cadence is a request for each visit, with a window round its time", () => {
  const read = readCadence(WEEK, momentOf, 0);
  const visits = visitsOf({ ...newRequest({ start: "", end: "", startUs: null, endUs: null }), target: "SS Cyg" }, read, textOf);
  expect(visits).toHaveLength(7);
  expect(visits.every(({ target }) => target === "SS Cyg")).toBe(true);
  expect(visits[6]?.windows).toEqual([
    { start: "2026-12-07T20:30:00", end: "2026-12-07T23:30:00", startUs: momentOf("2026-12-07T20:30"), endUs: momentOf("2026-12-07T23:30") },
  ]);
});

test.each([
  [{ first: "" }, "first"],
  [{ every: "0" }, "every"],
  [{ within: "13" }, "within"],
  [{ visits: "1" }, "visits"],
  [{ visits: "2.5" }, "visits"],
  [{ visits: "999" }, "visits"],
] as const)("what is wrong of it is said at its field: %j", (change, field) => {
  const read = readCadence({ ...WEEK, ...change }, momentOf, 5);
  expect(read.windows).toEqual([]);
  expect([...read.problems.keys()]).toContain(field);
});
