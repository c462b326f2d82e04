/** Which film shows a moment, and what to say where none does. Pure. */

import type { FilmListShape, FilmShape, UnfilmedShape } from "../../generated/api.js";
import type { TimeSpan } from "../../series/time-window.js";
import { HOUR_US, MINUTE_US } from "../../series/zone-clock.js";

/** What there is of one camera. */
export interface CameraFilms {
  readonly stream: string;
  readonly name: string;
  /** By time. */
  readonly films: readonly FilmShape[];
  readonly unfilmed: readonly UnfilmedShape[];
  /** It is being filmed now. */
  readonly filming: boolean;
}

export type FilmState =
  | { readonly kind: "film"; readonly film: FilmShape }
  /** A film of that time has not come whole to the hub. */
  | { readonly kind: "coming"; readonly film: FilmShape }
  | { readonly kind: "failed"; readonly film: FilmShape }
  /** Only the recording of raw topics has it. */
  | { readonly kind: "raw"; readonly recording: string }
  /** No film of that time; the nearest before and after, if any in the window. */
  | { readonly kind: "none"; readonly before: FilmShape | null; readonly after: FilmShape | null; readonly filming: boolean };

/**
 * Films are listed for stretches of this length (µs), and one more on each side: who moves about in an hour finds
 * the film of a moment in what is known, and its picture is asked for at once. Shorter ones where a list has not room
 * for so many films.
 */
const STRETCH_US = HOUR_US;
const SHORT_STRETCH_US = 10 * MINUTE_US;

/** Pictures stand for so long after the last of a film (µs): none is cut off as it comes. */
const LAST_US = 100_000;

/** The time (µs) whose films are listed for a moment; `short`: a longer one has not room in a list. */
export function filmSpanAround(us: number, short: boolean): TimeSpan {
  const lengthUs = short ? SHORT_STRETCH_US : STRETCH_US;
  const fromUs = (Math.floor(us / lengthUs) - 1) * lengthUs;
  return { fromUs, toUs: fromUs + 3 * lengthUs };
}

/**
 * @param names of cameras by their address
 * @returns the cameras of which there is anything, in the order of the names
 */
export function filmsByCamera(list: FilmListShape, names: ReadonlyMap<string, string>): CameraFilms[] {
  const known = [...names.keys()];
  const streams = new Set([...list.films, ...list.unfilmed].map(({ stream }) => stream));
  const cameraOrder = (stream: string): number => (known.includes(stream) ? known.indexOf(stream) : known.length);
  return [...streams]
    .sort((a, b) => cameraOrder(a) - cameraOrder(b) || a.localeCompare(b))
    .map((stream) => ({
      stream,
      name: names.get(stream) ?? stream,
      films: list.films.filter((film) => film.stream === stream).sort((a, b) => a.begin_us - b.begin_us),
      unfilmed: list.unfilmed.filter((stretch) => stretch.stream === stream),
      filming: list.filming.includes(stream),
    }));
}

/** What of a camera shows a moment (µs). */
export function filmStateAt({ films, unfilmed, filming }: CameraFilms, us: number): FilmState {
  const isInside = (stretch: { readonly begin_us: number; readonly end_us: number }): boolean => stretch.begin_us <= us && us <= stretch.end_us + LAST_US;
  // Of two that meet, the later one.
  const there = films.filter(isInside);
  const here = there.filter(({ state }) => state === "complete").at(-1) ?? there.at(-1);
  if (here !== undefined) return { kind: here.state === "complete" ? "film" : here.state === "failed" ? "failed" : "coming", film: here };
  const raw = unfilmed.find(isInside);
  if (raw !== undefined) return { kind: "raw", recording: raw.recording };
  const before = films.filter(({ end_us }) => end_us < us).at(-1) ?? null;
  const after = films.find(({ begin_us }) => begin_us > us) ?? null;
  return { kind: "none", before, after, filming };
}

/** Whether any camera has a film that can be played at a moment. */
export function isFilmed(reels: readonly CameraFilms[], us: number): boolean {
  return reels.some((reel) => filmStateAt(reel, us).kind === "film");
}

/** When the next film begins after a moment; null for none. */
export function nextFilmStart(reels: readonly CameraFilms[], us: number): number | null {
  const begins = reels.flatMap(({ films }) => films.filter(({ state, begin_us }) => state === "complete" && begin_us > us));
  return begins.length === 0 ? null : Math.min(...begins.map(({ begin_us }) => begin_us));
}

/** Where playing begins when nobody has said: with the first film that reaches into the window. */
export function firstFilmMoment(reels: readonly CameraFilms[], fromUs: number): number | null {
  return isFilmed(reels, fromUs) ? fromUs : nextFilmStart(reels, fromUs);
}

/** The picture that stands at a time in a film: the last one that has come (0 for a time before the first). */
export function pictureAt(times: Float64Array, us: number): number {
  let [low, high] = [0, times.length];
  while (low < high) {
    const middle = (low + high) >> 1;
    if ((times[middle] ?? Infinity) <= us) low = middle + 1;
    else high = middle;
  }
  return Math.max(0, low - 1);
}

/** The moment (µs) a picture further on or back from where a film stands; null beyond its ends. */
export function stepTime(film: FilmShape, times: Float64Array, us: number, by: 1 | -1): number | null {
  const time = times[pictureAt(times, us - film.begin_us) + by];
  return time === undefined ? null : film.begin_us + time;
}
