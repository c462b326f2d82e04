/** What of a site is public. Pure. */

import type { DeviceShape, SignalShape, SiteShape, StreamShape } from "../../generated/api.js";

export interface PublicDevice {
  readonly device: DeviceShape;
  readonly signals: readonly SignalShape[];
  readonly streams: readonly StreamShape[];
}

/** The devices that everybody may know of, each with its public signals and streams only. */
export function publicOf(detail: SiteShape): readonly PublicDevice[] {
  return detail.devices
    .map((device) => ({
      device,
      signals: device.signals.filter((signal) => signal.public),
      streams: device.streams.filter((stream) => stream.public),
    }))
    .filter(({ device, signals, streams }) => device.public || signals.length > 0 || streams.length > 0);
}
