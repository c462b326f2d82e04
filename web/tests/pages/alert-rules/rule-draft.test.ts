import { expect, test } from "vitest";
import type { AlertRuleAsk, AlertRuleShape } from "../../../src/generated/api.js";
import { filterText, NEW_RULE, readRule, ruleDraft, ruleGroup, type RuleDraft } from "../../../src/pages/alert-rules/rule-draft.js";
import { draftOf } from "../../../src/pages/requests/form/fill-draft.js";
import { readGroup, type ReadRequest } from "../../../src/pages/requests/form/read-draft.js";

const NOW = Date.parse("2026-11-23T20:00:00Z") * 1000;
const textOf = (us: number): string => new Date(us / 1000).toISOString().slice(0, 19);

function readOf(rule: Pick<AlertRuleAsk, "configurations" | "constraints"> | null): ReadRequest | undefined {
  return readGroup(draftOf(ruleGroup(rule, NOW), textOf), { momentOf: (text) => Date.parse(`${text}Z`) * 1000, nowUs: NOW, abilities: null }).requests[0];
}

const WHOLE: RuleDraft = {
  ...NEW_RULE, name: "bright bursts", sources: "*SWIFT*\n\n*FERMI*", largestError: "0.1", lowestDec: "-30", hours: "12",
  parameters: "Rate_Signif >= 7\nTrig_Timescale ≤ 4,5\nPacket_Type = 61, 67",
};

test("a rule is read with its conditions", () => {
  const { asked, problems } = readRule(WHOLE, readOf(null));
  expect([...problems]).toEqual([]);
  expect(asked).toMatchObject({
    name: "bright bursts", hours: 12,
    filter: {
      sources: ["*SWIFT*", "*FERMI*"], roles: ["observation"], largest_error: 0.1, lowest_declination: -30, highest_declination: 90,
      least: { Rate_Signif: 7 }, most: { Trig_Timescale: 4.5 }, equal: { Packet_Type: ["61", "67"] },
    },
    configurations: [{ exposure: 60, count: 5 }],
  });
});

test("a rule that is kept comes back into its form, and asks the same", () => {
  const { asked } = readRule(WHOLE, readOf(null));
  const kept = { ...asked, id: "7", maker: "ada" } as AlertRuleShape;
  expect(readRule(ruleDraft(kept), readOf(kept)).asked).toEqual(asked);
  expect(filterText(kept.filter ?? {})).toBe("from *SWIFT* or *FERMI*, observation, known to 0.1° or better, declination −30° to 90°, Rate_Signif at least 7, Trig_Timescale at most 4.5, Packet_Type is 61 or 67");
});

test.each([
  [{ name: " " }, "name"],
  [{ roles: [] }, "roles"],
  [{ largestError: "wide" }, "largestError"],
  [{ lowestDec: "50", highestDec: "40" }, "highestDec"],
  [{ parameters: "Rate_Signif" }, "parameters"],
  [{ parameters: "Rate_Signif >= much" }, "parameters"],
  [{ hours: "0" }, "hours"],
  [{ priority: "" }, "priority"],
] as const)("what is wrong is said at its field: %j", (change, field) => {
  const { asked, problems } = readRule({ ...WHOLE, ...change }, readOf(null));
  expect(asked).toBeNull();
  expect([...problems.keys()]).toContain(field);
});

test("a rule with frames that are none cannot be kept", () => {
  const read = readOf({ configurations: [{ exposure: -1 }] });
  expect(readRule(WHOLE, read).asked).toBeNull();
});
