import { expect, test } from "vitest";
import type { AbilitiesShape, GroupAsk, GroupShape } from "../../../../src/generated/api.js";
import { parseDec, parseRa } from "../../../../src/format/sexagesimal.js";
import { newGroup, replaceRequest, rowField, swapRequests, writeField, type GroupDraft, type RequestDraft } from "../../../../src/pages/requests/form/draft.js";
import { coordinateTexts, draftOf, movedToNow, withZone } from "../../../../src/pages/requests/form/fill-draft.js";
import { readGroup, type DraftReading } from "../../../../src/pages/requests/form/read-draft.js";

const momentOf = (text: string): number => Date.parse(`${text}Z`) * 1000;
const textOf = (us: number): string => new Date(us / 1000).toISOString().slice(0, 19);
const NOW = momentOf("2026-11-23T20:00:00");
const END = momentOf("2026-12-23T20:00:00");
const WINDOW = { start: "2026-11-23T20:00:00", end: "2026-12-23T20:00:00", startUs: null, endUs: null };
const ABILITIES: AbilitiesShape = {
  filters: ["R", "Ha"], types: ["LIGHT", "DARK", "BIAS"], exposure: { low: 0.01, high: 600 }, binning: { low: 1, high: 4 }, gain: { low: 0, high: 300 }, guides: false, field: null,
  measures_seeing: true, measures_clouds: true,
};
const READING: DraftReading = { momentOf, nowUs: NOW, abilities: ABILITIES };

function whole(change: Partial<RequestDraft> = {}): GroupDraft {
  const made = newGroup("P1", WINDOW);
  const [request] = made.requests;
  if (request === undefined) throw new Error("a new group has a request");
  return { ...made, requests: [{ ...request, target: "M 42", ra: "05:35:17", dec: "-05:23:28", moonLit: "50", ...change }] };
}

/** As the hub would have it once it is kept. */
function kept(asked: GroupAsk | null): GroupShape {
  const requests = asked?.requests.map((request, i) => ({ id: String(i), state: "DRAFT", frames_done: [], failures: 0, charge_s: 1, ...request }));
  return { ...asked, id: "1", requests } as unknown as GroupShape;
}

test("a whole form is what the hub is asked for, with shutter time", () => {
  const { asked, problems, requests, shutterS } = readGroup(whole(), READING);
  expect([...problems, ...(requests[0]?.problems ?? [])]).toEqual([]);
  expect(shutterS).toBe(600);
  expect(asked).toMatchObject({ proposal: "P1", operator: "SINGLE", urgency: "NORMAL", priority: 10 });
  expect(asked?.requests[0]).toMatchObject({
    target: { type: "ICRS", name: "M 42", proper_motion_ra: 0, epoch: 2000 },
    constraints: { min_altitude: 30, max_airmass: 10, max_moon_illumination: 0.5, max_clouds: null, phase: null },
    windows: [{ start_us: NOW, end_us: END }],
  });
});

const ROW = whole().requests[0]?.frames[0];
test.each([
  [{ ra: "5 hours or so" }, "ra"],
  [{ dec: "-95" }, "dec"],
  [{ motionRa: "fast" }, "motionRa"],
  [{ epoch: "1500" }, "epoch"],
  [{ way: "fixed", altitude: "91" }, "altitude"],
  [{ way: "none" }, "way"],
  [{ minAltitude: "" }, "minAltitude"],
  [{ clouds: "101" }, "clouds"],
  [{ phasePeriod: "2.5" }, "phaseEpoch"],
  [{ phaseEpoch: "yesterday", phasePeriod: "2.5", phaseStart: "0", phaseEnd: "1" }, "phaseEpoch"],
  [{ windows: [{ ...WINDOW, start: "" }] }, rowField("start", 0)],
  [{ windows: [WINDOW, { ...WINDOW, end: "2026-11-23T19:00:00" }] }, rowField("end", 1)],
  [{ windows: [{ ...WINDOW, start: "2026-11-01T00:00:00", end: "2026-11-02T00:00:00" }] }, rowField("end", 0)],
  [{ windows: [] }, "windows"],
  [{ frames: [] }, "frames"],
  [{ frames: [ROW, { ...ROW, type: "DARK" }] }, "frames"],
  [{ frames: [{ ...ROW, count: "1.5" }] }, rowField("count", 0)],
  [{ frames: [{ ...ROW, exposure: "minute" }] }, rowField("exposure", 0)],
  [{ frames: [{ ...ROW, exposure: "601" }] }, rowField("exposure", 0)],
  [{ frames: [{ ...ROW, filter: "L" }] }, rowField("filter", 0)],
  [{ frames: [{ ...ROW, binning: "5" }] }, rowField("binning", 0)],
  [{ frames: [{ ...ROW, gain: "301" }] }, rowField("gain", 0)],
  [{ frames: [{ ...ROW, guiding: "ON" }] }, rowField("guiding", 0)],
  [{ frames: [{ ...ROW, type: "SKY_FLAT" }] }, rowField("type", 0)],
] as const)("what is wrong is said at its field: %j", (change, field) => {
  const { asked, requests } = readGroup(whole(change as unknown as Partial<RequestDraft>), READING);
  expect(asked).toBeNull();
  expect([...(requests[0]?.problems.keys() ?? [])]).toContain(field);
});

test("what a site cannot choose is refused where it is written, and is no question where it is not", () => {
  const plain = { ...ABILITIES, filters: null, binning: null, gain: null };
  expect(readGroup(whole({ frames: ROW === undefined ? [] : [{ ...ROW, filter: "a note" }] }), { ...READING, abilities: plain }).asked).not.toBeNull();
  expect(readGroup(whole({ frames: ROW === undefined ? [] : [{ ...ROW, binning: "2" }] }), { ...READING, abilities: plain }).asked).toBeNull();
});

test("a limit on what a site does not measure would hold nothing back, and is refused at its field", () => {
  const blind = { ...READING, abilities: { ...ABILITIES, measures_seeing: false, measures_clouds: false } };
  const read = readGroup(whole({ seeing: "2.5", clouds: "20" }), blind);
  expect(read.asked).toBeNull();
  expect([...(read.requests[0]?.problems.keys() ?? [])]).toEqual(["seeing", "clouds"]);
  expect(readGroup(whole(), blind).asked).not.toBeNull();
});

test("all of a group comes back into its form, and asks the same", () => {
  const star: Partial<RequestDraft> = {
    motionRa: "-801.551", motionDec: "10362.394", epoch: "2016", maxAirmass: "1.8", hourAngle: "3", seeing: "2.5", clouds: "20",
    phasePeriod: "0.56738", phaseEpoch: "JD 2460000.1234", phaseStart: "0.9", phaseEnd: "0.1",
    windows: [{ ...WINDOW, startUs: NOW + 1, endUs: END - 1 }, { ...WINDOW, start: "2027-01-01T20:00:00", end: "2027-01-02T04:00:00" }],
    frames: ROW === undefined ? [] : [{ ...ROW, filter: "R", gain: "120", binning: "2", dither: "5", guiding: "OFF" }, { ...ROW, filter: "Ha", exposure: "0.1" }],
  };
  const dark: Partial<RequestDraft> = { way: "none", frames: ROW === undefined ? [] : [{ ...ROW, type: "DARK" }, { ...ROW, type: "BIAS", exposure: "0" }] };
  const fixed: Partial<RequestDraft> = { way: "fixed", altitude: "80.5", azimuth: "12.25", moonLit: "" };
  const requests = [star, dark, fixed, { way: "body" as const, body: "saturn" as const, target: "Saturn" }].flatMap((change) => whole(change).requests);
  const written: GroupDraft = { ...whole(), name: "All", operator: "SEQUENCE", urgency: "TIME_CRITICAL", priority: "12.5", requests };
  const { asked } = readGroup(written, READING);
  expect(asked).not.toBeNull();
  expect(asked?.requests[0]?.windows[0]).toEqual({ start_us: NOW + 1, end_us: END - 1 });
  expect(readGroup(draftOf(kept(asked), textOf), READING).asked).toEqual(asked);
});

test("a phase that is counted from long ago is counted from a later cycle, and is the same", () => {
  const phase = { phasePeriod: "2.5", phaseEpoch: "JD 2415020.5", phaseStart: "0.2", phaseEnd: "0.4" };
  const read = readGroup(whole(phase), READING).asked?.requests[0]?.constraints?.phase;
  expect(read?.epoch_us).toBeGreaterThanOrEqual(0);
  const cycles = ((read?.epoch_us ?? 0) / 86_400e6 + 2_440_587.5 - 2_415_020.5) / 2.5;
  expect(Math.abs(cycles - Math.round(cycles))).toBeLessThan(1e-9);
});

test("what is asked once more begins now when it is over, with all of its distances", () => {
  const over = kept(readGroup(whole({ windows: [WINDOW, { ...WINDOW, start: "2026-12-24T20:00:00", end: "2026-12-25T20:00:00" }] }), READING).asked);
  const later = NOW + 365 * 86_400e6;
  const windows = movedToNow(over, later).requests[0]?.windows ?? [];
  expect(windows[0]).toEqual({ start_us: later, end_us: later + END - NOW });
  expect((windows[1]?.start_us ?? 0) - later).toBe(momentOf("2026-12-24T20:00:00") - NOW);
  expect(movedToNow(over, NOW)).toBe(over);
});

test("typing changes one field of the request that is shown, and of its rows", () => {
  let draft = replaceRequest(whole(), 1, whole({ target: "M 31" }).requests);
  expect(draft.operator).toBe("MANY");
  draft = writeField(draft, 1, "minAltitude", "40");
  draft = writeField(draft, 1, "end-0", "2026-12-01T00:00:00");
  draft = writeField(draft, 1, "type-0", "BIAS");
  draft = writeField(draft, 0, "operator", "SEQUENCE");
  expect(draft.operator).toBe("SEQUENCE");
  expect(draft.requests[0]?.minAltitude).toBe("30");
  expect(draft.requests[1]).toMatchObject({ minAltitude: "40", windows: [{ end: "2026-12-01T00:00:00", endUs: null }], frames: [{ type: "BIAS", exposure: "0", guiding: "OFF" }] });
  expect(swapRequests(draft, 0, 1).requests.map(({ target }) => target)).toEqual(["M 31", "M 42"]);
});

test("by another clock what was kept is shown anew, and what was typed stays", () => {
  const draft = draftOf(kept(readGroup(whole({ windows: [WINDOW, WINDOW] }), READING).asked), textOf);
  const typed = writeField(draft, 0, "start-1", "2026-11-25T00:00:00");
  const shown = withZone(typed, (us) => textOf(us + 3_600e6)).requests[0]?.windows;
  expect(shown?.[0]?.start).toBe("2026-11-23T21:00:00");
  expect(shown?.[1]?.start).toBe("2026-11-25T00:00:00");
});

test("coordinates are shown so exactly that nothing is lost by reading them", () => {
  for (const [ra, dec] of [[83.82208, -5.39111], [0.0000123, 89.99999], [359.9999, -0.00002]] as const) {
    const texts = coordinateTexts(ra, dec);
    expect(Math.abs(parseRa(texts.ra) * 15 - ra)).toBeLessThan(3e-6);
    expect(Math.abs(parseDec(texts.dec) - dec)).toBeLessThan(3e-6);
  }
});
