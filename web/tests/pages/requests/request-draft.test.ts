import { expect, test } from "vitest";
import type { GroupShape } from "../../../src/generated/api.js";
import { coordinateTexts, draftOf, newDraft, readDraft, rowField, type RequestDraft } from "../../../src/pages/requests/request-draft.js";
import { parseDec, parseRa } from "../../../src/format/sexagesimal.js";

const momentOf = (text: string): number => Date.parse(`${text}Z`) * 1000;
const textOf = (us: number): string => new Date(us / 1000).toISOString().slice(0, 19);
const NOW = momentOf("2026-11-23T20:00:00");
const WHOLE: RequestDraft = {
  ...newDraft("P1", { start: "2026-11-23T20:00:00", end: "2026-12-23T20:00:00" }), target: "M 42", ra: "05:35:17", dec: "-05:23:28", moonLit: "50",
};
const read = (change: Partial<RequestDraft>): ReturnType<typeof readDraft> => readDraft({ ...WHOLE, ...change }, momentOf, NOW);

test("a whole form is what the hub is asked for, with shutter time", () => {
  const { asked, problems, shutterS } = read({});
  expect([...problems]).toEqual([]);
  expect(shutterS).toBe(600);
  expect(asked).toMatchObject({ proposal: "P1", urgency: "NORMAL", priority: 10 });
  expect(asked?.requests[0]).toMatchObject({
    target: { type: "ICRS", name: "M 42" }, constraints: { min_altitude: 30, max_airmass: 10, max_moon_illumination: 0.5, max_clouds: null },
    windows: [{ start_us: NOW, end_us: momentOf("2026-12-23T20:00:00") }],
  });
});

test.each([
  [{ proposal: "" }, "proposal"],
  [{ ra: "5 hours or so" }, "ra"],
  [{ dec: "-95" }, "dec"],
  [{ way: "fixed", altitude: "91" }, "altitude"],
  [{ way: "none" }, "way"],
  [{ minAltitude: "" }, "minAltitude"],
  [{ clouds: "101" }, "clouds"],
  [{ windowStart: "" }, "windowStart"],
  [{ windowEnd: "2026-11-23T19:00:00" }, "windowEnd"],
  [{ configurations: [] }, "configurations"],
  [{ configurations: [{ ...WHOLE.configurations[0], count: "1.5" }] }, rowField("count", 0)],
  [{ configurations: [{ ...WHOLE.configurations[0], exposure: "minute" }] }, rowField("exposure", 0)],
] as const)("what is wrong is said at its field: %j", (change, field) => {
  const { asked, problems } = read(change as Partial<RequestDraft>);
  expect(asked).toBeNull();
  expect([...problems.keys()]).toContain(field);
});

test("a group of one request comes back into its form, and asks the same", () => {
  const { asked } = read({});
  const request = { id: "1", state: "DRAFT", frames_done: [], failures: 0, charge_s: 1, ...asked?.requests[0] };
  const group = { ...asked, id: "1", name: "Orion", requests: [request] } as unknown as GroupShape;
  const draft = draftOf(group, textOf);
  expect(draft).not.toBeNull();
  if (draft !== null) expect(readDraft(draft, momentOf, NOW).asked?.requests).toEqual(asked?.requests);
  expect(draftOf({ ...group, requests: [...group.requests, ...group.requests] }, textOf)).toBeNull();
});

test("coordinates are shown so exactly that nothing is lost by reading them", () => {
  for (const [ra, dec] of [[83.82208, -5.39111], [0.0000123, 89.99999], [359.9999, -0.00002]] as const) {
    const texts = coordinateTexts(ra, dec);
    expect(Math.abs(parseRa(texts.ra) * 15 - ra)).toBeLessThan(3e-6);
    expect(Math.abs(parseDec(texts.dec) - dec)).toBeLessThan(3e-6);
  }
});
