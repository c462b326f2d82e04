/** What people call the signals of a site, by their addresses. */

import type { SiteShape } from "../generated/api.js";

const known = new WeakMap<SiteShape, ReadonlyMap<string, string>>();

/** `Battery, Voltage` by `power/voltage`; the same map as long as the description is the same. */
export function signalLabels(detail: SiteShape): ReadonlyMap<string, string> {
  let labels = known.get(detail);
  if (labels === undefined) {
    labels = new Map(detail.devices.flatMap((device) => device.signals.map((signal) => [signal.address, `${device.name}, ${signal.name}`])));
    known.set(detail, labels);
  }
  return labels;
}
