import { afterEach, beforeEach, describe, expect, test, vi } from "vitest";
import { FilmStills, type FilmStill } from "../../../src/elements/camera/film-stills.js";
import type { FilmPicture } from "../../../src/wire/films-api.js";
import { DecoderOfBytes, MadeChunk, openFrames, settle } from "./made-decoder.js";

/** Pictures come each second; each fifth is whole. */
function pictureAt(us: number): FilmPicture {
  const number = Math.floor(us / 1e6);
  const first = number - (number % 5);
  const numbers = Array.from({ length: number - first + 1 }, (_, i) => first + i);
  return {
    codec: "avc1.42C01E", description: Uint8Array.of(1), timesUs: numbers.map((each) => each * 1e6), beforeUs: number === 0 ? null : (number - 1) * 1e6,
    nextUs: number === 9 ? null : (number + 1) * 1e6, data: numbers.map((each) => Uint8Array.of(each)),
  };
}

interface Question {
  readonly us: number;
  readonly answer: () => void;
  readonly fail: () => void;
}

function makeStills(): { stills: FilmStills; asked: Question[]; drawn: [number, FilmStill][]; failed: string[]; pass: (ms: number) => void } {
  const asked: Question[] = [];
  const drawn: [number, FilmStill][] = [];
  const failed: string[] = [];
  let now = 0;
  const stills = new FilmStills({
    fetch: (_film, us) =>
      new Promise((resolve, reject) => {
        asked.push({ us, answer: () => { resolve(pictureAt(us)); }, fail: () => { reject(new Error("gone")); } });
      }),
    draw: (frame, still) => drawn.push([(frame as unknown as { picture: number }).picture, still]),
    failed: (film) => failed.push(film),
  }, () => now);
  const pass = (ms: number): void => {
    now += ms;
    vi.advanceTimersByTime(ms);
  };
  return { stills, asked, drawn, failed, pass };
}

describe("stills of films", () => {
  beforeEach(() => {
    vi.useFakeTimers();
    vi.stubGlobal("VideoDecoder", DecoderOfBytes);
    vi.stubGlobal("EncodedVideoChunk", MadeChunk);
    openFrames.clear();
    DecoderOfBytes.made = [];
  });
  afterEach(() => {
    vi.unstubAllGlobals();
    vi.useRealTimers();
  });

  test("the picture of a moment is drawn with its own time, and nothing is left open", async () => {
    const { stills, asked, drawn, pass } = makeStills();
    stills.want("a", 7.4e6);
    expect(stills.isSettled).toBe(false);
    asked[0]?.answer();
    await settle();
    expect(drawn).toEqual([[7, { film: "a", us: 7e6, untilUs: 8e6, beforeUs: 6e6 }]]);
    expect([stills.isSettled, openFrames.size]).toEqual([true, 0]);
    pass(500);
    // Within the same picture nothing is asked for; of another film it is.
    stills.want("a", 7.9e6);
    expect(asked.length).toBe(1);
    pass(500);
    stills.want("b", 7.9e6);
    expect([asked.length, stills.isSettled]).toEqual([2, false]);
  });

  test("while a hand moves the moment the places in between are left out", async () => {
    const { stills, asked, drawn, pass } = makeStills();
    const places = (): number[] => asked.map(({ us }) => us / 1e6);
    // A place each 30 ms: something is seen of the way, and the last waits behind none of those between.
    for (let at = 1; at <= 9; at += 1) {
      stills.want("a", at * 1e6);
      pass(30);
    }
    expect(places()).toEqual([1, 8]);
    pass(10);
    // Two are under way: it comes with the first place that is free.
    expect(places()).toEqual([1, 8]);
    for (const number of [1, 0]) {
      asked[number]?.answer();
      await settle();
    }
    expect(places()).toEqual([1, 8, 9]);
    asked[2]?.answer();
    await settle();
    // What comes late is not drawn over what is newer.
    expect(drawn.map(([picture]) => picture)).toEqual([8, 9]);
    expect(DecoderOfBytes.made.length).toBe(1);
  });

  test("what was asked for before it was cleared is never drawn", async () => {
    const { stills, asked, drawn } = makeStills();
    stills.want("a", 1e6);
    stills.clear();
    asked[0]?.answer();
    await settle();
    expect([drawn, openFrames.size, stills.shown]).toEqual([[], 0, null]);
  });

  test("a film whose pictures cannot be had is told, once", async () => {
    const { stills, asked, failed } = makeStills();
    stills.want("a", 1e6);
    asked[0]?.fail();
    await settle();
    expect([failed, asked.length]).toEqual([["a"], 1]);
  });

  test("the first picture stands also before its time, the last one for ever", async () => {
    const { stills, asked, pass } = makeStills();
    stills.want("a", 0);
    asked[0]?.answer();
    await settle();
    expect([stills.showsMoment("a", -5), stills.showsMoment("a", 1e6)]).toEqual([true, false]);
    pass(500);
    stills.want("a", 9e6);
    asked[1]?.answer();
    await settle();
    expect(stills.showsMoment("a", 1e9)).toBe(true);
  });
});
