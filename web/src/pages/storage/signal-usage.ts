/** What each signal takes: its channels together, filtered and sorted. */

import type { Sorting } from "../../elements/layout/data-table.js";
import type { ChannelStorageShape } from "../../generated/api.js";

export interface SignalUse {
  readonly site: string;
  /** `device/signal`, without a channel's part. */
  readonly address: string;
  readonly name: string;
  readonly channels: readonly string[];
  readonly described: boolean;
  readonly samples: number;
  readonly bytes: number;
  readonly dayBytes: number;
  readonly firstUs: number;
  readonly lastUs: number;
  /** 0: for good. */
  readonly keepDays: number;
}

export type SortKey = "name" | "bytes" | "day" | "samples" | "first" | "keep";

/** The largest first. */
export const FIRST_SORTING: Sorting<SortKey> = { by: "bytes", down: true };

export function signalUsage(channels: readonly ChannelStorageShape[]): SignalUse[] {
  const found = new Map<string, ChannelStorageShape[]>();
  for (const channel of channels) {
    const key = `${channel.site}\n${signalOf(channel.address)}`;
    const group = found.get(key);
    if (group === undefined) found.set(key, [channel]);
    else group.push(channel);
  }
  return [...found.values()].flatMap((group) => {
    const [first] = group;
    if (first === undefined) return [];
    const address = signalOf(first.address);
    return [
      {
        site: first.site,
        address,
        name: first.name || address,
        channels: group.map((channel) => channel.address),
        described: group.some(({ described }) => described),
        samples: sum(group.map(({ samples }) => samples)),
        bytes: sum(group.map(({ bytes }) => bytes)),
        dayBytes: sum(group.map(({ day_bytes }) => day_bytes)),
        firstUs: Math.min(...group.map(({ first_us }) => first_us)),
        lastUs: Math.max(...group.map(({ last_us }) => last_us)),
        keepDays: Math.max(...group.map(({ keep_days }) => keep_days)),
      },
    ];
  });
}

/** Those that all words of a filter fit. */
export function filterSignals(signals: readonly SignalUse[], filter: string): readonly SignalUse[] {
  const words = filter.toLowerCase().split(/\s+/).filter(Boolean);
  if (words.length === 0) return signals;
  return signals.filter(({ site, address, name }) => {
    const text = `${site} ${address} ${name}`.toLowerCase();
    return words.every((word) => text.includes(word));
  });
}

export function sortSignals(signals: readonly SignalUse[], { by, down }: Sorting<SortKey>): SignalUse[] {
  const sign = down ? -1 : 1;
  const ordered = [...signals];
  ordered.sort((a, b) => sign * compareSignals(a, b, by) || a.site.localeCompare(b.site) || a.address.localeCompare(b.address));
  return ordered;
}

/** The same column turns round; another begins with what one looks for there. */
export function toggleSorting(now: Sorting<SortKey>, by: SortKey): Sorting<SortKey> {
  return now.by === by ? { by, down: !now.down } : { by, down: by !== "name" && by !== "first" };
}

function compareSignals(a: SignalUse, b: SignalUse, by: SortKey): number {
  if (by === "name") return a.name.localeCompare(b.name);
  return numberOf(a, by) - numberOf(b, by);
}

function numberOf(use: SignalUse, by: Exclude<SortKey, "name">): number {
  switch (by) {
    case "bytes":
      return use.bytes;
    case "day":
      return use.dayBytes;
    case "samples":
      return use.samples;
    case "first":
      return use.firstUs;
    case "keep":
      // For good is longest.
      return use.keepDays || Number.MAX_VALUE;
  }
}

function signalOf(address: string): string {
  return address.split(".")[0] ?? address;
}

function sum(numbers: readonly number[]): number {
  return numbers.reduce((total, number) => total + number, 0);
}
