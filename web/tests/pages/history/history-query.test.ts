import { describe, expect, it } from "vitest";
import { loadedSeries } from "../../../src/pages/history/data/history-loader.js";
import { quickOf, quickShown, readView, spanOf, writeView, type HistoryView } from "../../../src/pages/history/history-query.js";
import { firstChoice, channelRows, groupChannels } from "../../../src/pages/history/data/channel-rows.js";
import { textBand } from "../../../src/pages/history/data/text-band.js";
import { stateRuns } from "../../../src/series/state-runs.js";
import { ZoneClock } from "../../../src/series/zone-clock.js";
import type { SignalInfo, SiteDetail, StoredInfo } from "../../../src/wire/api-types.js";

const madrid = new ZoneClock("Europe/Madrid");
const NOW = Date.parse("2026-11-21T10:00:00Z") * 1000;

describe("the address of the history page", () => {
  it("reads back what it wrote", () => {
    const views: HistoryView[] = [
      { channels: ["base/speed", "base/pose.x"], shown: { last: 3600 }, joined: true, without: ["stop", "link"], versus: 7, outliers: 2.5 },
      { channels: [], shown: { fromUs: 1_795_000_000_000_001, toUs: 1_795_000_000_500_000 }, joined: false, without: [], versus: 0, outliers: 0 },
      { channels: null, shown: { last: 300 }, joined: false, without: [], versus: 0, outliers: 0 },
      { channels: ["odd/ä&c=x"], shown: { last: 7 }, joined: false, without: [], versus: 0, outliers: 0 },
      { channels: null, shown: { fromUs: 5, toUs: 60 }, joined: false, without: [], versus: 0, outliers: 0, at: 7, films: ["cam/a", "b/ä&c"] },
      { channels: null, shown: { fromUs: 5, toUs: 60 }, joined: false, without: [], versus: 0, outliers: 0, films: [] },
    ];
    for (const view of views) expect(readView(writeView(view))).toEqual(view);
  });

  it("is as if empty where it makes no sense", () => {
    for (const search of ["", "?from=5&to=4", "?without=nothing", "?versus=0.5", "?versus=x", "?last=-3", "?last=x", "?from=1e99&to=2e99", "?from=1", "?at=x", "?at=-1", "?at=0.5"]) {
      expect(readView(search)).toEqual({ channels: null, shown: { last: 900 }, joined: false, without: [], versus: 0, outliers: 0 });
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

function signal(id: string, change: Partial<SignalInfo> = {}): SignalInfo {
  return {
    id, address: `base/${id}`, name: id, type: "number", unit: "m", decimals: -1, minimum: null, maximum: null,
    states: [], frame: "local", max_age: 5, primary: true, public: false, channels: [`base/${id}`], ...change,
  };
}

const DETAIL: SiteDetail = {
  site: "agv", name: "A", zone: "UTC", online: true, catalogue: "1", since_us: 0, place: null, rules: [], enclosures: [], last_seen_us: 0,
  devices: [
    {
      id: "base", name: "Base", kind: "vehicle", streams: [], commands: [], drive: null, public: false, link_loss: "", pointing: null, unguarded: false, rights: [],
      signals: [
        signal("left"),
        signal("volt", { unit: "V", primary: false }),
        signal("right"),
        signal("mode", { type: "state", unit: "", states: ["off", "on"] }),
        signal("pose", { type: "position", unit: "", channels: ["base/pose.x", "base/pose.yaw"], primary: false }),
        signal("count", { unit: "" }),
      ],
    },
  ],
};

describe("rows of the history page", () => {
  it("share a chart when they share a unit, and states and unitless numbers stand alone", () => {
    const groups = groupChannels(channelRows(DETAIL)).map(({ title, rows }) => [title, rows.map(({ address }) => address)]);
    expect(groups).toEqual([
      ["m", ["base/left", "base/right", "base/pose.x"]],
      ["V", ["base/volt"]],
      ["mode", ["base/mode"]],
      ["rad", ["base/pose.yaw"]],
      ["", ["base/count"]],
    ]);
  });

  it("share a chart with other units when asked to, at most so many units in one", () => {
    const groups = (axes: number): [string, readonly string[]][] =>
      groupChannels(channelRows(DETAIL), axes).map(({ title, rows }) => [title, rows.map(({ address }) => address)]);
    expect(groups(4)).toEqual([
      ["m, V, rad, no unit", ["base/left", "base/right", "base/pose.x", "base/volt", "base/pose.yaw", "base/count"]],
      ["mode", ["base/mode"]],
    ]);
    expect(groups(2).map(([title]) => title)).toEqual(["m, V", "rad, no unit", "mode"]);
  });

  it("show last what is no longer described, as what it was, and nothing twice", () => {
    const was = { described: false, samples: 3, first_us: 1, last_us: 3, decimals: -1 };
    const former: StoredInfo[] = [
      { ...was, address: "base/left", name: "left", type: "number", unit: "m", states: [] },
      { ...was, address: "base/gear", name: "Gear", type: "state", unit: "", states: ["low", "high"] },
      { ...was, address: "arm/place.yaw", name: "Place", type: "position", unit: "", states: [] },
      { ...was, address: "arm/old", name: "", type: "", unit: "", states: [] },
    ];
    const rows = channelRows(DETAIL, former);
    expect(rows.filter((row) => row.former).map(({ address, name, type, unit, device }) => [address, name, type, unit, device.name])).toEqual([
      ["base/gear", "Gear", "state", "", "Base"],
      ["arm/place.yaw", "Place, yaw", "number", "rad", "arm"],
      ["arm/old", "arm/old", "number", "", "arm"],
    ]);
    expect(rows.filter(({ address }) => address === "base/left")).toHaveLength(1);
    expect(firstChoice(rows)).toEqual(["base/left", "base/right"]);
  });

  it("begin with the first main numbers", () => {
    expect(firstChoice(channelRows(DETAIL))).toEqual(["base/left", "base/right"]);
    expect(firstChoice([])).toEqual([]);
  });
});

describe("what was loaded", () => {
  it("lists texts with their times", () => {
    const loaded = loadedSeries({ address: "a", t_us: [1, 2], v: [null, null], text: ["docked", "gone"], kind: "exact", gaps: [] }, 5e6);
    expect(loaded.texts).toEqual([{ timeUs: 1, text: "docked" }, { timeUs: 2, text: "gone" }]);
  });

  it("holds each text until the next, and none across a gap", () => {
    const texts = ["docked", "gone", "docked"];
    const gaps = [{ from_us: 4e6, to_us: 6e6, reason: "the spool was full" }];
    const loaded = loadedSeries({ address: "a", t_us: [1e6, 3e6, 7e6], v: [null, null, null], text: texts, kind: "exact", gaps }, 5e6);
    const { words, samples } = textBand(loaded, 5e6);
    expect(words).toEqual(["docked", "gone"]);
    expect(stateRuns(samples.times, samples.values, 8e6, samples.allowedUs)).toEqual([
      { fromUs: 1e6, toUs: 3e6, value: 0 },
      { fromUs: 3e6, toUs: 4e6 + 1, value: 1 },
      { fromUs: 7e6, toUs: 8e6, value: 0 },
    ]);
  });

  it("tells a silence once: with its reason where the hub has one", () => {
    const loaded = loadedSeries(
      {
        address: "a", t_us: [0, 1e6, 30e6, 31e6, 32e6, 33e6, 90e6], v: [1, 1, 1, 1, 1, 1, 1], kind: "exact",
        gaps: [{ from_us: 1e6, to_us: 30e6, reason: "the spool was full" }],
      },
      5e6,
    );
    expect(loaded.gaps).toEqual([
      { from_us: 1e6, to_us: 30e6, reason: "the spool was full" },
      { from_us: 33e6, to_us: 90e6, reason: "" },
    ]);
  });
});
