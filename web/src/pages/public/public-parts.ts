/** What of a site is public. Pure. */

import type { DeviceInfo, SignalInfo, SiteDetail, StreamInfo } from "../../wire/api-types.js";

export interface PublicDevice {
  readonly device: DeviceInfo;
  readonly signals: readonly SignalInfo[];
  readonly streams: readonly StreamInfo[];
}

/** The devices that everybody may know of, each with its public signals and streams only. */
export function publicOf(detail: SiteDetail): readonly PublicDevice[] {
  return detail.devices
    .map((device) => ({
      device,
      signals: device.signals.filter((signal) => signal.public),
      streams: device.streams.filter((stream) => stream.public),
    }))
    .filter(({ device, signals, streams }) => device.public || signals.length > 0 || streams.length > 0);
}
