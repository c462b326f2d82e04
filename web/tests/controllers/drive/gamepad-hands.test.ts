import { beforeEach, expect, test } from "vitest";
import { DriveSession } from "../../../src/controllers/drive/drive-session.js";
import { GamepadHands, type PadInPlace } from "../../../src/controllers/drive/gamepad-hands.js";
import { StopClient } from "../../../src/controllers/drive/stop-client.js";
import { FakeLine } from "./fake-connection.js";

const [HALT, STOP, SLOWER, FASTER, GRIP] = [0, 1, 2, 3, 4];
const LIMITS = { maxSpeed: 1, maxReverse: 0.5, maxTurn: 2 };
let now = 0;
let line: FakeLine;
let seat: DriveSession;
let hands: GamepadHands;

function pad(pressed: readonly number[], axes: readonly number[] = [0, -1], more: Partial<PadInPlace> = {}): PadInPlace {
  return { index: 0, mapping: "standard", axes, buttons: Array.from({ length: 17 }, (_, i) => ({ pressed: pressed.includes(i) })), ...more };
}

beforeEach(() => {
  now = 1000;
  line = new FakeLine();
  seat = new DriveSession(line, { site: "agv", device: "base", limits: LIMITS }, true, () => now);
  const stop = new StopClient(line, "agv", "base", true, () => now);
  hands = new GamepadHands(seat, stop);
  seat.machine.grant(7, now);
  seat.machine.onGatewayTick(1, now);
});

/** Driving frames sent since the last look: m/s each. */
function speeds(): readonly unknown[] {
  return line.take("drive").map(({ linear }) => linear);
}

function drive(): void {
  hands.read([pad([])], true);
  hands.read([pad([GRIP])], true);
}

test("a pad drives as a key does: a frame with the press, zeros with the release", () => {
  drive();
  expect(speeds()).toEqual([0.5]);
  hands.read([pad([])], true);
  expect(speeds()).toEqual([0]);
  expect(seat.machine.phase).toBe("braking");
});

test("a window without the focus is not driven in, and what is held ends with it", () => {
  hands.read([pad([])], false);
  hands.read([pad([GRIP])], false);
  expect(speeds()).toEqual([]);
  hands.read([pad([])], true);
  drive();
  speeds();
  hands.read([pad([GRIP])], false);
  expect(speeds()).toEqual([0]);
  expect(seat.machine.haltReason).toBe("blur");
  // Held on, it does not begin again by itself once the focus is back.
  hands.read([pad([GRIP])], true);
  expect(seat.machine.phase).toBe("braking");
});

test.each([
  ["an event", (): void => { hands.forget(0); }],
  ["nothing but a hole in the list", (): void => { hands.read([null], true); }],
  ["another layout", (): void => { hands.read([pad([GRIP], [0, -1], { mapping: "" })], true); }],
  ["leaving the page", (): void => { hands.forgetAll(); }],
])("a pad that is lost with %s brings the vehicle to rest", (_how, lose) => {
  drive();
  speeds();
  lose();
  expect(speeds()).toEqual([0]);
  expect(seat.machine.haltReason).toBe("gamepad lost");
  // Back again with the button held, it waits for a new press.
  hands.read([pad([GRIP])], true);
  expect(speeds()).toEqual([]);
});

test("the buttons at the right thumb do what S, minus and plus do", () => {
  drive();
  hands.read([pad([GRIP, FASTER])], true);
  expect(seat.machine.speedLevel).toBeCloseTo(0.6);
  hands.read([pad([GRIP])], true);
  hands.read([pad([GRIP, SLOWER])], true);
  expect(seat.machine.speedLevel).toBeCloseTo(0.5);
  speeds();
  hands.read([pad([GRIP, HALT])], true);
  expect(speeds().at(-1)).toBe(0);
  expect(seat.machine.haltReason).toBe("stop key");
});

test("STOP needs no lease and no right to drive, and one held since before is no press", () => {
  const watcher = new GamepadHands(null, new StopClient(line, "agv", "base", true, () => now));
  watcher.read([pad([STOP])], true);
  expect(line.take("stop")).toHaveLength(0);
  watcher.read([pad([])], true);
  watcher.read([pad([STOP])], true);
  watcher.read([pad([STOP])], true);
  expect(line.take("stop")).toHaveLength(1);
});

test("without control the buttons change nothing", () => {
  seat.machine.revoke("freed");
  hands.read([pad([])], true);
  hands.read([pad([GRIP, FASTER])], true);
  expect(seat.machine.speedLevel).toBe(0.5);
  expect(speeds()).toEqual([]);
});
