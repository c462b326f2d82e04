/** What may be asked of the hub about films of cameras. */

import { msg, str } from "@lit/localize";
import { Decoder } from "@msgpack/msgpack";
import type { FilmListShape } from "../generated/api.js";
import { FrameError } from "./codec.js";
import type { HubApi } from "./hub-api.js";

/** One picture of a film, after those that it is made from; see the hub's route. */
export interface FilmPicture {
  readonly codec: string;
  readonly description: Uint8Array<ArrayBuffer>;
  /** When each of them came (µs, UTC); the last one is the picture. */
  readonly timesUs: readonly number[];
  /** When the pictures beside it came (µs, UTC); null for none. */
  readonly beforeUs: number | null;
  readonly nextUs: number | null;
  readonly data: readonly Uint8Array<ArrayBuffer>[];
}

interface PictureAnswer {
  readonly codec: string;
  readonly description: Uint8Array<ArrayBuffer>;
  readonly times_us: readonly number[];
  readonly before_us: number | null;
  readonly next_us: number | null;
  readonly data: readonly Uint8Array<ArrayBuffer>[];
}

const decoder = new Decoder();

/** Later than any film: the answer lists none, and says how filming stands. */
const NEVER_US = 2 ** 53;

export class FilmsApi {
  constructor(private readonly hub: Pick<HubApi, "request">) {}

  /** Films that have something of a stretch of time (µs). */
  listFilms(site: string, fromUs: number, toUs: number, signal?: AbortSignal): Promise<FilmListShape> {
    const query = `from_us=${String(Math.max(0, Math.floor(fromUs)))}&to_us=${String(Math.ceil(toUs))}`;
    return this.hub.request("GET", `/api/sites/${encodeURIComponent(site)}/films?${query}`, undefined, { signal });
  }

  /** Which cameras are being filmed, and whether one may be. */
  recordingStatus(site: string): Promise<FilmListShape> {
    return this.listFilms(site, NEVER_US, NEVER_US);
  }

  /** The gateway does it; whether it did is seen in `now`. */
  async setRecording(site: string, stream: string, on: boolean): Promise<void> {
    await this.hub.request("POST", `/api/sites/${encodeURIComponent(site)}/recordings`, { on, stream });
  }
}

/** Gives pictures out of films. */
export class FilmPicturesApi {
  constructor(private readonly hub: Pick<HubApi, "requestBytes">) {}

  /** The picture that stands at a moment (µs, UTC). */
  async findPicture(site: string, film: string, atUs: number, signal?: AbortSignal): Promise<FilmPicture> {
    const bytes = await this.hub.requestBytes(`${pathOf(site, film)}/picture?at_us=${String(Math.max(0, Math.floor(atUs)))}`, { signal });
    const { codec, description, times_us: timesUs, before_us: beforeUs, next_us: nextUs, data } = decodeAnswer(bytes);
    return { codec, description, timesUs, beforeUs, nextUs, data };
  }
}

/** @throws FrameError when the bytes are no such answer */
function decodeAnswer(bytes: ArrayBuffer): PictureAnswer {
  let found: unknown;
  try {
    found = decoder.decode(bytes);
  } catch (error) {
    throw new FrameError(msg(str`an answer that is not MessagePack: ${String(error)}`));
  }
  if (typeof found !== "object" || found === null || !("data" in found) || !Array.isArray(found.data) || found.data.length === 0) throw new FrameError(msg("an answer without pictures"));
  return found as PictureAnswer;
}

/** Where a film's file is. */
export function filmPath(site: string, film: string): string {
  return `${pathOf(site, film)}/file`;
}

function pathOf(site: string, film: string): string {
  return `/api/sites/${encodeURIComponent(site)}/films/${encodeURIComponent(film)}`;
}
