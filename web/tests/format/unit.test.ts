import { describe, expect, it } from "vitest";
import { differenceToShown, limitToShown, shownDifferenceText, shownText, shownUnit, toShown, toStored } from "../../src/format/unit.js";
import { shownFence } from "../../src/pages/history/data/shown-fence.js";
import { channelRows } from "../../src/pages/history/data/channel-rows.js";
import { ChartFeed } from "../../src/tiles/chart/chart-feed.js";
import type { SiteShape } from "../../src/generated/api.js";
import type { Batch } from "../../src/wire/subscriptions.js";
import { device, signal } from "../tiles/observatory/described.js";

const FAHRENHEIT = { unit: "°F", factor: 1.8, offset: 32, decimals: 1 };
const warm = signal("warm", { unit: "°C", decimals: 1, shown: FAHRENHEIT });

describe("values in the unit that was chosen", () => {
  it("are shown by factor and offset, and come back", () => {
    expect(toShown(FAHRENHEIT, 20)).toBe(68);
    expect(toStored(FAHRENHEIT, 68)).toBeCloseTo(20);
    expect(limitToShown(FAHRENHEIT, -40)).toBe(-40);
    expect(limitToShown(FAHRENHEIT, null)).toBeNull();
    expect(shownText(warm, 20.04)).toBe("68.1\u202f°F");
    expect(shownUnit(warm)).toEqual({ unit: "°F", decimals: 1 });
  });

  it("are shown as they are stored where nobody chose", () => {
    const plain = signal("plain", { unit: "m/s", decimals: 2 });
    expect([toShown(null, 3), toStored(null, 3)]).toEqual([3, 3]);
    expect(shownText(plain, 3)).toBe("3.00\u202fm/s");
  });

  it("have differences without the zero of the scale", () => {
    expect(differenceToShown(FAHRENHEIT, 10)).toBe(18);
    expect(shownDifferenceText(warm, 10)).toBe("18.0\u202f°F");
  });

  it("have their outliers' fences shown, and the same fence again for the same one", () => {
    const fence = { address: "a", samples: 9, stored: 9, first: 10, third: 20, low: 0, high: 30, count: 1, exact: true };
    const shown = shownFence(fence, FAHRENHEIT);
    expect([shown.low, shown.first, shown.third, shown.high]).toEqual([32, 50, 68, 86]);
    expect(shownFence(fence, FAHRENHEIT)).toBe(shown);
    expect(shownFence(fence, null)).toBe(fence);
  });
});

describe("what charts hold", () => {
  it("are numbers as they are shown, and parts of positions as they are stored", () => {
    const heard: ((batch: Batch) => void)[] = [];
    const feed = new ChartFeed(
      "s",
      { subscribe: (_site, _channels, _everyMs, listener) => (heard.push(listener), (): void => undefined) },
      { history: () => Promise.resolve({ series: [] }) },
      () => undefined,
      60e6,
      () => 0,
    );
    const place = signal("place", { type: "position", shown: { unit: "ft", factor: 3.28, offset: 0, decimals: 1 }, channels: ["it/place.x"] });
    feed.subscribeSignals([warm, place]);
    const columns = { channel: [0, 1], timeUs: [1e6, 1e6], value: [20, 7], texts: [null, null], ageMs: [0, 0] };
    for (const listener of heard) listener({ first: false, channels: ["it/warm", "it/place.x"], columns } as unknown as Batch);
    expect(feed.channelOf("it/warm").trace.newest).toBe(68);
    expect(feed.channelOf("it/place.x").trace.newest).toBe(7);
  });

  it("share a chart by the unit that is shown", () => {
    const site = {
      site: "s", name: "S", zone: "UTC", online: true, since_us: 0, last_seen_us: 0, catalogue: "1", place: null, rules: [], enclosures: [],
      shown_units: { "°C": FAHRENHEIT }, map: null, devices: [device("other", [warm, signal("other", { unit: "°F" })])],
    } satisfies SiteShape;
    const gone = { address: "it/gone", name: "Gone", unit: "°C", type: "number", states: [], decimals: 1, described: false, samples: 1, first_us: 0, last_us: 0 };
    expect(channelRows(site, [gone]).map(({ address, unit }) => [address, unit])).toEqual([
      ["it/warm", "°F"],
      ["it/other", "°F"],
      ["it/gone", "°F"],
    ]);
  });
});
