import { afterEach, beforeEach, describe, expect, test, vi } from "vitest";
import { CommandClient } from "../../../src/controllers/drive/command-client.js";
import { DriveSession } from "../../../src/controllers/drive/drive-session.js";
import { StopClient } from "../../../src/controllers/drive/stop-client.js";
import { PUSH } from "../../../src/controllers/drive/stick.js";
import type { LeaseUpdate, StopUpdate } from "../../../src/generated/wire.js";
import { FakeLine } from "./fake-connection.js";

const LIMITS = { maxSpeed: 0.2, maxReverse: 0.2, maxTurn: 2 };
const AT = { site: "agv", device: "base" } as const;

function lease(more: Partial<LeaseUpdate> = {}): LeaseUpdate {
  const nobodyAsks = { rival: "", asking: false, answer_ms: 0, forceable: false };
  return {
    t: "lease_news", ...AT, holder: "Ada", yours: true, epoch: 4, remains_ms: 3000, ...nobodyAsks, refused: "", ...more,
  };
}
function stopNews(more: Partial<StopUpdate> = {}): StopUpdate {
  return { t: "stop_news", ...AT, latched: true, confirmed: false, who: "Ada", time_us: 1, id: "", ...more };
}
function siteNews(online: boolean): Parameters<FakeLine["say"]>[0] {
  return { t: "site", site: "agv", online, since_us: 0, catalogue: "", loop_ms: 0, skew_ms: 0, why: "", rival_us: 0 };
}

let line: FakeLine;
beforeEach(() => {
  vi.useFakeTimers({ toFake: ["setTimeout", "clearTimeout", "setInterval", "clearInterval", "performance"] });
  line = new FakeLine();
});
afterEach(() => {
  vi.useRealTimers();
});

describe("the seat", () => {
  let seat: DriveSession;
  let ticks: ReturnType<typeof setInterval>;

  beforeEach(() => {
    seat = new DriveSession(line, { ...AT, limits: LIMITS }, true);
    seat.open();
    let tick = 0;
    ticks = setInterval(() => {
      line.say({ t: "tick", site: "agv", tick: ++tick });
    }, 50);
  });
  afterEach(() => {
    clearInterval(ticks);
    seat.close();
  });

  function sit(): void {
    seat.takeControl();
    line.say(lease());
    vi.advanceTimersByTime(60);
    line.sent.length = 0;
  }

  test("asks for the lease, and renews it each second while it is mine", () => {
    seat.takeControl();
    expect(line.take("lease")).toMatchObject([{ ...AT, op: "take" }]);
    line.say(lease());
    vi.advanceTimersByTime(1100);
    expect(line.take("lease")).toMatchObject([{ op: "renew" }]);
  });

  test("the first frame is sent before the press returns", () => {
    sit();
    seat.pressHold("key:KeyW", PUSH.forward);
    expect(line.take("drive")).toMatchObject([{ ...AT, epoch: 4, linear: 0.1, angular: 0 }]);
  });

  test("twenty a second while held, three zeros after, then silence", () => {
    sit();
    seat.pressHold("key:KeyW", PUSH.forward);
    vi.advanceTimersByTime(990);
    expect(line.take("drive")).toHaveLength(20);
    seat.releaseHold("key:KeyW");
    vi.advanceTimersByTime(990);
    expect(line.take("drive").map((frame) => frame["linear"])).toEqual([0, 0, 0]);
  });

  test("out of sight: zeros first, then the lease goes back, all in one turn", () => {
    sit();
    seat.pressHold("key:KeyW", PUSH.forward);
    line.sent.length = 0;
    seat.onHidden();
    expect(line.sent.map((message) => message.t)).toEqual(["drive", "drive", "drive", "lease"]);
    expect(line.sent.at(-1)).toMatchObject({ op: "free" });
    seat.unblock("hidden");
    line.sent.length = 0;
    seat.pressHold("key:KeyW", PUSH.forward);
    expect(line.sent).toEqual([]);
  });

  test("out of sight no press counts, lease or not", () => {
    seat.onHidden();
    sit();
    seat.pressHold("key:KeyW", PUSH.forward);
    expect(line.take("drive")).toEqual([]);
  });

  test("a press that the system takes away ends everything that is held", () => {
    sit();
    seat.pressHold("pad", PUSH.forward, "analog");
    seat.pressHold("key:KeyA", PUSH.left);
    line.sent.length = 0;
    seat.cancelHold("pad");
    vi.advanceTimersByTime(500);
    expect(line.take("drive")).toHaveLength(3);
    expect(seat.problem).toContain("interrupted");
  });

  test("a lost connection ends the lease, and nothing is sent when it is back", () => {
    sit();
    seat.pressHold("key:KeyW", PUSH.forward);
    line.become("lost");
    expect(seat.problem).toContain("connection");
    line.become("open");
    line.sent.length = 0;
    vi.advanceTimersByTime(2000);
    expect(line.sent).toEqual([]);
    expect(seat.lease.epoch).toBe(0);
  });

  test("a site that goes offline ends it too, in words of its own", () => {
    sit();
    seat.pressHold("key:KeyW", PUSH.forward);
    line.say(siteNews(false));
    line.sent.length = 0;
    vi.advanceTimersByTime(500);
    expect(line.sent).toEqual([]);
    expect(seat.problem).toContain("offline");
    seat.takeControl();
    expect(line.sent).toEqual([]);
  });

  test("a take-over silences it and says by whom", () => {
    sit();
    seat.pressHold("key:KeyW", PUSH.forward);
    line.say(lease({ holder: "Grace", yours: false, epoch: 0 }));
    line.sent.length = 0;
    vi.advanceTimersByTime(500);
    expect(line.take("drive")).toEqual([]);
    expect(seat.problem).toBe("Grace has control now.");
  });

  test("a moving frame is not put behind a jam, a zero is", () => {
    sit();
    line.bufferedBytes = 100_000;
    seat.pressHold("key:KeyW", PUSH.forward);
    expect(line.take("drive")).toEqual([]);
    seat.releaseHold("key:KeyW");
    expect(line.take("drive")).toMatchObject([{ linear: 0 }]);
  });

  test("news of another device or site changes nothing", () => {
    seat.takeControl();
    line.say(lease({ device: "arm" }));
    line.say(lease({ site: "dome" }));
    expect(seat.lease.epoch).toBe(0);
  });

  test("leaving gives the lease back and listens to nothing any more", () => {
    sit();
    seat.pressHold("key:KeyW", PUSH.forward);
    line.sent.length = 0;
    seat.close();
    expect(line.sent.map((message) => message.t)).toEqual(["drive", "drive", "drive", "lease"]);
    expect(line.listening).toBe(0);
    line.sent.length = 0;
    vi.advanceTimersByTime(3000);
    expect(line.sent).toEqual([]);
  });

  test("starts with what was said of the lease before", () => {
    const late = new DriveSession(line, { ...AT, limits: LIMITS }, true);
    late.open(lease({ holder: "Grace", yours: false, epoch: 0 }));
    expect(late.lease.state).toEqual({ kind: "other", holder: "Grace", forceable: false });
    late.close();
  });
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

describe("a command", () => {
  let commands: CommandClient;
  beforeEach(() => {
    commands = new CommandClient(line, "agv");
    commands.open();
  });
  afterEach(() => {
    commands.close();
  });

  test("is sent once and never again by itself, whatever happens to the link", () => {
    commands.sendCommand("base", "wander", { active: true });
    expect(line.take("command")).toMatchObject([{ ...AT, command: "wander", args: { active: true } }]);
    line.become("lost");
    line.become("open");
    vi.advanceTimersByTime(60_000);
    expect(line.take("command")).toEqual([]);
    expect(commands.desk.latestRequest("base", "wander")?.phase).toBe("unknown");
  });

  test("has another id each time", () => {
    commands.sendCommand("base", "wander", {});
    commands.sendCommand("base", "wander", {});
    const ids = line.take("command").map((message) => message["id"]);
    expect(new Set(ids).size).toBe(2);
  });

  test("without a connection is offline at once, and not kept for later", () => {
    line.become("lost");
    commands.sendCommand("base", "wander", {});
    expect(commands.desk.latestRequest("base", "wander")?.phase).toBe("offline");
    line.become("open");
    expect(line.take("command")).toEqual([]);
  });
});
