import { describe, expect, test } from "vitest";
import type { SiteSummary } from "../../../src/generated/api.js";
import { fleetGroups, tagsOf } from "../../../src/pages/home/fleet-list.js";
import { fleetRobots } from "../../../src/pages/map/fleet-robots.js";
import { placeText } from "../../../src/tiles/site-glance.js";
import { troublesOf } from "../../../src/tiles/site-trouble.js";

const row = (site: string, more: Partial<SiteSummary> = {}): SiteSummary => ({
  site, name: site, zone: "UTC", online: true, since_us: 0, last_seen_us: 0, why: "", loop_ms: 0, skew_ms: 0, rival_us: 0, devices: 1, signals: 1, stale: 0,
  group: "", tags: [], state: "", battery: null, latitude: null, longitude: null, moving: false, heading: null, driver: "", stream: "", stops: [], ...more,
});
const ALL = { words: "", tag: "", order: "name" } as const;
const sites = (rows: readonly SiteSummary[], query: Parameters<typeof fleetGroups>[1], troubles: Parameters<typeof fleetGroups>[2] = new Map()): string[] =>
  fleetGroups(rows, query, troubles).flatMap((group) => group.rows.map(({ site }) => site));

describe("many sites", () => {
  test("stand under their groups, those in none last, by name as people count", () => {
    const rows = [row("r10", { group: "North" }), row("lone"), row("r9", { group: "North" }), row("a", { group: "East" })];
    expect(fleetGroups(rows, ALL, new Map()).map(({ name, rows: found }) => [name, found.map(({ site }) => site)])).toEqual([["East", ["a"]], ["North", ["r9", "r10"]], ["", ["lone"]]]);
  });

  test("are found by all words, in names, tags, states and drivers, without regard to case and accents", () => {
    const rows = [row("p", { name: "Peña", tags: ["indoor"] }), row("q", { state: "Dock: charging", driver: "Ana" })];
    expect(sites(rows, { ...ALL, words: "pena INDOOR" })).toEqual(["p"]);
    expect(sites(rows, { ...ALL, words: "charg ana" })).toEqual(["q"]);
    expect(sites(rows, { ...ALL, words: "pena ana" })).toEqual([]);
    expect(sites(rows, { ...ALL, tag: "indoor" })).toEqual(["p"]);
    expect(tagsOf(rows)).toEqual(["indoor"]);
  });

  test("come with trouble first: critical alarms, then who is away, then warnings", () => {
    const rows = [row("well"), row("warned"), row("away", { online: false }), row("burning")];
    const troubles = new Map([["burning", { bad: 1, warn: 0 }], ["warned", { bad: 0, warn: 2 }]]);
    expect(sites(rows, { ...ALL, order: "trouble" }, troubles)).toEqual(["burning", "away", "warned", "well"]);
  });

  test("come by battery with the unknown ones last, and by when they were heard", () => {
    const rows = [row("x"), row("full", { battery: 90 }), row("low", { battery: 5 })];
    expect(sites(rows, { ...ALL, order: "battery" })).toEqual(["low", "full", "x"]);
    const heard = [row("old", { online: false, last_seen_us: 1 }), row("new", { online: false, last_seen_us: 2 }), row("now")];
    expect(sites(heard, { ...ALL, order: "heard" })).toEqual(["now", "new", "old"]);
  });

  test("are sorted in a moment, a thousand of them", () => {
    const rows = Array.from({ length: 1000 }, (_, i) => row(`site${String(i)}`, { group: `G${String(i % 20)}`, tags: ["t"] }));
    const began = performance.now();
    fleetGroups(rows, { words: "site t", tag: "t", order: "trouble" }, new Map());
    expect(performance.now() - began).toBeLessThan(500);
  });
});

test("alarms count until somebody settles them, and shelved ones do not", () => {
  const alarm = (site: string, severity: string, phase: string): never => ({ site, severity, phase }) as never;
  const list = [alarm("a", "critical", "active"), alarm("a", "warning", "acknowledged"), alarm("a", "critical", "normal"), alarm("b", "info", "active")];
  expect([...troublesOf({ list, isShelved: () => false })]).toEqual([["a", { bad: 1, warn: 1 }], ["b", { bad: 0, warn: 0 }]]);
  expect([...troublesOf({ list, isShelved: () => true })]).toEqual([]);
});

test("a robot that is away, or only described, is drawn as old; where nothing is known it is left out", () => {
  const rows = [row("live", { name: "Live one", latitude: 1, longitude: 2, moving: true, heading: 30 }), row("site", { latitude: 3, longitude: 4 }), row("nowhere")];
  const robots = fleetRobots(rows, new Map([["live", { bad: 0, warn: 1 }]]));
  expect(robots.map(({ id, name, stale, trouble, heading }) => [id, name, stale, trouble, heading])).toEqual([["live", "Live one", false, "warn", 30], ["site", "site", true, "", Number.NaN]]);
});

test("a place is told by hemispheres, not by signs", () => {
  expect(placeText(-33.5, 151.25)).toBe("33.50000° S, 151.25000° E");
});
