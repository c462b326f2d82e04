import { expect, test } from "vitest";
import type { FrameShape, NightStateShape, PlanShape } from "../../src/generated/api.js";
import { placePauses } from "../../src/series/plan-layout.js";
import { nightBlocks, plannedBlocks, shareRows, takenBlocks } from "../../src/series/night-blocks.js";

const MINUTE_US = 60e6;

function frame(minute: number, target: string, filter = "R"): FrameShape {
  return {
    id: String(minute), device: "camera", night: "2026-11-23", name: "", time_us: minute * MINUTE_US, target, filter, kind: "Light", exposure_s: 60,
    ra_deg: null, dec_deg: null, width: 1, height: 1, bytes: 1, digest: "", problems: [], measured: false, solved: false, stars: null, fwhm: null, background: null, zero_point: null, note: "",
  };
}

const PLAN: PlanShape = {
  made_us: 0, night_start_us: 0, night_end_us: 600 * MINUTE_US, method: "dispatch", value: 1, bound: null,
  blocks: [
    { request: "7", proposal: "P1", target: "M 42", start_us: 100 * MINUTE_US, end_us: 130 * MINUTE_US, overhead_s: 20, reason: "highest", pauses: [{ kind: "flip", start_us: 110 * MINUTE_US, end_us: 112 * MINUTE_US, reason: "its target passes the meridian" }] },
    { request: "", proposal: "", target: "", start_us: 130 * MINUTE_US, end_us: 160 * MINUTE_US, overhead_s: 20, reason: "", pauses: [] },
  ],
};
const STATE: NightStateShape = {
  phase: "observing", armed_by: "ada", armed_until_us: 0, why: "", since_us: 0, request: "7", step: "exposing", frames_done: 1, frames: 3, heard_us: 0, site_time_us: 0, speed: 0,
};

test("frames of one target in a row are one visit, and after a pause another", () => {
  const visits = takenBlocks([frame(12, "M 31", "V"), frame(11, "M 31"), frame(40, "M 31"), frame(42, "M 33"), frame(44, "")], [{ id: "3", target: "M 31", proposal: "P2" }]);
  expect(visits.map(({ name, startMs, endMs, reason }) => [name, startMs / 60_000, endMs / 60_000, reason])).toEqual([
    ["M 31", 11, 13, "2 frames (R, V)."],
    ["M 31", 40, 41, "1 frame (R)."],
    ["M 33", 42, 43, "1 frame (R)."],
  ]);
  expect(visits.map(({ request, proposal }) => [request, proposal])).toEqual([["3", "P2"], ["3", "P2"], ["", ""]]);
});

test("pictures for focus and centring are no visit of their own", () => {
  const visits = takenBlocks([frame(10, "focus or centring"), frame(11, "M 31"), frame(12, "M 31"), frame(13, "focus or centring")], []);
  expect(visits.map(({ name }) => name)).toEqual(["M 31"]);
});

test("of a plan what is over is left away, what is observed is current, and another's block has no name", () => {
  expect(plannedBlocks(PLAN, STATE, 110 * 60_000).map(({ name, state }) => [name, state])).toEqual([["M 42", "current"], ["another's request", "planned"]]);
  expect(plannedBlocks(PLAN, null, 131 * 60_000).map(({ name }) => name)).toEqual(["another's request"]);
  expect(plannedBlocks(null, STATE, 0)).toEqual([]);
});

test("a turn at the meridian stands on the line where the plan has it, and is cut to the window", () => {
  const planned = plannedBlocks(PLAN, null, 0);
  expect(planned[0]?.pauses).toEqual([{ kind: "flip", startMs: 110 * 60_000, endMs: 112 * 60_000, reason: "its target passes the meridian" }]);
  const [pause] = placePauses(planned, { from: 111 * 60_000, to: 121 * 60_000 });
  expect([pause?.left, pause?.width]).toEqual([0, 0.1]);
  expect(placePauses(planned, { from: 113 * 60_000, to: 121 * 60_000 })).toEqual([]);
});

test("frames of the block that is observed are not shown a second time", () => {
  const planned = plannedBlocks(PLAN, STATE, 110 * 60_000);
  const taken = takenBlocks([frame(50, "M 31"), frame(102, "M 42")], []);
  expect(nightBlocks(taken, planned).map(({ name, state }) => [name, state])).toEqual([["M 31", "done"], ["M 42", "current"], ["another's request", "planned"]]);
});

test("shares that are got sum to one, those due to at most one, and nobody's is not a number", () => {
  const proposal = (id: string, share: number, used: number) => ({ id, title: "", share, used_s: used, hours_allocated: 1, active: true });
  expect(shareRows([proposal("a", 1, 300), proposal("b", 1, 100)]).map(({ due, got }) => [due, got])).toEqual([[0.5, 0.75], [0.5, 0.25]]);
  expect(shareRows([proposal("a", 0.4, 0)])[0]).toMatchObject({ due: 0.4, got: Number.NaN });
});
