import { afterEach, beforeEach, describe, expect, test, vi } from "vitest";
import { DriveSession } from "../../../src/controllers/drive/drive-session.js";
import { PUSH } from "../../../src/controllers/drive/stick.js";
import type { LeaseUpdate } from "../../../src/generated/wire.js";
import { FakeLine } from "./fake-connection.js";

const LIMITS = { maxSpeed: 0.2, maxReverse: 0.2, maxTurn: 2 };
const AT = { site: "agv", device: "base" } as const;
function lease(more: Partial<LeaseUpdate> = {}): LeaseUpdate {
  const nobodyAsks = { rival: "", asking: false, answer_ms: 0, forceable: false };
  return {
    t: "lease_news", ...AT, holder: "Ada", yours: true, epoch: 4, remains_ms: 3000, ...nobodyAsks, refused: "", ...more,
  };
}
function siteNews(online: boolean): Parameters<FakeLine["say"]>[0] {
  return { t: "site", site: "agv", online, since_us: 0, catalogue: "", loop_ms: 0, skew_ms: 0, why: "", rival_us: 0, away: false };
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

  test("an interlock's lock ends what is held in the same turn, and no press counts before it is gone", () => {
    sit();
    seat.pressHold("key:KeyW", PUSH.forward);
    line.sent.length = 0;
    seat.followLock("Too steep");
    expect(line.sent).toHaveLength(1);
    vi.advanceTimersByTime(500);
    expect(line.take("drive").map((frame) => frame["linear"])).toEqual([0, 0, 0]);
    seat.followLock("Too steep, and wet");
    seat.pressHold("key:KeyA", PUSH.left);
    expect(line.take("drive")).toEqual([]);
    seat.followLock("");
    seat.pressHold("key:KeyD", PUSH.right);
    expect(line.take("drive")).toHaveLength(1);
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
