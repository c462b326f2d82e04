import { beforeEach, expect, test } from "vitest";
import { ARMED_MS, REPEAT_MS, RESET_ANSWER_MS, StopDesk, type StopWord } from "../../../src/controllers/drive/stop-machine.js";

function word(more: Partial<StopWord> = {}): StopWord {
  return { latched: true, confirmed: false, who: "Ada", time_us: 1, id: "", ...more };
}

let desk: StopDesk;
beforeEach(() => {
  desk = new StopDesk();
});

function latched(): void {
  desk.press("s1", 0);
  desk.news(word({ id: "s1", confirmed: true }), 10);
}

test("sent, latched at the gateway and confirmed by the robot are three things", () => {
  expect(desk.phase).toBe("unknown");
  expect(desk.press("s1", 0)).toBe("s1");
  expect(desk.phase).toBe("sent");
  desk.news(word({ id: "s1" }), 12);
  expect(desk.phase).toBe("latched");
  expect(desk.answeredIn).toBe(12);
  desk.news(word({ id: "s1", confirmed: true }), 400);
  expect(desk.phase).toBe("confirmed");
  expect(desk.answeredIn).toBe(12);
});

test("it is repeated with the same id until that id comes back", () => {
  desk.press("s1", 0);
  expect(desk.beat(REPEAT_MS - 1)).toBeNull();
  expect(desk.beat(REPEAT_MS)).toBe("s1");
  expect(desk.beat(REPEAT_MS + 1)).toBeNull();
  expect(desk.beat(2 * REPEAT_MS)).toBe("s1");
  desk.news(word({ id: "another" }), 450);
  expect(desk.phase).toBe("sent");
  expect(desk.beat(3 * REPEAT_MS)).toBe("s1");
  desk.news(word({ id: "s1" }), 700);
  expect(desk.beat(10_000)).toBeNull();
});

test("a second press while one is under way sends the first again, at once", () => {
  desk.press("s1", 0);
  expect(desk.press("s2", 50)).toBe("s1");
});

test("it goes on through a lost link", () => {
  desk.press("s1", 0);
  desk.lose();
  expect(desk.phase).toBe("sent");
  expect(desk.beat(5000)).toBe("s1");
});

test("a lost link leaves nothing known of a latch", () => {
  latched();
  desk.lose();
  expect(desk.phase).toBe("unknown");
  expect(desk.latched).toBeNull();
});

test("a refusal ends the repeating and says why", () => {
  desk.press("s1", 0);
  desk.refused("You may not see this device.");
  expect(desk.beat(1000)).toBeNull();
  expect(desk.trouble).toBe("You may not see this device.");
});

test("driving is barred from the press on, until it is clear", () => {
  expect(desk.bars).toBe(false);
  desk.press("s1", 0);
  expect(desk.bars).toBe(true);
  desk.news(word({ id: "s1" }), 10);
  expect(desk.bars).toBe(true);
  desk.news(word({ latched: false }), 20);
  expect(desk.bars).toBe(false);
});

test("what was clear before the press arrives does not lift it", () => {
  desk.press("s1", 0);
  desk.news(word({ latched: false }), 5);
  expect(desk.bars).toBe(true);
  expect(desk.phase).toBe("sent");
});

test("releasing takes two steps, the second within ten seconds", () => {
  latched();
  expect(desk.release(20)).toBeNull();
  expect(desk.askReset(20)).toBe(true);
  expect(desk.release(25)).toBeNull();
  desk.key("t", "", 30);
  expect(desk.reset.kind).toBe("armed");
  expect(desk.release(40)).toBe("t");
  expect(desk.release(41)).toBeNull();
  desk.news(word({ latched: false }), 60);
  expect(desk.phase).toBe("clear");
  expect(desk.reset.kind).toBe("none");
});

test("after ten seconds the second step is closed again", () => {
  latched();
  desk.askReset(0);
  desk.key("t", "", 0);
  expect(desk.release(ARMED_MS)).toBeNull();
  desk.beat(ARMED_MS);
  expect(desk.reset.kind).toBe("none");
});

test("a refused reset says why, and so does one without an answer", () => {
  latched();
  desk.askReset(0);
  desk.key("", "Take control first.", 5);
  expect(desk.reset.kind).toBe("none");
  expect(desk.trouble).toBe("Take control first.");
  desk.askReset(10);
  desk.beat(10 + RESET_ANSWER_MS);
  expect(desk.reset.kind).toBe("none");
  expect(desk.trouble).toContain("did not answer");
});

test("a token nobody asked for is no key, and STOP pressed again takes it away", () => {
  latched();
  desk.key("t", "", 0);
  expect(desk.release(1)).toBeNull();
  desk.askReset(2);
  desk.key("t", "", 3);
  desk.press("s2", 4);
  expect(desk.release(5)).toBeNull();
});

test("there is nothing to release while it is clear, unknown or only sent", () => {
  expect(desk.askReset(0)).toBe(false);
  desk.press("s1", 0);
  expect(desk.askReset(1)).toBe(false);
});

test("further news of the same latch does not disturb the second step", () => {
  latched();
  desk.askReset(0);
  desk.key("t", "", 0);
  desk.news(word({ confirmed: true }), 5);
  expect(desk.release(10)).toBe("t");
});
