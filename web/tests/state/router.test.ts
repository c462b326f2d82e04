import { readdirSync, readFileSync } from "node:fs";
import { describe, expect, test } from "vitest";
import { alarmPath, devicePath, localPath, returnPath, routeOf, sitePath } from "../../src/state/router.js";

describe("addresses", () => {
  test.each([
    ["/", "home", ""],
    ["/home", "home", ""],
    ["/home/", "home", ""],
    ["/login", "login", ""],
    ["/sites/agv/live", "live", "agv"],
    ["/sites/a%20b/history", "history", "a b"],
    ["/sites/agv/drive/", "drive", "agv"],
    ["/sites/agv", "missing", ""],
    ["/sites/agv/home", "missing", ""],
    ["/sites/%E0%A4%A/live", "missing", ""],
    ["/sites/agv/sightings", "sightings", "agv"],
    ["/elsewhere", "missing", ""],
    ["/constructor", "missing", ""],
    ["/logout", "logout", ""],
    ["/devices", "devices", ""],
    ["/public", "public", ""],
    ["/account/", "account", ""],
    ["/admin", "people", ""],
    ["/admin/people", "people", ""],
    ["/admin/roles", "roles", ""],
    ["/admin/gateways", "gateways", ""],
    ["/admin/clients", "clients", ""],
    ["/admin/storage", "storage", ""],
    ["/admin/audit", "audit", ""],
    ["/admin/support", "support", ""],
    ["/admin/constructor", "missing", ""],
    ["/sites/agv/devices", "missing", ""],
    ["/sites/agv/devices/a/b", "missing", ""],
    ["/sites/agv/live/base", "missing", ""],
  ])("%s is the page %s of site '%s'", (path, page, site) => {
    expect(routeOf(path)).toEqual({ page, site, device: "" });
  });

  test("a site's path leads back to the site, whatever it is called", () => {
    for (const site of ["agv", "a/b", "ü ?#%", ".."]) expect(routeOf(sitePath(site, "live")).site).toBe(site);
  });
});

test("a device's path leads back to the device, whatever it is called", () => {
  for (const device of ["base", "a/b", "ü ?#%", ".."]) {
    expect(routeOf(devicePath("s", device))).toEqual({ page: "device", site: "s", device });
  }
});

describe("the way back after signing in", () => {
  const origin = "https://hub.example";
  test.each([
    ["?return=%2Fsites%2Fagv%2Flive%3Fa%3D1", "/sites/agv/live?a=1"],
    ["", "/home"],
    ["?return=https%3A%2F%2Fevil.test%2F", "/home"],
    ["?return=%2F%2Fevil.test%2Fhome", "/home"],
    ["?return=%2F%5Cevil.test", "/home"],
    ["?return=%2F%09%2Fevil.test", "/home"],
    ["?return=javascript%3Aalert(1)", "/home"],
    ["?return=%2Flogin%3Freturn%3D%2Flogin", "/home"],
    ["?return=%2Flogout", "/home"],
  ])("%s leads to %s", (search, path) => {
    expect(returnPath(search, origin)).toBe(path);
  });
});

describe("a link", () => {
  test.each([
    ["https://hub.example/home", "/home"],
    ["https://hub.example/sites/agv/history?x=1", "/sites/agv/history?x=1"],
    ["https://hub.example/api/export.csv", null],
    ["https://elsewhere.example/home", null],
    ["mailto:a@b.example", null],
    ["nonsense", null],
  ])("to %s is ours as %s", (href, path) => {
    expect(localPath(href, "https://hub.example")).toBe(path);
  });
});

test("an alarm has an address on the page of alarms", () => {
  expect(alarmPath({ site: "agv", alarm: "battery_low" })).toBe("/alarms?alarm=agv/battery_low");
});

describe("links of our pages", () => {
  const folder = new URL("../../src/", import.meta.url);
  // Read, not imported: coverage would take each for a file without lines.
  const files = readdirSync(folder, { recursive: true }).filter((name) => name.endsWith(".ts"));
  const written = files.flatMap((file) =>
    // What is put together is left out, and so is what the hub serves itself.
    [...readFileSync(new URL(file, folder), "utf8").matchAll(/href="(\/[^"$]*)"/g)].map(([, path]) => ({ file, path: path ?? "" })),
  );

  test("lead to pages that are there", () => {
    expect(written.length).toBeGreaterThan(5);
    expect(written.filter(({ path }) => path !== "/" && routeOf(path).page === "missing")).toEqual([]);
  });
});
