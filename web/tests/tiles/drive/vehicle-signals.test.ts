import { expect, test } from "vitest";
import type { DeviceShape, SignalShape, SiteShape } from "../../../src/generated/api.js";
import { vehicleHeading, vehicleSignals } from "../../../src/tiles/drive/vehicle-signals.js";
import { NO_DEVICE } from "../../../src/tiles/observatory/device-part.js";

function signal(address: string, more: Partial<SignalShape> = {}): SignalShape {
  return {
    id: address.split("/")[1] ?? "", address, name: address, type: "number", role: "none", unit: "", decimals: 2, minimum: null, maximum: null, states: [], meanings: [],
    frame: "", max_age: 1, primary: true, public: false, ros: "", channels: [address], shown: null, ...more,
  };
}
const charge = (address: string): SignalShape => signal(address, { role: "battery.level", unit: "%" });
const BASE: DeviceShape = {
  ...NO_DEVICE,
  id: "base",
  signals: [signal("base/wheel", { unit: "m/s" }), signal("base/speed", { unit: "m/s", role: "vehicle.speed" })],
  drive: { max_speed: 1, max_sideways: 0,
    max_steering: 0,
    ptz: false,
    joints: [],
    max_reverse: 1, max_turn: 1, rate: 20, ttl: 0.25, lease: 3, picture: "", position: "gps/pose", stop: true, shown_speed: null, shown_turn: null },
};
const site = (...others: readonly DeviceShape[]): SiteShape => ({
  site: "agv", name: "", zone: "UTC", online: true, since_us: 0, last_seen_us: 0, catalogue: "", place: null, devices: [BASE, ...others], rules: [], enclosures: [], map: null,
} as unknown as SiteShape);
const other = (id: string, ...signals: readonly SignalShape[]): DeviceShape => ({ ...NO_DEVICE, id, signals });

test("speed goes by its role, and the position by what the drive names, wherever it is", () => {
  const found = vehicleSignals(site(other("gps", signal("gps/pose", { type: "position" }))), BASE);
  expect(found.speed?.id).toBe("speed");
  expect(found.position?.address).toBe("gps/pose");
  expect(vehicleSignals(site(), BASE).position).toBeUndefined();
});

test("the battery is its own, or the only one there is; of two others nobody knows which", () => {
  const power = other("power", charge("power/charge"));
  expect(vehicleSignals(site(power), BASE).battery?.address).toBe("power/charge");
  expect(vehicleSignals(site(power, other("arm", charge("arm/charge"))), BASE).battery).toBeUndefined();
  const own = { ...BASE, signals: [charge("base/charge")] };
  expect(vehicleSignals(site(power), own).battery?.address).toBe("base/charge");
});

test("a heading is from true north where the site says where its frame lies, else of that frame", () => {
  const map = { origin: { latitude: 42, longitude: 1, heading: 90 } };
  expect(vehicleHeading({ ...site(), map } as unknown as SiteShape, Math.PI / 2)).toEqual({ degrees: 0, local: false });
  expect(vehicleHeading(site(), 0.5 * Math.PI + 4 * Math.PI).degrees).toBeCloseTo(90);
  expect(vehicleHeading(site(), -Math.PI / 3)).toEqual({ degrees: expect.closeTo(-60) as number, local: true });
  expect(vehicleHeading(site(), Number.NaN).degrees).toBeNaN();
});
