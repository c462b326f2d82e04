/** One camera's pictures over a socket of their own, so that they never stand before a command. */

import type { MediaToBrowser, CameraPicture, CameraPictureBoxes, CameraPictureOverlay } from "../generated/wire.js";
import { backoffMs, comeback } from "./backoff.js";
import { decodeMedia, encodeMessage, FrameError } from "./codec.js";
import { HubClock } from "./hub-clock.js";

export type MediaState = "connecting" | "open" | "lost" | "refused";

export interface MediaListener {
  /** Draw it, then call `shown` (also when it could not be drawn): the next one waits for that. */
  readonly onShot: (shot: CameraPicture, shown: () => void) => void;
  /** What is seen on a picture; only after `boxes(true)`. */
  readonly onBoxes?: (boxes: CameraPictureBoxes) => void;
  /** What a model tells of a picture; only after `requestOverlays(true)`. */
  readonly onOverlay?: (overlay: CameraPictureOverlay) => void;
  /** The camera gives pictures that cannot be shown; the next `onShot` ends that. */
  readonly onTrouble: (why: string) => void;
  /** `why` is the hub's sentence when it said one. */
  readonly onState: (state: MediaState, why: string) => void;
}

export interface MediaOptions {
  readonly url: string;
  readonly openSocket?: (url: string) => WebSocket;
  /** This page's monotonic clock (ms). */
  readonly now?: () => number;
  readonly random?: () => number;
}

/** The first pings follow each other so soon; later ones only follow the clocks' drift. */
const SOON_MS = 1000;
const LATER_MS = 5000;
const SOON_PINGS = 4;
/** A hub that has not answered a ping by then is of a version that does not. */
const SILENT_MS = 10_000;

/** Opens at once; `close()` ends it for good. Comes back by itself after a loss, and once somebody has signed in anew. */
export class MediaSocket {
  private socket: WebSocket | null = null;
  private timer: ReturnType<typeof setTimeout> | undefined;
  private attempt = 0;
  private readonly stopWaiting: () => void;
  private still = false;
  private boxed = false;
  private overlaid = false;
  /** Of the hub that sends these pictures: of several, another one may answer on the page's own socket. */
  private readonly clock = new HubClock();
  private readonly now: () => number;
  private pingTimer: ReturnType<typeof setTimeout> | undefined;
  private pings = 0;
  private openedAt = 0;

  constructor(
    private readonly options: MediaOptions,
    private readonly listener: MediaListener,
  ) {
    this.now = options.now ?? (() => performance.now());
    this.stopWaiting = comeback.subscribe(() => {
      this.resume();
    });
    this.openSocket();
  }

  close(): void {
    this.stopWaiting();
    clearTimeout(this.timer);
    this.closeSocket();
  }

  /**
   * Age (ms) of a picture by its `hub_us`; NaN before the hub has told its clock. `otherwise` is asked where it never does.
   */
  ageMsOf(hubUs: number, otherwise: (hubUs: number) => number): number {
    const now = this.now();
    const age = this.clock.ageMs(hubUs, now);
    if (!Number.isNaN(age) || now - this.openedAt < SILENT_MS) return age;
    return otherwise(hubUs);
  }

  /** Tells the hub whether a picture a second will do, since nobody looks closely. */
  setLowRate(still: boolean): void {
    if (this.still === still) return;
    this.still = still;
    if (this.socket?.readyState === 1) this.socket.send(encodeMessage({ t: "glance", still }));
  }

  /** Tells the hub whether to say what is seen on the pictures. */
  requestBoxes(on: boolean): void {
    if (this.boxed === on) return;
    this.boxed = on;
    this.sendRequest(this.socket);
  }

  /** Tells the hub whether to say what models tell of the pictures. */
  requestOverlays(on: boolean): void {
    if (this.overlaid === on) return;
    this.overlaid = on;
    this.sendRequest(this.socket);
  }

  private sendRequest(socket: WebSocket | null): void {
    if (socket?.readyState !== 1) return;
    const on = this.boxed;
    socket.send(encodeMessage(this.overlaid ? { t: "boxes_ask", on, overlays: true } : { t: "boxes_ask", on }));
  }

  /** Begins anew, as after a loss: what came cannot be gone on with. */
  restart(): void {
    this.scheduleRetry("");
  }

  private openSocket(): void {
    this.listener.onState("connecting", "");
    const socket = (this.options.openSocket ?? ((url) => new WebSocket(url)))(this.options.url);
    socket.binaryType = "arraybuffer";
    this.socket = socket;
    socket.onopen = () => {
      this.attempt = 0;
      if (this.still) socket.send(encodeMessage({ t: "glance", still: true }));
      if (this.boxed || this.overlaid) this.sendRequest(socket);
      this.clock.reset();
      this.pings = 0;
      this.openedAt = this.now();
      this.ping(socket);
      this.listener.onState("open", "");
    };
    socket.onmessage = (event: MessageEvent<unknown>) => {
      if (event.data instanceof ArrayBuffer) this.receiveMessage(event.data, socket);
    };
    socket.onclose = () => {
      if (this.socket === socket) this.scheduleRetry("");
    };
  }

  private ping(socket: WebSocket): void {
    if (socket.readyState !== 1) return;
    this.pings += 1;
    socket.send(encodeMessage({ t: "ping", n: this.pings, at_ms: this.now() }));
    clearTimeout(this.pingTimer);
    this.pingTimer = setTimeout(
      () => {
        this.ping(socket);
      },
      this.pings < SOON_PINGS ? SOON_MS : LATER_MS,
    );
  }

  private receiveMessage(bytes: ArrayBuffer, socket: WebSocket): void {
    let message: MediaToBrowser | null;
    try {
      message = decodeMedia(bytes);
    } catch (error) {
      if (!(error instanceof FrameError)) throw error;
      this.scheduleRetry("");
      return;
    }
    if (message === null) return;
    switch (message.t) {
      case "shot": {
        const seq = message.seq;
        this.listener.onShot(message, () => {
          if (socket.readyState === 1) socket.send(encodeMessage({ t: "shown", seq }));
        });
        return;
      }
      case "shot_boxes":
        this.listener.onBoxes?.(message);
        return;
      case "shot_overlay":
        this.listener.onOverlay?.(message);
        return;
      case "pong":
        this.clock.recordExchange(message.at_ms, this.now(), message.hub_us);
        return;
      case "problem":
        // A camera that is away may come back; one that is not ours, or not there, will not.
        if (message.code === "picture") this.listener.onTrouble(message.message);
        else if (message.code === "offline" || message.code === "busy") this.scheduleRetry(message.message);
        else this.stopRefused(message.message);
        return;
      case "ended":
        // Until somebody has signed in anew.
        this.closeSocket();
        this.listener.onState("refused", message.reason);
        return;
    }
  }

  private stopRefused(why: string): void {
    this.close();
    this.listener.onState("refused", why);
  }

  private resume(): void {
    if (this.socket !== null) return;
    clearTimeout(this.timer);
    this.openSocket();
  }

  private scheduleRetry(why: string): void {
    this.closeSocket();
    this.listener.onState("lost", why);
    const delay = backoffMs(this.attempt, (this.options.random ?? Math.random)());
    this.attempt += 1;
    this.timer = setTimeout(() => {
      this.openSocket();
    }, delay);
  }

  private closeSocket(): void {
    clearTimeout(this.pingTimer);
    const socket = this.socket;
    this.socket = null;
    if (socket === null) return;
    socket.onmessage = null;
    socket.onclose = null;
    socket.onopen = null;
    socket.close();
  }
}

/** The address of a path on the hub that served this page, as a WebSocket. */
export function socketUrl(path: string, page: { protocol: string; host: string }): string {
  return `${page.protocol === "https:" ? "wss:" : "ws:"}//${page.host}${path}`;
}

/**
 * Path of a camera's socket; `stream` is its address, ``device/stream``, `forms` what we can show.
 * With `unblurred` it gives the pictures of a blurred camera as they are.
 */
export function mediaPath(site: string, stream: string, forms: readonly string[], unblurred = false): string {
  return `/ws/media${unblurred ? "/unblurred" : ""}?${new URLSearchParams({ site, stream, forms: forms.join(",") }).toString()}`;
}
