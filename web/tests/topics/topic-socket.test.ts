import { afterEach, beforeEach, expect, test, vi } from "vitest";
import type { TopicMessage, TopicUpdate } from "../../src/generated/wire.js";
import { topicPath, TopicSocket, type TopicLink } from "../../src/topics/topic-socket.js";
import { FakeSocket } from "../wire/fake-socket.js";

const sockets: FakeSocket[] = [];
const states: [TopicLink, string][] = [];
const messages: TopicMessage[] = [];
const updates: TopicUpdate[] = [];
const troubles: string[] = [];

function open(): TopicSocket {
  return new TopicSocket(
    {
      url: "ws://hub/ws/topic",
      openSocket: () => {
        const socket = new FakeSocket();
        sockets.push(socket);
        return socket as unknown as WebSocket;
      },
      random: () => 0,
    },
    {
      onUpdate: (update) => updates.push(update),
      onMessage: (message) => messages.push(message),
      onTrouble: (why) => troubles.push(why),
      onState: (state, why) => states.push([state, why]),
    },
  );
}

beforeEach(() => {
  vi.useFakeTimers();
  for (const list of [sockets, states, messages, updates, troubles]) list.length = 0;
});
afterEach(() => {
  vi.useRealTimers();
});

test("each message is confirmed, so that the hub knows what is under way", () => {
  open();
  sockets[0]?.say({ t: "topic_update", listed: true, type: "std_msgs/msg/String" });
  sockets[0]?.say({ t: "topic_message", number: 7, tree: '{"data":"a"}' });
  expect(sockets[0]?.sent).toEqual([{ t: "topic_shown", number: 7 }]);
  expect(messages[0]?.tree).toBe('{"data":"a"}');
  expect(updates[0]).toMatchObject({ listed: true, latched: false, definition: "" });
});

test("of bytes that come often each fourth is confirmed, and large ones at once: one of these is under way at a time", () => {
  open();
  const sayBytes = (number: number, size: number): void => sockets[0]?.say({ t: "topic_bytes", number, data: new Uint8Array(size) });
  for (let number = 1; number <= 9; number += 1) sayBytes(number, 3000);
  sayBytes(10, 5000);
  expect(sockets[0]?.sent).toEqual([4, 8, 10].map((number) => ({ t: "topic_shown", number })));
});

test("it comes back after a loss, and not after it was closed", () => {
  const socket = open();
  sockets[0]?.onopen?.();
  sockets[0]?.die();
  vi.advanceTimersByTime(125);
  expect(states.map(([state]) => state)).toEqual(["connecting", "open", "lost", "connecting"]);
  socket.close();
  vi.advanceTimersByTime(60_000);
  expect(sockets).toHaveLength(2);
});

test("what cannot be read is told, and the topic goes on", () => {
  open();
  sockets[0]?.say({ t: "problem", code: "unreadable", message: "it ends too early" });
  sockets[0]?.say({ t: "topic_message", number: 1, tree: "{}" });
  expect(troubles).toEqual(["it ends too early"]);
  expect(messages).toHaveLength(1);
});

test("a right that is lost ends it for good, in the hub's words", () => {
  open();
  sockets[0]?.say({ t: "problem", code: "forbidden", message: "you have no right to this topic any more" });
  vi.advanceTimersByTime(60_000);
  expect(states.at(-1)).toEqual(["refused", "you have no right to this topic any more"]);
  expect(sockets).toHaveLength(1);
});

test("site and topic are written into the address", () => {
  expect(topicPath("a&b", "/scan", 4)).toBe("/ws/topic?site=a%26b&topic=%2Fscan&rate=4");
});
