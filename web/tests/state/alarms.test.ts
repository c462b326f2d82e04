import { beforeEach, expect, test } from "vitest";
import type { AlarmUpdate } from "../../src/generated/wire.js";
import { AlarmSound } from "../../src/state/alarm-sound.js";
import { Alarms } from "../../src/state/alarms.js";
import { FakeLine } from "../controllers/drive/fake-connection.js";

let line: FakeLine;
let now = 0;
let alarms: Alarms;
beforeEach(() => {
  now = 1e6;
  line = new FakeLine();
  alarms = new Alarms(line, () => now);
});

function news(alarm: string, more: Partial<AlarmUpdate> = {}): AlarmUpdate {
  return {
    t: "alarm", site: "agv", alarm, device: "base", name: alarm, kind: "limit", severity: "warning", phase: "normal",
    why: "", known: true, unknown_why: "", raised_us: 0, cleared_us: 0, acked_us: 0, acked_by: "", assigned: "",
    shelved_until_us: 0, shelved_by: "", shelved_why: "", undelivered: "", advice: "", signals: [], shares: [], made: false, gone: false,
    ...more,
  };
}
const names = (): string[] => alarms.list.map(({ alarm }) => alarm);
const unseen = (): string[] => alarms.summary.unseen.map(({ alarm }) => alarm);

test("the worst stands first, and what cannot be judged before what is well", () => {
  line.say(news("well"));
  line.say(news("unknown", { known: false }));
  line.say(news("seen", { phase: "acknowledged", severity: "critical", raised_us: 9 }));
  line.say(news("over", { phase: "cleared", raised_us: 8 }));
  line.say(news("new", { phase: "active", raised_us: 7 }));
  line.say(news("worst", { phase: "active", severity: "critical", raised_us: 1 }));
  expect(names()).toEqual(["worst", "new", "over", "seen", "unknown", "well"]);
  expect(unseen()).toEqual(["worst", "new", "over"]);
});

test("what is shelved is not on the bar until its time is over", () => {
  line.say(news("low", { phase: "active", shelved_until_us: 2e6 }));
  expect(unseen()).toEqual([]);
  now = 2e6;
  expect(unseen()).toEqual(["low"]);
});

test("what could not be delivered is on the bar while it stands", () => {
  line.say(news("low", { phase: "acknowledged", undelivered: "no route" }));
  expect(alarms.summary.undelivered.map(({ alarm }) => alarm)).toEqual(["low"]);
  line.say(news("low", { phase: "normal", undelivered: "no route" }));
  expect(alarms.summary.undelivered).toEqual([]);
});

test("what a hub judges that is away is forgotten, and what is judged elsewhere is not", () => {
  line.say(news("low"));
  line.say(news("high", { site: "moon" }));
  const site = { t: "site", site: "agv", online: false, since_us: 1, catalogue: "", loop_ms: 0, skew_ms: 0, why: "", rival_us: 0, away: false } as const;
  line.say(site);
  expect(names()).toEqual(["high", "low"]);
  line.say({ ...site, away: true });
  expect(names()).toEqual(["high"]);
});

test("what is gone, and everything without a connection, is forgotten", () => {
  line.say(news("low"));
  line.say(news("high"));
  line.say(news("low", { gone: true }));
  expect(names()).toEqual(["high"]);
  line.become("lost");
  expect(names()).toEqual([]);
});

test("only what is raised while the page looks on makes a sound, once, and only when it is wanted", () => {
  let beeps = 0;
  const kept = new Map<string, string>();
  const storage = { getItem: (key: string) => kept.get(key) ?? null, setItem: (key: string, value: string) => void kept.set(key, value) };
  const sound = new AlarmSound(storage, { beep: () => (beeps += 1) });
  alarms.subscribe(() => {
    sound.soundIfMore(alarms.raised);
  });
  // It was so before the page came.
  line.say(news("old", { phase: "active", raised_us: 1 }));
  line.say(news("low"));
  line.say(news("low", { phase: "active", raised_us: 2 }));
  expect(beeps).toBe(0);
  sound.setOn(true);
  expect(beeps).toBe(1);
  line.say(news("low", { phase: "active", raised_us: 2, assigned: "ada" }));
  expect(beeps).toBe(1);
  line.say(news("low", { phase: "active", raised_us: 3 }));
  expect(beeps).toBe(2);
  sound.setOn(false);
  line.say(news("low", { phase: "active", raised_us: 4 }));
  expect(beeps).toBe(2);
  // Another page of this browser is silent until somebody has touched it.
  kept.set("talaia-alarm-sound", "on");
  const next = new AlarmSound(storage, { beep: () => (beeps += 1) });
  next.soundIfMore(1);
  expect(beeps).toBe(2);
  next.unlockAudio();
  next.soundIfMore(2);
  expect(beeps).toBe(3);
});

test("what was raised while there was no connection is heard when it is back", () => {
  line.say(news("low"));
  line.say(news("old", { phase: "active", raised_us: 1 }));
  line.become("lost");
  line.say(news("old", { phase: "active", raised_us: 1 }));
  expect(alarms.raised).toBe(0);
  line.say(news("low", { phase: "active", raised_us: 2 }));
  expect(alarms.raised).toBe(1);
});
