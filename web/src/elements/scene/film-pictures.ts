/**
 * What cameras' films show at a past moment, for a scene: a picture at a time, asked for as the moment moves. It is
 * the picture that a board's film shows, and has its own time: what stands for long grows old beside the moment.
 */

import { msg } from "@lit/localize";
import type { TimeSpan } from "../../series/time-window.js";
import { filmsByCamera, filmSpanAround, filmStateAt, type CameraFilms, type FilmState } from "../../state/past/film-search.js";
import type { PastBoard } from "../../state/past/past-board.js";
import type { PictureListener, StreamPictures } from "../../scene/stream-pictures.js";
import { PageRest, type PageVisibility } from "../../topics/page-rest.js";
import { comeback } from "../../wire/backoff.js";
import type { FilmPicturesApi, FilmsApi } from "../../wire/films-api.js";
import { decodesStills, FilmStills } from "../camera/film-stills.js";

export interface FilmPicturesOptions {
  readonly site: string;
  readonly past: Pick<PastBoard, "us" | "playing" | "isSettled" | "jumps" | "subscribe">;
  readonly lists: Pick<FilmsApi, "listFilms">;
  readonly pictures: Pick<FilmPicturesApi, "findPicture">;
  /** Copies what is seen at once: the frame is closed afterwards. */
  readonly copyFrame?: (frame: VideoFrame) => ImageBitmap;
  readonly page?: PageVisibility;
  /** A clock that only goes forward (ms). */
  readonly now?: () => number;
}

/** What could not be had, and at which moment and time that was. */
interface FilmFailure {
  readonly what: string;
  readonly jumps: number;
  readonly ms: number;
}

interface FilmedCamera {
  readonly stream: string;
  readonly stills: FilmStills;
  wishedMs: number;
  /** The film whose pictures could not be had. */
  failure: FilmFailure | null;
  hasPicture: boolean;
  trouble: string;
  missing: boolean;
}

/** Playing, a picture is asked for this often (ms): as often as recordings are. */
const PLAYING_MS = 200;
/** What could not be had is asked for again after so long (ms), or at another moment. */
const AGAIN_MS = 5000;

const NO_FILMS: Omit<CameraFilms, "stream" | "name"> = { films: [], unfilmed: [], filming: false };

export class FilmPictures implements StreamPictures {
  private readonly cameras = new Map<string, FilmedCamera>();
  private known: { readonly span: TimeSpan; readonly reels: ReadonlyMap<string, CameraFilms> } | null = null;
  private asking: { readonly span: TimeSpan; readonly ending: AbortController } | null = null;
  private listFailure: FilmFailure | null = null;
  /** A long stretch has more films than a list. */
  private isDense = false;
  private readonly page: PageVisibility;
  private readonly now: () => number;
  private readonly stops: readonly (() => void)[];

  constructor(
    private readonly options: FilmPicturesOptions,
    private readonly listener: PictureListener,
  ) {
    this.page = options.page ?? document;
    this.now = options.now ?? (() => performance.now());
    // The moment moves only while it is looked at; what is shown stays true meanwhile.
    const rest = new PageRest({ onRest: () => undefined, onSeen: this.update }, this.page);
    rest.watch();
    this.stops = [
      options.past.subscribe(this.update),
      comeback.subscribe(this.retry),
      () => {
        rest.close();
      },
    ];
  }

  followStreams(wanted: ReadonlyMap<string, string>): void {
    for (const [key, { stream }] of this.cameras) if (wanted.get(key) !== stream) this.end(key);
    for (const [key, stream] of wanted) if (!this.cameras.has(key)) this.cameras.set(key, this.makeCamera(key, stream));
    this.update();
  }

  close(): void {
    for (const stop of this.stops) stop();
    this.asking?.ending.abort();
    this.asking = null;
    for (const key of [...this.cameras.keys()]) this.end(key);
  }

  private makeCamera(key: string, stream: string): FilmedCamera {
    const { site, pictures, copyFrame = copyOf } = this.options;
    const stills = new FilmStills(
      {
        fetch: (film, us, signal) => pictures.findPicture(site, film, us, signal),
        draw: (frame, still) => {
          const image = copyFrame(frame);
          camera.hasPicture = true;
          this.report(key, camera, "", false);
          this.listener.onPicture(key, { image, timeUs: still.us, heardMs: still.us / 1000, rectified: false });
        },
        failed: (film) => {
          camera.failure = this.failureOf(film);
          this.withdraw(key, camera, msg("This film's pictures cannot be had: the hub does not give them, or this browser cannot decode them."));
        },
      },
      this.now,
    );
    const camera: FilmedCamera = { stream, stills, wishedMs: -Infinity, failure: null, hasPicture: false, trouble: "", missing: false };
    return camera;
  }

  /** The moment may be another one, or more may be known. */
  private readonly update = (): void => {
    if (this.page.hidden || this.cameras.size === 0) return;
    const decodes = decodesStills();
    if (decodes) this.loadList();
    for (const [key, camera] of this.cameras) {
      if (decodes) this.showMoment(key, camera);
      else this.withdraw(key, camera, msg("This browser cannot show single pictures of films: it has no WebCodecs, or the page came without https."));
    }
  };

  private showMoment(key: string, camera: FilmedCamera): void {
    const { us, playing } = this.options.past;
    const state = this.stateAt(camera.stream, us);
    if (state === null) {
      const failed = this.isHeldBack(this.listFailure, "");
      this.withdraw(key, camera, failed ? msg("The hub did not say which films there are.") : "", failed);
      return;
    }
    if (state.kind !== "film") {
      this.withdraw(key, camera, wordOf(state));
      return;
    }
    const now = this.now();
    if (this.isHeldBack(camera.failure, state.film.id) || (playing && now - camera.wishedMs < PLAYING_MS)) return;
    camera.wishedMs = now;
    camera.failure = null;
    // What stands in its place does so until it is seen.
    this.report(key, camera, "", camera.missing);
    camera.stills.want(state.film.id, us);
  }

  /** What there is of a moment; null while it is not known. */
  private stateAt(stream: string, us: number): FilmState | null {
    const { known } = this;
    if (known === null || us < known.span.fromUs || us >= known.span.toUs) return null;
    return filmStateAt(known.reels.get(stream) ?? { ...NO_FILMS, stream, name: stream }, us);
  }

  private loadList(): void {
    const { us, isSettled } = this.options.past;
    // Who moves about wants the rest of the board first.
    if (!isSettled) return;
    const span = filmSpanAround(us, this.isDense);
    if (isSame(this.known?.span, span) || isSame(this.asking?.span, span) || this.isHeldBack(this.listFailure, "")) return;
    this.asking?.ending.abort();
    const ending = new AbortController();
    this.asking = { span, ending };
    void this.askList(span, ending.signal);
  }

  private async askList(span: TimeSpan, signal: AbortSignal): Promise<void> {
    try {
      const list = await this.options.lists.listFilms(this.options.site, span.fromUs, span.toUs, signal);
      if (signal.aborted) return;
      this.known = { span, reels: new Map(filmsByCamera(list, new Map()).map((reel) => [reel.stream, reel])) };
      this.isDense ||= list.more;
      this.listFailure = null;
    } catch {
      if (signal.aborted) return;
      this.listFailure = this.failureOf("");
    }
    this.asking = null;
    this.update();
  }

  private failureOf(what: string): FilmFailure {
    return { what, jumps: this.options.past.jumps, ms: this.now() };
  }

  private isHeldBack(failure: FilmFailure | null, what: string): boolean {
    return failure?.what === what && failure.jumps === this.options.past.jumps && this.now() - failure.ms < AGAIN_MS;
  }

  private readonly retry = (): void => {
    this.listFailure = null;
    for (const camera of this.cameras.values()) camera.failure = null;
    this.update();
  };

  /** Nothing that is shown is of this moment. */
  private withdraw(key: string, camera: FilmedCamera, why: string, missing = true): void {
    camera.stills.clear();
    if (camera.hasPicture) this.listener.onPicture(key, null);
    camera.hasPicture = false;
    this.report(key, camera, why, missing);
  }

  private report(key: string, camera: FilmedCamera, trouble: string, missing: boolean): void {
    const before = { trouble: camera.trouble, missing: camera.missing };
    // First: who is told may ask for the same again.
    Object.assign(camera, { trouble, missing });
    if (before.trouble !== trouble) this.listener.onTrouble(key, trouble);
    if (before.missing !== missing) this.listener.onMissing(key, missing);
  }

  private end(key: string): void {
    const camera = this.cameras.get(key);
    if (camera === undefined) return;
    this.cameras.delete(key);
    this.withdraw(key, camera, "", false);
    camera.stills.close();
  }
}

function isSame(a: TimeSpan | undefined, b: TimeSpan): boolean {
  return a?.fromUs === b.fromUs && a.toUs === b.toUs;
}

function wordOf(state: FilmState): string {
  switch (state.kind) {
    case "film":
      return "";
    case "coming":
      return msg("This film is still being uploaded");
    case "failed":
      return msg("This film is lost");
    case "raw":
      return msg("The pictures of this time are messages in a recording (MCAP), for Foxglove or Lichtblick.");
    case "none":
      return msg("No film of this moment");
  }
}

/** A canvas gives its picture away at once, where `createImageBitmap` may read a frame that is closed by then. */
function copyOf(frame: VideoFrame): ImageBitmap {
  const canvas = new OffscreenCanvas(frame.displayWidth, frame.displayHeight);
  canvas.getContext("2d")?.drawImage(frame, 0, 0);
  return canvas.transferToImageBitmap();
}
