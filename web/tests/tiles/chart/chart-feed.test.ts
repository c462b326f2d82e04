import { describe, expect, it } from "vitest";
import { ChartFeed } from "../../../src/tiles/chart/chart-feed.js";
import { samplesOf } from "../../../src/state/past/history-samples.js";
import type { HistoryAnswer, SignalShape } from "../../../src/generated/api.js";
import type { HistoryQuery } from "../../../src/wire/hub-api.js";
import type { Batch, BatchListener } from "../../../src/wire/subscriptions.js";

function signal(id: string): SignalShape {
  return {
    id, address: `base/${id}`, name: id, type: "number", role: "none", unit: "m", decimals: -1, minimum: null, maximum: null, shown: null,
    states: [], meanings: [], frame: "local", max_age: 5, primary: true, public: false, ros: "", channels: [`base/${id}`],
  };
}

class Hub {
  readonly listeners = new Map<string, BatchListener>();
  readonly asked: HistoryQuery[] = [];
  answer: (query: HistoryQuery) => Promise<HistoryAnswer> = () => Promise.resolve({ series: [] });

  subscribe(_site: string, channels: readonly string[], _everyMs: number, listener: BatchListener): () => void {
    const key = channels.join();
    this.listeners.set(key, listener);
    return () => this.listeners.delete(key);
  }

  history(_site: string, query: HistoryQuery): Promise<HistoryAnswer> {
    this.asked.push(query);
    return this.answer(query);
  }

  send(channels: string, timeUs: readonly number[], change: { first?: boolean; ageMs?: number } = {}): void {
    const batch: Batch = {
      site: "agv",
      channels: channels.split(","),
      first: change.first ?? false,
      columns: {
        channel: Uint16Array.from(timeUs, () => 0),
        timeUs: Float64Array.from(timeUs),
        value: Float64Array.from(timeUs, (_, i) => i),
        texts: {},
        ageMs: change.ageMs === undefined ? [] : timeUs.map(() => change.ageMs ?? 0),
      },
    };
    this.listeners.get(channels)?.(batch);
  }
}

function start(now: () => number = () => 1000): { hub: Hub; feed: ChartFeed } {
  const hub = new Hub();
  return { hub, feed: new ChartFeed("agv", hub, hub, () => undefined, 30e6, now) };
}

const settled = async (): Promise<void> => {
  for (let i = 0; i < 5; i += 1) await Promise.resolve();
};

describe("a feed of charts", () => {
  it("hears scores of detectors beside the signals, and asks for those of before", async () => {
    const { hub, feed } = start();
    feed.subscribeSignals([signal("speed")], ["base/speed~together"]);
    hub.send("base/speed,base/speed~together", [5e6], { first: true });
    await settled();
    expect(hub.asked.map(({ channels }) => channels)).toEqual([["base/speed"], ["base/speed~together"]]);
    // One that stays the same is in the history once a minute: so the line begins before the window.
    const [speed, score] = hub.asked;
    expect((speed?.fromUs ?? 0) - (score?.fromUs ?? 0)).toBe(130e6);
    // The history has a score a minute at least: so long a pause is no gap.
    feed.channelOf("base/speed~together").trace.addSample(1e6, 0.2);
    expect(feed.channelOf("base/speed~together").trace.allowedUs).toBe(130e6);
    expect(feed.channelOf("base/speed").trace.allowedUs).toBe(5e6);
  });

  it("asks for what came before, once the hub has told its newest", async () => {
    const { hub, feed } = start();
    feed.subscribeSignals([signal("speed")]);
    expect(hub.asked).toEqual([]);
    hub.answer = () =>
      Promise.resolve({ series: [{ address: "base/speed", t_us: [80e6, 90e6], v: [7, 8], kind: "exact", gaps: [] }] });
    hub.send("base/speed", [100e6], { first: true });
    await settled();
    expect(hub.asked).toHaveLength(1);
    expect(hub.asked[0]).toMatchObject({ channels: ["base/speed"], toUs: 100e6 });
    expect([...feed.channelOf("base/speed").trace.values]).toEqual([7, 8, 0]);
    expect(feed.backfill).toBe("done");
  });

  it("asks for new channels only when the choice changes, and for all after a loss", async () => {
    const { hub, feed } = start();
    hub.answer = ({ channels }) =>
      Promise.resolve({ series: channels.map((address) => ({ address, t_us: [], v: [], kind: "exact" as const, gaps: [] })) });
    feed.subscribeSignals([signal("speed")]);
    hub.send("base/speed", [100e6], { first: true });
    await settled();
    feed.subscribeSignals([signal("speed"), signal("turn")]);
    hub.send("base/speed,base/turn", [101e6], { first: true });
    await settled();
    hub.send("base/speed,base/turn", [102e6], { first: true });
    await settled();
    expect(hub.asked.map(({ channels }) => channels)).toEqual([["base/speed"], ["base/turn"], ["base/speed", "base/turn"]]);
  });

  it("says that the past could not be had, and goes on with the present", async () => {
    const { hub, feed } = start();
    hub.answer = () => Promise.reject(new Error("no"));
    feed.subscribeSignals([signal("speed")]);
    hub.send("base/speed", [100e6], { first: true });
    await settled();
    hub.send("base/speed", [101e6]);
    expect([feed.backfill, feed.channelOf("base/speed").trace.length]).toEqual(["failed", 2]);
  });

  it("tells the age of what was old already when it came, and of what stopped coming", () => {
    let now = 1000;
    const { hub, feed } = start(() => now);
    expect(feed.ageS("base/speed")).toBeNaN();
    feed.subscribeSignals([signal("speed")]);
    hub.send("base/speed", [100e6], { first: true, ageMs: 60_000 });
    expect(feed.ageS("base/speed")).toBe(60);
    hub.send("base/speed", [161e6]);
    now += 7000;
    expect(feed.ageS("base/speed")).toBe(7);
  });

  it("does not take a late, older sample for a sign of life", () => {
    let now = 1000;
    const { hub, feed } = start(() => now);
    feed.subscribeSignals([signal("speed")]);
    hub.send("base/speed", [100e6]);
    now += 9000;
    hub.send("base/speed", [99e6]);
    expect(feed.ageS("base/speed")).toBe(9);
    expect([...feed.channelOf("base/speed").trace.times]).toEqual([99e6, 100e6]);
  });

  it("shows the window that ends at the robot's now", () => {
    let now = 1000;
    const { hub, feed } = start(() => now);
    feed.subscribeSignals([signal("speed")]);
    hub.send("base/speed", [100e6]);
    now += 2000;
    expect(feed.currentWindow(now)).toEqual({ fromUs: 72e6, toUs: 102e6 });
    feed.setLength(10e6);
    expect(feed.currentWindow(now).fromUs).toBe(92e6);
  });
});

describe("a series of the past", () => {
  it("comes in order of time, with a break in each gap", () => {
    const past = samplesOf({
      address: "a", t_us: [30, 10, 20, 90], v: [3, 1, null, 9], kind: "exact", gaps: [{ from_us: 40, to_us: 80, reason: "r" }],
    });
    expect([...past.times]).toEqual([10, 20, 30, 41, 90]);
    expect([...past.values]).toEqual([1, NaN, 3, NaN, 9]);
  });

  it("counts pairs of least and greatest as one reading", () => {
    const t_us = Array.from({ length: 100 }, (_, i) => i * 10);
    const plain = { address: "a", t_us, v: t_us, gaps: [] };
    expect(samplesOf({ ...plain, kind: "exact" }).intervalUs).toBe(10);
    expect(samplesOf({ ...plain, kind: "minmax" }).intervalUs).toBe(20);
  });
});
