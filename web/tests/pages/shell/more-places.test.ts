import { expect, test } from "vitest";
import type { Me } from "../../../src/generated/api.js";
import { morePlaces, rowPageOf, sitePages } from "../../../src/pages/shell/more-places.js";

const person: Me = {
  name: "ada", role: "operator", admin: false, factor: false, factor_missing: false, codes_locked_us: 0,
  password: true, idle_ends_us: 0, ends_us: 0,
  permissions: [{ right: "view", site: "agv", device: "base" }],
};
const OBSERVATORY = { observing: true, archived: true };

test("what of a site has no place of its own in the navigation is behind the last one", () => {
  const more = morePlaces("agv", person, { observing: false, archived: false });
  expect(more.map(({ path }) => path)).toEqual(
    ["/boards", ...["logbook", "log", "notes", "missions", "anomalies", "sightings", "review", "recordings", "cameras", "scene", "topics"].map((page) => `/sites/agv/${page}`)],
  );
  // Boards have a place beside the others where the window is wide.
  expect(more.filter(({ spared }) => spared).map(({ path }) => path)).toEqual(["/boards"]);
});

test("an observatory's devices and pictures give way to its night where the window is narrow", () => {
  const spared = (archived: boolean): string[] =>
    morePlaces("obs", person, { ...OBSERVATORY, archived }).filter((place) => place.spared).map(({ path }) => path);
  expect(spared(true)).toEqual(["/boards", "/devices", "/sites/obs/archive"]);
  expect(spared(false)).toEqual(["/boards", "/devices"]);
});

test("guests have all of theirs on one page, and without a site there is nothing more", () => {
  expect(morePlaces("obs", { ...person, role: "guest", permissions: [] }, OBSERVATORY)).toEqual([]);
  expect(morePlaces("", person, OBSERVATORY)).toEqual([]);
});

test("a site's row has every page of it: now, then what was, then the raw matter", () => {
  const all = sitePages("obs", person, { actuable: true, ...OBSERVATORY }).map(({ page }) => page);
  expect(all).toEqual(["live", "drive", "missions", "night", "cameras", "scene", "history", "logbook", "log", "notes", "sightings", "review", "anomalies", "recordings", "archive", "topics"]);
  const vehicle = sitePages("agv", person, { actuable: true, observing: false, archived: false }).map(({ page }) => page);
  expect(vehicle).not.toContain("night");
  expect(vehicle).not.toContain("archive");
});

test("the row of who sees only what is public has nothing behind closed doors; without a site there is none", () => {
  const guest = { ...person, role: "guest", permissions: [] };
  expect(sitePages("obs", guest, { actuable: true, ...OBSERVATORY }).map(({ path }) => path)).toEqual(["/sites/obs/live", "/sites/obs/history"]);
  expect(sitePages("", person, { actuable: true, ...OBSERVATORY })).toEqual([]);
});

test("what is planned for a night belongs to it", () => {
  expect(rowPageOf("forecast")).toBe("night");
  expect(rowPageOf("logbook")).toBe("logbook");
  // Zones are drawn over a camera's picture.
  expect(rowPageOf("zones")).toBe("cameras");
});
