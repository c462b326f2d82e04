import { describe, expect, it } from "vitest";
import { firstFilmMoment, isFilmed, nextFilmStart, pictureAt, filmsByCamera, filmStateAt, stepTime, type CameraFilms } from "../../../src/state/past/film-search.js";
import { nextSpeed, Playhead, SPEEDS } from "../../../src/state/past/playhead.js";
import type { FilmListShape, FilmShape } from "../../../src/generated/api.js";

function film(id: string, begin_us: number, end_us: number, more: Partial<FilmShape> = {}): FilmShape {
  return { id, stream: "cam/front", state: "complete", why: "", who: "", note: "", begin_us, end_us, size: 1, have: 1, pictures: 3, ...more };
}

function list(films: readonly FilmShape[], more: Partial<FilmListShape> = {}): FilmListShape {
  return { films: [...films], more: false, unfilmed: [], filming: [], may_film: false, why_not: "", ...more };
}

const NAMES = new Map([["cam/front", "Front"], ["gate/road", "Road"]]);

function only(films: readonly FilmShape[], more: Partial<FilmListShape> = {}): CameraFilms {
  const [reel] = filmsByCamera(list(films, more), NAMES);
  if (reel === undefined) throw new Error("no reel");
  return reel;
}

describe("the films of a window", () => {
  it("stand by camera, in the order of the site, and by time", () => {
    const found = filmsByCamera(
      list([film("b", 50e6, 60e6), film("r", 0, 10e6, { stream: "gate/road" }), film("a", 0, 10e6), film("x", 0, 1, { stream: "gone/eye" })]),
      NAMES,
    );
    expect(found.map(({ name }) => name)).toEqual(["Front", "Road", "gone/eye"]);
    expect(found[0]?.films.map(({ id }) => id)).toEqual(["a", "b"]);
  });

  it("say which of them shows a moment, and what there is instead", () => {
    const reel = only([film("a", 0, 10e6), film("b", 50e6, 60e6), film("c", 70e6, 80e6, { state: "uploading" }), film("d", 90e6, 95e6, { state: "failed" })]);
    expect(filmStateAt(reel, 5e6)).toMatchObject({ kind: "film", film: { id: "a" } });
    expect(filmStateAt(reel, 10.05e6)).toMatchObject({ kind: "film", film: { id: "a" } });
    expect(filmStateAt(reel, 30e6)).toMatchObject({ kind: "none", before: { id: "a" }, after: { id: "b" } });
    expect(filmStateAt(reel, -1)).toMatchObject({ kind: "none", before: null, after: { id: "a" } });
    expect(filmStateAt(reel, 75e6)).toMatchObject({ kind: "coming", film: { id: "c" } });
    expect(filmStateAt(reel, 92e6)).toMatchObject({ kind: "failed" });
    // Of two that meet, the later one.
    expect(filmStateAt(only([film("a", 0, 10e6), film("b", 10.01e6, 20e6)]), 10.05e6)).toMatchObject({ film: { id: "b" } });
  });

  it("tell a camera that only the raw recording has", () => {
    const raw = { recording: "r1", stream: "cam/front", begin_us: 0, end_us: 10e6 };
    expect(filmStateAt(only([], { unfilmed: [raw] }), 5e6)).toEqual({ kind: "raw", recording: "r1" });
    expect(filmStateAt(only([film("a", 0, 10e6)], { unfilmed: [raw] }), 5e6).kind).toBe("film");
  });

  it("know where to begin, and where it goes on after a gap", () => {
    const reels = [only([film("a", 10e6, 20e6), film("b", 50e6, 60e6)]), only([film("u", 30e6, 31e6, { state: "uploading" })])];
    expect(firstFilmMoment(reels, 15e6)).toBe(15e6);
    expect(firstFilmMoment(reels, 0)).toBe(10e6);
    expect(nextFilmStart(reels, 25e6)).toBe(50e6);
    expect(nextFilmStart(reels, 70e6)).toBeNull();
    expect(isFilmed(reels, 55e6)).toBe(true);
    expect(isFilmed(reels, 30.5e6)).toBe(false);
  });

  it("step from picture to picture, however far they are apart", () => {
    const times = Float64Array.from([0, 40_000, 900_000, 933_000]);
    const single = film("a", 100e6, 101e6);
    expect([-1, 0, 39_999, 40_000, 899_999, 5e6].map((us) => pictureAt(times, us))).toEqual([0, 0, 0, 1, 1, 3]);
    expect(stepTime(single, times, 100e6 + 50_000, 1)).toBe(100e6 + 900_000);
    expect(stepTime(single, times, 100e6 + 50_000, -1)).toBe(100e6);
    expect(stepTime(single, times, 101e6, 1)).toBeNull();
    expect(stepTime(single, times, 100e6, -1)).toBeNull();
  });
});

describe("the moment that is shown", () => {
  it("goes on at its speed, and stands while it is paused or waits for a picture", () => {
    const head = new Playhead();
    head.seek(1000e6, 0);
    expect(head.timeUs(5000)).toBe(1000e6);
    head.play(5000);
    expect(head.timeUs(6000)).toBe(1001e6);
    head.setSpeed(4, 6000);
    expect(head.timeUs(7000)).toBe(1005e6);
    head.setWaiting(true, 7000);
    expect(head.timeUs(99_000)).toBe(1005e6);
    head.setWaiting(false, 99_000);
    expect(head.timeUs(100_000)).toBe(1009e6);
    head.pause(100_000);
    expect([head.timeUs(200_000), head.playing]).toEqual([1009e6, false]);
    head.seek(7, 200_000);
    expect(head.timeUs(300_000)).toBe(7);
  });

  it("has speeds from half to sixteen times", () => {
    expect([nextSpeed(1, 1), nextSpeed(1, -1), nextSpeed(0.5, -1), nextSpeed(16, 1)]).toEqual([2, 0.5, 0.5, 16]);
    expect(SPEEDS).toEqual([0.5, 1, 2, 4, 8, 16]);
  });
});
