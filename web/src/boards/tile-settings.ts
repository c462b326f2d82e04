/** The settings of a tile: what can be set, as a schema that a form is made of, and how they are read. Pure. */

import type { BoardTileShape, DeviceKind, SignalType } from "../generated/api.js";

export type SettingValue = boolean | number | string | readonly string[];
export type TileSettings = BoardTileShape["settings"];

/** What a field asks for; `signals`, `streams` and `lines` are lists. */
export type SettingKind = "signal" | "signals" | "device" | "stream" | "streams" | "command" | "topic" | "extension" | "text" | "lines" | "number" | "flag" | "choice";

export interface SettingField {
  readonly key: string;
  readonly label: string;
  readonly kind: SettingKind;
  readonly hint?: string;
  /** Without it the tile has nothing to show. */
  readonly needed?: boolean;
  /** Of signals: only these. */
  readonly types?: readonly SignalType[];
  /** Of devices: only these. */
  readonly kinds?: readonly DeviceKind[];
  readonly options?: readonly (readonly [value: string, label: string])[];
  readonly standard?: SettingValue;
  readonly least?: number;
  readonly most?: number;
}

export function settingText(settings: TileSettings, key: string, standard = ""): string {
  const value = settings[key];
  return typeof value === "string" ? value : standard;
}

/** NaN stands for nothing. */
export function settingNumber(settings: TileSettings, key: string, standard = Number.NaN): number {
  const value = settings[key];
  return typeof value === "number" ? value : standard;
}

export function settingFlag(settings: TileSettings, key: string, standard = false): boolean {
  const value = settings[key];
  return typeof value === "boolean" ? value : standard;
}

/** A list; a single text is a list of one. */
export function settingList(settings: TileSettings, key: string): readonly string[] {
  const value = settings[key];
  if (typeof value === "string") return value === "" ? [] : [value];
  return typeof value === "object" ? value : [];
}

/** Whether a field says nothing. */
export function isUnset(settings: TileSettings, key: string): boolean {
  const value = settings[key];
  return value === undefined || value === "" || (Array.isArray(value) && value.length === 0);
}

/** Settings with one of them changed; one that says nothing is left out. */
export function withSetting(settings: TileSettings, key: string, value: SettingValue): TileSettings {
  const next = { ...settings, [key]: value };
  if (!isUnset(next, key)) return next;
  return Object.fromEntries(Object.entries(next).filter(([name]) => name !== key));
}

export interface TextLink {
  readonly label: string;
  readonly href: string;
}

/**
 * Links, a line each: `Manual | https://example.org`, or a page of the dashboard, `/alarms`. Other
 * schemes than http and https are none.
 */
export function linksOf(lines: readonly string[]): readonly TextLink[] {
  return lines.flatMap((line) => {
    const [first = "", second = ""] = line.split("|").map((part) => part.trim());
    const href = second === "" ? first : second;
    const local = href.startsWith("/") && !href.startsWith("//");
    if (!local && !(URL.canParse(href) && /^https?:$/.test(new URL(href).protocol))) return [];
    return [{ label: first, href }];
  });
}
