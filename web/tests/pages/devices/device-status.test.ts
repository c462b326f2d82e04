import { expect, test } from "vitest";
import { matchesSearch, deviceStatus } from "../../../src/pages/devices/device-status.js";
import { publicOf } from "../../../src/pages/public/public-parts.js";
import type { DeviceShape, DeviceSummary, SignalShape, SiteShape } from "../../../src/generated/api.js";

const row = (change: Partial<DeviceSummary> = {}): DeviceSummary => ({
  site: "agv", site_name: "House vehicle", device: "base", name: "Vehicle base", kind: "vehicle", online: true,
  rights: ["view"], public: false, signals: 4, stale: 0, ...change,
});

test("a device of an unlinked site is offline, whatever its signals say", () => {
  expect(deviceStatus(row({ online: false, stale: 4 }))).toBe("offline");
  expect(deviceStatus(row({ stale: 1 }))).toBe("stale");
  expect(deviceStatus(row())).toBe("online");
});

test("a filter finds all of its words, in any of a device's names", () => {
  expect(matchesSearch(row(), "  HOUSE vehi ", "")).toBe(true);
  expect(matchesSearch(row(), "house arm", "")).toBe(false);
  expect(matchesSearch(row({ public: true }), "public", "")).toBe(true);
  expect(matchesSearch(row(), "", "stale")).toBe(false);
});

test("of a site only what is public stands on the public page, for an operator too", () => {
  const signal = (id: string, open: boolean): SignalShape => ({
    id, address: `base/${id}`, name: id, type: "number", role: "none", unit: "m", decimals: 1, minimum: null, maximum: null, shown: null,
    states: [], meanings: [], frame: "local", max_age: 5, primary: true, public: open, ros: "", channels: [`base/${id}`],
  });
  const device = (id: string, signals: SignalShape[]): DeviceShape => ({
    id, name: id, kind: "other", signals, streams: [], commands: [], drive: null, public: false, link_loss: "", pointing: null, slew: null, unguarded: false, rights: ["use"],
  });
  const detail: SiteShape = {
    site: "agv", name: "A", zone: "UTC", online: true, since_us: 0, last_seen_us: 0, catalogue: "",
    place: null, rules: [], enclosures: [], shown_units: {}, map: null,
    devices: [device("base", [signal("open", true), signal("closed", false)]), device("safe", [signal("own", false)])],
  };
  const shown = publicOf(detail).map((device) => [device.device.id, device.signals.map(({ id }) => id)]);
  expect(shown).toEqual([["base", ["open"]]]);
});
