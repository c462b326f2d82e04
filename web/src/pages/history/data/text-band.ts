/** Texts over time as a band: each different text is a state. */

import { Trace } from "../../../series/trace.js";
import type { LoadedSeries } from "./history-loader.js";

const MOST = 200_000;
/** `pauseAllowed` gives three usual intervals. */
const OFTEN = 3;

export interface TextBand {
  readonly words: readonly string[];
  readonly samples: Trace;
}

/**
 * @param maxAgeUs the signal's limit of age (µs): after it nobody knows whether the text still holds
 * @param known words that have their places already
 */
export function textBand({ texts, gaps, trace }: LoadedSeries, maxAgeUs: number, known: readonly string[] = []): TextBand {
  const places = new Map(known.map((word, place) => [word, place]));
  for (const { text } of texts) if (!places.has(text)) places.set(text, places.size);
  const points = texts.map(({ timeUs, text }) => ({ timeUs, place: places.get(text) ?? NaN }));
  for (const { from_us } of gaps) points.push({ timeUs: from_us + 1, place: NaN });
  points.sort((a, b) => a.timeUs - b.timeUs);
  const samples = new Trace(Infinity, maxAgeUs, MOST);
  const times = points.map(({ timeUs }) => timeUs);
  // The pause allowed is the channel's own: of thinned texts only the first and last of each pixel are here.
  samples.backfill(times, points.map(({ place }) => place), trace.allowedUs / OFTEN);
  return { words: [...places.keys()], samples };
}
