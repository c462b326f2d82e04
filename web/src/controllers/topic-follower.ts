/** Follows a raw topic for an element: its newest message, how it comes, and what is the matter with it. */

import { ContextConsumer } from "@lit/context";
import { msg } from "@lit/localize";
import type { ReactiveController, ReactiveControllerHost } from "lit";
import type { TopicMessage, TopicUpdate } from "../generated/wire.js";
import { TopicFlow } from "../series/topic-flow.js";
import { socketsContext } from "../state/contexts.js";
import type { PastBoard } from "../state/past/past-board.js";
import type { PastTopicState } from "../state/past/past-topics.js";
import { PageRest } from "../topics/page-rest.js";
import { pastProblem } from "../topics/past-bytes.js";
import { sharedTopicsOver, type HeardMessage } from "../topics/shared-topics.js";
import type { TopicLink } from "../topics/topic-socket.js";

/**
 * - `loading`: nothing is known yet
 * - `waiting`: it is there, and no message has come
 * - `ended`: nobody publishes it any more
 * - `away`: the robot's gateway is not connected; `lost`: this page is not
 * - `error`: its messages cannot be had or read
 * - `unrecorded`: no recording holds it at the past moment that is shown
 */
export type TopicState = "loading" | "waiting" | "live" | "stale" | "ended" | "away" | "lost" | "error" | "forbidden" | "unrecorded";

export class TopicFollower implements ReactiveController {
  update: TopicUpdate | null = null;
  /** Newest message, and what it says. */
  message: TopicMessage | null = null;
  tree: unknown;
  /** Why messages are missing, or the topic is refused. */
  why = "";
  flow = new TopicFlow();
  private link: TopicLink = "connecting";
  private asked: { readonly site: string; readonly topic: string; readonly rate: number; readonly past: PastBoard | null } | null = null;
  private recorded: PastTopicState | null = null;
  private stopFollowing: (() => void) | null = null;
  private readonly rest = new PageRest({
    onRest: () => {
      this.stop();
    },
    onSeen: () => {
      this.open();
    },
  });
  private readonly sockets: ContextConsumer<typeof socketsContext, ReactiveControllerHost & HTMLElement>;

  /**
   * @param onMessage is called with what each message says, and when it came (by `nowMs`)
   * @param onReset is called before messages of another past moment
   */
  constructor(
    private readonly host: ReactiveControllerHost & HTMLElement,
    private readonly onMessage: (tree: unknown, nowMs: number) => void = () => undefined,
    private readonly onReset: () => void = () => undefined,
  ) {
    // Known before anything is followed.
    this.sockets = new ContextConsumer(host, { context: socketsContext });
    host.addController(this);
  }

  /** What time it is (ms): now, or at the past moment that is shown. */
  nowMs(): number {
    return this.asked?.past?.nowMs() ?? performance.now();
  }

  /**
   * Follows a topic; the same again changes nothing. Call it from `willUpdate`; empty follows none.
   *
   * @param past what recordings hold of it at the moment that this shows, in the place of what comes
   */
  follow(site: string, topic: string, rate: number, past: PastBoard | null = null): void {
    const { asked } = this;
    if (asked !== null && asked.site === site && asked.topic === topic && asked.rate === rate && asked.past === past) return;
    this.stop();
    this.update = null;
    this.message = null;
    this.tree = undefined;
    this.flow = new TopicFlow();
    this.recorded = null;
    this.asked = site === "" || topic === "" ? null : { site, topic, rate, past };
    this.open();
  }

  /** How it stands. `online`: whether the site's gateway is connected. */
  stateAt(nowMs: number, online: boolean): TopicState {
    if (this.asked !== null && this.asked.past !== null) return this.pastState(nowMs);
    if (this.link === "refused") return "forbidden";
    if (this.link === "lost") return "lost";
    if (!online) return "away";
    if (this.update === null) return this.message === null ? "loading" : "lost";
    if (this.why !== "" || this.update.problem !== "") return "error";
    if (!this.update.listed) return this.message === null ? "waiting" : "ended";
    if (this.message === null) return "waiting";
    return !this.update.latched && this.flow.isStale(nowMs) ? "stale" : "live";
  }

  private pastState(nowMs: number): TopicState {
    const { recorded } = this;
    if (recorded === null || recorded.kind === "loading") return this.message === null ? "loading" : "live";
    if (recorded.kind === "none") return "unrecorded";
    if (this.why !== "") return "error";
    if (recorded.kind === "waiting" || this.message === null) return "waiting";
    return !recorded.latched && this.flow.isStale(nowMs) ? "stale" : "live";
  }

  /** What is said of an error: of its messages, or of the topic. */
  get problem(): string {
    return this.why === "" ? (this.update?.problem ?? "") : this.why;
  }

  hostConnected(): void {
    this.rest.watch();
    this.open();
  }

  hostDisconnected(): void {
    this.rest.close();
    this.stop();
  }

  private open(): void {
    if (this.asked === null || this.stopFollowing !== null || document.hidden) return;
    const { site, topic, rate, past } = this.asked;
    this.why = "";
    if (past !== null) {
      this.stopFollowing = this.openPast(past, topic, rate);
      return;
    }
    this.stopFollowing = sharedTopicsOver(this.sockets.value).follow(site, topic, rate, {
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
    this.stopFollowing?.();
    this.stopFollowing = null;
  }

  /** Recorded messages, as the moment comes to them. */
  private openPast(past: PastBoard, topic: string, rate: number): () => void {
    let number = 0;
    return past.topics.follow("trees", topic, rate, {
      onReset: () => {
        this.message = null;
        this.tree = undefined;
        this.flow = new TopicFlow();
        this.onReset();
        this.host.requestUpdate();
      },
      onMessage: ({ timeUs, publishUs, size, tree }) => {
        if (tree === "") {
          this.why = msg("A message of it is none of its type.");
          return;
        }
        number += 1;
        const message: TopicMessage = { t: "topic_message", number, seq: number, time_us: timeUs, publish_us: publishUs, age_ms: 0, size, tree };
        this.receiveMessage({ message, tree: JSON.parse(tree), nowMs: timeUs / 1000 });
      },
      onState: (state) => {
        this.recorded = state;
        this.why = state.kind === "none" ? "" : pastProblem(state);
        this.host.requestUpdate();
      },
    });
  }

  private receiveMessage({ message, tree, nowMs }: HeardMessage): void {
    this.message = message;
    this.why = "";
    this.flow.count({ seq: message.seq, timeUs: message.time_us, ageMs: message.age_ms }, nowMs);
    this.tree = tree;
    this.onMessage(tree, nowMs);
    this.host.requestUpdate();
  }
}
