/** One stream of a site: media socket to canvas, with the picture's age. */

import { css, html, LitElement, type TemplateResult } from "lit";
import { customElement, property, query, state } from "lit/decorators.js";
import { LinkController } from "../../controllers/link.js";
import "../../elements/camera/camera-view.js";
import type { CameraLink, CameraView } from "../../elements/camera/camera-view.js";
import type { Shot } from "../../generated/wire.js";
import { MediaSocket, mediaPath, socketUrl } from "../../wire/media.js";
import { Film, playsFilms } from "./film.js";
import { Newest } from "./newest.js";

const MIME: Readonly<Record<string, string>> = { jpeg: "image/jpeg", png: "image/png", webp: "image/webp" };
/** The age on the picture changes this often. */
const AGE_EVERY_MS = 100;
const RATE_WINDOW_MS = 2000;
/** A film that breaks so often is not tried again: single pictures from then on. */
const MOST_BREAKS = 3;

/** Asked once for all cameras of the page. */
let films: Promise<boolean> | undefined;
let breaks = 0;

/**
 * @fires t-picture after each picture: detail is when it was taken, on this page's clock, or null
 */
@customElement("t-camera")
export class Camera extends LitElement {
  static override styles = css`
    :host {
      display: block;
    }
    :host([hidden]) {
      display: none;
    }
    :host(:fullscreen) {
      background: #000;
    }
    :host(:fullscreen) t-camera-view {
      aspect-ratio: auto;
      block-size: 100%;
      border: 0;
    }
  `;

  @property() site = "";
  /** Address of the stream, `device/stream`; empty for none. */
  @property() stream = "";
  @property() name = "";
  @property({ type: Boolean }) online = true;
  @property({ type: Boolean }) full = false;
  /** The page makes itself full, and not the picture alone. */
  @property({ type: Boolean }) paged = false;

  @state() private media: CameraLink = "connecting";
  @state() private why = "";
  @state() private takenAt: number | null = null;
  @state() private drawn = false;
  @query("t-camera-view") private readonly view!: CameraView;

  private readonly link = new LinkController(this);
  private socket: MediaSocket | null = null;
  private newest: Newest | null = null;
  private film: Film | null = null;
  private forms: readonly string[] | null = null;
  private last: Shot | null = null;
  private seen = true;
  private readonly sight = new IntersectionObserver((entries) => {
    this.seen = entries.at(-1)?.isIntersecting ?? true;
    this.glance();
  });
  private arrivals: number[] = [];
  private timer: ReturnType<typeof setInterval> | undefined;
  private opened = "";

  override connectedCallback(): void {
    super.connectedCallback();
    this.timer = setInterval(() => {
      this.requestUpdate();
    }, AGE_EVERY_MS);
    this.sight.observe(this);
    document.addEventListener("visibilitychange", this.glance);
    document.addEventListener("fullscreenchange", this.fullChanged);
    films ??= playsFilms();
    void films.then((able) => {
      this.forms = able && breaks < MOST_BREAKS ? ["h264", "jpeg"] : ["jpeg"];
      this.requestUpdate();
    });
  }

  override disconnectedCallback(): void {
    super.disconnectedCallback();
    clearInterval(this.timer);
    this.sight.disconnect();
    document.removeEventListener("visibilitychange", this.glance);
    document.removeEventListener("fullscreenchange", this.fullChanged);
    this.shut();
    this.opened = "";
  }

  override updated(): void {
    // A camera of a site that is away is not asked for over and over.
    const { forms } = this;
    const wanted = this.stream !== "" && this.online && forms !== null ? mediaPath(this.site, this.stream, forms) : "";
    if (wanted === this.opened) return;
    this.opened = wanted;
    this.shut();
    if (wanted !== "") this.openSocket(wanted);
  }

  override render(): TemplateResult {
    const now = performance.now();
    const { connection } = this.link;
    const lost = connection !== undefined && connection.state !== "open";
    return html`<t-camera-view
      .link=${this.linkNow()}
      .why=${this.why || (lost ? "The connection to the hub is lost." : "")}
      .name=${this.name}
      .age=${this.takenAt === null ? Number.NaN : now - this.takenAt}
      .rate=${this.rate(now)}
      .drawn=${this.drawn}
      .time=${this.last?.time_us ?? 0}
      .small=${this.last?.small ?? false}
      .full=${this.full}
      @t-fullscreen=${this.fullAsked}
    ></t-camera-view>`;
  }

  private linkNow(): CameraLink {
    if (this.stream === "") return "none";
    return this.online ? this.media : "offline";
  }

  private rate(now: number): number {
    const recent = this.arrivals.filter((at) => now - at < RATE_WINDOW_MS).length;
    return (recent * 1000) / RATE_WINDOW_MS;
  }

  private openSocket(path: string): void {
    this.media = "connecting";
    this.why = "";
    this.drawn = false;
    this.takenAt = null;
    const newest = new Newest({
      decode: (shot) => this.decode(shot),
      draw: (bitmap, shot) => {
        this.draw(bitmap, shot);
      },
      failed: (shot) => {
        if (shot.format in MIME) return;
        this.media = "unsupported";
        this.why = `It comes as ${shot.format}; this page can show ${Object.keys(MIME).join(", ")}.`;
      },
    });
    this.newest = newest;
    const film = new Film({
      draw: (frame, shot) => {
        this.draw(frame, shot);
      },
      broken: () => {
        breaks += 1;
        if (breaks === MOST_BREAKS) this.forms = ["jpeg"];
        this.socket?.again();
        this.requestUpdate();
      },
    });
    this.film = film;
    this.socket = new MediaSocket(
      { url: socketUrl(path, location) },
      {
        onShot: (shot, shown) => {
          if (shot.format === "h264") film.take(shot, shown);
          else newest.take(shot, shown);
        },
        onTrouble: (why) => {
          this.media = "bad";
          this.why = why;
        },
        onState: (state, why) => {
          this.media = state === "open" || state === "refused" ? state : "connecting";
          this.why = state === "lost" ? "The picture's connection is lost; trying again." : why;
        },
      },
    );
    this.glance();
  }

  /** A camera that nobody has in sight makes do with a picture now and then. */
  private readonly glance = (): void => {
    this.socket?.glance(document.hidden || !this.seen);
  };

  private readonly fullAsked = (event: Event): void => {
    if (this.paged) return;
    event.stopPropagation();
    if (document.fullscreenElement === null) void this.requestFullscreen().catch(() => undefined);
    else void document.exitFullscreen();
  };

  private readonly fullChanged = (): void => {
    // `document.fullscreenElement` is the outermost host, and not this.
    if (!this.paged) this.full = this.matches(":fullscreen");
  };

  private decode(shot: Shot): Promise<ImageBitmap> {
    const type = MIME[shot.format];
    if (type === undefined) return Promise.reject(new TypeError(shot.format));
    // The bytes are a view on one frame of the socket, which is ours alone.
    return createImageBitmap(new Blob([shot.data as Uint8Array<ArrayBuffer>], { type }));
  }

  private draw(picture: ImageBitmap | VideoFrame, shot: Shot): void {
    const now = performance.now();
    this.view.draw(picture);
    if (this.media === "bad") {
      this.media = "open";
      this.why = "";
    }
    this.last = shot;
    // For tests and measurements; see `bench/`.
    (globalThis as { __talaiaPictured?: (timeUs: number, format: string) => void }).__talaiaPictured?.(shot.time_us, shot.format);
    const age = this.link.connection?.ageOf(shot.hub_us) ?? Number.NaN;
    this.takenAt = Number.isFinite(age) ? now - Math.max(0, age) : null;
    this.drawn = true;
    this.arrivals = [...this.arrivals.slice(-120), now];
    this.dispatchEvent(new CustomEvent("t-picture", { detail: this.takenAt }));
  }

  private shut(): void {
    this.socket?.close();
    this.newest?.close();
    this.film?.close();
    this.film = null;
    this.last = null;
    this.socket = null;
    this.newest = null;
    this.dispatchEvent(new CustomEvent("t-picture", { detail: null }));
  }
}

declare global {
  interface HTMLElementTagNameMap {
    "t-camera": Camera;
  }
  interface GlobalEventHandlersEventMap {
    "t-picture": CustomEvent<number | null>;
  }
}
