/**
 * Pictures of films that stand still: each is one question and one answer, and is decoded here. A `<video>` asks for a
 * film's tables, then for its pictures, and begins with more of them than are needed.
 */

import type { FilmPicture } from "../../wire/films-api.js";

/** A picture that is seen. */
export interface FilmStill {
  readonly film: string;
  /** When it came (µs, UTC), and up to when it stands: the next one's time, Infinity for the last. */
  readonly us: number;
  readonly untilUs: number;
  /** When the one before it came (µs, UTC); null for none. */
  readonly beforeUs: number | null;
}

export interface FilmStillsOptions {
  readonly fetch: (film: string, us: number, signal: AbortSignal) => Promise<FilmPicture>;
  /** Draws it at once: the frame is closed afterwards. */
  readonly draw: (frame: VideoFrame, still: FilmStill) => void;
  /** This film's pictures cannot be had in this way. */
  readonly failed: (film: string) => void;
}

interface Wish {
  readonly film: string;
  readonly us: number;
  readonly number: number;
}

/** Questions that run at a time. */
const MOST_RUNNING = 2;
/** Wishes that follow one another sooner than this (ms) are of a hand that moves the moment. */
const QUICK_MS = 100;
/** Meanwhile a picture is asked for this often (ms), so that something is seen of the way... */
const SEEN_MS = 200;
/** ...and once the hand has rested for so long (ms): the last one waits behind none of those between. */
const REST_MS = 40;

export function decodesStills(scope: { VideoDecoder?: typeof VideoDecoder } = globalThis): boolean {
  return scope.VideoDecoder !== undefined;
}

export class FilmStills {
  private still: FilmStill | null = null;
  private wish: Wish | null = null;
  /** Counts the wishes; of those that were answered no older one is drawn any more. */
  private asked = 0;
  private drawn = 0;
  private wishedMs = -Infinity;
  private startedMs = -Infinity;
  private rest: ReturnType<typeof setTimeout> | undefined;
  private running = 0;
  private started = 0;
  private decoding: Promise<void> = Promise.resolve();
  private asking = new AbortController();
  private readonly decoder = new PictureDecoder();

  /** @param now a clock that only goes forward (ms) */
  constructor(
    private readonly options: FilmStillsOptions,
    private readonly now: () => number = () => performance.now(),
  ) {}

  /** What is seen; null for nothing. */
  get shown(): FilmStill | null {
    return this.still;
  }

  /** The picture that was wanted last is seen. */
  get isSettled(): boolean {
    const { wish } = this;
    return wish === null || this.showsMoment(wish.film, wish.us);
  }

  showsMoment(film: string, us: number): boolean {
    const { still } = this;
    // Before a film's first picture stands that one.
    return still?.film === film && us < still.untilUs && (us >= still.us || still.beforeUs === null);
  }

  /** The picture of a moment (µs) is to be seen. */
  want(film: string, us: number): void {
    if (this.wish?.film === film && this.wish.us === us) return;
    this.wish = { film, us, number: ++this.asked };
    const now = this.now();
    const isQuick = now - this.wishedMs < QUICK_MS;
    this.wishedMs = now;
    clearTimeout(this.rest);
    if (isQuick && now - this.startedMs < SEEN_MS) this.rest = setTimeout(this.askNext, REST_MS);
    else this.askNext();
  }

  /** Nothing is wanted any more, and nothing seen. */
  clear(): void {
    clearTimeout(this.rest);
    this.asking.abort();
    this.asking = new AbortController();
    this.wish = null;
    this.still = null;
    this.drawn = this.asked;
  }

  close(): void {
    this.clear();
    this.decoder.close();
  }

  private readonly askNext = (): void => {
    const { wish } = this;
    if (wish === null || wish.number === this.started || this.running >= MOST_RUNNING || this.isSettled) return;
    this.started = wish.number;
    this.startedMs = this.now();
    this.running += 1;
    void this.answer(wish, this.asking.signal).finally(() => {
      this.running -= 1;
      // What waited for a place is asked for now; while a hand moves, once it rests.
      clearTimeout(this.rest);
      if (this.now() - this.wishedMs >= REST_MS) this.askNext();
      else this.rest = setTimeout(this.askNext, REST_MS);
    });
  };

  private async answer(wish: Wish, signal: AbortSignal): Promise<void> {
    try {
      const picture = await this.options.fetch(wish.film, wish.us, signal);
      // One after the other: there is one decoder. Of those that wait only the newest is decoded.
      const turn = this.decoding.then(() => this.show(wish, picture, signal));
      this.decoding = turn.catch(() => undefined);
      await turn;
    } catch {
      if (signal.aborted || wish.film !== this.wish?.film) return;
      this.clear();
      this.options.failed(wish.film);
    }
  }

  private async show(wish: Wish, picture: FilmPicture, signal: AbortSignal): Promise<void> {
    if (signal.aborted || wish.number < this.drawn) return;
    this.drawn = wish.number;
    const frame = await this.decoder.decodeLast(picture);
    try {
      signal.throwIfAborted();
      const us = picture.timesUs.at(-1) ?? 0;
      this.still = { film: wish.film, us, untilUs: picture.nextUs ?? Infinity, beforeUs: picture.beforeUs };
      this.options.draw(frame, this.still);
    } finally {
      frame.close();
    }
  }
}

/** Decodes what belongs to one picture, and keeps that alone. */
class PictureDecoder {
  private decoder: VideoDecoder | null = null;
  private configured = "";
  private last: VideoFrame | null = null;
  private failure = "no picture came out";

  /** Rejects where it cannot be decoded. */
  async decodeLast(picture: FilmPicture): Promise<VideoFrame> {
    const decoder = this.decoderFor(picture);
    picture.data.forEach((data, i) => {
      decoder.decode(new EncodedVideoChunk({ type: i === 0 ? "key" : "delta", timestamp: i, data }));
    });
    await decoder.flush();
    const { last } = this;
    this.last = null;
    if (last === null) throw new RangeError(this.failure);
    return last;
  }

  close(): void {
    const { decoder } = this;
    this.decoder = null;
    this.last?.close();
    this.last = null;
    if (decoder !== null && decoder.state !== "closed") decoder.close();
  }

  private decoderFor({ codec, description }: FilmPicture): VideoDecoder {
    const wanted = `${codec} ${description.join()}`;
    if (this.decoder?.state === "configured" && wanted === this.configured) return this.decoder;
    this.close();
    this.configured = wanted;
    const decoder: VideoDecoder = new VideoDecoder({
      output: (frame) => {
        if (this.decoder !== decoder) {
          frame.close();
          return;
        }
        this.last?.close();
        this.last = frame;
      },
      error: (error) => {
        this.failure = error.message;
      },
    });
    decoder.configure({ codec, description, optimizeForLatency: true });
    this.decoder = decoder;
    return decoder;
  }
}
