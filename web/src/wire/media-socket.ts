/** One camera's pictures over a socket of their own, so that they never stand before a command. */

import type { MediaToBrowser, CameraPicture, CameraPictureBoxes, CameraPictureOverlay } from "../generated/wire.js";
import { backoffMs, comeback } from "./backoff.js";
import { decodeMedia, encodeMessage, FrameError } from "./codec.js";

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
  readonly random?: () => number;
}

/** Opens at once; `close()` ends it for good. Comes back by itself after a loss, and once somebody has signed in anew. */
export class MediaSocket {
  private socket: WebSocket | null = null;
  private timer: ReturnType<typeof setTimeout> | undefined;
  private attempt = 0;
  private readonly stopWaiting: () => void;
  private still = false;
  private boxed = false;
  private overlaid = false;

  constructor(
    private readonly options: MediaOptions,
    private readonly listener: MediaListener,
  ) {
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
      this.listener.onState("open", "");
    };
    socket.onmessage = (event: MessageEvent<unknown>) => {
      if (event.data instanceof ArrayBuffer) this.receiveMessage(event.data, socket);
    };
    socket.onclose = () => {
      if (this.socket === socket) this.scheduleRetry("");
    };
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
