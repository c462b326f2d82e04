import { expect, test } from "vitest";
import { definitionOf, FIELDS, alarmFields, kindFitsType, idOf, fieldLabel } from "../../../src/pages/alarms/alarm-definition.js";
import { historyAt, alarmStatus } from "../../../src/elements/feedback/alarm-labels.js";
import type { AlarmUpdate } from "../../../src/generated/wire.js";

test("a form says a definition, with only the keys of its kind", () => {
  const said = definitionOf({ name: " Low ", kind: "limit", severity: "critical", signal: "power/voltage", below: "11,2", delay: "", expression: "x", record: "on" });
  expect(said).toEqual({
    definition: {
      name: "Low", kind: "limit", severity: "critical", record: true, signal: "power/voltage", above: null, below: 11.2,
      hysteresis: 0, delay: 0, clear_delay: 0, max_age: null, unknown_after: null, advice: "",
      repeat: null, escalate: [], remind: null,
    },
  });
  expect(definitionOf({ kind: "limit", above: "eleven" })).toEqual({ wrong: "above" });
});

test("an alarm about a device is about none of its signals alone", () => {
  const said = definitionOf({ name: "Odd", kind: "anomaly", signal: "power/voltage", device: "power" });
  expect(said).toMatchObject({ definition: { device: "power", signal: "" } });
  expect(definitionOf({ name: "Odd", kind: "anomaly", signal: "power/voltage" })).toMatchObject({ definition: { device: "", signal: "power/voltage" } });
});

test("a definition fills the form, and comes back as it was", () => {
  const definition = { name: "Door", kind: "state", severity: "info", record: false, signal: "a/door", is_one_of: ["open", "ajar"], is_not: [], delay: 2, clear_delay: 0, max_age: null, unknown_after: 60, advice: "Shut it.", repeat: 60, escalate: [{ who: "eve", after: 300 }], remind: null } as const;
  expect(definitionOf(alarmFields(definition))).toEqual({ definition });
});

test("a short name is made of any name", () => {
  expect(idOf("Battery low!")).toBe("battery_low");
  expect(idOf("3 Tür offen")).toBe("tu_r_offen");
  expect(idOf("温度")).toBe("alarm");
});

test("what cannot be judged is never called well", () => {
  const alarm = { phase: "normal", known: false } as AlarmUpdate;
  expect(alarmStatus(alarm, false)).toEqual(["unknown", "cannot be judged"]);
  expect(alarmStatus({ ...alarm, known: true }, true)).toEqual(["ok", "well, shelved"]);
  expect(alarmStatus({ ...alarm, phase: "active" }, false)[0]).toBe("bad");
});

test("an alarm leads to its chart at the moment when it was raised", () => {
  const path = historyAt({ site: "agv", signals: ["power/voltage"], raised_us: 1000e6, cleared_us: 1010e6 });
  expect(path).toBe("/sites/agv/history?c=power/voltage&from=880000000&to=1130000000");
});

test("a number is asked for in the signal's unit, and of the signals only those that fit", () => {
  const above = FIELDS.find(({ name: name }) => name === "above");
  if (above === undefined) throw new Error("there is no such field");
  expect([fieldLabel(above, "V"), fieldLabel(above, "")]).toEqual(["Raised above (V)", "Raised above"]);
  expect([kindFitsType("limit", "number"), kindFitsType("limit", "state"), kindFitsType("state", "text"), kindFitsType("state", "number"), kindFitsType("stale", "state")]).toEqual([true, false, true, false, true]);
});
