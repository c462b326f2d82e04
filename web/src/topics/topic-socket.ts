/** One raw topic of a robot over a socket of its own; the robot is heard for it while it is open. */

import type { TopicBytes, TopicMessage, TopicToBrowser, TopicUpdate } from "../generated/wire.js";
import { backoffMs, comeback } from "../wire/backoff.js";
import { decodeTopic, encodeMessage, FrameError } from "../wire/codec.js";

export type TopicLink = "connecting" | "open" | "lost" | "refused";

export interface TopicListener {
  readonly onUpdate: (update: TopicUpdate) => void;
  readonly onMessage: (message: TopicMessage) => void;
  /** Of a socket that was asked for bytes. */
  readonly onBytes?: (message: TopicBytes) => void;
  /** Messages are missing, or cannot be read; the next `onMessage` ends that. */
  readonly onTrouble: (why: string) => void;
  /** `why` is the hub's sentence when it said one. */
  readonly onState: (state: TopicLink, why: string) => void;
}

export interface TopicSocketOptions {
  readonly url: string;
  readonly openSocket?: (url: string) => WebSocket;
  readonly random?: () => number;
}

/** Bytes of a message that hardly fills a line. */
const SMALL = 4096;

/** Opens at once; `close()` ends it for good. Comes back by itself after a loss, and once somebody has signed in anew. */
export class TopicSocket {
  private socket: WebSocket | null = null;
  private timer: ReturnType<typeof setTimeout> | undefined;
  private attempt = 0;
  private readonly stopWaiting: () => void;

  constructor(
    private readonly options: TopicSocketOptions,
    private readonly listener: TopicListener,
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

  private openSocket(): void {
    this.listener.onState("connecting", "");
    const socket = (this.options.openSocket ?? ((url) => new WebSocket(url)))(this.options.url);
    socket.binaryType = "arraybuffer";
    this.socket = socket;
    socket.onopen = () => {
      this.attempt = 0;
      this.listener.onState("open", "");
    };
    socket.onmessage = (event: MessageEvent<unknown>) => {
      if (event.data instanceof ArrayBuffer) this.receiveMessage(event.data, socket);
    };
    socket.onclose = () => {
      if (this.socket === socket) this.scheduleRetry();
    };
  }

  private receiveMessage(bytes: ArrayBuffer, socket: WebSocket): void {
    let message: TopicToBrowser | null;
    try {
      message = decodeTopic(bytes);
    } catch (error) {
      if (!(error instanceof FrameError)) throw error;
      this.scheduleRetry();
      return;
    }
    if (message === null) return;
    switch (message.t) {
      case "topic_update":
        this.listener.onUpdate(message);
        return;
      case "topic_message":
        // At once: the hub counts what is under way, not what is looked at.
        if (socket.readyState === 1) socket.send(encodeMessage({ t: "topic_shown", number: message.number }));
        this.listener.onMessage(message);
        return;
      case "topic_bytes":
        // A number stands for all before it: of small ones, of which many come, each fourth is enough. The hub lets 16 be under way.
        if (socket.readyState === 1 && (message.data.length > SMALL || message.number % 4 === 0)) socket.send(encodeMessage({ t: "topic_shown", number: message.number }));
        this.listener.onBytes?.(message);
        return;
      case "problem":
        // What cannot be read now may be read later; what is not ours will not be.
        if (message.code === "forbidden" || message.code === "unknown") this.stopRefused(message.message);
        else this.listener.onTrouble(message.message);
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

  private scheduleRetry(): void {
    this.closeSocket();
    this.listener.onState("lost", "");
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

/** Path of a topic's socket; `rate` is how many messages a second are wanted at the most. */
export function topicPath(site: string, topic: string, rate: number): string {
  return `/ws/topic?${new URLSearchParams({ site, topic, rate: String(rate) }).toString()}`;
}

/** The same for the bytes as the robot serialized them; of a cloud at most `points` of its points. */
export function bytesPath(site: string, topic: string, { rate, points }: { readonly rate: number; readonly points: number }): string {
  return `${topicPath(site, topic, rate)}&as=bytes&points=${String(points)}`;
}
