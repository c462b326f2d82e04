/** Every tile that a board can have, in each of its states: fresh, empty, old, away, closed to the person, failing. */

import { html, type TemplateResult } from "lit";
import { styled } from "../../elements/base/style-directive.js";
import type { TileSettings } from "../../boards/tile-settings.js";
import { BOARD_TILES } from "../../tiles/board/board-catalog.js";
import type { BoardTileEntry } from "../../tiles/board/board-tile-entry.js";
import "../../tiles/board/board-tile.js";
import type { GalleryEntry, GalleryState } from "./entry.js";
import { madeContext } from "./made-up/scope.js";
import type { Mood } from "./made-up/answers.js";

/** What each is told to show, by its type; nothing where it needs to be told nothing. */
const SHOWN: Readonly<Record<string, TileSettings>> = {
  value: { signal: "base/battery" },
  chart: { signals: ["base/speed", "base/turn"], least: "0.1", most: "0.3" },
  xy: { x: "base/speed", y: "base/turn" },
  timeline: { signals: ["base/mode", "dome/shutter"] },
  gauge: { signal: "base/battery", warn_below: "20" },
  table: { device: "base" },
  text: { text: ["The dome's motor is greased each May.", "Ask Marta before you open it by hand."], links: ["Manual | https://example.org", "Alarms | /alarms"] },
  camera: { stream: "base/front" },
  trail: { signal: "base/pose" },
  command: { command: "base/wander" },
  drive: { device: "base" },
  topic: { topic: "/odom", fields: ["twist.linear.x"] },
  parameters: { device: "lidar" },
  lifecycle: { device: "lidar" },
  device: { device: "power" },
  dome: { device: "dome" },
  weather: { device: "weather" },
  sky: { device: "telescope" },
  extension: { tile: "wheel", device: "base" },
};
const WORDS: Readonly<Record<Mood, string>> = {
  live: "fresh", empty: "nothing has come yet", stale: "what there is, is old", away: "the gateway is not connected", barred: "the hub lets the person see nothing of it", failing: "the hub cannot answer, the devices are not reached",
};
/** These read nothing of the hub. */
const PLAIN = ["text"];

function renderTile({ type, desktop, phone }: BoardTileEntry, settings: TileSettings, mood: Mood): TemplateResult {
  const tile = { id: "t1", type, title: "", settings: { ...settings }, desktop: null, phone: null };
  return html`<t-made-scope .mood=${mood} ${styled({ "--rows": String(desktop[1]), "--phone-rows": String(phone[1]) })}><t-board-tile .tile=${tile} .context=${madeContext(mood)}></t-board-tile></t-made-scope>`;
}

/** What its settings name is not there, or not for this person. */
function barredSettings({ settings }: BoardTileEntry): TileSettings {
  const told = settings.filter(({ kind }) => ["signal", "signals", "device", "stream", "streams", "command", "extension"].includes(kind));
  return Object.fromEntries(told.map(({ key, kind }) => [key, kind === "signals" || kind === "streams" ? ["vault/door"] : "vault/door"]));
}

function tileStates(entry: BoardTileEntry): readonly GalleryState[] {
  const settings = SHOWN[entry.type] ?? {};
  const barred = barredSettings(entry);
  const moods = (Object.keys(WORDS) as Mood[]).filter((mood) => mood === "live" || !PLAIN.includes(entry.type));
  return [
    ...moods.map((mood): GalleryState => ({ name: WORDS[mood], show: () => renderTile(entry, settings, mood) })),
    ...(entry.type === "extension" ? [{ name: "its file is not there", show: () => renderTile(entry, { tile: "broken", device: "base" }, "live") }] : []),
    { name: "told nothing yet", show: () => renderTile(entry, {}, "live") },
    ...(Object.keys(barred).length === 0 ? [] : [{ name: "what it names is not open to the person", show: () => renderTile(entry, barred, "live") }]),
  ];
}

/** One section for each tile, by the tile's type. */
export const TILE_SECTIONS: ReadonlyMap<string, GalleryEntry> = new Map(
  BOARD_TILES.map((entry) => [entry.type, { tag: `tile-${entry.type}`, title: entry.title, states: tileStates(entry), least: entry.desktop[0] * 6 }]),
);
