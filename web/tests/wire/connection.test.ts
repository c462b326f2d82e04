import { afterEach, beforeEach, describe, expect, test, vi } from "vitest";
import { Connection, type LinkState } from "../../src/wire/connection.js";
import { FakeSocket } from "./fake-socket.js";

const sockets: FakeSocket[] = [];
const newest = (): FakeSocket => {
  const socket = sockets.at(-1);
  if (socket === undefined) throw new Error("no socket was opened");
  return socket;
};

let touched = false;

function connect(): { connection: Connection; states: LinkState[] } {
  const connection = new Connection({
    url: "ws://hub/ws",
    openSocket: () => {
      const socket = new FakeSocket();
      sockets.push(socket);
      return socket as unknown as WebSocket;
    },
    now: () => Date.now(),
    random: () => 0,
    touched: () => touched,
  });
  const states: LinkState[] = [];
  connection.onState((state) => states.push(state));
  connection.start();
  return { connection, states };
}

const value = (sub: number): object => ({
  t: "values", sub, base_us: 10, channel: new Uint8Array(2), offset: new Uint8Array(4), value: new Uint8Array(8),
});

beforeEach(() => {
  vi.useFakeTimers();
  sockets.length = 0;
});
afterEach(() => {
  vi.useRealTimers();
});

describe("a connection", () => {
  test("is open once the hub has greeted, not before", () => {
    const { connection } = connect();
    expect(connection.state).toBe("connecting");
    expect(connection.send({ t: "ping", n: 1, at_ms: 0 })).toBe(false);
    newest().greet();
    expect(connection.state).toBe("open");
  });

  test("says with each ping whether a person has touched the page", () => {
    touched = true;
    connect();
    newest().greet();
    touched = false;
    vi.advanceTimersByTime(1000);
    const pings = newest().sent.filter((message) => message["t"] === "ping");
    expect(pings.map((ping) => ping["active"])).toEqual([true, false]);
  });

  test("comes back after a loss, with a delay that grows", () => {
    const { states } = connect();
    newest().greet();
    newest().die();
    vi.advanceTimersByTime(124);
    expect(sockets).toHaveLength(1);
    vi.advanceTimersByTime(1);
    expect(sockets).toHaveLength(2);
    newest().die();
    vi.advanceTimersByTime(249);
    expect(sockets).toHaveLength(2);
    vi.advanceTimersByTime(1);
    newest().greet();
    expect(states).toEqual(["connecting", "open", "lost", "lost", "open"]);
  });

  test("finds out after a sleep whether its socket is dead, and opens another", () => {
    const { connection, states } = connect();
    newest().greet();
    connection.probe();
    vi.advanceTimersByTime(2600);
    expect(states).toEqual(["connecting", "open", "lost"]);
    expect(sockets).toHaveLength(2);
    newest().greet();
    expect(connection.state).toBe("open");
  });

  test("goes on after a sleep where the hub still answers", () => {
    const { connection } = connect();
    newest().greet();
    connection.probe();
    newest().say({ t: "pong", n: 1, at_ms: Date.now(), hub_us: 0 });
    vi.advanceTimersByTime(900);
    newest().say({ t: "pong", n: 2, at_ms: Date.now(), hub_us: 0 });
    vi.advanceTimersByTime(2600);
    expect(sockets).toHaveLength(1);
  });

  test("starts again at the shortest delay after it was open", () => {
    connect();
    for (let i = 0; i < 5; i++) {
      newest().die();
      vi.advanceTimersByTime(8000);
    }
    newest().greet();
    newest().die();
    const before = sockets.length;
    vi.advanceTimersByTime(125);
    expect(sockets).toHaveLength(before + 1);
  });

  test("asks again for what the hub could not take, and for nothing else", () => {
    const { connection } = connect();
    newest().greet();
    connection.subscribe("agv", ["base/speed"], 0, () => undefined);
    newest().say({ t: "subscribed", sub: 0, refused: [] });
    connection.subscribe("agv", ["base/turn"], 0, () => undefined);
    const asked = (): unknown[] =>
      newest()
        .sent.filter((message) => message["t"] === "subscribe")
        .map((message) => message["sub"]);
    expect(asked()).toEqual([0, 1]);
    newest().say({ t: "problem", code: "store", message: "the database does not answer", about: "subscribe" });
    vi.advanceTimersByTime(999);
    expect(asked()).toEqual([0, 1]);
    vi.advanceTimersByTime(1);
    expect(asked()).toEqual([0, 1, 1]);
    newest().say({ t: "subscribed", sub: 1, refused: [] });
    newest().say({ t: "problem", code: "forbidden", message: "no", about: "subscribe" });
    vi.advanceTimersByTime(3000);
    expect(asked()).toEqual([0, 1, 1]);
  });

  test("does not wait for a hub that does not greet", () => {
    const { connection } = connect();
    vi.advanceTimersByTime(10_000);
    expect([connection.state, newest().closed]).toEqual(["lost", true]);
  });

  test("begins anew what hangs since before a sleep", () => {
    const { connection } = connect();
    newest().die();
    vi.advanceTimersByTime(125);
    const hung = newest();
    vi.advanceTimersByTime(3000);
    connection.retryNow();
    expect([sockets.length, hung.closed]).toEqual([3, true]);
    newest().greet();
    expect(connection.state).toBe("open");
  });

  test("tries at once when it is told that the network is back", () => {
    const { connection } = connect();
    newest().die();
    connection.retryNow();
    expect(sockets).toHaveLength(2);
    connection.retryNow();
    expect(sockets).toHaveLength(2);
  });

  test("counts as lost after four pings without an answer", () => {
    const { connection } = connect();
    newest().greet();
    vi.advanceTimersByTime(3999);
    expect(connection.state).toBe("open");
    vi.advanceTimersByTime(1);
    expect(connection.state).toBe("lost");
    expect(sockets[0]?.closed).toBe(true);
  });

  test("stays open while pings are answered, and tells ages by them", () => {
    const { connection } = connect();
    const socket = newest();
    socket.greet();
    for (let i = 0; i < 20; i++) {
      const ping = socket.sent.at(-1);
      socket.say({ t: "pong", n: ping?.["n"], at_ms: ping?.["at_ms"], hub_us: 1_000_000 * (i + 50) });
      vi.advanceTimersByTime(1000);
    }
    expect(connection.state).toBe("open");
    expect(connection.roundTripMs).toBe(0);
    expect(connection.ageMsOf(69_000_000)).toBeCloseTo(1000);
  });

  test("ends for good when the hub ends the session, and says why", () => {
    const { connection } = connect();
    newest().greet();
    newest().say({ t: "ended", reason: "an admin removed you" });
    vi.advanceTimersByTime(60_000);
    expect([connection.state, connection.endedReason, sockets.length]).toEqual(["ended", "an admin removed you", 1]);
  });

  test("may be started again after its end", () => {
    const { connection } = connect();
    newest().say({ t: "ended", reason: "log-out" });
    connection.start();
    newest().greet();
    expect(connection.state).toBe("open");
  });

  test("is idle when it is stopped, and opens nothing more", () => {
    const { connection } = connect();
    newest().die();
    connection.stop();
    vi.advanceTimersByTime(60_000);
    expect([connection.state, sockets.length]).toEqual(["idle", 1]);
  });

  test("drops a socket that speaks no MessagePack, and tries another", () => {
    const { connection } = connect();
    newest().greet();
    newest().onmessage?.({ data: new Uint8Array([0xc1]).buffer });
    expect(connection.state).toBe("lost");
    vi.advanceTimersByTime(125);
    expect(sockets).toHaveLength(2);
  });

  test("passes over a message that a newer hub sends", () => {
    const { connection } = connect();
    newest().greet();
    newest().say({ t: "horoscope" });
    expect(connection.state).toBe("open");
  });

  test("hands each kind of message to those who asked for it, until they stop", () => {
    const { connection } = connect();
    const seen: number[] = [];
    const stop = connection.onMessage("tick", (news) => seen.push(news.tick));
    newest().say({ t: "tick", site: "agv", tick: 1 });
    stop();
    newest().say({ t: "tick", site: "agv", tick: 2 });
    expect(seen).toEqual([1]);
  });
});

describe("subscriptions", () => {
  test("are asked for at once on an open connection", () => {
    const { connection } = connect();
    newest().greet();
    connection.subscribe("agv", ["base/speed"], 200, () => undefined);
    expect(newest().sent.at(-1)).toEqual({ t: "subscribe", sub: 0, site: "agv", channels: ["base/speed"], every_ms: 200 });
  });

  test("are asked for again after a reconnect, without the ones that ended", () => {
    const { connection } = connect();
    const stop = connection.subscribe("agv", ["a/b"], 0, () => undefined);
    connection.subscribe("agv", ["c/d"], 0, () => undefined);
    newest().greet();
    stop();
    newest().die();
    vi.advanceTimersByTime(125);
    newest().greet();
    expect(newest().sent.filter((message) => message["t"] === "subscribe").map((message) => message["sub"])).toEqual([1]);
  });

  test("mark the first batch, also the first after a reconnect", () => {
    const { connection } = connect();
    const firsts: boolean[] = [];
    connection.subscribe("agv", ["a/b"], 0, (batch) => firsts.push(batch.first));
    newest().greet();
    newest().say(value(0));
    newest().say(value(0));
    newest().die();
    vi.advanceTimersByTime(125);
    newest().greet();
    newest().say(value(0));
    expect(firsts).toEqual([true, false, true]);
  });

  test("that have ended hear nothing of what is still under way", () => {
    const { connection } = connect();
    newest().greet();
    const seen: unknown[] = [];
    connection.subscribe("agv", ["a/b"], 0, (batch) => seen.push(batch))();
    connection.subscribe("agv", ["c/d"], 0, (batch) => seen.push(batch));
    newest().say(value(0));
    expect(seen).toEqual([]);
    expect(newest().tags()).toEqual(["ping", "subscribe", "unsubscribe", "subscribe"]);
  });
});
