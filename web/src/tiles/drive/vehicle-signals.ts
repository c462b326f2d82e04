/** Which signals of a site tell how a vehicle stands: by their roles, then by their units. Pure. */

import type { DeviceShape, SignalShape, SiteShape } from "../../generated/api.js";
import { headingOfYaw } from "../../elements/map/geodesy.js";
import { frameOf } from "../map/site-overlays.js";

/** What the description has of them. */
export interface VehicleSignals {
  /** m/s */
  readonly speed: SignalShape | undefined;
  readonly position: SignalShape | undefined;
  readonly battery: SignalShape | undefined;
}

export function vehicleSignals(detail: SiteShape, device: DeviceShape): VehicleSignals {
  const all = detail.devices.flatMap(({ signals }) => signals);
  const charge = (signals: readonly SignalShape[]): SignalShape | undefined => signals.find(({ role }) => role === "battery.level");
  const address = device.drive?.position ?? "";
  return {
    speed: device.signals.find(({ role }) => role === "vehicle.speed") ?? device.signals.find(({ type, unit }) => type === "number" && unit === "m/s"),
    position: address === "" ? undefined : all.find((signal) => signal.address === address),
    // Its own, or the only one there is: of two others nobody knows which it runs on.
    battery: charge(device.signals) ?? (all.filter(({ role }) => role === "battery.level").length === 1 ? charge(all) : undefined),
  };
}

/** Where a vehicle points: from true north where that is known, else in its own frame. */
export interface VehicleHeading {
  /** °, clockwise from true north; with `local` counter-clockwise from x. NaN: not known. */
  readonly degrees: number;
  readonly local: boolean;
}

/** @param yaw - of the position's own frame (rad, counter-clockwise); NaN: not known */
export function vehicleHeading(detail: SiteShape, yaw: number): VehicleHeading {
  const frame = frameOf(detail.map);
  if (frame !== null) return { degrees: headingOfYaw(yaw, frame.heading), local: false };
  const degrees = (yaw * 180) / Math.PI;
  // Of what has turned more than once only the rest is of interest.
  return { degrees: degrees - 360 * Math.round(degrees / 360), local: true };
}
