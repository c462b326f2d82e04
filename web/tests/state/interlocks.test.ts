import { beforeEach, expect, test } from "vitest";
import type { InterlockUpdate } from "../../src/generated/wire.js";
import { lockText } from "../../src/format/interlock-reason.js";
import { Interlocks } from "../../src/state/interlocks.js";
import { FakeLine } from "../controllers/drive/fake-connection.js";

let line: FakeLine;
let now = 0;
let interlocks: Interlocks;
beforeEach(() => {
  now = 0;
  line = new FakeLine();
  interlocks = new Interlocks(line, () => now);
});

function news(interlock: string, more: Partial<InterlockUpdate> = {}): InterlockUpdate {
  return {
    t: "interlock_news", site: "obs", interlock, name: interlock, locked: true, unsafe: true, why: "Rain is raining",
    since_us: 1, clears_ms: 0, refuses: ["Dome: Open"], targets: ["dome/open"], slows: [], slowed: [], overridable: true,
    overridden_by: "", reason: "", override_ms: 0, longest_s: 0, condition: "", no_override: "", unknown: [],
    ...more,
  };
}
const names = (): string[] => interlocks.list.map((interlock) => interlock.news.interlock);

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
  expect(one && interlocks.remainingMs(one, one.news.clears_ms)).toBe(3000);
  now = 9000;
  expect(one && interlocks.remainingMs(one, one.news.clears_ms)).toBe(0);
});

test("nothing is claimed of a site that went offline, or over a lost connection", () => {
  line.say(news("rain"));
  line.say({ t: "site", site: "obs", online: false, since_us: 0, catalogue: "", loop_ms: 0, skew_ms: 0, why: "", rival_us: 0, away: false });
  expect(names()).toEqual([]);
  line.say(news("rain"));
  line.become("lost");
  expect(names()).toEqual([]);
});

test("a command is locked by the interlock that names it or all of its device, until it is overridden", () => {
  line.say(news("rain"));
  line.say(news("wind", { targets: ["mast/*"] }));
  expect(interlocks.lockOf("obs", "dome", "open")?.interlock).toBe("rain");
  expect(interlocks.lockOf("obs", "mast", "raise")?.interlock).toBe("wind");
  expect(interlocks.lockOf("obs", "dome", "close")).toBeNull();
  expect(interlocks.lockOf("other", "dome", "open")).toBeNull();
  line.say(news("rain", { overridden_by: "Ada", override_ms: 5000 }));
  expect(interlocks.lockOf("obs", "dome", "open")).toBeNull();
});

test("who stands before a lock reads what locks, why, and who can help", () => {
  expect(lockText(news("rain"))).toBe("Locked by rain: Rain is raining. An admin can override it.");
  expect(lockText(news("rain", { longest_s: 60 }))).toContain("You can override it in the bar at the top.");
  expect(lockText(news("rain", { overridable: false }))).toBe("Locked by rain: Rain is raining.");
  expect(lockText(news("rain", { unsafe: false, why: "" }))).toContain("safe now, but not for long enough yet");
  expect(lockText(news("rain", { why: "" }))).toContain("unsafe now");
});

test("a page of a site is told of its own interlocks, and of overrides anywhere", () => {
  line.say(news("rain"));
  line.say(news("person", { site: "agv" }));
  const at = (site: string): string[] => interlocks.listAt(site).map((interlock) => interlock.news.interlock);
  expect([at("obs"), at("agv"), at("other"), at("").length]).toEqual([["rain"], ["person"], [], 2]);
  expect([interlocks.hasAny("obs"), interlocks.hasAny("other"), interlocks.hasAny()]).toEqual([true, false, true]);
  line.say(news("rain", { overridden_by: "Ada", override_ms: 5000 }));
  expect(at("agv")).toEqual(["rain", "person"]);
});
