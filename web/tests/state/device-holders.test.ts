import { beforeEach, expect, test } from "vitest";
import type { CommandUpdate } from "../../src/generated/wire.js";
import { DeviceHolders } from "../../src/state/device-holders.js";
import { FakeLine } from "../controllers/drive/fake-connection.js";

let line: FakeLine;
let now = 0;
let holders: DeviceHolders;
beforeEach(() => {
  now = 10_000;
  line = new FakeLine();
  holders = new DeviceHolders(line, () => now);
});

function news(id: string, acting: string, more: Partial<CommandUpdate> = {}): CommandUpdate {
  return {
    t: "command_news", site: "obs", device: "dome", command: "close", id, phase: "running", message: "", progress: 0,
    who: "Ada", blocked_by: "", acting, acting_s: 4,
    ...more,
  };
}
const words = (): string[] => holders.holdersOf("obs", "dome").map((holder) => holder.words);

test("who acts on a device stands from the first word of it to its end, the newest first", () => {
  line.say(news("1", "Ada is acting on Dome: Close"));
  expect(holders.holdersOf("obs", "dome")[0]?.since).toBe(6000);
  now = 12_000;
  line.say(news("1", "Ada is acting on Dome: Close", { acting_s: 6.3, progress: 0.5 }));
  expect(holders.holdersOf("obs", "dome")[0]?.since).toBe(6000);
  line.say(news("2", "Bob is acting on Dome: Open", { acting_s: 0 }));
  line.say(news("3", "Eve is acting on Roof: Open", { device: "roof" }));
  expect(words()).toEqual(["Bob is acting on Dome: Open", "Ada is acting on Dome: Close"]);
  line.say(news("2", "", { phase: "succeeded" }));
  expect(words()).toEqual(["Ada is acting on Dome: Close"]);
});

test("one who was interrupted acts no longer, though the command goes on", () => {
  line.say(news("1", "Ada is acting on Dome: Close"));
  line.say(news("1", "", { message: "interrupted by Bob (Dome: Open)" }));
  expect(words()).toEqual([]);
});

test("nobody is said to act at a site that is away, or on a line that is cut", () => {
  line.say(news("1", "Ada is acting on Dome: Close"));
  line.say({ t: "site", site: "obs", online: false } as never);
  expect(words()).toEqual([]);
  line.say(news("1", "Ada is acting on Dome: Close"));
  line.become("lost");
  expect(words()).toEqual([]);
});
