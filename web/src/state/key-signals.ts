/** Which few signals say most about a site. */

import type { DeviceInfo, SignalInfo } from "../wire/api-types.js";

export interface DeviceSignals {
  readonly device: DeviceInfo;
  readonly signals: readonly SignalInfo[];
}

/** The primary signals of each device that has any, at most `count` of each. */
export function primaryByDevice(devices: readonly DeviceInfo[], count: number): readonly DeviceSignals[] {
  return devices
    .map((device) => ({ device, signals: device.signals.filter(isKey).slice(0, count) }))
    .filter(({ signals }) => signals.length > 0);
}

function isKey(signal: SignalInfo): boolean {
  return signal.primary && signal.type !== "position" && signal.type !== "text";
}

/** The first primary signal of each device, then the second of each, and so on. */
export function keySignals(devices: readonly DeviceInfo[], count: number): readonly SignalInfo[] {
  const columns = devices.map((device) =>
    device.signals.filter(isKey),
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
