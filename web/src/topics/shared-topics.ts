/** The raw topics that this page follows: one socket for each, however many elements show it. */

import type { TopicMessage, TopicUpdate } from "../generated/wire.js";
import { socketUrl } from "../wire/media-socket.js";
import { topicPath, TopicSocket, type TopicLink, type TopicListener } from "./topic-socket.js";

/** Messages a second, of a topic of which all count: each may be another node's. */
export const ALL_MESSAGES = 20;

/** A message with what it says, read once for all, and when it came (`performance.now`). */
export interface HeardMessage {
  readonly message: TopicMessage;
  readonly tree: unknown;
  readonly nowMs: number;
}

/** What an element is told. */
export interface TopicFollowing extends Omit<TopicListener, "onMessage"> {
  readonly onMessage: (heard: HeardMessage) => void;
}

type OpenSocket = (url: string) => WebSocket;
type OpenTopic = (path: string, listener: TopicListener) => Pick<TopicSocket, "close">;

/** What whoever comes later is told, too: so many of the newest messages, of so many letters together. */
const MOST_KEPT = 20;
const MOST_LETTERS = 256 * 1024;

export class SharedTopics {
  private readonly topics = new Map<string, SharedTopic>();

  constructor(
    private readonly open: OpenTopic = (path, listener) => new TopicSocket({ url: socketUrl(path, location) }, listener),
  ) {}

  /** Follows a topic at `rate` messages a second at the most, or as others of the page do if that is more; gives what ends it. */
  follow(site: string, topic: string, rate: number, following: TopicFollowing): () => void {
    const key = `${site}\n${topic}`;
    let shared = this.topics.get(key);
    if (shared === undefined) {
      shared = new SharedTopic(
        (wanted, listener) => this.open(topicPath(site, topic, wanted), listener),
        () => this.topics.delete(key),
      );
      this.topics.set(key, shared);
    }
    return shared.add(rate, following);
  }
}

class SharedTopic {
  private readonly followings = new Set<TopicFollowing>();
  private socket: Pick<TopicSocket, "close"> | null = null;
  private rate = 0;
  private link: TopicLink = "connecting";
  private why = "";
  private update: TopicUpdate | null = null;
  private kept: HeardMessage[] = [];

  constructor(
    private readonly open: (rate: number, listener: TopicListener) => Pick<TopicSocket, "close">,
    private readonly onEnd: () => void,
  ) {}

  add(rate: number, following: TopicFollowing): () => void {
    const known = this.socket !== null;
    this.followings.add(following);
    if (known) this.tellKnown(following);
    // Never slower again: that would open another socket for nothing but a few messages less.
    if (rate > this.rate && this.link !== "refused") {
      this.rate = rate;
      this.reopen();
    }
    return () => {
      this.followings.delete(following);
      if (this.followings.size > 0 || this.socket === null) return;
      this.socket.close();
      this.socket = null;
      this.onEnd();
    };
  }

  private tellKnown(following: TopicFollowing): void {
    following.onState(this.link, this.why);
    if (this.update !== null) following.onUpdate(this.update);
    for (const heard of this.kept) following.onMessage(heard);
  }

  private reopen(): void {
    this.socket?.close();
    this.socket = this.open(this.rate, {
      onUpdate: (update) => {
        this.update = update;
        for (const following of this.followings) following.onUpdate(update);
      },
      onMessage: (message) => {
        this.hearMessage({ message, tree: JSON.parse(message.tree), nowMs: performance.now() });
      },
      onTrouble: (why) => {
        for (const following of this.followings) following.onTrouble(why);
      },
      onState: (state, why) => {
        this.link = state;
        this.why = why;
        for (const following of this.followings) following.onState(state, why);
      },
    });
  }

  private hearMessage(heard: HeardMessage): void {
    this.kept.push(heard);
    let letters = this.kept.reduce((sum, { message }) => sum + message.tree.length, 0);
    // The newest always stays.
    while (this.kept.length > 1 && (this.kept.length > MOST_KEPT || letters > MOST_LETTERS)) {
      letters -= this.kept.shift()?.message.tree.length ?? 0;
    }
    for (const following of this.followings) following.onMessage(heard);
  }
}

/** Those of this page. */
const ofPage = new SharedTopics();
const ofOthers = new WeakMap<OpenSocket, SharedTopics>();

/** The page's own, or those whose sockets something else opens. */
export function sharedTopicsOver(openSocket: OpenSocket | undefined): SharedTopics {
  if (openSocket === undefined) return ofPage;
  const known = ofOthers.get(openSocket);
  if (known !== undefined) return known;
  const made = new SharedTopics((path, listener) => new TopicSocket({ url: socketUrl(path, location), openSocket }, listener));
  ofOthers.set(openSocket, made);
  return made;
}
