/** The channels of a site that have a history, and how they share charts. */

import { msg, str } from "@lit/localize";
import { shownUnit } from "../../../format/unit.js";
import type { DeviceShape, ShownUnitShape, SignalShape, SiteShape, StoredShape } from "../../../generated/api.js";

/** One channel that can be chosen. */
export interface ChannelRow {
  readonly address: string;
  readonly device: Pick<DeviceShape, "id" | "name">;
  readonly name: string;
  readonly type: "number" | "state" | "text";
  /** As they are shown; see `format/unit.ts`. */
  readonly unit: string;
  readonly decimals: number;
  /** How stored values are shown; null: as they are. */
  readonly shown: ShownUnitShape | null;
  readonly states: readonly string[];
  /** s */
  readonly maxAge: number;
  readonly primary: boolean;
  /** The site's description had it once, and has it no longer. */
  readonly former: boolean;
}

/** Rows that are drawn in one chart: numbers of a unit or a few, or one state, or one text. */
export interface ChartGroup {
  readonly key: string;
  readonly title: string;
  readonly type: ChannelRow["type"];
  readonly rows: readonly ChannelRow[];
}

const TYPES = ["number", "state", "text", "position"] as const satisfies readonly SignalShape["type"][];
const PART_UNITS: Readonly<Record<string, string>> = { x: "m", y: "m", yaw: "rad", lat: "°", lon: "°", alt: "m" };
const DEGREE_DIGITS = 6;
/** Of a former signal its limit of age (s) is not known: what descriptions take when they say nothing. */
const FORMER_AGE = 5;
/** Chosen when the address chooses nothing. */
const FIRST_CHOICE = 2;

/** @param former channels that have history and are no longer described; they come last */
export function channelRows(detail: SiteShape, former: readonly StoredShape[] = []): ChannelRow[] {
  const rows = detail.devices.flatMap((device) =>
    device.signals.flatMap((signal) => signal.channels.map((channel) => rowOf(detail, device, signal, channel))),
  );
  // What has come back since they were asked for stands under its device.
  const described = new Set(rows.map(({ address }) => address));
  return [...rows, ...former.filter(({ address }) => !described.has(address)).map((stored) => formerRow(detail, stored))];
}

function formerRow(detail: SiteShape, { address, name, unit, type, states, decimals }: StoredShape): ChannelRow {
  const id = address.split("/")[0] ?? "";
  const device = detail.devices.find((device) => device.id === id) ?? { id, name: id };
  const kind = TYPES.find((known) => known === type) ?? "number";
  const shown = kind === "number" ? (detail.shown_units[unit] ?? null) : null;
  const signal = { name: name || address, type: kind, unit, states, decimals, shown, max_age: FORMER_AGE, primary: false };
  return { ...rowOf(detail, device, signal, address), former: true };
}

/** What to show to somebody who has not chosen: the first main numbers. */
export function firstChoice(rows: readonly ChannelRow[]): string[] {
  const numbers = rows.filter(({ type }) => type === "number");
  const main = numbers.filter(({ primary }) => primary);
  return (main.length > 0 ? main : numbers).slice(0, FIRST_CHOICE).map(({ address }) => address);
}

/**
 * Puts numbers of one unit together, in the order of the description.
 *
 * @param axes so many units may share a chart
 */
export function groupChannels(rows: readonly ChannelRow[], axes = 1): ChartGroup[] {
  const found = new Map<string, { title: string; type: ChannelRow["type"]; rows: ChannelRow[] }>();
  for (const row of rows) {
    const key = row.type === "number" && row.unit !== "" ? msg(str`unit ${row.unit}`) : row.address;
    const group = found.get(key) ?? { title: row.type === "number" ? row.unit : row.name, type: row.type, rows: [] };
    found.set(key, group);
    group.rows.push(row);
  }
  const groups = [...found].map(([key, group]) => ({ key, ...group }));
  return axes > 1 ? joinGroups(groups, axes) : groups;
}

/** The units among some rows. */
export function unitsOf(rows: readonly ChannelRow[]): string[] {
  return [...new Set(rows.filter(({ type }) => type === "number").map(({ unit }) => unit))];
}

// Numbers first, since what is joined may have stood anywhere; numbers without a unit are one unit here.
function joinGroups(groups: readonly ChartGroup[], axes: number): ChartGroup[] {
  const numbers = groups.filter(({ type }) => type === "number").flatMap(({ rows }) => rows);
  const units = unitsOf(numbers);
  const charts = Array.from({ length: Math.ceil(units.length / axes) }, (_, i): ChartGroup => {
    const own = units.slice(i * axes, (i + 1) * axes);
    const rows = numbers.filter(({ unit }) => own.includes(unit));
    return { key: msg(str`units ${own.join(" ")}`), title: own.map((unit) => unit || msg("no unit")).join(", "), type: "number", rows };
  });
  return [...charts, ...groups.filter(({ type }) => type !== "number")];
}

type DescribedChannel = Pick<SignalShape, "name" | "type" | "unit" | "states" | "decimals" | "shown" | "max_age" | "primary">;

function rowOf(detail: SiteShape, device: ChannelRow["device"], signal: DescribedChannel, channel: string): ChannelRow {
  const plain = { address: channel, device, shown: signal.shown, states: [], maxAge: signal.max_age, primary: signal.primary, former: false } as const;
  if (signal.type !== "position") {
    return { ...plain, name: signal.name, type: signal.type, ...shownUnit(signal), states: signal.states };
  }
  const part = channel.slice(channel.lastIndexOf(".") + 1);
  const stored = PART_UNITS[part] ?? "";
  const shown = detail.shown_units[stored] ?? null;
  const { unit, decimals } = shownUnit({ unit: stored, decimals: stored === "°" ? DEGREE_DIGITS : -1, shown });
  return { ...plain, name: `${signal.name}, ${part}`, type: "number", unit, decimals, shown };
}
