/** Follows a raw topic for an element: its newest message, how it comes, and what is the matter with it. */

import type { ReactiveController, ReactiveControllerHost } from "lit";
import type { TopicMessage, TopicUpdate } from "../generated/wire.js";
import { TopicFlow } from "../series/topic-flow.js";
import { sharedTopics, type HeardMessage } from "../topics/shared-topics.js";
import type { TopicLink } from "../topics/topic-socket.js";

/**
 * - `loading`: nothing is known yet
 * - `waiting`: it is there, and no message has come
 * - `ended`: nobody publishes it any more
 * - `away`: the robot's gateway is not connected; `lost`: this page is not
 * - `error`: its messages cannot be had or read
 */
export type TopicState = "loading" | "waiting" | "live" | "stale" | "ended" | "away" | "lost" | "error" | "forbidden";

/** A page that is hidden for so long (ms) lets the robot rest. */
const HIDDEN_MS = 5000;

export class TopicFollower implements ReactiveController {
  update: TopicUpdate | null = null;
  /** Newest message, and what it says. */
  message: TopicMessage | null = null;
  tree: unknown;
  /** Why messages are missing, or the topic is refused. */
  why = "";
  flow = new TopicFlow();
  private link: TopicLink = "connecting";
  private asked: { readonly site: string; readonly topic: string; readonly rate: number } | null = null;
  private stopFollowing: (() => void) | null = null;
  private timer: ReturnType<typeof setTimeout> | undefined;

  /** @param onMessage is called with what each message says, and when it came (`performance.now`) */
  constructor(
    private readonly host: ReactiveControllerHost,
    private readonly onMessage: (tree: unknown, nowMs: number) => void = () => undefined,
  ) {
    host.addController(this);
  }

  /** Follows a topic; the same again changes nothing. Call it from `willUpdate`; empty follows none. */
  follow(site: string, topic: string, rate: number): void {
    const { asked } = this;
    if (asked !== null && asked.site === site && asked.topic === topic && asked.rate === rate) return;
    this.stop();
    this.update = null;
    this.message = null;
    this.tree = undefined;
    this.flow = new TopicFlow();
    this.asked = site === "" || topic === "" ? null : { site, topic, rate };
    this.open();
  }

  /** How it stands. `online`: whether the site's gateway is connected. */
  stateAt(nowMs: number, online: boolean): TopicState {
    if (this.link === "refused") return "forbidden";
    if (this.link === "lost") return "lost";
    if (!online) return "away";
    if (this.update === null) return this.message === null ? "loading" : "lost";
    if (this.why !== "" || this.update.problem !== "") return "error";
    if (!this.update.listed) return this.message === null ? "waiting" : "ended";
    if (this.message === null) return "waiting";
    return !this.update.latched && this.flow.isStale(nowMs) ? "stale" : "live";
  }

  /** What is said of an error: of its messages, or of the topic. */
  get problem(): string {
    return this.why === "" ? (this.update?.problem ?? "") : this.why;
  }

  hostConnected(): void {
    document.addEventListener("visibilitychange", this.onVisibility);
    this.open();
  }

  hostDisconnected(): void {
    document.removeEventListener("visibilitychange", this.onVisibility);
    this.stop();
  }

  private open(): void {
    if (this.asked === null || this.stopFollowing !== null || document.hidden) return;
    const { site, topic, rate } = this.asked;
    this.why = "";
    this.stopFollowing = sharedTopics.follow(site, topic, rate, {
      onUpdate: (update) => {
        this.update = update;
        this.host.requestUpdate();
      },
      onMessage: (heard) => {
        this.receiveMessage(heard);
      },
      onTrouble: (why) => {
        this.why = why;
        this.host.requestUpdate();
      },
      onState: (state, why) => {
        this.link = state;
        this.why = why;
        this.host.requestUpdate();
      },
    });
  }

  private stop(): void {
    clearTimeout(this.timer);
    this.timer = undefined;
    this.stopFollowing?.();
    this.stopFollowing = null;
  }

  private receiveMessage({ message, tree, nowMs }: HeardMessage): void {
    this.message = message;
    this.why = "";
    this.flow.count({ seq: message.seq, timeUs: message.time_us, ageMs: message.age_ms }, nowMs);
    this.tree = tree;
    this.onMessage(tree, nowMs);
    this.host.requestUpdate();
  }

  private readonly onVisibility = (): void => {
    clearTimeout(this.timer);
    this.timer = undefined;
    if (document.hidden) {
      this.timer = setTimeout(() => {
        this.stop();
      }, HIDDEN_MS);
    } else this.open();
  };
}
