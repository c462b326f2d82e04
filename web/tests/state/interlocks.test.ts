import { beforeEach, expect, test } from "vitest";
import type { InterlockNews } from "../../src/generated/wire.js";
import { Interlocks } from "../../src/state/interlocks.js";
import { FakeLine } from "../controllers/drive/fake-line.js";

let line: FakeLine;
let now = 0;
let interlocks: Interlocks;
beforeEach(() => {
  now = 0;
  line = new FakeLine();
  interlocks = new Interlocks(line, () => now);
});

function news(interlock: string, more: Partial<InterlockNews> = {}): InterlockNews {
  return {
    t: "interlock_news", site: "obs", interlock, name: interlock, locked: true, unsafe: true, why: "Rain is raining",
    since_us: 1, clears_ms: 0, refuses: ["Dome: Open"], overridden_by: "", reason: "", override_ms: 0, longest_s: 0,
    ...more,
  };
}
const names = (): string[] => interlocks.list.map((one) => one.news.interlock);

test("what locks or is overridden is listed, and what is released is not", () => {
  line.say(news("rain"));
  line.say(news("wind", { locked: false, unsafe: false }));
  line.say(news("doors", { locked: true, overridden_by: "Ada", override_ms: 5000 }));
  expect(names()).toEqual(["doors", "rain"]);
  line.say(news("rain", { locked: false, unsafe: false }));
  expect(names()).toEqual(["doors"]);
});

test("what is unsafe stands before what only waits", () => {
  line.say(news("a", { unsafe: false, clears_ms: 5000 }));
  line.say(news("b"));
  expect(names()).toEqual(["b", "a"]);
});

test("times that are left are counted down from when they were told", () => {
  line.say(news("a", { unsafe: false, clears_ms: 5000 }));
  now = 2000;
  const [one] = interlocks.list;
  expect(one && interlocks.left(one, one.news.clears_ms)).toBe(3000);
  now = 9000;
  expect(one && interlocks.left(one, one.news.clears_ms)).toBe(0);
});

test("nothing is claimed of a site that went offline, or over a lost connection", () => {
  line.say(news("rain"));
  line.say({ t: "site", site: "obs", online: false, since_us: 0, catalogue: "", loop_ms: 0, skew_ms: 0, why: "" });
  expect(names()).toEqual([]);
  line.say(news("rain"));
  line.become("lost");
  expect(names()).toEqual([]);
});
