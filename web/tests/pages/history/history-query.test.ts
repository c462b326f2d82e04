import { describe, expect, it } from "vitest";
import { quickOf, quickShown, readView, spanOf, writeView, type HistoryView } from "../../../src/pages/history/history-query.js";
import { ZoneClock } from "../../../src/series/zone-clock.js";

const madrid = new ZoneClock("Europe/Madrid");
const NOW = Date.parse("2026-11-21T10:00:00Z") * 1000;
describe("the address of the history page", () => {
  it("reads back what it wrote", () => {
    const views: HistoryView[] = [
      { channels: ["base/speed", "base/pose.x"], shown: { last: 3600 }, joined: true, without: ["stop", "link"], versus: 7, shiftUs: 0, outliers: 2.5 },
      { channels: [], shown: { fromUs: 1_795_000_000_000_001, toUs: 1_795_000_000_500_000 }, joined: false, without: [], versus: 0, shiftUs: 0, outliers: 0 },
      { channels: null, shown: { last: 300 }, joined: false, without: [], versus: 0, shiftUs: 0, outliers: 0 },
      { channels: ["odd/ä&c=x"], shown: { last: 7 }, joined: false, without: [], versus: 0, shiftUs: 0, outliers: 0 },
      { channels: null, shown: { fromUs: 5, toUs: 60 }, joined: false, without: [], versus: 0, shiftUs: -3600000000, outliers: 0, at: 7, films: ["cam/a", "b/ä&c"] },
      { channels: null, shown: { fromUs: 5, toUs: 60 }, joined: false, without: [], versus: 0, shiftUs: 0, outliers: 0, films: [] },
    ];
    for (const view of views) expect(readView(writeView(view))).toEqual(view);
  });

  it("is as if empty where it makes no sense", () => {
    for (const search of ["", "?from=5&to=4", "?without=nothing", "?versus=0.5", "?versus=x", "?last=-3", "?last=x", "?from=1e99&to=2e99", "?from=1", "?at=x", "?at=-1", "?at=0.5", "?shift=soon", "?shift=0.5"]) {
      expect(readView(search)).toEqual({ channels: null, shown: { last: 900 }, joined: false, without: [], versus: 0, shiftUs: 0, outliers: 0 });
    }
    expect(readView("?c=a&c=a").channels).toEqual(["a"]);
  });

  it("knows its quick ranges by the site's own days", () => {
    const today = quickShown("today", NOW, madrid);
    expect(today).toEqual({ fromUs: Date.parse("2026-11-20T23:00:00Z") * 1000, toUs: Date.parse("2026-11-21T23:00:00Z") * 1000 });
    expect(quickOf(today, NOW, madrid)).toBe("today");
    expect(quickOf(quickShown("yesterday", NOW, madrid), NOW, madrid)).toBe("yesterday");
    expect(quickOf({ last: 900 }, NOW, madrid)).toBe("900");
    expect(quickOf({ last: 901 }, NOW, madrid)).toBe("");
    expect(spanOf({ last: 60 }, NOW)).toEqual({ fromUs: NOW - 60e6, toUs: NOW });
  });
});
