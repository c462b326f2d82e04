import { expect, test } from "vitest";
import type { EventShape } from "../../../src/generated/api.js";
import { alignRuns, eventRuns, runOffers } from "../../../src/pages/runs/run-offers.js";

test("two runs meet at their starts, and the first one says how long is looked", () => {
  expect(alignRuns({ fromUs: 1000, toUs: 1600 }, { fromUs: 100, toUs: 200 })).toEqual({ span: { fromUs: 1000, toUs: 1600 }, shiftUs: 900 });
});

test("marks say no length: the other run's is taken, or five minutes", () => {
  const mark = { fromUs: 1000, toUs: 1000 };
  expect(alignRuns(mark, { fromUs: 100, toUs: 250 }).span).toEqual({ fromUs: 1000, toUs: 1150 });
  expect(alignRuns(mark, { fromUs: 2000, toUs: 2000 })).toEqual({ span: { fromUs: 1000, toUs: 1000 + 300e6 }, shiftUs: -1000 });
});

const line = (time_us: number, kind: string, device: string, message: string, who = ""): EventShape => ({ id: String(time_us), time_us, kind, device, message, who, good: true, sighting: null });

test("a drive lasts from the lease that was taken until it is freed, or somebody else takes it", () => {
  const events = [
    line(60, "lease freed", "base", "epoch 2", "bo"),
    line(40, "lease taken", "base", "epoch 2", "bo"),
    line(35, "lease freed", "arm", "epoch 7", "ada"),
    line(10, "lease taken", "base", "epoch 1", "ada"),
    line(5, "lease freed", "base", "epoch 0", "before"),
  ];
  expect(eventRuns(events)).toEqual([
    { id: "drive base 10", name: "Drive of base by ada", fromUs: 10, toUs: 40 },
    { id: "drive base 40", name: "Drive of base by bo", fromUs: 40, toUs: 60 },
  ]);
});

test("an anomaly lasts to its own end, and one that goes on is no run yet", () => {
  const events = [
    line(90, "anomaly began", "base", "Speed: again"),
    line(50, "anomaly ended", "base", "Speed: 3 above the usual"),
    line(30, "anomaly ended", "base", "Current: usual again"),
    line(20, "anomaly began", "base", "Current: too much"),
    line(15, "anomaly began", "base", "Speed: by another detector"),
    line(10, "anomaly began", "base", "Speed: 3 above the usual"),
  ];
  expect(runOffers([], [], events).map(({ name, fromUs, toUs }) => [name, fromUs, toUs])).toEqual([
    ["Anomaly: Current", 20, 30],
    ["Anomaly: Speed", 10, 50],
  ]);
});
