import { describe, expect, it, test } from "vitest";
import type { FieldShape } from "../../../../src/generated/api.js";
import { parseDec, parseRa } from "../../../../src/format/sexagesimal.js";
import { newRequest, type RequestDraft } from "../../../../src/pages/requests/form/draft.js";
import { draftOf } from "../../../../src/pages/requests/form/fill-draft.js";
import { angleText, framingSpan, NEW_FRAMING, panelRequests, readFraming, sizeText, starRadius } from "../../../../src/pages/requests/form/framing-draft.js";
import { readRequest } from "../../../../src/pages/requests/form/read-draft.js";
import { separation } from "../../../../src/sky/tangent-plane.js";

const CENTRE = { raDeg: 10.6848, decDeg: 41.2691 };
const FIELD: FieldShape = { width: 0.4, height: 0.3, position_angle: 20, rotates: true };
const WINDOW = { start: "2026-11-23T20:00:00", end: "2026-12-23T20:00:00", startUs: null, endUs: null };
const READING = { momentOf: (text: string): number => Date.parse(`${text}Z`) * 1000, nowUs: Date.parse("2026-11-23T20:00:00Z") * 1000, abilities: null };
const M31: RequestDraft = { ...newRequest(WINDOW), target: "M 31", ra: "00:42:44.35", dec: "+41:16:08.8" };

describe("framing as it is typed", () => {
  it("begins with one panel at the angle at which the camera stands", () => {
    const { mosaic, field, problems } = readFraming(NEW_FRAMING, CENTRE, FIELD, null);
    expect([...problems]).toEqual([]);
    expect(field).toEqual(FIELD);
    expect(mosaic?.panels.map(({ angle }) => angle)).toEqual([20]);
  });

  it("turns where there is a rotator, and nowhere else", () => {
    const angleOf = (rotates: boolean): number | undefined => readFraming(NEW_FRAMING, CENTRE, { ...FIELD, rotates }, 75).mosaic?.panels[0]?.angle;
    expect([angleOf(true), angleOf(false)]).toEqual([75, 20]);
  });

  it.each([
    [{ across: "0" }, "across"],
    [{ down: "21" }, "down"],
    [{ across: "1.5" }, "across"],
    [{ overlap: "95" }, "overlap"],
  ])("says what is wrong with %j", (change, field) => {
    const { mosaic, problems } = readFraming({ ...NEW_FRAMING, ...change }, CENTRE, FIELD, null);
    expect([...problems.keys()]).toEqual([field]);
    expect(mosaic).toBeNull();
  });

  it("goes by a size that is typed where none is described, and by nothing until then", () => {
    expect(readFraming(NEW_FRAMING, CENTRE, null, null)).toMatchObject({ field: null, mosaic: null });
    expect(readFraming({ ...NEW_FRAMING, width: "1,5", height: "1" }, CENTRE, null, null).field).toEqual({ width: 1.5, height: 1 });
    expect(readFraming({ ...NEW_FRAMING, width: "wide", height: "1" }, CENTRE, null, null).problems.has("width")).toBe(true);
    // A description is not overruled.
    expect(readFraming({ ...NEW_FRAMING, width: "9", height: "9" }, CENTRE, FIELD, null).field?.width).toBe(0.4);
  });
});

test("each panel is a request that differs in its place, its name and its angle", () => {
  const { mosaic } = readFraming({ ...NEW_FRAMING, across: "2", down: "2", overlap: "10" }, CENTRE, FIELD, 0);
  if (mosaic === null) throw new Error("a mosaic");
  const drafts = panelRequests(M31, mosaic, true);
  expect(drafts.map(({ target }) => target)).toEqual(["M 31 panel 1-1", "M 31 panel 1-2", "M 31 panel 2-1", "M 31 panel 2-2"]);
  drafts.forEach((draft, i) => {
    const at = { raDeg: parseRa(draft.ra) * 15, decDeg: parseDec(draft.dec) };
    expect(separation(at, mosaic.panels[i]?.centre ?? CENTRE)).toBeLessThan(3e-5);
    expect({ ...draft, target: "", ra: "", dec: "", angle: "" }).toEqual({ ...M31, target: "", ra: "", dec: "", angle: "" });
    const { asked, problems } = readRequest(draft, READING);
    expect([...problems]).toEqual([]);
    expect(asked.target).toMatchObject({ position_angle: Number(draft.angle) });
  });
  expect(panelRequests(M31, mosaic, false).map(({ angle }) => angle)).toEqual(["", "", "", ""]);
});

test("a position angle is asked for as it is written, and read again", () => {
  const angleOf = (angle: string): unknown => readRequest({ ...M31, angle }, READING).asked.target;
  expect(angleOf("")).not.toHaveProperty("position_angle");
  expect(angleOf("-30")).toMatchObject({ position_angle: 330 });
  expect(angleOf("360")).toMatchObject({ position_angle: 0 });
  expect(readRequest({ ...M31, angle: "askew" }, READING).problems.get("angle")).toContain("Position angle");
  const request = { ...readRequest({ ...M31, angle: "33.5" }, READING).asked, id: "1", state: "DRAFT", frames_done: [], failures: 0, charge_s: 1 };
  const group = { proposal: "P", name: "", operator: "SINGLE", urgency: "NORMAL", priority: 10, requests: [request] } as unknown as Parameters<typeof draftOf>[0];
  expect(draftOf(group, String).requests[0]?.angle).toBe("33.5");
});

test("the drawing has room about the mosaic, and asks for stars in few steps", () => {
  expect(framingSpan({ width: 0.2, height: 0.13 }, 1)).toBe(1.5);
  expect(framingSpan({ width: 3, height: 4 }, 1)).toBe(15);
  expect(framingSpan({ width: 60, height: 60 }, 8)).toBe(40);
  expect(starRadius(1.5)).toBe(2);
  expect(starRadius(1.4)).toBe(2);
  expect(starRadius(40)).toBe(20);
});

test("angles and sizes are written short", () => {
  expect([angleText(0), angleText(12.3456), angleText(359.999)]).toEqual(["0", "12.35", "0"]);
  expect(sizeText({ width: 0.2, height: 0.1 })).toBe("12.0′ × 6.0′");
  expect(sizeText({ width: 2, height: 0.5 })).toBe("2.00° × 0.50°");
});
