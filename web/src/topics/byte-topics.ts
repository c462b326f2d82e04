/** Several raw topics of a robot as bytes, for one element: followed while it is looked at, and no longer. */

import type { TopicBytes, TopicUpdate } from "../generated/wire.js";
import { socketUrl } from "../wire/media-socket.js";
import { PageRest, type PageVisibility } from "./page-rest.js";
import { bytesPath, TopicSocket, type TopicLink, type TopicListener } from "./topic-socket.js";

/** How a topic is followed: messages a second at the most, points of a cloud at the most. */
export interface ByteWish {
  readonly topic: string;
  readonly rate: number;
  readonly points: number;
}

/** How a topic that is followed stands. */
export interface ByteTopicState {
  readonly link: TopicLink;
  readonly update: TopicUpdate | null;
  /** Why nothing comes; empty when nothing is wrong. */
  readonly why: string;
}

export interface ByteListener {
  readonly onBytes: (topic: string, message: TopicBytes) => void;
  readonly onState: () => void;
}

/** What follows one topic: by the path of its socket, or by what is wished of it. */
export type OpenBytes = (path: string, listener: TopicListener, wish: ByteWish) => Pick<TopicSocket, "close">;

/** Topics whose sockets something else opens; undefined: the page's own. */
export function bytesOver(openSocket: ((url: string) => WebSocket) | undefined): OpenBytes | undefined {
  return openSocket === undefined ? undefined : (path, heard) => new TopicSocket({ url: socketUrl(path, location), openSocket }, heard);
}

interface Followed {
  readonly wish: ByteWish;
  socket: Pick<TopicSocket, "close"> | null;
  state: ByteTopicState;
}

const BEFORE: ByteTopicState = { link: "connecting", update: null, why: "" };

export class ByteTopics {
  private readonly followed = new Map<string, Followed>();
  private readonly rest: PageRest;

  constructor(
    private readonly site: string,
    private readonly listener: ByteListener,
    private readonly page: PageVisibility = document,
    private readonly open: OpenBytes = (path, heard) => new TopicSocket({ url: socketUrl(path, location) }, heard),
  ) {
    this.rest = new PageRest(
      {
        onRest: () => {
          for (const followed of this.followed.values()) {
            followed.socket?.close();
            followed.socket = null;
          }
        },
        onSeen: () => {
          for (const followed of this.followed.values()) if (followed.socket === null) this.connect(followed);
        },
      },
      page,
    );
    this.rest.watch();
  }

  /** Follows these and no others; what stays the same goes on. */
  followAll(wishes: readonly ByteWish[]): void {
    const wanted = new Map(wishes.map((wish) => [wish.topic, wish]));
    for (const [topic, { wish, socket }] of this.followed) {
      const next = wanted.get(topic);
      if (next !== undefined && next.rate === wish.rate && next.points === wish.points) continue;
      socket?.close();
      this.followed.delete(topic);
    }
    for (const [topic, wish] of wanted) {
      if (this.followed.has(topic)) continue;
      const made: Followed = { wish, socket: null, state: BEFORE };
      this.followed.set(topic, made);
      if (!this.page.hidden) this.connect(made);
    }
  }

  stateOf(topic: string): ByteTopicState | null {
    return this.followed.get(topic)?.state ?? null;
  }

  close(): void {
    this.rest.close();
    this.followAll([]);
  }

  private connect(followed: Followed): void {
    const { topic } = followed.wish;
    const change = (more: Partial<ByteTopicState>): void => {
      followed.state = { ...followed.state, ...more };
      this.listener.onState();
    };
    const listener: TopicListener = {
      onUpdate: (update) => {
        change({ update, why: update.problem });
      },
      onMessage: () => undefined,
      onBytes: (message) => {
        if (followed.state.why !== "") change({ why: "" });
        this.listener.onBytes(topic, message);
      },
      onTrouble: (why) => {
        change({ why });
      },
      onState: (link, why) => {
        change({ link, why });
      },
    };
    followed.socket = this.open(bytesPath(this.site, topic, followed.wish), listener, followed.wish);
  }
}
