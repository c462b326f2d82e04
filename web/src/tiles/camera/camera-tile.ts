/**
 * One stream of a site: media socket to canvas, with the picture's age and what is seen on it.
 *
 * Long, because a picture's whole way through the page is read together.
 */

import { consume } from "@lit/context";
import { msg, str } from "@lit/localize";
import { css, html, LitElement, nothing, type PropertyValues, type TemplateResult } from "lit";
import { customElement, property, query, state } from "lit/decorators.js";
import { ConnectionStateController } from "../../controllers/connection-state.js";
import "../../elements/camera/camera-view.js";
import type { CameraLink, CameraView } from "../../elements/camera/camera-view.js";
import type { CameraPicture } from "../../generated/wire.js";
import { socketsContext } from "../../state/contexts.js";
import { MediaSocket, mediaPath, socketUrl } from "../../wire/media-socket.js";
import { ContrastCheck } from "./contrast-check.js";
import "./blur-button.js";
import "./film-button.js";
import { H264Player, supportsH264 } from "./h264-player.js";
import { BoxSync, type CurrentBoxes } from "./box-sync.js";
import { JpegPlayer } from "../../elements/camera/jpeg-player.js";
import { decodePicture } from "../../elements/camera/jpeg-stream.js";
import { CameraMarks } from "./camera-marks.js";
import { ModelOverlays } from "./model-overlays.js";
import { ObjectDetection } from "./object-detection.js";
import type { DetectShape, LaneShape, PictureModelShape } from "../../generated/api.js";

const MIME: Readonly<Record<string, string>> = { jpeg: "image/jpeg", png: "image/png", webp: "image/webp" };
/** The age on the picture changes this often. */
const AGE_EVERY_MS = 100;
const RATE_WINDOW_MS = 2000;
/** A film that breaks so often is not tried again: single pictures from then on. */
const MOST_BREAKS = 3;

type DecodedPicture = ImageBitmap | VideoFrame;

/** Asked once for all cameras of the page. */
let films: Promise<boolean> | undefined;
let breaks = 0;

/**
 * @slot over - lies over the picture, where that is `editing`
 * @slot hud - lies over the picture, above its lower edge
 * @fires t-picture after each picture: detail is when it was taken, on this page's clock, or null
 */
@customElement("t-camera")
export class CameraTile extends LitElement {
  static override styles = css`
    :host {
      display: block;
    }
    :host([hidden]) {
      display: none;
    }
    /* As large as its place: what is left beside the picture is black. */
    :host([filling]) {
      display: grid;
      grid-template-rows: minmax(0, 1fr) auto;
      block-size: 100%;
      min-block-size: 0;
    }
    :host([filling]) t-camera-view {
      aspect-ratio: auto;
    }
    t-objects-choice {
      margin-block-start: var(--t-space-2);
    }
    :host(:fullscreen) {
      background: #000;
    }
    :host(:fullscreen) t-objects-choice {
      position: absolute;
      inset: 4rem auto auto var(--t-space-2);
      max-inline-size: 22rem;
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
  /** It fills its place; without that it is as high as a picture of 4 by 3. */
  @property({ type: Boolean, reflect: true }) filling = false;
  /** The page makes itself full, and not the picture alone. */
  @property({ type: Boolean }) paged = false;
  /** What is looked for on its pictures; null where nothing is. */
  @property({ attribute: false }) detect: DetectShape | null | undefined = null;
  @property({ attribute: false }) lane: LaneShape | null | undefined = null;
  /** What else looks at its pictures. */
  @property({ attribute: false }) models: readonly PictureModelShape[] | undefined = [];
  /** It shows single exposures (see `showsExposures`): none is live, and one without contrast is a picture, too. */
  @property({ type: Boolean }) still = false;
  /** Faces on its pictures are blurred for those who may not see them. */
  @property({ type: Boolean }) blurred = false;
  /** This person may see them. */
  @property({ type: Boolean }) unblurrable = false;
  /** This person drives by this picture: it is never held back for what is seen on it. */
  @property({ type: Boolean }) driving = false;

  /** Something is drawn over the picture, in the slot `over`. */
  @property({ type: Boolean }) editing = false;

  /** Asked for anew with each page: nobody is shown more than they want by habit. */
  @state() private unblurred = false;
  @state() private media: CameraLink = "connecting";
  @state() private why = "";
  @state() private takenAt: number | null = null;
  @state() private drawn = false;
  @state() private seen: CurrentBoxes | null = null;
  @query("t-camera-view") private readonly view!: CameraView;

  @consume({ context: socketsContext }) private readonly sockets: ((url: string) => WebSocket) | undefined;

  private readonly link = new ConnectionStateController(this);
  private socket: MediaSocket | null = null;
  private newest: JpegPlayer | null = null;
  private readonly contrast = new ContrastCheck();
  private film: H264Player | null = null;
  private forms: readonly string[] | null = null;
  private last: CameraPicture | null = null;
  private inSight = true;
  private readonly sight = new IntersectionObserver((entries) => {
    this.inSight = entries.at(-1)?.isIntersecting ?? true;
    this.reportVisibility();
  });
  private readonly objects = new ObjectDetection(this, browserStorage());
  private readonly marked = new CameraMarks(this, browserStorage());
  private readonly modelled = new ModelOverlays(this, browserStorage());
  private readonly inStep = new BoxSync<DecodedPicture, CameraPicture>();
  private dueTimer: ReturnType<typeof setTimeout> | undefined;
  private arrivals: number[] = [];
  private timer: ReturnType<typeof setInterval> | undefined;
  private opened = "";

  override connectedCallback(): void {
    super.connectedCallback();
    this.timer = setInterval(() => {
      this.seen = this.inStep.currentBoxes(performance.now());
      this.requestUpdate();
    }, AGE_EVERY_MS);
    this.sight.observe(this);
    document.addEventListener("visibilitychange", this.reportVisibility);
    document.addEventListener("fullscreenchange", this.onFullScreenChange);
    films ??= supportsH264();
    void films.then((able) => {
      this.forms = able && breaks < MOST_BREAKS ? ["h264", "jpeg"] : ["jpeg"];
      this.requestUpdate();
    });
  }

  override disconnectedCallback(): void {
    super.disconnectedCallback();
    clearInterval(this.timer);
    this.sight.disconnect();
    document.removeEventListener("visibilitychange", this.reportVisibility);
    document.removeEventListener("fullscreenchange", this.onFullScreenChange);
    this.closeSocket();
    this.opened = "";
  }

  override willUpdate(changed: PropertyValues<this>): void {
    // Of another camera nothing has been asked.
    if (changed.has("stream") || changed.has("site")) this.unblurred = false;
    this.marked.setSubject(this.site, this.detect ?? null, this.lane ?? null, this.models ?? []);
    this.modelled.setSubject(this.site, this.stream, this.models ?? []);
    this.objects.setSubject({ site: this.site, stream: this.stream, detects: this.detect ?? null });
  }

  override updated(): void {
    this.inStep.setPrompt(this.driving);
    if (this.driving) this.drawDue();
    this.requestBoxes();
    // A camera of a site that is away is not asked for over and over.
    const { forms } = this;
    const wanted = this.stream !== "" && this.online && forms !== null ? mediaPath(this.site, this.stream, forms, this.unblurred && this.blurred && this.unblurrable) : "";
    if (wanted === this.opened) return;
    this.opened = wanted;
    this.closeSocket();
    if (wanted !== "") this.openSocket(wanted);
  }

  override render(): TemplateResult {
    const now = performance.now();
    const { connection } = this.link;
    const things = this.objects.isWanted ? (this.seen?.things ?? []) : [];
    const heard = this.inStep.lastBoxesAt;
    const lost = connection !== undefined && connection.state !== "open";
    return html`<t-camera-view
      .link=${this.linkNow()}
      .why=${this.why || (lost ? msg("The connection to the hub is lost.") : "")}
      .name=${this.name}
      .age=${this.takenAt === null ? Number.NaN : now - this.takenAt}
      .rate=${this.frameRate(now)}
      .drawn=${this.drawn}
      .time=${this.last?.time_us ?? 0}
      .small=${this.last?.small ?? false}
      .full=${this.full}
      ?still=${this.still}
      .marks=${this.marked.marks}
      .overlays=${this.modelled.overlaysOn(this.last, now, this.driving)}
      .things=${this.objects.framedThings(things)}
      ?earlier=${this.seen?.standing === "earlier"}
      ?editing=${this.editing}
      @t-fullscreen=${this.onFullScreenRequest}
        ><slot name="over" slot="over"></slot><slot name="hud" slot="hud"></slot>${this.objects.renderOverlay(things, heard === null ? null : now - heard, this.driving)}${this.modelled.renderStrip(now)}${this.marked.renderButton()}${this.blurred && this.stream !== ""
            ? html`<t-blur-button slot="tool" ?may=${this.unblurrable && this.online} ?unblurred=${this.unblurred} @t-unblur=${this.onUnblur}></t-blur-button>`
            : nothing}${this.online ? html`<t-film-button slot="tool" site=${this.site} stream=${this.stream}></t-film-button>` : nothing}</t-camera-view
      >${this.objects.renderBelow(this.driving)}`;
  }

  private readonly onUnblur = (event: CustomEvent<boolean>): void => {
    this.unblurred = event.detail;
  };

  private linkNow(): CameraLink {
    if (this.stream === "") return "none";
    return this.online ? this.media : "offline";
  }

  private frameRate(now: number): number {
    const recent = this.arrivals.filter((at) => now - at < RATE_WINDOW_MS).length;
    return (recent * 1000) / RATE_WINDOW_MS;
  }

  private openSocket(path: string): void {
    this.media = "connecting";
    this.why = "";
    this.drawn = false;
    this.takenAt = null;
    const newest = new JpegPlayer({
      decode: (shot) => this.decodeJpeg(shot),
      draw: (bitmap, shot) => {
        this.onDecoded(bitmap, shot);
      },
      failed: (shot) => {
        if (shot.format in MIME) return;
        this.media = "unsupported";
        this.why = msg(str`It comes as ${shot.format}; this page can show ${Object.keys(MIME).join(", ")}.`);
      },
    });
    this.newest = newest;
    const film = new H264Player({
      draw: (frame, shot) => {
        this.onDecoded(frame, shot);
      },
      broken: () => {
        breaks += 1;
        if (breaks === MOST_BREAKS) this.forms = ["jpeg"];
        this.socket?.restart();
        this.requestUpdate();
      },
    });
    this.film = film;
    this.socket = new MediaSocket(
      { url: socketUrl(path, location), ...(this.sockets === undefined ? {} : { openSocket: this.sockets }) },
      {
        onShot: (shot, shown) => {
          if (shot.format === "h264") film.receivePicture(shot, shown);
          else newest.receivePicture(shot, shown);
        },
        onBoxes: (boxes) => {
          const now = performance.now();
          this.objects.receiveBoxes(boxes);
          this.inStep.addBoxes(boxes, now);
          this.seen = this.inStep.currentBoxes(now);
        },
        onOverlay: (overlay) => {
          this.modelled.receiveOverlay(overlay, performance.now());
        },
        onTrouble: (why) => {
          this.media = "bad";
          this.why = why;
        },
        onState: (state, why) => {
          this.media = state === "open" || state === "refused" ? state : "connecting";
          this.why = state === "lost" ? msg("The picture's connection is lost; trying again.") : why;
        },
      },
    );
    this.reportVisibility();
  }

  /** A camera that nobody has in sight makes do with a picture now and then. */
  private readonly reportVisibility = (): void => {
    this.socket?.setLowRate(document.hidden || !this.inSight);
    this.requestBoxes();
  };

  /** Boxes are asked for while somebody sees them. */
  private requestBoxes(): void {
    const on = this.objects.isWanted && !document.hidden && this.inSight;
    this.socket?.requestBoxes(on);
    if (!on) this.inStep.clearBoxes();
    const drawn = this.modelled.isWanted && !document.hidden && this.inSight;
    this.socket?.requestOverlays(drawn);
    if (!drawn) this.modelled.clearOverlays();
  }

  private readonly onFullScreenRequest = (event: Event): void => {
    if (this.paged) return;
    event.stopPropagation();
    if (document.fullscreenElement === null) void this.requestFullscreen().catch(() => undefined);
    else void document.exitFullscreen();
  };

  private readonly onFullScreenChange = (): void => {
    // `document.fullscreenElement` is the outermost host, and not this.
    if (!this.paged) this.full = this.matches(":fullscreen");
  };

  private decodeJpeg(shot: CameraPicture): Promise<ImageBitmap> {
    const type = MIME[shot.format];
    if (type === undefined) return Promise.reject(new TypeError(shot.format));
    return decodePicture(shot.data, type);
  }

  /** Decoded, and so paid for: that it may wait for its boxes is nothing the hub could help with. */
  private onDecoded(picture: DecodedPicture, shot: CameraPicture): void {
    const age = this.ageMsOf(shot);
    this.inStep.addPicture(picture, shot, age, performance.now());
    this.drawDue();
  }

  /** Age (ms) of a picture by the clock of the hub that sent it; NaN while that is not known. */
  private ageMsOf(shot: CameraPicture): number {
    return this.socket?.ageMsOf(shot.hub_us, (hubUs) => this.link.connection?.ageMsOf(hubUs) ?? Number.NaN) ?? Number.NaN;
  }

  /** Draws what is due, and comes back for the next. */
  private readonly drawDue = (): void => {
    clearTimeout(this.dueTimer);
    const due = this.inStep.takeDuePicture(performance.now());
    if (due !== null) this.drawPicture(due.picture, due.shot);
    const { dueAt } = this.inStep;
    if (dueAt !== null) this.dueTimer = setTimeout(this.drawDue, Math.max(0, dueAt - performance.now()));
  };

  private drawPicture(picture: DecodedPicture, shot: CameraPicture): void {
    const now = performance.now();
    if (!this.still && !this.contrast.showsPicture(picture, now)) {
      // The last good one stays and grows old: it turns grey, and the vehicle slows down.
      picture.close();
      this.media = "bad";
      this.why = msg("The picture shows nothing: no contrast at all. Is the lens covered, or the line too narrow?");
      return;
    }
    this.view.drawPicture(picture);
    this.seen = this.inStep.currentBoxes(now);
    if (this.media === "bad") {
      this.media = "open";
      this.why = "";
    }
    this.last = shot;
    // For tests and measurements; see `bench/`.
    (globalThis as { __talaiaPictured?: (timeUs: number, format: string) => void }).__talaiaPictured?.(shot.time_us, shot.format);
    const age = this.ageMsOf(shot);
    this.takenAt = Number.isFinite(age) ? now - Math.max(0, age) : null;
    this.drawn = true;
    this.arrivals = [...this.arrivals.slice(-120), now];
    this.dispatchEvent(new CustomEvent("t-picture", { detail: this.takenAt }));
  }

  private closeSocket(): void {
    this.socket?.close();
    this.newest?.close();
    this.film?.close();
    this.film = null;
    clearTimeout(this.dueTimer);
    this.inStep.close();
    this.modelled.clearOverlays();
    this.seen = null;
    this.last = null;
    this.socket = null;
    this.newest = null;
    this.dispatchEvent(new CustomEvent("t-picture", { detail: null }));
  }
}

/** A browser that forbids storage throws at the mere mention of it. */
function browserStorage(): Storage | null {
  try {
    return window.localStorage;
  } catch {
    return null;
  }
}

declare global {
  interface HTMLElementTagNameMap {
    "t-camera": CameraTile;
  }
  interface GlobalEventHandlersEventMap {
    "t-picture": CustomEvent<number | null>;
  }
}
