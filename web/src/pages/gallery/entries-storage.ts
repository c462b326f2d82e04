/** What the history takes, in its states. */

import { html } from "lit";
import type { SignalUse } from "../storage/signal-usage.js";
import type { GalleryEntry } from "./entry.js";
import "../storage/storage-table.js";

const NOON_US = 1_780_000_000_000_000;
const DAY_US = 86_400_000_000;

function use(name: string, bytes: number, change: Partial<SignalUse> = {}): SignalUse {
  const address = `base/${name.toLowerCase().replaceAll(" ", "_")}`;
  return {
    site: "agv", address, name, channels: [address], described: true, samples: Math.round(bytes / 4), bytes, dayBytes: bytes / 90,
    firstUs: NOON_US - 90 * DAY_US, lastUs: NOON_US, keepDays: 0, ...change,
  };
}

const SIGNALS: readonly SignalUse[] = [
  use("Speed", 3.1e9),
  use("Motor temperature", 6.4e8, { keepDays: 30, firstUs: NOON_US - 30 * DAY_US }),
  use("Oil pressure", 9.2e7, { described: false, dayBytes: 0, lastUs: NOON_US - 40 * DAY_US }),
  use("A name that somebody has made rather long, to see where it goes", 812_000),
];

export const entries: readonly GalleryEntry[] = [
  {
    tag: "t-storage-table",
    wide: true,
    states: [
      { name: "a few signals", show: () => html`<t-storage-table .signals=${SIGNALS}></t-storage-table>` },
      { name: "of one day", show: () => html`<t-storage-table .signals=${[use("Speed", 4_000, { firstUs: NOON_US })]}></t-storage-table>` },
    ],
  },
];
