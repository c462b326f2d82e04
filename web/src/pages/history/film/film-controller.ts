/** The films of the window, and the moment at which they and the charts' cursor stand. */

import type { ReactiveController, ReactiveControllerHost } from "lit";
import { lengthOf, type TimeSpan } from "../../../series/time-window.js";
import { SECOND_US } from "../../../series/zone-clock.js";
import type { FilmListShape } from "../../../generated/api.js";
import { LatestRequest } from "../data/latest-request.js";
import { firstFilmMoment, isFilmed, nextFilmStart, filmsByCamera, type CameraFilms } from "../../../state/past/film-search.js";
import { nextSpeed, Playhead } from "../../../state/past/playhead.js";

export interface FilmSource {
  listFilms(site: string, fromUs: number, toUs: number, signal?: AbortSignal): Promise<FilmListShape>;
}

interface FilmQuestion {
  readonly site: string;
  readonly span: TimeSpan;
  readonly turn: number;
}

/** Playing, the page is drawn anew this often (ms): the films themselves run at their own rate. */
const DRAW_MS = 40;
/** A film that is on its way, or being made, is asked for this often (ms). */
const AGAIN_MS = 3000;
const STEP_US = 5 * SECOND_US;
const NOTHING: FilmListShape = { films: [], more: false, unfilmed: [], filming: [], may_film: false, why_not: "" };

export class FilmController implements ReactiveController {
  reels: readonly CameraFilms[] = [];
  more = false;
  private list: FilmListShape = NOTHING;
  private readonly head = new Playhead();
  private moment: number | null = null;
  /** A person has put it there: it is the charts' cursor, too. */
  private isMeant = false;
  private span: TimeSpan = { fromUs: 0, toUs: 0 };
  private frame = 0;
  private drawnMs = 0;
  private isHeld = false;
  private readonly asker: LatestRequest<FilmQuestion, FilmListShape>;

  constructor(
    private readonly host: ReactiveControllerHost,
    private readonly source: () => FilmSource | null,
    /** The moment has left the window, playing. */
    private readonly left: (us: number) => void,
  ) {
    host.addController(this);
    this.asker = new LatestRequest<FilmQuestion, FilmListShape>({
      fetch: ({ site, span }, signal) => this.source()?.listFilms(site, span.fromUs, span.toUs, signal) ?? Promise.resolve(NOTHING),
      isStillUseful: (running, next) => running.site === next.site,
      onAnswer: (list) => {
        this.list = list;
      },
      onChange: () => {
        host.requestUpdate();
      },
    });
  }

  hostDisconnected(): void {
    cancelAnimationFrame(this.frame);
    this.head.pause(performance.now());
    this.asker.cancelRequest();
    this.list = NOTHING;
    this.reels = [];
    this.moment = null;
  }

  /** Another site: nothing of the last one is shown. */
  clear(): void {
    this.hostDisconnected();
  }

  /** The moment that is shown (µs); null while there is no film. */
  get us(): number | null {
    return this.moment;
  }

  /** The moment as the charts' cursor; null until a person has played, stepped or clicked. */
  get cursorUs(): number | null {
    return this.isMeant ? this.moment : null;
  }

  get playing(): boolean {
    return this.head.playing;
  }

  get speed(): number {
    return this.head.speed;
  }

  get held(): boolean {
    return this.isHeld;
  }

  get renderFailure(): unknown {
    return this.asker.state === "failed" ? this.asker.error : null;
  }

  /** @param names of the cameras, by their address */
  load(site: string, span: TimeSpan, names: ReadonlyMap<string, string>): void {
    this.span = span;
    const step = Math.max(STEP_US, 2 ** Math.floor(Math.log2(lengthOf(span) / 4)));
    const fromUs = Math.max(0, Math.floor(span.fromUs / step) * step);
    const coming = this.list.filming.length > 0 || this.list.films.some(({ state }) => state === "uploading");
    const turn = coming ? Math.floor(Date.now() / AGAIN_MS) : 0;
    this.asker.request({ site, span: { fromUs, toUs: Math.ceil(span.toUs / step) * step }, turn });
    this.reels = this.filmsInSpan(filmsByCamera(this.list, names), span);
    this.more = this.list.more;
    this.moveToFilm();
  }

  retry(): void {
    this.asker.invalidate();
    this.host.requestUpdate();
  }

  seek(us: number): void {
    this.isMeant = true;
    this.previewMoment(us);
  }

  /** Shows a moment that a pointer passes over. */
  previewMoment(us: number): void {
    this.head.seek(us, performance.now());
    this.moment = us;
    this.host.requestUpdate();
  }

  toggle(): void {
    if (this.playing) this.pause();
    else this.play();
  }

  play(): void {
    const from = this.moment;
    if (from === null) return;
    this.isMeant = true;
    // At the end it begins anew, as everywhere.
    if (!isFilmed(this.reels, from) && nextFilmStart(this.reels, from) === null) {
      const first = firstFilmMoment(this.reels, this.span.fromUs);
      if (first !== null) this.seek(first);
    }
    this.head.play(performance.now());
    this.isHeld = false;
    this.scheduleFrame();
    this.host.requestUpdate();
  }

  pause(): void {
    const now = performance.now();
    this.head.pause(now);
    this.moment = this.head.timeUs(now);
    cancelAnimationFrame(this.frame);
    this.host.requestUpdate();
  }

  setSpeed(speed: number): void {
    this.head.setSpeed(speed, performance.now());
    this.host.requestUpdate();
  }

  changeSpeed(by: 1 | -1): void {
    this.setSpeed(nextSpeed(this.speed, by));
  }

  /** The moment waits for a picture that has not come, or goes on. */
  setWaiting(held: boolean): void {
    if (held === this.isHeld || !this.playing) return;
    this.isHeld = held;
    this.head.setWaiting(held, performance.now());
    this.host.requestUpdate();
  }

  private filmsInSpan(reels: readonly CameraFilms[], span: TimeSpan): CameraFilms[] {
    const isInSpan = (stretch: { readonly begin_us: number; readonly end_us: number }): boolean => stretch.begin_us <= span.toUs && stretch.end_us >= span.fromUs;
    return reels.filter(({ films, unfilmed }) => films.some(isInSpan) || unfilmed.some(isInSpan));
  }

  /** Puts the moment to where there is a film, unless a person has put it elsewhere. */
  private moveToFilm(): void {
    const { moment, span } = this;
    if (this.reels.length === 0 && !this.playing) {
      if (this.list !== NOTHING) this.moment = null;
      return;
    }
    const inside = moment !== null && moment >= span.fromUs && moment <= span.toUs;
    if (inside || this.playing) return;
    const first = firstFilmMoment(this.reels, span.fromUs) ?? span.fromUs;
    this.head.seek(first, performance.now());
    this.moment = first;
    this.isMeant = false;
  }

  private scheduleFrame(): void {
    cancelAnimationFrame(this.frame);
    this.frame = requestAnimationFrame(this.onFrame);
  }

  private readonly onFrame = (nowMs: number): void => {
    if (!this.playing) return;
    const now = performance.now();
    let us = this.head.timeUs(now);
    if (!isFilmed(this.reels, us)) {
      const skip = nextFilmStart(this.reels, us);
      if (skip === null) {
        this.moment = us;
        this.pause();
        return;
      }
      this.head.seek(skip, now);
      us = skip;
    }
    this.moment = us;
    if (nowMs - this.drawnMs >= DRAW_MS) {
      this.drawnMs = nowMs;
      if (us > this.span.toUs || us < this.span.fromUs) this.left(us);
      this.host.requestUpdate();
    }
    this.scheduleFrame();
  };
}
