import { flatPosition } from "../../../src/elements/map/geodesy.js";
import { describe, expect, test } from "vitest";
import { mergeTracks, courseOf, extendTrack, formatLength, isBreak, joinTrack, MOST_POINTS, niceLength, type TrackPoint } from "../../../src/elements/map/track.js";

const at = (x: number, y: number, timeUs: number): TrackPoint => ({ x, y, timeUs });

describe("joining the channels of a position", () => {
  test("takes the moments of the first that lie within the second", () => {
    const x = { t_us: [1, 2, 3, 5, 7], v: [10, 20, 30, 50, 70] };
    const y = { t_us: [2, 4, 5, 6], v: [-2, -4, -5, -6] };
    expect(joinTrack(x, y)).toEqual([at(20, -2, 2), at(30, -3, 3), at(50, -5, 5)]);
  });

  test("of least and greatest takes the middle", () => {
    const x = { t_us: [0, 2, 4, 6], v: [1, 3, 5, 9], kind: "minmax" } as const;
    const y = { t_us: [0, 2, 4, 6], v: [0, 0, 2, 4], kind: "minmax" } as const;
    expect(joinTrack(x, y)).toEqual([at(2, 0, 1), at(7, 3, 5)]);
  });

  test("makes nothing up across a gap", () => {
    const x = { t_us: [0, 15e6, 30e6], v: [0, 1, 2] };
    const y = { t_us: [0, 30e6], v: [0, 9] };
    expect(joinTrack(x, y)).toEqual([at(0, 0, 0), at(2, 9, 30e6)]);
    expect(isBreak(at(0, 0, 0), at(2, 9, 30e6))).toBe(true);
    expect(isBreak(at(0, 0, 0), at(0.1, 0, 30e6))).toBe(false);
    expect(isBreak(at(0, 0, 0), at(2, 9, 1e6))).toBe(false);
  });

  test("leaves out what is no number", () => {
    expect(joinTrack({ t_us: [1, 2], v: [null, 2] }, { t_us: [1, 2], v: [1, 2] })).toEqual([at(2, 2, 2)]);
    expect(joinTrack({ t_us: [], v: [] }, { t_us: [1], v: [1] })).toEqual([]);
  });
});

describe("a growing trail", () => {
  test("takes a point that is elsewhere, and none that is in the same place", () => {
    const track = extendTrack([], at(0, 0, 1), 100);
    expect(extendTrack(track, at(0.001, 0, 2), 100)).toHaveLength(1);
    expect(extendTrack(track, at(0.5, 0, 2), 100)).toHaveLength(2);
  });

  test("forgets what is older than it keeps", () => {
    expect(extendTrack([at(0, 0, 1), at(1, 0, 60)], at(2, 0, 120), 100)).toEqual([at(1, 0, 60), at(2, 0, 120)]);
  });

  test("does not go back in time", () => {
    const track = [at(0, 0, 10)];
    expect(extendTrack(track, at(5, 5, 9), 100)).toEqual(track);
  });

  test("does not grow without end", () => {
    const long = Array.from({ length: MOST_POINTS }, (_, i) => at(i, 0, i));
    expect(extendTrack(long, at(-1, 0, MOST_POINTS), 1e12)).toHaveLength(MOST_POINTS);
  });

  test("history comes before what was seen live, without doubling it", () => {
    const live = [at(2, 0, 20), at(3, 0, 30)];
    expect(mergeTracks([at(1, 0, 10), at(2, 0, 20), at(9, 9, 25)], live)).toEqual([at(1, 0, 10), ...live]);
  });
});

describe("degrees on a plane", () => {
  test("a thousandth of a degree north is 111 m", () => {
    expect(flatPosition({ lat: 41.001, lon: 2 }, { lat: 41, lon: 2 }).y).toBeCloseTo(111.2, 0);
  });

  test("east shrinks with the latitude", () => {
    expect(flatPosition({ lat: 60, lon: 2.001 }, { lat: 60, lon: 2 }).x).toBeCloseTo(55.6, 0);
  });

  test("the antimeridian is no wall", () => {
    expect(flatPosition({ lat: 0, lon: -179.999 }, { lat: 0, lon: 179.999 }).x).toBeCloseTo(222.4, 0);
  });
});

test("the course is the way of the last stretch, and unknown while standing", () => {
  expect(courseOf([at(0, 0, 1), at(0, 1, 2)])).toBeCloseTo(Math.PI / 2);
  expect(courseOf([at(0, 0, 1), at(0.01, 0, 2)])).toBeNaN();
  expect(courseOf([])).toBeNaN();
});

test("grid steps are one, two or five times a power of ten", () => {
  expect([0.03, 0.2, 0.21, 1, 3, 60, 700].map(niceLength)).toEqual([0.05, 0.2, 0.5, 1, 5, 100, 1000]);
  expect(niceLength(Number.NaN)).toBe(1);
});

test("lengths are said in cm, m or km", () => {
  expect([0.2, 5, 2000].map(formatLength)).toEqual(["20\u202fcm", "5\u202fm", "2\u202fkm"]);
});
