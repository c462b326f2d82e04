import { describe, expect, it } from "vitest";
import { keyAction } from "../../../src/elements/chart/chart-keys.js";

const SPAN = { fromUs: 1000e6, toUs: 1100e6 };

describe("keys on a chart", () => {
  it("move the cursor, with shift in leaps, and never out of the plot", () => {
    expect(keyAction("ArrowRight", false, 0.5, SPAN, false)).toEqual({ wish: "cursor", part: 0.51 });
    expect(keyAction("ArrowLeft", true, 0.05, SPAN, false)).toEqual({ wish: "cursor", part: 0 });
    expect(keyAction("ArrowLeft", false, null, SPAN, false)).toEqual({ wish: "cursor", part: 1 });
    expect(keyAction("ArrowRight", false, null, SPAN, false)).toEqual({ wish: "cursor", part: 0 });
    expect(keyAction("Escape", false, 0.2, SPAN, false)).toEqual({ wish: "cursor", part: null });
  });

  it("zoom about the cursor, and about the middle without one", () => {
    expect(keyAction("+", false, 0, SPAN, true)).toEqual({ wish: "span", span: { fromUs: 1000e6, toUs: 1050e6 } });
    expect(keyAction("-", false, null, SPAN, true)).toEqual({ wish: "span", span: { fromUs: 950e6, toUs: 1150e6 } });
  });

  it("move the window of a chart that zooms, and with shift its cursor", () => {
    expect(keyAction("ArrowRight", false, 0.5, SPAN, true)).toEqual({ wish: "span", span: { fromUs: 1010e6, toUs: 1110e6 } });
    expect(keyAction("ArrowLeft", false, null, SPAN, true)).toEqual({ wish: "span", span: { fromUs: 990e6, toUs: 1090e6 } });
    expect(keyAction("PageDown", false, null, SPAN, true)).toEqual({ wish: "span", span: { fromUs: 1050e6, toUs: 1150e6 } });
    expect(keyAction("ArrowRight", true, 0.5, SPAN, true)).toEqual({ wish: "cursor", part: 0.51 });
    expect(keyAction("End", true, 0.5, SPAN, true)).toEqual({ wish: "cursor", part: 1 });
    expect(keyAction("End", false, 0.5, SPAN, true)).toBeNull();
  });

  it("leave all else to the page, and zooming to charts that zoom", () => {
    expect(keyAction("Tab", false, 0.5, SPAN, true)).toBeNull();
    expect(keyAction(" ", false, 0.5, SPAN, true)).toBeNull();
    expect(keyAction("+", false, 0.5, SPAN, false)).toBeNull();
    expect(keyAction("Escape", false, null, SPAN, true)).toBeNull();
  });
});
