import { beforeEach, expect, test } from "vitest";
import type { TopicMessage, TopicUpdate } from "../../src/generated/wire.js";
import { SharedTopics, type HeardMessage, type TopicFollowing } from "../../src/topics/shared-topics.js";
import type { TopicListener } from "../../src/topics/topic-socket.js";

interface Opened {
  readonly path: string;
  readonly listener: TopicListener;
  closed: boolean;
}

class Follower implements TopicFollowing {
  readonly heard: HeardMessage[] = [];
  readonly states: string[] = [];
  readonly updates: TopicUpdate[] = [];
  readonly onMessage = (heard: HeardMessage): void => void this.heard.push(heard);
  readonly onState = (state: string): void => void this.states.push(state);
  readonly onUpdate = (update: TopicUpdate): void => void this.updates.push(update);
  readonly onTrouble = (): void => undefined;
}

const opened: Opened[] = [];
const shared = new SharedTopics((path, listener) => {
  const one = { path, listener, closed: false };
  opened.push(one);
  listener.onState("connecting", "");
  return { close: () => void (one.closed = true) };
});
const message = (number: number, tree = `{"n":${String(number)}}`): TopicMessage => ({ number, tree }) as TopicMessage;

beforeEach(() => {
  opened.length = 0;
});

test("elements that follow one topic share one socket, which closes with the last of them", () => {
  const [a, b] = [new Follower(), new Follower()];
  const endA = shared.follow("agv", "/diagnostics", 20, a);
  const endB = shared.follow("agv", "/diagnostics", 4, b);
  expect(opened.map(({ path }) => path)).toEqual(["/ws/topic?site=agv&topic=%2Fdiagnostics&rate=20"]);
  opened[0]?.listener.onMessage(message(1));
  expect([a, b].map(({ heard }) => heard[0]?.tree)).toEqual([{ n: 1 }, { n: 1 }]);
  endA();
  opened[0]?.listener.onMessage(message(2));
  expect([a, b].map(({ heard }) => heard.length)).toEqual([1, 2]);
  expect(opened[0]?.closed).toBe(false);
  endB();
  endB();
  expect(opened[0]?.closed).toBe(true);
  shared.follow("agv", "/diagnostics", 4, a)();
  expect(opened).toHaveLength(2);
});

test("whoever comes later is told what is known, as when it came", () => {
  const ends = [shared.follow("agv", "/a", 20, new Follower())];
  opened[0]?.listener.onState("open", "");
  opened[0]?.listener.onUpdate({ listed: true } as TopicUpdate);
  for (let number = 1; number <= 30; number += 1) opened[0]?.listener.onMessage(message(number));
  const early = new Follower();
  ends.push(shared.follow("agv", "/a", 20, early));
  expect(early.states).toEqual(["open"]);
  expect(early.updates).toHaveLength(1);
  expect(early.heard.map((heard) => heard.message.number)).toEqual(Array.from({ length: 20 }, (_, at) => at + 11));
  // Of large ones only the newest is kept.
  opened[0]?.listener.onMessage(message(31, JSON.stringify("x".repeat(300_000))));
  const late = new Follower();
  ends.push(shared.follow("agv", "/a", 20, late));
  expect(late.heard).toEqual(early.heard.slice(-1));
  for (const end of ends) end();
});

test("who wants it oftener than the others has it opened anew for all, and slower never again", () => {
  const [slow, fast] = [new Follower(), new Follower()];
  const endSlow = shared.follow("agv", "/a", 4, slow);
  const endFast = shared.follow("agv", "/a", 20, fast);
  expect(opened.map(({ path, closed }) => [path.slice(-2), closed])).toEqual([["=4", true], ["20", false]]);
  opened[1]?.listener.onMessage(message(1));
  expect(slow.heard).toHaveLength(1);
  endFast();
  expect(opened).toHaveLength(2);
  endSlow();
});

test("topics and sites of the same name are apart, and a refusal is not asked again", () => {
  const ends = [shared.follow("agv", "/a", 4, new Follower()), shared.follow("moon", "/a", 4, new Follower())];
  expect(opened).toHaveLength(2);
  opened[0]?.listener.onState("refused", "no right");
  const late = new Follower();
  ends.push(shared.follow("agv", "/a", 20, late));
  expect(opened).toHaveLength(2);
  expect(late.states).toEqual(["refused"]);
  for (const end of ends) end();
});
