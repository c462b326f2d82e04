import { beforeEach, expect, test } from "vitest";
import { ARMED_MS, REPEAT_MS, RESET_ANSWER_MS, StopMachine, type StopReport } from "../../../src/controllers/drive/stop-machine.js";

function word(more: Partial<StopReport> = {}): StopReport {
  return { latched: true, confirmed: false, who: "Ada", time_us: 1, id: "", ...more };
}

let desk: StopMachine;
beforeEach(() => {
  desk = new StopMachine();
});

function latched(): void {
  desk.pressStop("s1", 0);
  desk.applyUpdate(word({ id: "s1", confirmed: true }), 10);
}

test("sent, latched at the gateway and confirmed by the robot are three things", () => {
  expect(desk.phase).toBe("unknown");
  expect(desk.pressStop("s1", 0)).toBe("s1");
  expect(desk.phase).toBe("sent");
  desk.applyUpdate(word({ id: "s1" }), 12);
  expect(desk.phase).toBe("latched");
  expect(desk.answerMs).toBe(12);
  desk.applyUpdate(word({ id: "s1", confirmed: true }), 400);
  expect(desk.phase).toBe("confirmed");
  expect(desk.answerMs).toBe(12);
});

test("it is repeated with the same id until that id comes back", () => {
  desk.pressStop("s1", 0);
  expect(desk.advance(REPEAT_MS - 1)).toBeNull();
  expect(desk.advance(REPEAT_MS)).toBe("s1");
  expect(desk.advance(REPEAT_MS + 1)).toBeNull();
  expect(desk.advance(2 * REPEAT_MS)).toBe("s1");
  desk.applyUpdate(word({ id: "another" }), 450);
  expect(desk.phase).toBe("sent");
  expect(desk.advance(3 * REPEAT_MS)).toBe("s1");
  desk.applyUpdate(word({ id: "s1" }), 700);
  expect(desk.advance(10_000)).toBeNull();
});

test("a second press while one is under way sends the first again, at once", () => {
  desk.pressStop("s1", 0);
  expect(desk.pressStop("s2", 50)).toBe("s1");
});

test("it goes on through a lost link", () => {
  desk.pressStop("s1", 0);
  desk.onLinkLost();
  expect(desk.phase).toBe("sent");
  expect(desk.advance(5000)).toBe("s1");
});

test("a lost link leaves nothing known of a latch", () => {
  latched();
  desk.onLinkLost();
  expect(desk.phase).toBe("unknown");
  expect(desk.latchedBy).toBeNull();
});

test("a refusal ends the repeating and says why", () => {
  desk.pressStop("s1", 0);
  desk.markRefused("You may not see this device.");
  expect(desk.advance(1000)).toBeNull();
  expect(desk.trouble).toBe("You may not see this device.");
});

test("driving is barred from the press on, until it is clear", () => {
  expect(desk.blocksDriving).toBe(false);
  desk.pressStop("s1", 0);
  expect(desk.blocksDriving).toBe(true);
  desk.applyUpdate(word({ id: "s1" }), 10);
  expect(desk.blocksDriving).toBe(true);
  desk.applyUpdate(word({ latched: false }), 20);
  expect(desk.blocksDriving).toBe(false);
});

test("what was clear before the press arrives does not lift it", () => {
  desk.pressStop("s1", 0);
  desk.applyUpdate(word({ latched: false }), 5);
  expect(desk.blocksDriving).toBe(true);
  expect(desk.phase).toBe("sent");
});

test("releasing takes two steps, the second within ten seconds", () => {
  latched();
  expect(desk.releaseStop(20)).toBeNull();
  expect(desk.askReset(20)).toBe(true);
  expect(desk.releaseStop(25)).toBeNull();
  desk.receiveResetKey("t", "", 30);
  expect(desk.reset.kind).toBe("armed");
  expect(desk.releaseStop(40)).toBe("t");
  expect(desk.releaseStop(41)).toBeNull();
  desk.applyUpdate(word({ latched: false }), 60);
  expect(desk.phase).toBe("clear");
  expect(desk.reset.kind).toBe("none");
});

test("after ten seconds the second step is closed again", () => {
  latched();
  desk.askReset(0);
  desk.receiveResetKey("t", "", 0);
  expect(desk.releaseStop(ARMED_MS)).toBeNull();
  desk.advance(ARMED_MS);
  expect(desk.reset.kind).toBe("none");
});

test("a refused reset says why, and so does one without an answer", () => {
  latched();
  desk.askReset(0);
  desk.receiveResetKey("", "Take control first.", 5);
  expect(desk.reset.kind).toBe("none");
  expect(desk.trouble).toBe("Take control first.");
  desk.askReset(10);
  desk.advance(10 + RESET_ANSWER_MS);
  expect(desk.reset.kind).toBe("none");
  expect(desk.trouble).toContain("did not answer");
});

test("a token nobody asked for is no key, and STOP pressed again takes it away", () => {
  latched();
  desk.receiveResetKey("t", "", 0);
  expect(desk.releaseStop(1)).toBeNull();
  desk.askReset(2);
  desk.receiveResetKey("t", "", 3);
  desk.pressStop("s2", 4);
  expect(desk.releaseStop(5)).toBeNull();
});

test("there is nothing to release while it is clear, unknown or only sent", () => {
  expect(desk.askReset(0)).toBe(false);
  desk.pressStop("s1", 0);
  expect(desk.askReset(1)).toBe(false);
});

test("further news of the same latch does not disturb the second step", () => {
  latched();
  desk.askReset(0);
  desk.receiveResetKey("t", "", 0);
  desk.applyUpdate(word({ confirmed: true }), 5);
  expect(desk.releaseStop(10)).toBe("t");
});
