import { beforeEach, describe, expect, test } from "vitest";
import {
  DriveMachine,
  FRAME_MS,
  SILENT_MS,
  ZEROS,
  type DriveBlock,
  type DriveLimits,
  type VelocityFrame,
} from "../../../src/controllers/drive/drive-machine.js";
import { meaningOf } from "../../../src/controllers/drive/drive-keys.js";
import { pushOf } from "../../../src/controllers/drive/gamepad.js";
import { asideStick, combinedStick, CURVE, jointPush, PUSH } from "../../../src/controllers/drive/stick.js";

const LIMITS = { maxSpeed: 0.2, maxReverse: 0.1, maxTurn: 2 };

let machine: DriveMachine;
let now: number;

/** Lets time pass in steps of a millisecond and collects what is sent; marks keep coming. */
function pass(ms: number, ticks = true): VelocityFrame[] {
  const frames: VelocityFrame[] = [];
  for (const end = now + ms; now < end; ) {
    now += 1;
    if (ticks && now % 50 === 0) frames.push(...machine.onGatewayTick(now, now));
    frames.push(...machine.advance(now));
  }
  return frames;
}

function ready(epoch = 7): void {
  machine.grant(epoch, now);
  machine.onGatewayTick(now, now);
}

beforeEach(() => {
  machine = new DriveMachine(LIMITS);
  machine.setLevel(1);
  now = 1000;
});

describe("the lease", () => {
  test("nothing is ever sent without one", () => {
    expect(machine.pressHold("key:KeyW", PUSH.forward, now)).toEqual([]);
    expect(pass(500)).toEqual([]);
    expect(machine.haltMotion("blur", now, true)).toEqual([]);
  });

  test("a key held since before the grant does not drive", () => {
    machine.pressHold("key:KeyW", PUSH.forward, now);
    ready();
    expect(pass(200)).toEqual([]);
  });

  test("losing it while driving sends nothing more, not even zeros", () => {
    ready();
    machine.pressHold("key:KeyW", PUSH.forward, now);
    machine.revoke("lease lost");
    expect(pass(500)).toEqual([]);
    expect(machine.phase).toBe("idle");
    expect(machine.haltReason).toBe("lease lost");
  });

  test("what was held when it was lost does not drive under the next one", () => {
    ready(7);
    machine.pressHold("key:KeyW", PUSH.forward, now);
    machine.revoke("lease lost");
    ready(8);
    expect(machine.moveHold("key:KeyW", PUSH.forward, now)).toEqual([]);
    expect(pass(300)).toEqual([]);
    expect(machine.pressHold("key:KeyW", PUSH.forward, now)[0]?.epoch).toBe(8);
  });

  test("another epoch passes through rest, the same epoch again changes nothing", () => {
    ready(7);
    machine.pressHold("key:KeyW", PUSH.forward, now);
    machine.grant(7, now);
    expect(machine.phase).toBe("driving");
    machine.grant(9, now);
    expect(machine.phase).toBe("ready");
    expect(pass(300)).toEqual([]);
  });

  test("no frame leaves before the first time mark of the lease, and one leaves with it", () => {
    machine.grant(7, now);
    expect(machine.pressHold("key:KeyW", PUSH.forward, now)).toEqual([]);
    expect(pass(30, false)).toEqual([]);
    expect(machine.onGatewayTick(5, now + 20)).toHaveLength(1);
  });
});

describe("holding", () => {
  test("the first frame leaves with the press itself", () => {
    ready();
    expect(machine.pressHold("key:KeyW", PUSH.forward, now)).toMatchObject([
      { epoch: 7, linear: 0.2, angular: 0 },
    ]);
  });

  test("twenty frames a second follow while it lasts", () => {
    ready();
    machine.pressHold("key:KeyW", PUSH.forward, now);
    expect(pass(1000)).toHaveLength(1000 / FRAME_MS);
  });

  test("another key beside it counts at once, and makes a curve", () => {
    ready();
    machine.pressHold("key:KeyW", PUSH.forward, now);
    now += 3;
    expect(machine.pressHold("key:KeyA", PUSH.left, now)).toMatchObject([
      { linear: 0.2, angular: 2 * CURVE },
    ]);
  });

  test("letting one of two go counts at once, and the other goes on", () => {
    ready();
    machine.pressHold("key:KeyW", PUSH.forward, now);
    machine.pressHold("key:KeyA", PUSH.left, now);
    expect(machine.releaseHold("key:KeyW", now)).toMatchObject([{ linear: 0, angular: 2 }]);
    expect(machine.phase).toBe("driving");
  });

  test("opposite keys cancel", () => {
    ready();
    machine.pressHold("key:KeyW", PUSH.forward, now);
    expect(machine.pressHold("key:KeyX", PUSH.backward, now)).toMatchObject([{ linear: 0 }]);
  });

  test("two keys for the same direction are not faster than one, nor is a third hold", () => {
    ready();
    machine.pressHold("key:KeyW", PUSH.forward, now);
    machine.pressHold("key:ArrowUp", PUSH.forward, now);
    machine.pressHold("pad", { forward: 1, turn: 1 }, now, "analog");
    expect(machine.requestedVelocity).toEqual({ linear: 0.2, angular: 2 });
  });

  test("backward has a limit of its own", () => {
    ready();
    expect(machine.pressHold("key:KeyX", PUSH.backward, now)).toMatchObject([{ linear: -0.1 }]);
  });

  test("a pad that moves changes the next frame, not their number", () => {
    ready();
    machine.pressHold("pad", { forward: 0.5, turn: 0 }, now, "analog");
    const frames: VelocityFrame[] = [];
    for (let i = 0; i < 40; i++) {
      frames.push(...pass(5), ...machine.moveHold("pad", { forward: i / 40, turn: 0 }, now));
    }
    expect(frames).toHaveLength(200 / FRAME_MS);
    expect(frames.at(-1)?.linear).toBeGreaterThan(0.15);
  });

  test("nothing that is not a number goes out", () => {
    ready();
    const bad = { forward: Number.NaN, turn: Number.POSITIVE_INFINITY };
    expect(machine.pressHold("pad", bad, now, "analog")).toMatchObject([{ linear: 0, angular: 0 }]);
    machine.moveHold("pad", { forward: 50, turn: -50 }, now);
    expect(machine.requestedVelocity).toEqual({ linear: 0.2, angular: -2 });
  });
});

describe("letting go", () => {
  test("three zero frames, the first at once, then silence", () => {
    ready();
    machine.pressHold("key:KeyW", PUSH.forward, now);
    pass(120);
    const frames = [...machine.releaseHold("key:KeyW", now)];
    expect(frames).toMatchObject([{ linear: 0, angular: 0 }]);
    frames.push(...pass(2000));
    expect(frames).toHaveLength(ZEROS);
    expect(frames.every((frame) => frame.linear === 0 && frame.angular === 0)).toBe(true);
    expect(machine.phase).toBe("ready");
    expect(machine.dueAt).toBeNull();
  });

  test("a page that goes out of sight sends all three at once", () => {
    ready();
    machine.pressHold("key:KeyW", PUSH.forward, now);
    expect(machine.block("hidden", now)).toHaveLength(ZEROS);
    expect(pass(1000)).toEqual([]);
  });

  test.each(["blur", "cancelled", "gamepad lost", "dialog", "stop key", "stop", "interlock"] as const)(
    "%s brings it to rest, and what is still held does not start again",
    (why) => {
      ready();
      machine.pressHold("key:KeyW", PUSH.forward, now);
      machine.pressHold("pad", PUSH.left, now, "analog");
      const frames = [...machine.haltMotion(why, now), ...pass(500)];
      expect(frames).toHaveLength(ZEROS);
      expect(machine.haltReason).toBe(why);
      expect(machine.moveHold("pad", PUSH.left, now)).toEqual([]);
      expect(machine.releaseHold("key:KeyW", now)).toEqual([]);
      expect(pass(500)).toEqual([]);
    },
  );

  test("a halt while nothing is held sends nothing and hides no earlier reason", () => {
    ready();
    expect(machine.haltMotion("blur", now)).toEqual([]);
    expect(machine.haltReason).toBeNull();
  });

  test("a press during the zero frames drives at once", () => {
    ready();
    machine.pressHold("key:KeyW", PUSH.forward, now);
    machine.releaseHold("key:KeyW", now);
    expect(machine.pressHold("key:KeyD", PUSH.right, now)).toMatchObject([{ angular: -2 }]);
    expect(pass(100).every((frame) => frame.angular === -2)).toBe(true);
  });

  test("a gateway whose time marks stop is let go of", () => {
    ready();
    machine.pressHold("key:KeyW", PUSH.forward, now);
    const frames = pass(SILENT_MS + 300, false);
    expect(machine.haltReason).toBe("silent");
    expect(frames.slice(-ZEROS).every((frame) => frame.linear === 0)).toBe(true);
    expect(pass(500, false)).toEqual([]);
  });
});

describe("while it is barred", () => {
  test.each(["stop", "dialog", "hidden", "offline"] as const)("%s: no press counts", (bar) => {
    ready();
    machine.block(bar, now);
    expect(machine.pressHold("key:KeyW", PUSH.forward, now)).toEqual([]);
    machine.unblock(bar);
    expect(pass(300)).toEqual([]);
    expect(machine.pressHold("key:KeyW", PUSH.forward, now)).toHaveLength(1);
  });

  test("offline nothing is sent, not even zeros: they would arrive much later", () => {
    ready();
    machine.pressHold("key:KeyW", PUSH.forward, now);
    expect(machine.block("offline", now)).toEqual([]);
    expect(pass(500)).toEqual([]);
    expect(machine.haltReason).toBe("offline");
  });

  test.each(["stop", "dialog", "offline"] as const)("%s: once lifted, it is no longer told as the reason", (bar) => {
    ready();
    machine.pressHold("key:KeyW", PUSH.forward, now);
    machine.block(bar, now);
    expect(machine.haltReason).toBe(bar);
    machine.unblock(bar);
    expect(machine.haltReason).toBeNull();
  });

  test("that the page was hidden stays told when it is seen again", () => {
    ready();
    machine.pressHold("key:KeyW", PUSH.forward, now);
    machine.block("hidden", now);
    machine.unblock("hidden");
    expect(machine.haltReason).toBe("hidden");
  });

  test("a lifted bar does not hide another reason", () => {
    ready();
    machine.block("stop", now);
    machine.revoke("lease lost");
    machine.unblock("stop");
    expect(machine.haltReason).toBe("lease lost");
  });

  test("one bar lifted leaves the other", () => {
    ready();
    machine.block("stop", now);
    machine.block("dialog", now);
    machine.unblock("dialog");
    expect(machine.mayDrive).toBe(false);
  });
});

describe("the frame", () => {
  test("echoes the newest time mark with the time since it came", () => {
    ready();
    machine.onGatewayTick(4711, now + 10);
    expect(machine.pressHold("key:KeyW", PUSH.forward, now + 25)).toMatchObject([
      { tick: 4711, held_ms: 15 },
    ]);
  });

  test("an older mark that comes late does not replace a newer one", () => {
    machine.grant(7, now);
    machine.onGatewayTick(50, now);
    machine.onGatewayTick(40, now + 1);
    expect(machine.pressHold("key:KeyW", PUSH.forward, now + 5)).toMatchObject([
      { tick: 50, held_ms: 5 },
    ]);
  });

  test("carries the age of the picture, or -1 without one", () => {
    ready();
    expect(machine.pressHold("key:KeyW", PUSH.forward, now)[0]?.picture_ms).toBe(-1);
    machine.setPictureTime(now - 80);
    expect(machine.pressHold("key:KeyW", PUSH.forward, now)[0]?.picture_ms).toBe(80);
  });

  test("sequence numbers rise over releases and leases", () => {
    ready();
    const frames = [...machine.pressHold("a", PUSH.left, now), ...machine.releaseHold("a", now)];
    frames.push(...pass(300));
    machine.revoke("freed");
    ready(8);
    frames.push(...machine.pressHold("a", PUSH.left, now));
    const numbers = frames.map((frame) => frame.seq);
    expect(numbers).toEqual(numbers.map((_, i) => i + 1));
  });
});

describe("faster and slower", () => {
  test("go in steps of ten per cent and stop at ten and a hundred", () => {
    machine.setLevel(0.5);
    machine.faster();
    expect(machine.speedLevel).toBeCloseTo(0.6);
    for (let i = 0; i < 20; i++) machine.faster();
    expect(machine.speedLevel).toBe(1);
    for (let i = 0; i < 20; i++) machine.slower();
    expect(machine.speedLevel).toBeCloseTo(0.1);
    machine.setLevel(Number.NaN);
    expect(machine.speedLevel).toBeCloseTo(0.1);
  });

  test("count while a key is held", () => {
    ready();
    machine.pressHold("key:KeyW", PUSH.forward, now);
    machine.setLevel(0.1);
    expect(pass(60).at(-1)?.linear).toBeCloseTo(0.02);
  });
});

/** A small generator, so that a failure can be repeated by its seed. */
function dice(seed: number): (sides: number) => number {
  let state = seed;
  return (sides) => {
    state = (Math.imul(state, 1664525) + 1013904223) >>> 0;
    return Math.floor((state / 2 ** 32) * sides);
  };
}

test.each(Array.from({ length: 40 }, (_, i) => i + 1))(
  "whatever happens, the promises hold (seed %i)",
  (seed) => {
    const roll = dice(seed);
    const sources = ["key:KeyW", "key:KeyA", "pad", "gamepad:0"];
    const bars: DriveBlock[] = ["offline", "stop", "hidden", "dialog"];
    const raised = new Set<DriveBlock>();
    let epoch = 0;
    let lease = 0;
    let last = 0;
    for (let step = 0; step < 2000; step++) {
      now += roll(30);
      const source = sources[roll(sources.length)] ?? "";
      const bar = bars[roll(bars.length)] ?? "stop";
      const stick = { forward: roll(5) - 2, turn: roll(5) - 2 };
      const before = machine.phase;
      let frames: VelocityFrame[] = [];
      switch (roll(11)) {
        case 0:
          lease = ++epoch;
          machine.grant(lease, now);
          break;
        case 1:
          if (roll(4) === 0) {
            lease = 0;
            machine.revoke("lease lost");
          }
          break;
        case 2:
        case 3:
          frames = machine.pressHold(source, stick, now, roll(2) === 0 ? "analog" : "digital");
          break;
        case 4:
          frames = machine.moveHold(source, stick, now);
          break;
        case 5:
          frames = machine.releaseHold(source, now);
          break;
        case 6:
          frames = machine.haltMotion("blur", now, roll(2) === 0);
          break;
        case 7:
          raised.add(bar);
          frames = machine.block(bar, now);
          break;
        case 8:
          raised.delete(bar);
          machine.unblock(bar);
          break;
        case 9:
          frames = machine.onGatewayTick(now, now);
          break;
        default:
          frames = machine.advance(now);
      }
      for (const frame of frames) {
        expect(frame.epoch).toBe(lease);
        expect(lease).toBeGreaterThan(0);
        expect(frame.seq).toBeGreaterThan(last);
        last = frame.seq;
        expect(Math.abs(frame.linear)).toBeLessThanOrEqual(0.2);
        expect(Math.abs(frame.angular)).toBeLessThanOrEqual(2);
        expect(raised.has("offline")).toBe(false);
        const moving = frame.linear !== 0 || frame.angular !== 0;
        if (moving) {
          expect(machine.phase).toBe("driving");
          expect(raised.size).toBe(0);
        }
      }
      if (before === "ready" && machine.phase === "ready") expect(frames).toEqual([]);
      if (frames.length > 1) expect(frames.length).toBeLessThanOrEqual(ZEROS);
    }
  },
);

const WHEELS = { maxSpeed: 0.4, maxReverse: 0.2, maxTurn: 2 };

function granted(limits: DriveLimits): DriveMachine {
  const made = new DriveMachine(limits);
  made.setLevel(0.5);
  made.grant(7, 0);
  made.onGatewayTick(1, 0);
  return made;
}

function sent(frames: readonly VelocityFrame[]): VelocityFrame {
  const frame = frames.at(-1);
  if (frame === undefined) throw new Error("nothing was sent");
  return frame;
}

test("a base that moves sideways is pushed sideways, within its own limit", () => {
  const arm = granted({ ...WHEELS, maxSideways: 0.2 });
  const frame = sent(arm.pressHold("key:KeyQ", PUSH.sideLeft, 0));
  expect(frame).toMatchObject({ linear: 0, angular: 0, lateral: 0.1 });
  expect(sent(arm.releaseHold("key:KeyQ", 10))).toMatchObject({ linear: 0, angular: 0 });
});

test("a base that cannot move sideways does not obey such a push", () => {
  expect(granted(WHEELS).obeys(PUSH.sideLeft)).toBe(false);
  expect(granted({ ...WHEELS, maxSideways: 0.2 }).obeys(PUSH.sideLeft)).toBe(true);
});

test("steered wheels turn as far at any speed, and as far while it moves", () => {
  const arm = granted({ maxSpeed: 0.4, maxReverse: 0.2, maxTurn: 0, maxSteering: 0.3 });
  arm.pressHold("key:KeyW", PUSH.forward, 0);
  expect(sent(arm.pressHold("key:KeyA", PUSH.left, 0))).toMatchObject({ linear: 0.2, angular: 0, steering: 0.3 });
});

test("a joint moves while its button is held, two of them together, and against each other not at all", () => {
  const arm = granted({ maxSpeed: 0, maxReverse: 0, maxTurn: 0, jointSpeeds: [0.4, 0.2] });
  expect(sent(arm.pressHold("a", jointPush(0, 2, 1), 0)).joints).toEqual([0.2, 0]);
  expect(sent(arm.pressHold("b", jointPush(1, 2, -1), 0)).joints).toEqual([0.2, -0.1]);
  expect(sent(arm.pressHold("c", jointPush(0, 2, -1), 0)).joints).toEqual([0, -0.1]);
});

test("letting go of a joint sends frames that name none", () => {
  const arm = granted({ maxSpeed: 0, maxReverse: 0, maxTurn: 0, jointSpeeds: [0.4, 0.2] });
  arm.pressHold("a", jointPush(0, 2, 1), 0);
  expect(sent(arm.releaseHold("a", 20)).joints).toBeUndefined();
});

test("an arm does not obey the keys of a vehicle", () => {
  expect(granted({ maxSpeed: 0, maxReverse: 0, maxTurn: 0, jointSpeeds: [0.4] }).obeys(PUSH.forward)).toBe(false);
});

test("Q and E are to the sides, the right stick is so, and a pad is where it is told", () => {
  const press = { code: "KeyQ", key: "q", repeat: false, ctrlKey: false, altKey: false, metaKey: false, isComposing: false };
  expect(meaningOf(press)).toEqual({ kind: "push", direction: "sideLeft" });
  expect(meaningOf({ ...press, code: "KeyE", key: "e" })).toEqual({ kind: "push", direction: "sideRight" });
  expect(pushOf({ axes: [0, 0, 1, 0], buttons: [] })).toEqual({ forward: 0, turn: 0, side: -1 });
  expect(asideStick({ forward: 0.5, turn: 1 })).toEqual({ forward: 0.5, turn: 0, side: 1 });
  expect(combinedStick([PUSH.sideLeft, PUSH.sideRight])).toEqual({ forward: 0, turn: 0 });
});

test("a camera is turned by keys as by its own buttons, aslant as fast as straight", () => {
  const camera = granted({ maxSpeed: 0, maxReverse: 0, maxTurn: 0, jointSpeeds: [1, 1, 0.5], aims: ["pan", "tilt", "zoom"] });
  camera.setLevel(1);
  camera.pressHold("key:ArrowUp", PUSH.forward, 0);
  camera.pressHold("key:ArrowRight", PUSH.right, 0);
  expect(camera.requestedVelocity.joints).toEqual([1, 1, 0]);
  camera.pressHold("key:KeyE", PUSH.sideRight, 0);
  camera.pressHold("aim:up", jointPush(1, 3, 1), 0);
  // What two hold at once is no faster than what one holds.
  expect(camera.requestedVelocity.joints).toEqual([1, 1, 0.5]);
  camera.haltMotion("released", 0);
  expect(camera.requestedVelocity.joints).toEqual([0, 0, 0]);
});

test("a camera obeys the keys of the axes that it has", () => {
  const zooms = granted({ maxSpeed: 0, maxReverse: 0, maxTurn: 0, jointSpeeds: [1], aims: ["zoom"] });
  expect([PUSH.forward, PUSH.left, PUSH.sideLeft].map((push) => zooms.obeys(push))).toEqual([false, false, true]);
});
