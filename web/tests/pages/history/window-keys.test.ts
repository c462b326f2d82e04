import { describe, expect, it } from "vitest";
import { pageKeyAction } from "../../../src/pages/history/window-keys.js";
import { ZoneClock } from "../../../src/series/zone-clock.js";

const madrid = new ZoneClock("Europe/Madrid");
const us = (text: string): number => Date.parse(text) * 1000;
const SPAN = { fromUs: us("2026-11-21T10:00:00Z"), toUs: us("2026-11-21T10:10:00Z") };

describe("keys of the history page", () => {
  it("pan and zoom the window while no chart has the focus", () => {
    expect(pageKeyAction("ArrowRight", false, SPAN, madrid)).toEqual({ wish: "span", span: { fromUs: SPAN.fromUs + 60e6, toUs: SPAN.toUs + 60e6 } });
    expect(pageKeyAction("+", false, SPAN, madrid)).toEqual({ wish: "span", span: { fromUs: SPAN.fromUs + 150e6, toUs: SPAN.toUs - 150e6 } });
  });

  it("begin the window with its day, then with the day before, and end with the time", () => {
    const first = { fromUs: us("2026-11-20T23:00:00Z"), toUs: us("2026-11-20T23:10:00Z") };
    expect(pageKeyAction("Home", false, SPAN, madrid)).toEqual({ wish: "span", span: first });
    const second = { fromUs: us("2026-11-19T23:00:00Z"), toUs: us("2026-11-19T23:10:00Z") };
    expect(pageKeyAction("Home", false, first, madrid)).toEqual({ wish: "span", span: second });
    expect(pageKeyAction("End", false, SPAN, madrid)).toEqual({ wish: "shown", shown: { last: 600 } });
  });

  it("go back, and leave scrolling and all else to the browser", () => {
    expect(pageKeyAction("Escape", false, SPAN, madrid)).toEqual({ wish: "back" });
    expect(pageKeyAction("0", false, SPAN, madrid)).toEqual({ wish: "back" });
    for (const key of ["PageUp", "PageDown", "Tab", "ArrowUp", "a"]) expect(pageKeyAction(key, false, SPAN, madrid)).toBeNull();
    expect(pageKeyAction("ArrowLeft", true, SPAN, madrid)).toBeNull();
  });
});
