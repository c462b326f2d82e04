import { expect, test } from "vitest";
import type { MissionShape, SiteShape } from "../../../src/generated/api.js";
import { draftOf, emptyDraft, emptyStep, movedStep, readDraft, scheduleText } from "../../../src/pages/missions/mission-draft.js";

const SITE: SiteShape = {
  site: "agv", name: "AGV", zone: "Europe/Madrid", online: true, since_us: 0, last_seen_us: 0, catalogue: "c", place: null, rules: [], enclosures: [], shown_units: {}, map: null,
  devices: [
    {
      id: "base", name: "Base", kind: "vehicle", signals: [], streams: [], drive: null, public: false, link_loss: "", pointing: null, slew: null, unguarded: false, rights: ["view", "use"],
      commands: [
        {
          id: "turn", name: "Turn", role: "none", description: "", confirm: false, timeout: 10, cancellable: true, needs: null, ros: "",
          arguments: [{ id: "angle", name: "Angle", type: "number", unit: "deg", minimum: -180, maximum: 180, max_length: 200, default: null }],
        },
      ],
    },
  ],
};
const MISSION: MissionShape = {
  name: "Patrol", note: "",
  steps: [
    { kind: "command", name: "", device: "base", command: "turn", args: { angle: 90 }, units: { angle: "deg" }, condition: "", seconds: 0, goes_on: true },
    { kind: "until", name: "", device: "", command: "", args: {}, units: {}, condition: "{base/x} > 1", seconds: 60, goes_on: false },
    { kind: "pause", name: "Rest", device: "", command: "", args: {}, units: {}, condition: "", seconds: 5, goes_on: false },
  ],
  schedule: { at: "06:00", days: ["mon"], date: "" },
};

test("a mission that goes through the form comes out the same", () => {
  expect(readDraft(draftOf("7", MISSION), SITE)).toEqual({ mission: MISSION, errors: {} });
});

test("what is missing or out of its limits is told at its place", () => {
  const draft = draftOf("7", MISSION);
  const wrong = [{ typed: { angle: "999" } }, { condition: " " }, { seconds: "0" }];
  const steps = [...draft.steps.map((step, at) => ({ ...step, ...wrong[at] })), emptyStep()];
  const { mission, errors } = readDraft({ ...draft, name: "", schedule: "once", date: "", steps }, SITE);
  expect(mission).toBeNull();
  const fields = ["angle", "condition", "seconds", "command"];
  const places = steps.map(({ key }, at) => `${String(key)}/${String(fields[at])}`);
  expect(Object.keys(errors).sort()).toEqual(["date", "name", ...places].sort());
});

test("a step is moved up and down, and stays where there is no further", () => {
  const [first, second, third] = [emptyStep(), emptyStep("pause"), emptyStep("until")] as const;
  const steps = [first, second, third];
  const [a, b, c] = [first.key, second.key, third.key] as const;
  expect(movedStep(steps, b, -1).map(({ key }) => key)).toEqual([b, a, c]);
  expect(movedStep(steps, b, 1).map(({ key }) => key)).toEqual([a, c, b]);
  expect(movedStep(steps, a, -1)).toEqual(steps);
});

test("when it begins is said in words", () => {
  expect(scheduleText(null)).toBe("begins when somebody presses start");
  expect(scheduleText({ at: "06:00", days: [], date: "" })).toBe("every day at 06:00");
  expect(scheduleText({ at: "06:00", days: ["fri", "mon"], date: "" })).toBe("Mon, Fri at 06:00");
  expect(scheduleText({ at: "06:00", days: [], date: "2026-12-01" })).toBe("once, on 2026-12-01 at 06:00");
  expect(emptyDraft().steps).toHaveLength(1);
});
