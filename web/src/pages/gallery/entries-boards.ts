/** Boards: the tile around everything in its states, the grid, and the gauge. */

import { html, type TemplateResult } from "lit";
import { map } from "lit/directives/map.js";
import { PaintScheduler } from "../../elements/chart/paint-scheduler.js";
import type { NamedItem } from "../../elements/board/board-grid.js";
import type { BoardTileShape, SiteShape } from "../../generated/api.js";
import "../../elements/board/board-grid.js";
import "../../elements/layout/card.js";
import "../../elements/values/gauge.js";
import type { BoardTileContext } from "../../tiles/board/board-tile-entry.js";
import { BOARD_TILES } from "../../tiles/board/board-catalog.js";
import { PictureTimes } from "../../tiles/board/picture-times.js";
import "../../tiles/board/board-tile.js";
import type { GalleryEntry } from "./entry.js";

const DETAIL: SiteShape = {
  site: "yard", name: "Yard", zone: "Europe/Madrid", online: true, since_us: 0, last_seen_us: 0, catalogue: "c1", place: null, rules: [], enclosures: [], shown_units: {}, devices: [],
};
const CONTEXT: BoardTileContext = {
  site: "yard", zone: "Europe/Madrid", detail: DETAIL, device: null, online: false, feed: null, painter: new PaintScheduler(), pictures: new PictureTimes(), line: null, extensions: [],
};

function renderTile(type: string, settings: BoardTileShape["settings"], title = ""): TemplateResult {
  const tile: BoardTileShape = { id: "t1", type, title, settings, desktop: null, phone: null };
  return html`<t-board-tile .tile=${tile} .context=${CONTEXT}></t-board-tile>`;
}

const ITEMS: readonly NamedItem[] = [
  { id: "a", name: "Speed", x: 0, y: 0, w: 5, h: 2, least: [1, 1] },
  { id: "b", name: "Battery", x: 5, y: 0, w: 7, h: 1, least: [1, 1] },
  { id: "c", name: "Logbook", x: 5, y: 1, w: 7, h: 1, least: [1, 1] },
];

function renderGrid(editing: boolean): TemplateResult {
  return html`<t-board-grid .items=${ITEMS} ?editing=${editing}>${map(ITEMS, ({ id, name }) => html`<t-card slot=${id}>${name}</t-card>`)}</t-board-grid>`;
}

const LINES = ["The dome's motor is greased each May.", "Ask Marta before you open it by hand."];

export const entries: readonly GalleryEntry[] = [
  {
    tag: "t-board-tile",
    states: [
      { name: "words and links", show: () => renderTile("text", { text: LINES, links: ["Manual | https://example.org", "/alarms"] }, "Mind this") },
      { name: "of a type that this hub does not know", show: () => renderTile("hologram", {}) },
      { name: "the site is not linked", show: () => renderTile("alarms", {}) },
      // What each shows before it is told what, or where it may not.
      ...BOARD_TILES.filter(({ settings }) => settings.some(({ needed }) => needed === true)).flatMap(({ type, title, settings }) => [
        { name: `${title}: nothing chosen`, show: () => renderTile(type, {}) },
        { name: `${title}: not open to the person`, show: () => renderTile(type, Object.fromEntries(settings.filter(({ needed }) => needed === true).map(({ key }) => [key, "vault/door"]))) },
      ]),
    ],
  },
  {
    tag: "t-board-grid",
    wide: true,
    states: [
      { name: "looked at", show: () => renderGrid(false) },
      { name: "being arranged", show: () => renderGrid(true) },
    ],
  },
  {
    tag: "t-gauge",
    states: [
      { name: "live", show: () => html`<t-gauge state="live" .value=${62.4} unit="%"></t-gauge>` },
      { name: "beyond its limit", show: () => html`<t-gauge state="live" level="warn" .value=${8.2} unit="%"></t-gauge>` },
      { name: "stale", show: () => html`<t-gauge state="stale" .age=${90} .value=${40} unit="%"></t-gauge>` },
      { name: "no data yet", show: () => html`<t-gauge state="unknown" unit="%"></t-gauge>` },
      { name: "level", show: () => html`<t-gauge look="level" state="live" .value=${71} unit="%"></t-gauge>` },
      { name: "level, stale", show: () => html`<t-gauge look="level" state="stale" .age=${500} .value=${71} unit="%"></t-gauge>` },
    ],
  },
];
