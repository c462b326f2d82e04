import { describe, expect, it, vi } from "vitest";
import { HistoryLoader, loadedOf, type Past } from "../../../src/pages/history/loader.js";
import { quickOf, quickShown, readView, spanOf, writeView, type HistoryView } from "../../../src/pages/history/query.js";
import { firstChoice, rowsOf, together } from "../../../src/pages/history/rows.js";
import { ZoneClock } from "../../../src/series/zone.js";
import type { History, SignalInfo, SiteDetail } from "../../../src/wire/api.js";

const madrid = new ZoneClock("Europe/Madrid");
const NOW = Date.parse("2026-11-21T10:00:00Z") * 1000;

describe("the address of the history page", () => {
  it("reads back what it wrote", () => {
    const views: HistoryView[] = [
      { channels: ["base/speed", "base/pose.x"], shown: { last: 3600 } },
      { channels: [], shown: { fromUs: 1_795_000_000_000_001, toUs: 1_795_000_000_500_000 } },
      { channels: null, shown: { last: 300 } },
      { channels: ["odd/ä&c=x"], shown: { last: 7 } },
    ];
    for (const view of views) expect(readView(writeView(view))).toEqual(view);
  });

  it("is as if empty where it makes no sense", () => {
    for (const search of ["", "?from=5&to=4", "?last=-3", "?last=x", "?from=1e99&to=2e99", "?from=1"]) {
      expect(readView(search)).toEqual({ channels: null, shown: { last: 900 } });
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
    states: [], frame: "local", max_age: 5, primary: true, channels: [`base/${id}`], ...change,
  };
}

const DETAIL: SiteDetail = {
  site: "agv", name: "A", zone: "UTC", online: true, catalogue: "1", since_us: 0, last_seen_us: 0,
  devices: [
    {
      id: "base", name: "Base", kind: "vehicle", streams: [], commands: [], drive: null, link_loss: "", rights: [],
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
    const groups = together(rowsOf(DETAIL)).map(({ title, rows }) => [title, rows.map(({ address }) => address)]);
    expect(groups).toEqual([
      ["m", ["base/left", "base/right", "base/pose.x"]],
      ["V", ["base/volt"]],
      ["mode", ["base/mode"]],
      ["rad", ["base/pose.yaw"]],
      ["", ["base/count"]],
    ]);
  });

  it("begin with the first main numbers", () => {
    expect(firstChoice(rowsOf(DETAIL))).toEqual(["base/left", "base/right"]);
    expect(firstChoice([])).toEqual([]);
  });
});

describe("loading a window", () => {
  const question = (fromUs: number): Parameters<HistoryLoader["ask"]>[0] => ({
    site: "agv", channels: [{ address: "a", maxAge: 5 }], span: { fromUs, toUs: fromUs + 1000 }, width: 100,
  });
  const one: History = { series: [{ address: "a", t_us: [1, 2], v: [1, 2], kind: "exact", gaps: [] }] };

  it("asks once for what is asked twice, and only the last of a quick row of questions", async () => {
    vi.useFakeTimers();
    try {
      const history = vi.fn<Past["history"]>(() => Promise.resolve(one));
      const loader = new HistoryLoader({ history }, () => undefined);
      for (const from of [1000, 2000, 3000, 3000]) loader.ask(question(from), 140);
      await vi.advanceTimersByTimeAsync(200);
      expect(history).toHaveBeenCalledTimes(1);
      expect(history.mock.calls[0]?.[1]).toEqual({ channels: ["a"], fromUs: 2750, toUs: 4250, width: 150 });
      expect([loader.state, loader.data.get("a")?.count]).toEqual(["ready", 2]);
    } finally {
      vi.useRealTimers();
    }
  });

  it("keeps the old picture while it loads and when it fails, and asks again when told to", async () => {
    vi.useFakeTimers();
    try {
      let answer = (): Promise<History> => Promise.resolve(one);
      const loader = new HistoryLoader({ history: () => answer() }, () => undefined);
      loader.ask(question(0), 0);
      await vi.advanceTimersByTimeAsync(1);
      answer = () => Promise.reject(new Error("down"));
      loader.ask(question(5000), 0);
      await vi.advanceTimersByTimeAsync(1);
      expect([loader.state, loader.data.size]).toEqual(["failed", 1]);
      answer = () => Promise.resolve(one);
      loader.forget();
      loader.ask(question(5000), 0);
      await vi.advanceTimersByTimeAsync(1);
      expect(loader.state).toBe("ready");
    } finally {
      vi.useRealTimers();
    }
  });

  it("lists texts with their times", () => {
    const loaded = loadedOf({ address: "a", t_us: [1, 2], v: [null, null], text: ["docked", "gone"], kind: "exact", gaps: [] }, 5e6);
    expect(loaded.texts).toEqual([{ timeUs: 1, text: "docked" }, { timeUs: 2, text: "gone" }]);
  });

  it("tells a silence once: with its reason where the hub has one", () => {
    const loaded = loadedOf(
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
