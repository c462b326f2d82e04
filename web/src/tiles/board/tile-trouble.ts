/** Why a tile has nothing to show: it was told nothing yet, or what it names is not there for this person. Pure. */

import { msg, str } from "@lit/localize";
import { findCommand, findDevice, findSignal, findSignals, findStream, findStreams } from "../../boards/references.js";
import { isUnset, settingList, settingText, type SettingField, type TileSettings } from "../../boards/tile-settings.js";
import type { BoardTileContext, BoardTileEntry } from "./board-tile-entry.js";

export interface TileTrouble {
  readonly kind: "empty" | "forbidden";
  readonly what: string;
}

const CHOOSE: Readonly<Partial<Record<SettingField["kind"], string>>> = {
  signal: msg("Choose a signal"), signals: msg("Choose signals"), device: msg("Choose a device"), stream: msg("Choose a camera"),
  streams: msg("Choose cameras"), command: msg("Choose a command"), topic: msg("Choose a topic"), extension: msg("Choose a tile"),
};

/** What it names beside others that are there, and is not: the tile is drawn without it. */
export function missingNames(entry: BoardTileEntry, settings: TileSettings, context: BoardTileContext): readonly string[] {
  return entry.settings.flatMap(({ key, kind }) => {
    const list = settingList(settings, key);
    const missing = list.filter((name) => (kind === "signals" ? findSignal(name, context) : kind === "streams" ? findStream(name, context) : name) === null);
    return missing.length < list.length ? missing : [];
  });
}

/** Null where it can be drawn. */
export function tileTrouble(entry: BoardTileEntry, settings: TileSettings, context: BoardTileContext): TileTrouble | null {
  for (const field of entry.settings) {
    if (isUnset(settings, field.key)) {
      if (field.needed !== true) continue;
      return { kind: "empty", what: CHOOSE[field.kind] ?? msg(str`Set: ${field.label.toLowerCase()}`) };
    }
    if (!isFound(field, settings, context)) {
      return { kind: "forbidden", what: settingList(settings, field.key).join(", ") || settingText(settings, field.key) };
    }
  }
  return null;
}

/** Whether what a field names is there; of several, any. The hub tells what is hidden no better than what is missing. */
function isFound({ key, kind, kinds }: SettingField, settings: TileSettings, context: BoardTileContext): boolean {
  const text = settingText(settings, key);
  const list = settingList(settings, key);
  switch (kind) {
    case "signal":
      return findSignal(text, context) !== null;
    case "signals":
      return findSignals(list, context).length > 0;
    case "device": {
      const device = findDevice(text, context);
      return device !== null && (kinds === undefined || kinds.includes(device.kind));
    }
    case "stream":
      return findStream(text, context) !== null;
    case "streams":
      return findStreams(list, context).length > 0;
    case "command":
      return findCommand(text, context) !== null;
    case "extension":
      return context.extensions.some(({ name }) => name === text);
    case "topic":
    case "text":
    case "lines":
    case "number":
    case "flag":
    case "choice":
      return true;
  }
}
