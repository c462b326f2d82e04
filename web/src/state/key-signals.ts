/** Which few signals say most about a site. */

import type { DeviceInfo, SignalInfo } from "../wire/api.js";

/** The first primary signal of each device, then the second of each, and so on. */
export function keySignals(devices: readonly DeviceInfo[], count: number): readonly SignalInfo[] {
  const columns = devices.map((device) =>
    device.signals.filter((signal) => signal.primary && signal.type !== "position" && signal.type !== "text"),
  );
  const longest = Math.max(0, ...columns.map((column) => column.length));
  const chosen: SignalInfo[] = [];
  for (let row = 0; row < longest; row++) {
    for (const column of columns) {
      const signal = column[row];
      if (signal !== undefined && chosen.length < count) chosen.push(signal);
    }
  }
  return chosen;
}
