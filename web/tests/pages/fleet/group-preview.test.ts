import { expect, test } from "vitest";
import type { SharedCommandShape, SiteSummary } from "../../../src/generated/api.js";
import { commandKey, commandsOf, nameList, previewGroup, type GroupFacts } from "../../../src/pages/fleet/group-preview.js";
import { stopSummary, stopWords } from "../../../src/pages/fleet/group-stop-text.js";

const row = (site: string, online = true): SiteSummary => ({
  site, name: site.toUpperCase(), zone: "UTC", online, since_us: 0, last_seen_us: 0, why: "", loop_ms: 0, skew_ms: 0, rival_us: 0, devices: 1, signals: 1, stale: 0,
  group: "", tags: [], state: "", battery: null, latitude: null, longitude: null, moving: false, heading: null, driver: "", stream: "", stops: ["base"],
});
const shared = (sites: readonly string[], barred: readonly string[] = [], unit = ""): SharedCommandShape => ({
  device: "base", device_name: "Base", sites, barred,
  command: {
    id: "wander", name: "Wander", role: "none", description: "", confirm: false, timeout: 10, cancellable: false, needs: null, ros: "",
    arguments: unit === "" ? [] : [{ id: "speed", name: "Speed", type: "number", unit, minimum: null, maximum: null, max_length: 200, default: null }],
  },
});
const NOTHING: GroupFacts = { lockText: () => "", unreachableText: () => "", holderText: () => "" };
const whys = (chosen: readonly SiteSummary[], command: SharedCommandShape, all: readonly SharedCommandShape[], facts = NOTHING): readonly string[] =>
  previewGroup(chosen, command, all, facts).map(({ why }) => why);

test("each site of a group is asked, or it is said why not", () => {
  const command = shared(["a", "b", "locked", "away"], ["looked_at"]);
  const other = shared(["other"], [], "m/s");
  const chosen = [row("a"), row("b", false), row("none"), row("looked_at"), row("other"), row("locked"), row("away")];
  const facts: GroupFacts = {
    ...NOTHING,
    lockText: (site) => (site === "locked" ? "Locked by Rain." : ""),
    unreachableText: (site) => (site === "away" ? "Not reached." : ""),
  };
  expect(whys(chosen, command, [command, other], facts)).toEqual([
    "", "It is offline: nothing is sent, and nothing is kept for later.", "It has no such command.", "You may look at it, but not use it.",
    "Its command of this name takes other arguments.", "Locked by Rain.", "Not reached.",
  ]);
});

test("where somebody acts it is asked all the same, and what will come of it is said before", () => {
  const command = shared(["a"]);
  const [member] = previewGroup([row("a")], command, [command], { ...NOTHING, holderText: () => "Ada is acting on Base" });
  expect(member).toMatchObject({ why: "", note: "Ada is acting on Base: it will refuse. Interrupt on the device's own page." });
});

test("commands that most of the chosen sites have come first, and those that none has are not offered", () => {
  const few = shared(["a"], [], "m/s"), many = shared(["a", "b"]), none = shared(["z"], [], "km/h");
  expect(commandsOf([row("a"), row("b")], [few, none, many])).toEqual([many, few]);
  expect(new Set([few, many, none].map(commandKey)).size).toBe(3);
});

test("a long list of names is cut, and says how many are left", () => {
  expect(nameList(["a", "b", "c", "d"], 2)).toBe("a, b and 2 more");
  expect(nameList(["a", "b"], 2)).toBe("a, b");
});

test("how far STOP got is said in words: confirmed by the robot, latched only, not answered, not reached", () => {
  const at = (phase: "sent" | "latched" | "confirmed", online = true, waitingMs = 0): Parameters<typeof stopWords>[0] => ({ phase, online, waitingMs, answerMs: 12 });
  expect(stopWords(at("confirmed")).text).toContain("the robot's own readings say that it stands still");
  expect(stopWords(at("latched")).text).toContain("has not confirmed");
  expect(stopWords(at("sent", true, 1500)).word).toBe("no answer");
  expect(stopWords(at("sent", false)).text).toContain("Use the stop on the robot");
  expect(stopSummary([at("confirmed"), at("confirmed"), at("latched"), at("sent", false)])).toBe("2 of 4 stopped, 1 latched, 1 not reached");
});
