import { afterEach, beforeEach, describe, expect, test, vi } from "vitest";
import { StopClient } from "../../../src/controllers/drive/stop-client.js";
import type { StopUpdate } from "../../../src/generated/wire.js";
import { FakeLine } from "./fake-connection.js";

const AT = { site: "agv", device: "base" } as const;
function stopNews(more: Partial<StopUpdate> = {}): StopUpdate {
  return { t: "stop_news", ...AT, latched: true, confirmed: false, who: "Ada", time_us: 1, id: "", ...more };
}
let line: FakeLine;
beforeEach(() => {
  vi.useFakeTimers({ toFake: ["setTimeout", "clearTimeout", "setInterval", "clearInterval", "performance"] });
  line = new FakeLine();
});
afterEach(() => {
  vi.useRealTimers();
});
describe("STOP", () => {
  let stop: StopClient;
  beforeEach(() => {
    stop = new StopClient(line, "agv", "base", true);
    stop.open();
  });
  afterEach(() => {
    stop.close();
  });

  test("leaves with the press, and again every 200 ms with the same id until it is named", () => {
    stop.pressStop();
    vi.advanceTimersByTime(650);
    const sent = line.take("stop");
    expect(sent).toHaveLength(4);
    const id = sent[0]?.["id"];
    expect(new Set(sent.map((message) => message["id"])).size).toBe(1);
    line.say(stopNews({ id: String(id) }));
    vi.advanceTimersByTime(2000);
    expect(line.take("stop")).toEqual([]);
  });

  test("goes on through a lost connection and an off-line site", () => {
    stop.pressStop();
    line.become("lost");
    vi.advanceTimersByTime(1000);
    line.become("open");
    line.sent.length = 0;
    vi.advanceTimersByTime(250);
    expect(line.take("stop")).toHaveLength(1);
    line.say({ t: "problem", code: "offline", message: "The site is not connected.", about: "stop" });
    vi.advanceTimersByTime(250);
    expect(line.take("stop")).toHaveLength(1);
    expect(stop.desk.trouble).toBe("The site is not connected.");
  });

  test("is followed at a second gateway that waits, until that one is gone or the link is", () => {
    const held = { t: "held_stop_news", ...AT, id: "s1", held: 1, latched: 0, confirmed: 0 } as const;
    line.say({ ...held, device: "other" });
    expect(stop.held).toBeNull();
    line.say(held);
    expect(stop.held?.latched).toBe(0);
    line.say({ ...held, latched: 1 });
    expect(stop.held?.latched).toBe(1);
    line.say({ ...held, held: 0 });
    expect(stop.held).toBeNull();
    line.say(held);
    line.become("lost");
    expect(stop.held).toBeNull();
  });

  test("ends when the hub says that it is forbidden", () => {
    stop.pressStop();
    line.say({ t: "problem", code: "forbidden", message: "Not for you.", about: "stop" });
    line.sent.length = 0;
    vi.advanceTimersByTime(1000);
    expect(line.take("stop")).toEqual([]);
  });

  test("is released by two messages, the second with the key", () => {
    line.say(stopNews({ id: "x" }));
    stop.askReset(4);
    expect(line.take("reset")).toMatchObject([{ ...AT, epoch: 4, token: "" }]);
    line.say({ t: "reset_key", ...AT, token: "k", refused: "" });
    stop.releaseStop(4);
    expect(line.take("reset")).toMatchObject([{ epoch: 4, token: "k" }]);
    line.say(stopNews({ latched: false }));
    expect(stop.desk.phase).toBe("clear");
  });

  test("the second step closes by itself after ten seconds", () => {
    line.say(stopNews({ id: "x" }));
    stop.askReset(4);
    line.say({ t: "reset_key", ...AT, token: "k", refused: "" });
    vi.advanceTimersByTime(10_100);
    stop.releaseStop(4);
    expect(line.take("reset")).toHaveLength(1);
  });

  test("a page opened late knows that it is latched", () => {
    const late = new StopClient(line, "agv", "base", true);
    late.open(stopNews({ confirmed: true }));
    expect(late.desk.phase).toBe("confirmed");
    late.close();
  });
});
