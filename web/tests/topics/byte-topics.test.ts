import { afterEach, beforeEach, describe, expect, it, vi } from "vitest";
import type { TopicBytes, TopicUpdate } from "../../src/generated/wire.js";
import { ByteTopics, type ByteWish } from "../../src/topics/byte-topics.js";
import type { TopicListener } from "../../src/topics/topic-socket.js";

class FakePage {
  hidden = false;
  private listener: (() => void) | null = null;

  addEventListener(_type: string, listener: () => void): void {
    this.listener = listener;
  }

  removeEventListener(): void {
    this.listener = null;
  }

  show(hidden: boolean): void {
    this.hidden = hidden;
    this.listener?.();
  }
}

const SCAN: ByteWish = { topic: "/scan", rate: 20, points: 0 };
const CLOUD: ByteWish = { topic: "/points", rate: 10, points: 50_000 };

function follow(page: FakePage): { topics: ByteTopics; open: Map<string, TopicListener>; heard: string[] } {
  const open = new Map<string, TopicListener>();
  const heard: string[] = [];
  const topics = new ByteTopics("lab", { onBytes: (topic) => heard.push(topic), onState: () => undefined }, page, (path, listener) => {
    open.set(path, listener);
    return { close: () => open.delete(path) };
  });
  return { topics, open, heard };
}

describe("topics followed as bytes", () => {
  beforeEach(() => {
    vi.useFakeTimers();
  });
  afterEach(() => {
    vi.useRealTimers();
  });

  it("are those that were wished, and what stays the same goes on", () => {
    const { topics, open } = follow(new FakePage());
    topics.followAll([SCAN, CLOUD]);
    const before = new Set(open.values());
    topics.followAll([SCAN, { ...CLOUD, points: 1000 }]);
    expect(open.size).toBe(2);
    expect([...open.values()].filter((listener) => before.has(listener))).toHaveLength(1);
    topics.followAll([SCAN]);
    expect(open.size).toBe(1);
    expect(topics.stateOf("/points")).toBeNull();
    topics.close();
    expect(open.size).toBe(0);
  });

  it("say why nothing comes until something comes", () => {
    const { topics, open, heard } = follow(new FakePage());
    topics.followAll([SCAN]);
    const [listener] = open.values();
    listener?.onState("open", "");
    listener?.onUpdate({ problem: "nobody publishes it" } as TopicUpdate);
    expect(topics.stateOf("/scan")).toMatchObject({ link: "open", why: "nobody publishes it" });
    listener?.onBytes?.({} as TopicBytes);
    expect(topics.stateOf("/scan")?.why).toBe("");
    listener?.onTrouble("a message cannot be read");
    expect(topics.stateOf("/scan")?.why).toBe("a message cannot be read");
    expect(heard).toEqual(["/scan"]);
  });

  it("let the robot rest while the page is hidden for longer than a moment", () => {
    const page = new FakePage();
    const { topics, open } = follow(page);
    topics.followAll([SCAN]);
    page.show(true);
    vi.advanceTimersByTime(4000);
    page.show(false);
    vi.advanceTimersByTime(10_000);
    expect(open.size).toBe(1);
    page.show(true);
    vi.advanceTimersByTime(5000);
    expect(open.size).toBe(0);
    // A wish that comes while nobody looks waits until somebody does.
    topics.followAll([SCAN, CLOUD]);
    expect(open.size).toBe(0);
    page.show(false);
    expect(open.size).toBe(2);
  });
});
