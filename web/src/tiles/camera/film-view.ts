/**
 * One camera's film at the moment that the charts' cursor stands at.
 *
 * Standing still it is a picture that is asked for by itself (`film-stills.ts`), over the `<video>` that plays it.
 *
 * Long, because keeping a `<video>` at a moment that others decide is one matter: which file, where
 * in it, how fast, and what to say while there is no picture.
 */

import { consume } from "@lit/context";
import { msg, str } from "@lit/localize";
import { html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, property, query, state } from "lit/decorators.js";
import { base } from "../../elements/base/base-style.js";
import { momentText } from "../../elements/chart/cursor-values.js";
import { onPicture, pictureFrame } from "../../elements/camera/picture-overlay.js";
import { formatNumber } from "../../format/number.js";
import { formatClock, knownZone } from "../../format/time.js";
import { apiContext } from "../../state/contexts.js";
import { fetchTimes } from "../../wire/mp4-times.js";
import { FilmPicturesApi, filmPath } from "../../wire/films-api.js";
import type { HubApi } from "../../wire/hub-api.js";
import type { FilmShape } from "../../generated/api.js";
import { recordingPath } from "../../wire/recordings-api.js";
import { pictureAt, filmStateAt, stepTime, type CameraFilms, type FilmState } from "../../state/past/film-search.js";
import { decodesStills, FilmStills, type FilmStill } from "../../elements/camera/film-stills.js";
import { filmViewStyle } from "./film-view-style.js";
import "../../elements/forms/button.js";
import "../../elements/base/icon.js";

/** Playing, a film that is farther from the moment than this (s, at its own speed) jumps to it. */
const FAR_S = 0.35;
/** Nearer than that it goes this much faster or slower for each second that it is off. */
const PULL = 0.4;
/** A picture is asked for this far behind its beginning (s): its neighbour is not meant. */
const INTO_S = 0.000_5;
/** Less than this is the same place (s). */
const SAME_S = 0.000_4;
/** After so long (ms) at one moment somebody may well play from there: the film is made ready. */
const REST_MS = 1500;
/** A picture of another film stays for so long (ms) while that of the moment comes: as the rest of a board does. */
const BLINK_MS = 300;

interface PresentedFrame {
  readonly mediaTime: number;
}

/** @fires t-moment detail is a moment (µs) to go to */
@customElement("t-film-view")
export class FilmView extends LitElement {
  static override styles = [
    base,
    onPicture,
    pictureFrame,
    filmViewStyle,
  ];

  @property() site = "";
  @property({ attribute: false }) reel: CameraFilms | null = null;
  /** The moment that is to be shown (µs). */
  @property({ type: Number }) us = 0;
  @property({ type: Boolean }) playing = false;
  @property({ type: Number }) speed = 1;
  /** The moment stands still, since some picture has not come yet. */
  @property({ type: Boolean }) held = false;
  @property() zone = "UTC";

  /** When the picture that is seen came (µs); 0 for none. */
  @state() shownUs = 0;
  @state() private broken = "";

  /** A picture that stands still covers the film. */
  @state() private isStill = false;

  @consume({ context: apiContext }) private readonly api: HubApi | undefined;
  @query("video") private readonly video!: HTMLVideoElement;
  @query("canvas") private readonly canvas!: HTMLCanvasElement;

  private readonly stills = new FilmStills({
    fetch: async (film, us, signal) => {
      if (this.api === undefined) throw new RangeError("no hub");
      return new FilmPicturesApi(this.api).findPicture(this.site, film, us, signal);
    },
    draw: (frame, still) => {
      this.drawStill(frame, still);
    },
    failed: (film) => {
      this.withoutStills = film;
      this.isStill = false;
      this.requestUpdate();
    },
  });
  /** The film of which no single pictures can be had. */
  private withoutStills = "";
  private rest: ReturnType<typeof setTimeout> | undefined;
  private blink: ReturnType<typeof setTimeout> | undefined;
  private restedUs = Number.NaN;

  private film: FilmShape | null = null;
  private times: Float64Array | null = null;
  private asking: AbortController | null = null;
  private watching = 0;

  override disconnectedCallback(): void {
    super.disconnectedCallback();
    this.loadFilm(null);
    this.stills.close();
  }

  /** Whether the picture of the moment is there, or none is to be expected. */
  get ready(): boolean {
    if (this.film === null || this.broken !== "") return true;
    if (!this.playing && this.usesStills(this.film)) return this.isStill && this.stills.isSettled;
    return !this.video.seeking && this.video.readyState >= HTMLMediaElement.HAVE_CURRENT_DATA;
  }

  /** The moment of the next picture or of the one before; null where this film has none. */
  stepTimeUs(us: number, by: 1 | -1): number | null {
    const { film, times } = this;
    if (film === null) return null;
    if (times !== null) return stepTime(film, times, us, by);
    const { shown } = this.stills;
    if (shown !== null && this.stills.showsMoment(film.id, us)) {
      if (by < 0) return shown.beforeUs;
      return shown.untilUs === Infinity ? null : shown.untilUs;
    }
    const step = (film.end_us - film.begin_us) / Math.max(1, film.pictures - 1);
    const to = us + by * step;
    return film.begin_us <= to && to <= film.end_us ? to : null;
  }

  protected override updated(): void {
    const { reel } = this;
    const showing = reel === null ? null : filmStateAt(reel, this.us);
    this.loadFilm(showing?.kind === "film" ? showing.film : null);
    this.followMoment();
  }

  override render(): TemplateResult {
    const showing = this.reel === null ? null : filmStateAt(this.reel, this.us);
    const plays = showing?.kind === "film" && this.broken === "";
    const name = this.reel?.name ?? "";
    const label = plays && this.shownUs > 0 ? msg(str`Film of ${name}, picture of ${this.moment(this.shownUs)}`) : msg(str`Film of ${name}`);
    return html`<video
        .muted=${true}
        playsinline
        preload="metadata"
        disablepictureinpicture
        ?hidden=${!plays}
        aria-hidden=${plays && this.isStill ? "true" : nothing}
        aria-label=${label}
        @seeked=${this.onMediaReady}
        @loadeddata=${this.onMediaReady}
        @error=${this.onMediaError}
      ></video>
      <canvas role="img" aria-label=${label} ?hidden=${!plays || !this.isStill}></canvas>
      ${plays
        ? html`<div class="tint"></div>
            <a class="key get" href=${filmPath(this.site, showing.film.id)} download title=${msg("Download this film")} aria-label=${msg(str`Download this film of ${name}`)}>
              <svg viewBox="0 0 24 24" aria-hidden="true">
                <path d="M12 4v11M7 10l5 5 5-5M5 20h14" fill="none" stroke="currentColor" stroke-width="2" stroke-linecap="round" stroke-linejoin="round"></path>
              </svg>
            </a>`
        : showing === null ? nothing : this.renderPlaceholder(showing)}
      <span class="badge">${name}${plays && this.shownUs > 0 ? html`<time> · ${this.moment(this.shownUs)}</time>` : nothing}</span>`;
  }

  private renderPlaceholder(showing: FilmState): TemplateResult {
    switch (showing.kind) {
      case "film":
        return html`<div class="veil">
          <h3>${msg("This film cannot be played")}</h3>
          <p role="alert">${this.broken}</p>
          <div class="ways">
            <t-button @click=${this.retry}>${msg("Try again")}</t-button>
            <a href=${filmPath(this.site, showing.film.id)} download>${msg("Download the film")}</a>
          </div>
        </div>`;
      case "coming": {
        const { size, have } = showing.film;
        return html`<div class="veil">
          <h3>${msg("This film is still being uploaded")}</h3>
          <p>${msg(str`${formatNumber(size > 0 ? (100 * have) / size : 0, 0)} % of it has come from the gateway.`)}</p>
        </div>`;
      }
      case "failed":
        return html`<div class="veil">
          <h3>${msg("This film is lost")}</h3>
          <p>${showing.film.note}</p>
        </div>`;
      case "raw":
        return html`<div class="veil">
          <h3>${msg("Not as a film")}</h3>
          <p>${msg("The pictures of this time are messages in a recording (MCAP), for Foxglove or Lichtblick.")}</p>
          <a href=${recordingPath(this.site, showing.recording)} download>${msg("Download the recording")}</a>
        </div>`;
      case "none":
        return html`<div class="veil">
          <h3>${msg("No film of this moment")}</h3>
          ${showing.filming ? html`<p>${msg("It is being filmed now; the film comes when it has ended.")}</p>` : nothing}
          <div class="ways">
            ${showing.before === null ? nothing : this.renderFilmLink(msg("Before"), showing.before.end_us)}
            ${showing.after === null ? nothing : this.renderFilmLink(msg("Next"), showing.after.begin_us)}
          </div>
        </div>`;
    }
  }

  private renderFilmLink(word: string, us: number): TemplateResult {
    const goToFilm = (): void => {
      this.dispatchEvent(new CustomEvent("t-moment", { detail: us, bubbles: true, composed: true }));
    };
    return html`<t-button @click=${goToFilm}>${word}: ${formatClock(us, this.zone)}</t-button>`;
  }

  private moment(us: number): string {
    return momentText(us, knownZone(this.zone), 0);
  }

  // ── the file ──

  private loadFilm(film: FilmShape | null): void {
    if (film?.id === this.film?.id) return;
    this.film = film;
    this.times = null;
    this.broken = "";
    this.asking?.abort();
    this.asking = null;
    this.watching += 1;
    this.restedUs = Number.NaN;
    clearTimeout(this.rest);
    clearTimeout(this.blink);
    this.dropVideo();
    if (film === null) this.dropStill();
    else if (this.isStill && this.usesStills(film)) this.blink = setTimeout(this.dropOtherStill, BLINK_MS);
    else this.dropStill();
  }

  private coverFilm(still: FilmStill): void {
    this.isStill = true;
    this.shownUs = still.us;
  }

  /** The `<video>` gets the film, unless it has it. */
  private openVideo(film: FilmShape): void {
    const { video } = this;
    if (video.hasAttribute("src")) return;
    // Where to begin stands in the address: a browser that has to be told once it knows the file asks for it twice.
    video.src = `${filmPath(this.site, film.id)}#t=${(Math.max(0, this.us - film.begin_us) / 1e6).toFixed(3)}`;
    this.watchFrames(this.watching);
  }

  private dropVideo(): void {
    const { video } = this;
    if (!video.hasAttribute("src")) return;
    video.removeAttribute("src");
    video.load();
  }

  private readonly dropOtherStill = (): void => {
    if (this.stills.shown?.film !== this.film?.id) this.dropStill();
  };

  private dropStill(): void {
    // What is wanted of the film that is open now goes on being wanted.
    if (this.film === null || !this.usesStills(this.film)) this.stills.clear();
    this.isStill = false;
    this.shownUs = 0;
  }

  /** Single pictures can be had of it, and decoded here. */
  private usesStills(film: FilmShape): boolean {
    return this.api !== undefined && this.withoutStills !== film.id && decodesStills();
  }

  private drawStill(frame: VideoFrame, still: FilmStill): void {
    const { canvas, film } = this;
    if (still.film !== film?.id) return;
    canvas.width = frame.displayWidth;
    canvas.height = frame.displayHeight;
    canvas.getContext("2d")?.drawImage(frame, 0, 0);
    // Playing, the film itself is seen already.
    if (this.playing && !this.isStill && this.shownUs > 0) return;
    this.coverFilm(still);
    this.dispatchEvent(new CustomEvent("t-ready"));
  }

  /** Asked for once a picture is seen: it comes first. */
  private loadTimes(film: FilmShape): void {
    if (this.asking !== null) return;
    const asking = new AbortController();
    this.asking = asking;
    fetchTimes(filmPath(this.site, film.id), asking.signal).then(
      (times) => {
        if (asking.signal.aborted) return;
        this.times = times;
        // It may be the right picture already, and stay where it is.
        if (!this.isStill && this.video.paused && !this.video.seeking) this.holdsTime(film, this.video.currentTime);
        this.requestUpdate();
      },
      // Without them pictures are asked for by the clock alone.
      () => undefined,
    );
  }

  /** Learns of each picture that is seen while it plays when it came. */
  private watchFrames(turn: number): void {
    const { video } = this;
    const recordFrameTime = (_now: number, { mediaTime }: PresentedFrame): void => {
      if (turn !== this.watching || this.film === null) return;
      if (!video.paused) {
        this.isStill = false;
        this.holdsTime(this.film, mediaTime);
      }
      video.requestVideoFrameCallback(recordFrameTime);
    };
    if ("requestVideoFrameCallback" in video) video.requestVideoFrameCallback(recordFrameTime);
  }

  private holdsTime({ begin_us }: FilmShape, timeS: number): void {
    const { times } = this;
    const us = Math.round(timeS * 1e6);
    // The browser's own clock is coarser than the film's.
    this.shownUs = begin_us + Math.round(times === null ? us : (times[pictureAt(times, us + 1e6 * INTO_S)] ?? us));
  }

  // ── where it stands ──

  /** Where in the file the moment is (s). */
  private positionInFile(film: FilmShape): number {
    const us = Math.max(0, this.us - film.begin_us);
    const { times } = this;
    if (times === null) return us / 1e6;
    return (times[pictureAt(times, us)] ?? us) / 1e6 + INTO_S;
  }

  private followMoment(): void {
    const { film, video } = this;
    if (film === null || this.broken !== "") return;
    if (this.playing && this.us < film.end_us) {
      this.restedUs = Number.NaN;
      clearTimeout(this.rest);
      this.openVideo(film);
      this.playFilm(film, video);
    } else this.showStill(film, video);
  }

  private playFilm(film: FilmShape, video: HTMLVideoElement): void {
    const offS = (video.currentTime - (this.us - film.begin_us) / 1e6) / this.speed;
    if (video.seeking || video.readyState < HTMLMediaElement.HAVE_METADATA) return;
    if (Math.abs(offS) > FAR_S) {
      video.currentTime = Math.max(0, (this.us - film.begin_us) / 1e6);
      return;
    }
    if (this.held) {
      video.pause();
      return;
    }
    const rate = this.speed * (1 - PULL * offS);
    if (Math.abs(video.playbackRate - rate) > 0.01 * this.speed) video.playbackRate = Math.min(16, Math.max(0.1, rate));
    // It may be told to pause before it has begun, which is no failure.
    if (video.paused) video.play().catch(() => undefined);
  }

  private showStill(film: FilmShape, video: HTMLVideoElement): void {
    if (!video.paused) {
      video.pause();
      this.holdsTime(film, video.currentTime);
    }
    if (this.usesStills(film)) {
      this.stills.want(film.id, this.us);
      const { shown } = this.stills;
      // It may have been drawn before somebody played and came back.
      if (!this.isStill && shown !== null && this.stills.showsMoment(film.id, this.us)) this.coverFilm(shown);
      this.restAt(film, video);
      return;
    }
    this.openVideo(film);
    this.seekStill(film, video);
  }

  /** Below its picture the film comes to the same place, once the moment stays. */
  private restAt(film: FilmShape, video: HTMLVideoElement): void {
    if (this.us === this.restedUs) return;
    this.restedUs = this.us;
    clearTimeout(this.rest);
    this.rest = setTimeout(() => {
      if (film.id !== this.film?.id || this.playing || document.hidden) return;
      this.openVideo(film);
      this.seekStill(film, video);
    }, REST_MS);
  }

  private seekStill(film: FilmShape, video: HTMLVideoElement): void {
    // One after the other: while fingers move the cursor, what comes in between is left out.
    if (video.seeking || video.readyState < HTMLMediaElement.HAVE_METADATA) return;
    const place = this.positionInFile(film);
    if (Math.abs(video.currentTime - place) > SAME_S && !this.showsPictureAt(place)) video.currentTime = place;
  }

  /** What is seen is the picture of a place (s), and clearly within it: browsers round. */
  private showsPictureAt(placeS: number): boolean {
    const { times, video } = this;
    if (times === null) return false;
    const wanted = pictureAt(times, placeS * 1e6);
    const us = video.currentTime * 1e6;
    return us >= (times[wanted] ?? Infinity) + 1e6 * INTO_S && us < (times[wanted + 1] ?? Infinity) - 1e6 * INTO_S;
  }

  private readonly onMediaReady = (): void => {
    const { film, video } = this;
    // Standing still, the picture is that of the place: what is told of frames may come too late.
    if (film !== null && !this.isStill && video.paused && !video.seeking) this.holdsTime(film, video.currentTime);
    if (film !== null) this.loadTimes(film);
    this.followMoment();
    this.dispatchEvent(new CustomEvent("t-ready"));
  };

  private readonly onMediaError = (): void => {
    const { error } = this.video;
    if (this.film === null || error === null) return;
    // Of what nobody sees yet nothing is said: its picture is here.
    if (this.isStill && !this.playing) {
      this.dropVideo();
      return;
    }
    this.broken = error.code === MediaError.MEDIA_ERR_SRC_NOT_SUPPORTED || error.code === MediaError.MEDIA_ERR_DECODE
      ? msg("This browser cannot play it, or the hub does not give it any more.")
      : msg("The hub does not answer.");
  };

  private readonly retry = (): void => {
    const { film } = this;
    this.withoutStills = "";
    this.loadFilm(null);
    this.loadFilm(film);
    this.requestUpdate();
  };
}

declare global {
  interface HTMLElementTagNameMap {
    "t-film-view": FilmView;
  }
  interface HTMLElementEventMap {
    "t-moment": CustomEvent<number>;
  }
}
