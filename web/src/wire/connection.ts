/** The one WebSocket to the hub that carries all but pictures. */

import type { FromBrowser, ToBrowser } from "../generated/wire.js";
import { backoffMs } from "./backoff.js";
import { HubClock } from "./hub-clock.js";
import { decodeMessage, encodeMessage, FrameError, type Sendable } from "./codec.js";
import { Subscriptions, type BatchListener } from "./subscriptions.js";

/**
 * - `idle`: not started, or stopped on purpose
 * - `connecting`: the first attempt is under way
 * - `open`: the hub has greeted us
 * - `lost`: it was open or failed to open; tries go on
 * - `ended`: the hub said that the session is over; it stays so until `start()`
 */
export type LinkState = "idle" | "connecting" | "open" | "lost" | "ended";

type MessageTag = ToBrowser["t"];
type MessageOf<T extends MessageTag> = Extract<ToBrowser, { t: T }>;
type MessageListener<T extends MessageTag> = (message: MessageOf<T>) => void;

export interface ConnectionOptions {
  readonly url: string;
  readonly openSocket?: (url: string) => WebSocket;
  /** This page's monotonic clock (ms). */
  readonly now?: () => number;
  readonly random?: () => number;
  /** Whether a person has touched the page since this was last asked; said with each ping. */
  readonly touched?: () => boolean;
}

const PING_EVERY_MS = 1000;
/** So many pings in a row without an answer, and the socket counts as dead. */
const UNANSWERED = 4;
/** A socket over which the hub has not greeted by then will not come: a network that came back elsewhere leaves such. */
const GREETING_MS = 10_000;
/** Awake again: a socket that lives answers by then. */
const PROBE_MS = 2500;
/** A try that is younger than this is not begun anew. */
const YOUNG_MS = 2000;
/** After the hub could not take a subscription. */
const ASK_AGAIN_MS = 1000;

/**
 * Connects, comes back after a loss with a growing, jittered delay, and asks again for all
 * subscriptions then. Messages are never kept for later: `send` says whether the socket took it.
 */
export class Connection {
  readonly clock = new HubClock();
  private readonly url: string;
  private readonly openSocket: (url: string) => WebSocket;
  private readonly now: () => number;
  private readonly random: () => number;
  private readonly touched: () => boolean;
  private readonly listeners = new Map<MessageTag, Set<(message: never) => void>>();
  private readonly stateListeners = new Set<(state: LinkState) => void>();
  private readonly subscriptions = new Subscriptions();
  private socket: WebSocket | null = null;
  private current: LinkState = "idle";
  private attempt = 0;
  private retryTimer: ReturnType<typeof setTimeout> | undefined;
  private pingTimer: ReturnType<typeof setInterval> | undefined;
  private askTimer: ReturnType<typeof setTimeout> | undefined;
  private greetingTimer: ReturnType<typeof setTimeout> | undefined;
  private probeTimer: ReturnType<typeof setTimeout> | undefined;
  private triedAt = 0;
  private pings = 0;
  private unanswered = 0;
  private reason = "";

  constructor(options: ConnectionOptions) {
    this.url = options.url;
    this.openSocket = options.openSocket ?? ((url) => new WebSocket(url));
    this.now = options.now ?? (() => performance.now());
    this.random = options.random ?? Math.random;
    this.touched = options.touched ?? (() => false);
  }

  get state(): LinkState {
    return this.current;
  }

  /** Why the hub ended the session; empty otherwise. */
  get endedReason(): string {
    return this.reason;
  }

  /** Newest round trip to the hub (ms); NaN while unknown. */
  get roundTripMs(): number {
    return this.clock.roundTripMs;
  }

  /** Age (ms) of a moment on the hub's monotonic clock; NaN while unknown. */
  ageMsOf(hubUs: number): number {
    return this.clock.ageMs(hubUs, this.now());
  }

  start(): void {
    if (this.current !== "idle" && this.current !== "ended") return;
    this.attempt = 0;
    this.reason = "";
    this.setState("connecting");
    this.connect();
  }

  stop(): void {
    clearTimeout(this.retryTimer);
    this.closeSocket();
    this.setState("idle");
  }

  /** Tries at once instead of waiting out the delay: the page was shown, the network came back. */
  retryNow(): void {
    if (this.current !== "lost") return;
    // One that was begun before a sleep may hang for minutes.
    if (this.socket !== null && this.now() - this.triedAt < YOUNG_MS) return;
    clearTimeout(this.retryTimer);
    this.closeSocket();
    this.connect();
  }

  /** The device slept: the socket may be dead without having been closed. It answers soon, or is opened anew. */
  probe(): void {
    if (this.current !== "open") {
      this.retryNow();
      return;
    }
    // What was measured before is of a clock that may have stood still.
    this.clock.reset();
    this.ping();
    clearTimeout(this.probeTimer);
    this.probeTimer = setTimeout(() => {
      this.onLinkLost();
      this.retryNow();
    }, PROBE_MS);
  }

  /** Calls `listener` with each message of a kind. Returns the way to end it. */
  onMessage<T extends MessageTag>(tag: T, listener: MessageListener<T>): () => void {
    const set = this.listeners.get(tag) ?? new Set();
    this.listeners.set(tag, set);
    set.add(listener);
    return () => set.delete(listener);
  }

  /** Calls `listener` on each change of state. Returns the way to end it. */
  onState(listener: (state: LinkState) => void): () => void {
    this.stateListeners.add(listener);
    return () => this.stateListeners.delete(listener);
  }

  /** Sends now or not at all. False: not connected. */
  send(message: Sendable<FromBrowser>): boolean {
    if (this.current !== "open" || this.socket?.readyState !== 1) return false;
    this.socket.send(encodeMessage(message));
    return true;
  }

  /** Bytes that the socket has not sent yet. */
  get bufferedBytes(): number {
    return this.socket?.bufferedAmount ?? 0;
  }

  /**
   * Asks for channels, now and after each reconnect. Returns the way to end it.
   *
   * @param everyMs 0 sends samples as they come; more conflates
   */
  subscribe(site: string, channels: readonly string[], everyMs: number, listener: BatchListener): () => void {
    const sub = this.subscriptions.add(site, channels, everyMs, listener);
    const message = this.subscriptions.messageFor(sub);
    if (message !== null) this.send(message);
    return () => {
      const bye = this.subscriptions.remove(sub);
      if (bye !== null) this.send(bye);
    };
  }

  private connect(): void {
    const socket = this.openSocket(this.url);
    socket.binaryType = "arraybuffer";
    this.socket = socket;
    this.triedAt = this.now();
    this.greetingTimer = setTimeout(() => {
      this.onLinkLost();
    }, GREETING_MS);
    socket.onmessage = (event: MessageEvent<unknown>) => {
      if (event.data instanceof ArrayBuffer) this.receiveMessage(event.data);
    };
    socket.onclose = () => {
      if (this.socket === socket) this.onLinkLost();
    };
  }

  private receiveMessage(bytes: ArrayBuffer): void {
    let message: ToBrowser | null;
    try {
      message = decodeMessage(bytes);
      if (message?.t === "values") this.subscriptions.deliver(message);
    } catch (error) {
      if (!(error instanceof FrameError)) throw error;
      // A hub that speaks nonsense will do so again; a fresh connection is the best that is left.
      this.onLinkLost();
      return;
    }
    if (message === null) return;
    if (message.t === "greeting") this.onWelcome();
    if (message.t === "subscribed") this.subscriptions.markAccepted(message.sub);
    if (message.t === "problem" && message.about === "subscribe" && message.code === "store") this.retrySubscriptionsLater();
    if (message.t === "pong") {
      clearTimeout(this.probeTimer);
      this.unanswered = 0;
      this.clock.recordExchange(message.at_ms, this.now(), message.hub_us);
    }
    const listeners = this.listeners.get(message.t) ?? [];
    for (const listener of [...listeners]) listener(message as never);
    if (message.t === "ended") {
      this.reason = message.reason;
      this.closeSocket();
      this.setState("ended");
    }
  }

  private onWelcome(): void {
    clearTimeout(this.greetingTimer);
    this.attempt = 0;
    this.unanswered = 0;
    this.clock.reset();
    this.setState("open");
    for (const message of this.subscriptions.restartMessages()) this.send(message);
    clearInterval(this.pingTimer);
    this.pingTimer = setInterval(() => {
      this.ping();
    }, PING_EVERY_MS);
    this.ping();
  }

  /** While the hub's database is away, nothing new can be subscribed to: it is asked for again. */
  private retrySubscriptionsLater(): void {
    clearTimeout(this.askTimer);
    this.askTimer = setTimeout(() => {
      for (const message of this.subscriptions.pendingMessages()) this.send(message);
    }, ASK_AGAIN_MS);
  }

  private ping(): void {
    if (this.unanswered >= UNANSWERED) {
      this.onLinkLost();
      return;
    }
    this.unanswered += 1;
    this.pings += 1;
    this.send({ t: "ping", n: this.pings, at_ms: this.now(), active: this.touched() });
  }

  private onLinkLost(): void {
    this.closeSocket();
    const delay = backoffMs(this.attempt, this.random());
    this.attempt += 1;
    clearTimeout(this.retryTimer);
    this.retryTimer = setTimeout(() => {
      this.connect();
    }, delay);
    this.setState("lost");
  }

  private closeSocket(): void {
    clearInterval(this.pingTimer);
    clearTimeout(this.askTimer);
    clearTimeout(this.greetingTimer);
    clearTimeout(this.probeTimer);
    const socket = this.socket;
    this.socket = null;
    if (socket === null) return;
    socket.onmessage = null;
    socket.onclose = null;
    socket.close();
  }

  private setState(state: LinkState): void {
    if (state === "lost" || state !== this.current) {
      this.current = state;
      for (const listener of [...this.stateListeners]) listener(state);
    }
  }
}
