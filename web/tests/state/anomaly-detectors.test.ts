import { expect, test } from "vitest";
import type { AnomalyUpdate } from "../../src/generated/wire.js";
import { anomalyMarks } from "../../src/elements/chart/anomaly-marks.js";
import { AnomalyDetectors, shareOf } from "../../src/state/anomaly-detectors.js";
import type { AnomalyShape } from "../../src/generated/api.js";

function info(change: Partial<AnomalyShape> = {}): AnomalyShape {
  return {
    address: "power/voltage", detector: "together", name: "all together", bar: 0.65, score: 0.3, scores: "power/voltage~together",
    began_us: -1, from_us: 0, to_us: 0, why: "", forgiven: false, confirmed: false, learns: true, learning: 0, late: 0,
    title: "", signals: [], step_s: 0, mode: "", shares: [], ...change,
  };
}

function news(change: Partial<AnomalyUpdate> = {}): AnomalyUpdate {
  return {
    t: "anomaly", site: "agv", device: "power", address: "power/voltage", detector: "together",
    on: false, from_us: 0, to_us: 0, score: 0, why: "", forgiven: false, confirmed: false, learning: 0, mode: "", shares: [], ...change,
  };
}

function book(...detectors: readonly AnomalyShape[]): AnomalyDetectors {
  const made = new AnomalyDetectors();
  made.setList({ detectors, may_forgive: true, skipped: 0 });
  return made;
}

test("an anomaly that is told of is on until it is told to be over", () => {
  const held = book(info());
  expect(held.detectorsOf("power/voltage")[0]).toMatchObject({ on: false, anomaly: null });
  expect(held.applyUpdate(news({ on: true, from_us: 5, why: "far off", score: 0.9 }))).toBe(true);
  expect(held.detectorsOf("power/voltage")[0]).toMatchObject({ on: true, score: 0.9, anomaly: { fromUs: 5, toUs: Infinity, why: "far off" } });
  held.applyUpdate(news({ from_us: 5, to_us: 9, why: "far off" }));
  expect(held.detectorsOf("power/voltage")[0]).toMatchObject({ on: false, anomaly: { fromUs: 5, toUs: 9, forgiven: false } });
});

test("each anomaly is remembered once, in order of time, of all detectors of a signal", () => {
  const held = book(info(), info({ detector: "limits", scores: "power/voltage~limits", from_us: 6, to_us: 7, why: "low" }));
  held.applyUpdate(news({ on: true, from_us: 5 }));
  held.applyUpdate(news({ from_us: 5, to_us: 9 }));
  held.applyUpdate(news({ on: true, from_us: 20 }));
  held.applyUpdate(news({ from_us: 20, to_us: 22, forgiven: true }));
  expect(held.anomalies("power/voltage").map(({ fromUs, toUs, forgiven }) => [fromUs, toUs, forgiven])).toEqual([
    [5, 9, false],
    [6, 7, false],
    [20, 22, true],
  ]);
  expect(held.anomalies("base/speed")).toEqual([]);
});

test("what is told while the list is on its way is newer than the list", () => {
  const held = book(info());
  held.beginLoad();
  held.applyUpdate(news({ on: true, from_us: 5 }));
  held.setList({ detectors: [info()], may_forgive: false, skipped: 0 });
  expect(held.detectorsOf("power/voltage")[0]?.on).toBe(true);
  expect(held.mayForgive).toBe(false);
});

test("what was told before the list was asked for is not newer than it", () => {
  const held = book(info());
  held.applyUpdate(news({ on: true, from_us: 5 }));
  held.beginLoad();
  held.setList({ detectors: [info({ from_us: 5, to_us: 8 })], may_forgive: true, skipped: 0 });
  expect(held.detectorsOf("power/voltage")[0]).toMatchObject({ on: false, anomaly: { toUs: 8 } });
});

test("news of a detector that is not in the list changes nothing", () => {
  const held = book(info());
  const before = held.list;
  expect(held.applyUpdate(news({ detector: "still", on: true, from_us: 3 }))).toBe(false);
  expect(held.list).toBe(before);
});

test("the list is another whenever a detector stands otherwise, and no longer than needed", () => {
  const held = book(info(), info({ address: "base/speed", scores: "base/speed~together" }));
  const before = held.list;
  held.applyUpdate(news({ learning: 7 }));
  expect(held.list).not.toBe(before);
  expect(held.list).toHaveLength(2);
  for (let at = 1; at <= 80; at += 1) held.applyUpdate(news({ on: true, from_us: at }));
  expect(held.anomalies("power/voltage")).toHaveLength(50);
});

test("an anomaly that a person has said is none looks well on a chart, and one that is on goes on", () => {
  expect(
    anomalyMarks([
      { scores: "a~still", fromUs: 1, toUs: 2, why: "", title: "", shares: [], forgiven: true },
      { scores: "a~still", fromUs: 5, toUs: Infinity, why: "", title: "", shares: [], forgiven: false },
    ]),
  ).toEqual([
    { timeUs: 1, untilUs: 2, good: true },
    { timeUs: 5, untilUs: Infinity, good: false },
  ]);
});

test("a group's anomaly is one of the signals that had a part in it, and of no other", () => {
  const shares = [
    { signal: "power/voltage", share: 0.9, spreads: -4 },
    { signal: "base/speed", share: 0.04, spreads: 1 },
  ];
  const group = info({ address: "/body", detector: "group", scores: "/body~group", title: "The body", signals: ["power/voltage", "base/speed"], from_us: 3, to_us: 4, shares });
  const held = book(group);
  expect(held.anomalies("power/voltage")).toMatchObject([{ fromUs: 3, title: "The body" }]);
  expect(held.anomalies("base/speed")).toEqual([]);
  expect(held.anomalies("/body")).toHaveLength(1);
  held.applyUpdate(news({ address: "/body", detector: "group", device: "", on: true, from_us: 9, mode: "driving", shares: [{ t: "anomaly_share", signal: "base/speed", share: 1, spreads: 7 }] }));
  expect(held.detectorsOf("/body")).toMatchObject([{ mode: "driving", on: true }]);
  expect(held.anomalies("base/speed")).toMatchObject([{ fromUs: 9, title: "The body" }]);
  expect(held.anomalies("base/speed").map((anomaly) => shareOf(anomaly, "base/speed"))).toEqual([1]);
});
