import { expect, test } from "vitest";
import { ruleFromForm, quietHours } from "../../../src/pages/account/notification-rule.js";

const FILLED: Readonly<Record<string, string>> = {
  way: "3", target: " op@example.org ", site: "agv", least: "info", from: "22:30", to: "06:05", zone: "Europe/Madrid",
  quiet_least: "critical", group_s: "60", over: "on", own_requests: "on",
};
const said = (fields: Readonly<Record<string, string>>): FormData => {
  const data = new FormData();
  for (const [name, value] of Object.entries(fields)) data.set(name, value);
  return data;
};

test("a form that is filled in asks for a rule", () => {
  expect(ruleFromForm(said(FILLED))).toEqual({
    site: "agv", way: "3", target: "op@example.org", least: "info", over: true, quiet_from: 1350, quiet_to: 365,
    quiet_least: "critical", zone: "Europe/Madrid", group_s: 60, own_requests: true, nights: false,
  });
});

test("without a beginning there are no quiet hours, without an end they last until midnight", () => {
  expect(ruleFromForm(said({ ...FILLED, from: "" }))).toMatchObject({ quiet_from: 0, quiet_to: 0 });
  expect(ruleFromForm(said({ ...FILLED, to: "" }))).toMatchObject({ quiet_from: 1350, quiet_to: 0 });
});

test("what is left out is not asked for: no address, no word when it is over, no time to gather", () => {
  const bare = said({ ...FILLED, group_s: "soon" });
  bare.delete("target");
  bare.delete("over");
  expect(ruleFromForm(bare)).toMatchObject({ target: "", over: false, group_s: 0 });
});

test("quiet hours are shown as they were typed", () => {
  expect(quietHours({ quiet_from: 1350, quiet_to: 365 })).toEqual({ from: "22:30", to: "06:05" });
  expect(quietHours({ quiet_from: 1350, quiet_to: 0 })).toEqual({ from: "22:30", to: "00:00" });
  expect(quietHours({ quiet_from: 60, quiet_to: 60 })).toBeNull();
  expect(quietHours({})).toBeNull();
});
