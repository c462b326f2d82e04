import { describe, expect, it } from "vitest";
import { EventsLoader } from "../../../../src/pages/history/data/events-loader.js";
import { clusterMarks, kindOf, eventMarks, type EventMark } from "../../../../src/pages/history/chart/event-marks.js";
import type { EventShape } from "../../../../src/generated/api.js";

function mark(timeUs: number, change: Partial<EventMark> = {}): EventMark {
  return { timeUs, kind: "command", title: "command asked", device: "", who: "", message: "", good: true, ...change };
}

describe("marks of what happened", () => {
  it("tell their kind by the event's first word", () => {
    const said = ["alarm raised", "stop pressed", "command succeeded", "lease taken", "gateway lost", "recording_ended", "anomaly began", "sighting", "something new", ""];
    expect(said.map(kindOf)).toEqual(["alarm", "stop", "command", "driving", "link", "recording", "anomaly", "sighting", "other", "other"]);
  });

  it("stand in the order of time, under the names that people gave", () => {
    const event: EventShape = { id: "1", time_us: 5, kind: "stop pressed", device: "base", who: "ada", message: "", good: true };
    const marks = eventMarks([event, { ...event, time_us: 3, device: "gone" }], new Map([["base", "Vehicle base"]]));
    expect(marks.map(({ timeUs, device }) => [timeUs, device])).toEqual([[3, "gone"], [5, "Vehicle base"]]);
  });

  it("are put together where they cannot be told apart, as serious as the most serious", () => {
    const marks = [mark(-1), mark(0), mark(90, { kind: "alarm", good: false }), mark(120), mark(500), mark(1001)];
    const found = clusterMarks(marks, { fromUs: 0, toUs: 1000 }, 0.1);
    expect(found.map(({ timeUs, kind, good, marks: own }) => [timeUs, kind, good, own.length])).toEqual([
      [45, "alarm", false, 2], [120, "command", true, 1], [500, "command", true, 1],
    ]);
  });
});

describe("loading what happened", () => {
  it("asks anew for another window, and not for a move within what is known", () => {
    const asked: number[] = [];
    const loader = new EventsLoader({ events: (_site, { fromUs }) => (asked.push(fromUs), new Promise(() => undefined)) }, () => undefined);
    loader.loadEvents("agv", { fromUs: 1000e6, toUs: 1900e6 });
    const [first = NaN] = asked;
    expect(first).toBeLessThanOrEqual(1000e6);
    loader.loadEvents("agv", { fromUs: 1000e6 + 1, toUs: 1900e6 + 1 });
    expect(asked).toHaveLength(1);
    loader.loadEvents("other", { fromUs: 1000e6, toUs: 1900e6 });
    expect(asked).toHaveLength(2);
  });
});
