import { expect, test } from "vitest";
import { momentQuery, NO_FILTER, logbookPageQuery, readLogbookFilter, recordingAt, showsCurrentSightings, writeLogbookFilter } from "../../../src/pages/logbook/logbook-query.js";

test("a filter survives the address, and all of it is as if there were none", () => {
  const filter = { text: "rain & wind", kind: "alarm", device: "dome", who: "ada", bad: true };
  expect(readLogbookFilter(`?${writeLogbookFilter(filter)}`)).toEqual(filter);
  expect(writeLogbookFilter(NO_FILTER)).toBe("");
  expect(readLogbookFilter("?good=maybe&before=7")).toEqual(NO_FILTER);
});

test("the next page is asked for by the last row of this one", () => {
  expect(logbookPageQuery({ ...NO_FILTER, kind: "stop" }, "17", 50)).toBe("kind=stop&before=17&limit=50");
  expect(logbookPageQuery(NO_FILTER, "", 50)).toBe("limit=50");
});

test("an event leads to the history around its moment", () => {
  expect(momentQuery(100e6)).toBe("from=40000000&to=160000000&at=100000000");
});

test("what is in sight stands above the lines that it would fit among", () => {
  expect(showsCurrentSightings(NO_FILTER)).toBe(true);
  expect(showsCurrentSightings({ ...NO_FILTER, kind: "sighting" })).toBe(true);
  for (const other of [{ kind: "alarm" }, { text: "dog" }, { device: "camera" }, { who: "ada" }, { bad: true }]) {
    expect(showsCurrentSightings({ ...NO_FILTER, ...other })).toBe(false);
  }
});

test("of an event's device some signals are chosen there", () => {
  const many = Array.from({ length: 9 }, (_, at) => `base/s${String(at)}`);
  expect(momentQuery(100e6, ["base/pose.x"])).toBe("c=base/pose.x&from=40000000&to=160000000&at=100000000");
  expect(new URLSearchParams(momentQuery(100e6, many)).getAll("c")).toEqual(many.slice(0, 6));
});

test("a moment has a recording only while one ran", () => {
  const recordings = [{ begin_us: 50, end_us: 60 }, { begin_us: 10, end_us: 20 }];
  expect([9, 10, 20, 21, 55].map((at) => recordingAt(recordings, at)?.begin_us)).toEqual([undefined, 10, 10, undefined, 50]);
});
