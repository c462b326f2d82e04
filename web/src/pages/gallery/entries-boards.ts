/** Boards: the tile around everything in its states, the grid, and the gauge. */

import { html, type TemplateResult } from "lit";
import { map } from "lit/directives/map.js";
import { PaintScheduler } from "../../elements/chart/paint-scheduler.js";
import type { NamedItem } from "../../elements/board/board-grid.js";
import type { BoardTileShape, CommandShape, DeviceShape, SignalShape, SiteShape } from "../../generated/api.js";
import "../../elements/board/board-grid.js";
import "../../elements/board/time-bar.js";
import "../../elements/layout/card.js";
import "../../elements/values/gauge.js";
import type { BoardTileContext } from "../../tiles/board/board-tile-entry.js";
import { BOARD_TILES } from "../../tiles/board/board-catalog.js";
import { PictureTimes } from "../../tiles/board/picture-times.js";
import "../../tiles/board/board-tile.js";
import type { GalleryEntry } from "./entry.js";

const DETAIL: SiteShape = {
  site: "yard", name: "Yard", zone: "Europe/Madrid", online: true, since_us: 0, last_seen_us: 0, catalogue: "c1", place: null, rules: [], enclosures: [], shown_units: {}, map: null, devices: [],
};
const CONTEXT: BoardTileContext = {
  site: "yard", zone: "Europe/Madrid", detail: DETAIL, device: null, online: false, linked: false, past: null, feed: null, painter: new PaintScheduler(), pictures: new PictureTimes(), line: null, extensions: [],
};

function renderTile(type: string, settings: BoardTileShape["settings"], title = "", context = CONTEXT): TemplateResult {
  const tile: BoardTileShape = { id: "t1", type, title, settings, desktop: null, phone: null };
  return html`<t-board-tile .tile=${tile} .context=${context}></t-board-tile>`;
}

const SIGNAL: SignalShape = {
  id: "limit", address: "lidar/limit", name: "Greatest range", type: "number", role: "none", unit: "m", decimals: 1, minimum: null, maximum: null, shown: null, states: [], meanings: [],
  frame: "", max_age: 5, primary: true, public: false, ros: "parameter", channels: ["lidar/limit"],
};
const COMMAND: CommandShape = {
  id: "set_limit", name: "Set the range", role: "none", description: "", confirm: false, timeout: 10, cancellable: false, needs: null, ros: "parameter", arguments: [],
};
const LIDAR: DeviceShape = {
  id: "lidar", name: "Lidar", kind: "other", streams: [], drive: null, public: false, link_loss: "", pointing: null, slew: null, unguarded: false, rights: ["view", "use"],
  signals: [SIGNAL, { ...SIGNAL, id: "state", address: "lidar/state", name: "State", type: "state", states: ["inactive", "active"], ros: "lifecycle", channels: ["lidar/state"] }],
  commands: [
    COMMAND,
    { ...COMMAND, id: "activate", name: "Activate", ros: "lifecycle", needs: { channel: "lidar/state", max_age: 5, states: ["inactive", "active"], among: ["inactive"] } },
  ],
};
const WITH_NODES: BoardTileContext = { ...CONTEXT, detail: { ...DETAIL, devices: [LIDAR] } };

const NOON_US = 1_780_000_000_000_000;
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
      { name: "parameters", show: () => renderTile("parameters", {}, "", WITH_NODES) },
      { name: "parameters, of which the description names none", show: () => renderTile("parameters", {}) },
      { name: "life cycle", show: () => renderTile("lifecycle", {}, "", WITH_NODES) },
      { name: "life cycle, of which the description names none", show: () => renderTile("lifecycle", {}) },
      // What each shows before it is told what, or where it may not.
      ...BOARD_TILES.filter(({ settings }) => settings.some(({ needed }) => needed === true)).flatMap(({ type, title, settings }) => [
        { name: `${title}: nothing chosen`, show: () => renderTile(type, {}) },
        { name: `${title}: not open to the person`, show: () => renderTile(type, Object.fromEntries(settings.filter(({ needed }) => needed === true).map(({ key }) => [key, "vault/door"]))) },
      ]),
    ],
  },
  {
    tag: "t-time-bar",
    wide: true,
    states: [
      { name: "looking back", show: () => html`<t-time-bar .us=${NOON_US} .end=${NOON_US + 60e6} .speeds=${[1, 10]} zone="Europe/Madrid"></t-time-bar>` },
      { name: "with a note over a span, and another one begun", show: () => html`<t-time-bar notes .begun=${NOON_US - 600e6} .us=${NOON_US} .end=${NOON_US + 60e6} .speeds=${[1, 10]} zone="Europe/Madrid"><span slot="stretches" .style=${"--from: 0.4; --part: 0.2"}></span></t-time-bar>` },
      { name: "playing, expanded on a phone", show: () => html`<t-time-bar playing expanded .speed=${10} .us=${NOON_US} .end=${NOON_US + 60e6} .speeds=${[1, 10]} zone="UTC"></t-time-bar>` },
      { name: "nothing was recorded", show: () => html`<t-time-bar state="silent" .us=${NOON_US} .end=${NOON_US + 60e6} .speeds=${[1, 10]} zone="UTC"></t-time-bar>` },
      { name: "the hub does not answer", show: () => html`<t-time-bar state="failed" .us=${NOON_US} .end=${NOON_US + 60e6} .speeds=${[1, 10]} zone="UTC"></t-time-bar>` },
      { name: "at the newest moment", show: () => html`<t-time-bar at-end .us=${NOON_US} .end=${NOON_US} .speeds=${[1, 10]} zone="UTC"></t-time-bar>` },
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
