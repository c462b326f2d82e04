import { describe, expect, it } from "vitest";
import { ZoneClock } from "../../../src/series/zone-clock.js";
import type { FilmListShape, FilmShape, SeenShape } from "../../../src/generated/api.js";
import { clipOf, dayBounds, dayCounts, readReviewFilter, reviewKey, reviewPageQuery, shownDay, writeReviewFilter } from "../../../src/pages/review/review-query.js";

const DAYS = [
  { day: "2026-11-26", camera: "gate/road", count: 3, unseen: 0 },
  { day: "2026-11-26", camera: "hall/door", count: 2, unseen: 0 },
  { day: "2026-11-25", camera: "gate/road", count: 9, unseen: 4 },
];
const MADRID = new ZoneClock("Europe/Madrid");
const BEGAN = Date.parse("2026-11-26T12:00:00Z") * 1000;
const SEEN: SeenShape = { id: "7", camera: "gate/road", label: "person", many: 1, confidence: 0.9, began_us: BEGAN, ended_us: null, picture: true, seen: false, story: null };

function film(id: string, fromS: number, toS: number, more: Partial<FilmShape> = {}): FilmShape {
  const at = (seconds: number): number => BEGAN + seconds * 1e6;
  return { id, stream: "gate/road", state: "complete", why: "", who: "", note: "", begin_us: at(fromS), end_us: at(toS), size: 1, have: 1, pictures: 9, ...more };
}

function films(...some: FilmShape[]): FilmListShape {
  return { films: some, unfilmed: [], filming: [], may_film: false } as unknown as FilmListShape;
}

describe("a review", () => {
  it("is in the address, and reads nothing else from it", () => {
    const filter = readReviewFilter("?camera=gate%2Froad&label=person&zone=Mat&day=2026-11-26&all=true&sighting=7&until=99");
    expect(filter).toEqual({ camera: "gate/road", label: "person", zone: "Mat", day: "2026-11-26", all: true, sighting: "7", until: "99" });
    expect(readReviewFilter(`?${writeReviewFilter(filter)}`)).toEqual(filter);
    expect(readReviewFilter("?day=yesterday&until=soon")).toMatchObject({ day: "", until: "" });
  });

  it("begins with the newest day that has something new", () => {
    const days = dayCounts(DAYS);
    expect(days).toEqual([{ day: "2026-11-26", count: 5, unseen: 0 }, { day: "2026-11-25", count: 9, unseen: 4 }]);
    const none = readReviewFilter("");
    expect(shownDay(none, days)).toBe("2026-11-25");
    expect(shownDay({ ...none, all: true }, days)).toBe("2026-11-26");
    expect(shownDay(none, [])).toBe("");
  });

  it("asks for a day of the site's own time, also one of 25 hours", () => {
    const [from, to] = dayBounds("2026-10-25", MADRID);
    expect((to - from) / 3600e6).toBe(25);
    const asked = new URLSearchParams(reviewPageQuery({ ...readReviewFilter(""), zone: "Mat" }, "2026-11-26", MADRID, "", 60));
    expect(asked.get("from_us")).toBe(String(Date.parse("2026-11-25T23:00:00Z") * 1000));
    expect(asked.get("to_us")).toBe(String(Date.parse("2026-11-26T23:00:00Z") * 1000 - 1));
    expect([asked.get("unseen"), asked.get("zone"), asked.get("camera")]).toEqual(["true", "Mat", null]);
  });

  it("shows the film that has the beginning, from some seconds before", () => {
    expect(clipOf(films(film("a", -9, 20)), SEEN, 5)).toMatchObject({ film: { id: "a" }, from: 4 });
    expect(clipOf(films(film("a", -2, 20)), SEEN, 5)?.from).toBe(0);
    // Nothing was held before, so it begins with the moment at which the thing was believed.
    expect(clipOf(films(film("a", 1, 20)), SEEN, 5)?.from).toBe(0);
    expect(clipOf(films(film("a", -9, 20, { stream: "hall/door" }), film("b", 4, 20), film("c", -20, -1)), SEEN, 5)).toBeNull();
    // One that is whole before one that is on its way.
    expect(clipOf(films(film("a", -9, 20, { state: "coming" as FilmShape["state"] }), film("b", -3, 5)), SEEN, 5)?.film.id).toBe("b");
  });

  it("goes by the keys of other reviews", () => {
    expect(["j", "k", " ", "s", "x"].map(reviewKey)).toEqual(["next", "previous", "play", "seen", null]);
  });
});
