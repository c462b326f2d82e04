/**
 * Every tile that a board can have. The one table: whoever adds a tile writes its element and an entry
 * here, and its settings, its states and its place in the gallery follow from that.
 */

import { msg } from "@lit/localize";
import { html, type TemplateResult } from "lit";
import { DEVICE, findCommand, findDevice, findSignal, findSignals, findStream, findStreams, type BoardSubjects } from "../../boards/references.js";
import { settingFlag, settingList, settingNumber, settingText, type SettingField, type TileSettings } from "../../boards/tile-settings.js";
import type { DeviceShape } from "../../generated/api.js";
import type { BoardTileContext, BoardTileEntry, TileFeed } from "./board-tile-entry.js";

const SECONDS: SettingField = { key: "seconds", label: msg("Time shown (s)"), kind: "number", standard: 300, least: 10, most: 3600 };
const LINES: SettingField = { key: "lines", label: msg("Lines"), kind: "number", standard: 20, least: 1, most: 200 };

function feedOf(settings: TileSettings, subjects: BoardSubjects, keys: readonly string[] = ["signals"]): TileFeed {
  return { signals: findSignals(keys.flatMap((key) => settingList(settings, key)), subjects), seconds: settingNumber(settings, "seconds", 300) };
}

/** One that is chosen, else all of the site. */
function chosenDevices(settings: TileSettings, subjects: BoardSubjects): readonly DeviceShape[] {
  const device = settingText(settings, "device") === "" ? null : findDevice(settingText(settings, "device"), subjects);
  return device === null ? subjects.detail.devices : [device];
}

const signalTitle = (standard: string) => (settings: TileSettings, subjects: BoardSubjects): string => findSignal(settingText(settings, "signal"), subjects)?.name ?? standard;
const deviceTitle = (standard: string) => (settings: TileSettings, subjects: BoardSubjects): string => findDevice(settingText(settings, "device", DEVICE), subjects)?.name ?? standard;
const namesTitle = (standard: string) => (settings: TileSettings, subjects: BoardSubjects): string =>
  findSignals(settingList(settings, "signals"), subjects).map(({ name }) => name).join(", ") || standard;

const renderFilms = (names: readonly string[], context: BoardTileContext): TemplateResult =>
  html`<t-tile-films .context=${context} .streams=${findStreams(names, context)}></t-tile-films>`;

export const BOARD_TILES: readonly BoardTileEntry[] = [
  {
    type: "value", title: msg("Value"), about: msg("One signal's newest value, large."), icon: "live", desktop: [3, 2], phone: [2, 2], least: [1, 2],
    settings: [
      { key: "signal", label: msg("Signal"), kind: "signal", needed: true },
      { key: "size", label: msg("Size"), kind: "choice", standard: "xl", options: [["m", msg("Small")], ["l", msg("Middle")], ["xl", msg("Large")]] },
    ],
    past: "moves",
    load: () => import("../signal-value.js"),
    titleOf: signalTitle(msg("Value")),
    render: (settings, context) =>
      html`<t-signal-value bare .site=${context.site} .signal=${findSignal(settingText(settings, "signal"), context)} .size=${settingText(settings, "size", "xl")}></t-signal-value>`,
  },
  {
    type: "chart", title: msg("Chart"), about: msg("Several numbers over time, on one axis or one for each unit, with the band between a least and a greatest."), icon: "live",
    desktop: [6, 4], phone: [4, 4], least: [2, 3],
    settings: [
      { key: "signals", label: msg("Signals"), kind: "signals", types: ["number"], needed: true },
      SECONDS,
      { key: "axes", label: msg("An axis for each unit"), kind: "flag", standard: true },
      { key: "least", label: msg("Band from"), kind: "number", hint: msg("In the first signal's unit; drawn dashed") },
      { key: "most", label: msg("Band to"), kind: "number" },
    ],
    past: "moves",
    load: () => import("./chart-board-tile.js"),
    titleOf: namesTitle(msg("Chart")),
    feeds: feedOf,
    render: (settings, context) =>
      html`<t-tile-chart
        .context=${context}
        .signals=${findSignals(settingList(settings, "signals"), context)}
        .seconds=${settingNumber(settings, "seconds", 300)}
        .least=${settingNumber(settings, "least")}
        .most=${settingNumber(settings, "most")}
        ?many-axes=${settingFlag(settings, "axes", true)}
      ></t-tile-chart>`,
  },
  {
    type: "xy", title: msg("X-Y plot"), about: msg("One number over another: a path, a curve of a motor."), icon: "live", desktop: [4, 5], phone: [4, 5], least: [2, 3],
    settings: [
      { key: "x", label: msg("Across"), kind: "signal", types: ["number"], needed: true },
      { key: "y", label: msg("Upwards"), kind: "signal", types: ["number"], needed: true },
      SECONDS,
    ],
    past: "moves",
    load: () => import("./xy-board-tile.js"),
    feeds: (settings, subjects) => feedOf(settings, subjects, ["x", "y"]),
    render: (settings, context) =>
      html`<t-tile-xy
        .context=${context}
        .across=${findSignal(settingText(settings, "x"), context)}
        .upwards=${findSignal(settingText(settings, "y"), context)}
        .seconds=${settingNumber(settings, "seconds", 300)}
      ></t-tile-xy>`,
  },
  {
    type: "timeline", title: msg("State timeline"), about: msg("States over time, a band for each."), icon: "history", desktop: [6, 4], phone: [4, 4], least: [2, 2],
    settings: [{ key: "signals", label: msg("States"), kind: "signals", types: ["state"], needed: true }, SECONDS],
    past: "moves",
    load: () => import("./chart-board-tile.js"),
    feeds: feedOf,
    render: (settings, context) =>
      html`<t-tile-timeline .context=${context} .signals=${findSignals(settingList(settings, "signals"), context)} .seconds=${settingNumber(settings, "seconds", 300)}></t-tile-timeline>`,
  },
  {
    type: "gauge", title: msg("Gauge or level"), about: msg("A number between its least and its greatest."), icon: "live", desktop: [3, 4], phone: [2, 4], least: [1, 2],
    settings: [
      { key: "signal", label: msg("Signal"), kind: "signal", types: ["number"], needed: true },
      { key: "look", label: msg("Look", { id: "look.appearance" }), kind: "choice", standard: "gauge", options: [["gauge", msg("Gauge")], ["level", msg("Level")]] },
      { key: "least", label: msg("From", { id: "from.value" }), kind: "number", hint: msg("The signal's own limits where it is empty") },
      { key: "most", label: msg("To", { id: "to.value" }), kind: "number" },
      { key: "warn_below", label: msg("Warn below"), kind: "number" },
      { key: "warn_above", label: msg("Warn above"), kind: "number" },
    ],
    past: "moves",
    load: () => import("./gauge-board-tile.js"),
    titleOf: signalTitle(msg("Gauge or level")),
    render: (settings, context) =>
      html`<t-tile-gauge
        .context=${context}
        .signal=${findSignal(settingText(settings, "signal"), context)}
        .look=${settingText(settings, "look", "gauge")}
        .least=${settingNumber(settings, "least")}
        .most=${settingNumber(settings, "most")}
        .warnBelow=${settingNumber(settings, "warn_below")}
        .warnAbove=${settingNumber(settings, "warn_above")}
      ></t-tile-gauge>`,
  },
  {
    type: "table", title: msg("Table"), about: msg("Signals with their newest values, one below the other; all of a device, or those that you choose."), icon: "logbook",
    desktop: [4, 5], phone: [4, 5], least: [2, 2],
    settings: [
      { key: "device", label: msg("All of a device"), kind: "device" },
      { key: "signals", label: msg("Signals"), kind: "signals" },
    ],
    past: "moves",
    load: () => import("./list-board-tiles.js"),
    titleOf: (settings, subjects) => (settingText(settings, "device") === "" ? msg("Table") : deviceTitle(msg("Table"))(settings, subjects)),
    render: (settings, context) => {
      const device = settingText(settings, "device") === "" ? null : findDevice(settingText(settings, "device"), context);
      return html`<t-tile-table .context=${context} .signals=${[...(device?.signals ?? []), ...findSignals(settingList(settings, "signals"), context)]}></t-tile-table>`;
    },
  },
  {
    type: "text", title: msg("Text and links"), about: msg("Words of your own, and links to pages."), icon: "info", desktop: [3, 3], phone: [4, 2], least: [1, 1],
    settings: [
      { key: "text", label: msg("Text"), kind: "lines" },
      { key: "links", label: msg("Links"), kind: "lines", hint: msg("A line each: Manual | https://example.org") },
    ],
    past: "moves",
    load: () => import("./list-board-tiles.js"),
    render: (settings) => html`<t-tile-text .lines=${settingList(settings, "text")} .links=${settingList(settings, "links")}></t-tile-text>`,
  },
  {
    type: "camera", title: msg("Camera"), about: msg("One camera, live."), icon: "camera", desktop: [6, 6], phone: [4, 4], least: [2, 3],
    settings: [{ key: "stream", label: msg("Camera"), kind: "stream", needed: true }],
    past: (settings, context) => renderFilms([settingText(settings, "stream")], context),
    load: () => Promise.all([import("./camera-wall-tile.js"), import("./film-board-tile.js")]),
    titleOf: (settings, subjects) => findStream(settingText(settings, "stream"), subjects)?.name ?? msg("Camera"),
    render: (settings, context) => html`<t-tile-cameras alone .context=${context} .streams=${findStreams([settingText(settings, "stream")], context)}></t-tile-cameras>`,
  },
  {
    type: "cameras", title: msg("Camera wall"), about: msg("Several cameras side by side: all of the site, or those that you choose."), icon: "camera", desktop: [12, 6], phone: [4, 6], least: [2, 3],
    settings: [{ key: "streams", label: msg("Cameras"), kind: "streams", hint: msg("All where none is chosen") }],
    past: (settings, context) => renderFilms(settingList(settings, "streams"), context),
    load: () => Promise.all([import("./camera-wall-tile.js"), import("./film-board-tile.js")]),
    render: (settings, context) => html`<t-tile-cameras .context=${context} .streams=${findStreams(settingList(settings, "streams"), context)}></t-tile-cameras>`,
  },
  {
    type: "trail", title: msg("Position and trail"), about: msg("Where a device is and where it was: on a map where its place on Earth is known, else on a plain grid."), icon: "drive", desktop: [5, 5], phone: [4, 5], least: [2, 3],
    settings: [{ key: "signal", label: msg("Position"), kind: "signal", types: ["position"], needed: true }, { key: "colour", label: msg("Trail coloured by"), kind: "signal", types: ["number"], hint: msg("On a map: from blue for its least to orange for its most") }],
    past: "moves",
    load: () => import("../map/position-map.js"),
    titleOf: signalTitle(msg("Position and trail")),
    render: (settings, context) => html`<t-map .site=${context.site} .signal=${findSignal(settingText(settings, "signal"), context)} .colour=${findSignal(settingText(settings, "colour"), context)} .online=${context.online}></t-map>`,
  },
  {
    type: "scene", title: msg("3D scene"), about: msg("The robot in space: frames, model, scans, clouds, maps and paths of its topics."), icon: "live", desktop: [6, 7], phone: [4, 6], least: [3, 3],
    settings: [
      { key: "topics", label: msg("Only these layers"), kind: "lines", hint: msg("A topic each line, such as /scan; all that there are where it is empty") },
      { key: "lists", label: msg("Lists, goals and STOP beside it"), kind: "flag" },
    ],
    past: "moves",
    load: () => import("../scene/scene-tile.js"),
    render: (settings, context) =>
      html`<t-scene-tile
        .site=${context.site}
        .detail=${context.detail}
        .online=${context.online}
        .past=${context.past}
        zone=${context.zone}
        .topics=${settingList(settings, "topics")}
        ?bare=${!settingFlag(settings, "lists")}
      ></t-scene-tile>`,
  },
  {
    type: "drive", title: msg("Drive pad"), about: msg("Lease, pad, speed and STOP of a device that is driven."), icon: "drive", desktop: [5, 8], phone: [4, 9], least: [3, 5],
    settings: [{ key: "device", label: msg("Device"), kind: "device", standard: DEVICE }],
    past: "moves",
    load: () => import("./drive-board-tile.js"),
    rests: true,
    titleOf: deviceTitle(msg("Drive")),
    render: (settings, context) => html`<t-tile-drive .context=${context} .device=${findDevice(settingText(settings, "device", DEVICE), context)}></t-tile-drive>`,
  },
  {
    type: "command", title: msg("Command"), about: msg("A button or form that asks a device for something, once."), icon: "drive", desktop: [3, 3], phone: [4, 3], least: [2, 2],
    settings: [{ key: "command", label: msg("Command"), kind: "command", needed: true }],
    past: "moves",
    load: () => import("../command/command-card.js"),
    titleOf: (settings, subjects) => findCommand(settingText(settings, "command"), subjects)?.device.name ?? msg("Command"),
    render: (settings, context) => {
      const found = findCommand(settingText(settings, "command"), context);
      return html`<t-command-card .site=${context.site} .device=${found?.device ?? null} .command=${found?.command ?? null} .line=${context.line} .online=${context.online}></t-command-card>`;
    },
  },
  {
    type: "alarms", title: msg("Alarms"), about: msg("The alarms of the site, the worst first."), icon: "bell", desktop: [4, 4], phone: [4, 4], least: [2, 2],
    settings: [{ key: "all", label: msg("Those that are well, too"), kind: "flag" }],
    past: "moves",
    load: () => import("./event-board-tiles.js"),
    render: (settings, context) => html`<t-tile-alarms .context=${context} ?all=${settingFlag(settings, "all")}></t-tile-alarms>`,
  },
  {
    type: "logbook", title: msg("Logbook"), about: msg("What happened, the newest first."), icon: "logbook", desktop: [6, 4], phone: [4, 4], least: [2, 2],
    settings: [{ key: "device", label: msg("Of one device"), kind: "device" }, { key: "kind", label: msg("Only kinds that begin with"), kind: "text", hint: "alarm, command, stop" }, LINES],
    past: "moves",
    load: () => import("./event-board-tiles.js"),
    render: (settings, context) => {
      const device = settingText(settings, "device");
      return html`<t-tile-logbook
        .context=${context}
        device=${device === "" ? "" : (findDevice(device, context)?.id ?? "")}
        kind=${settingText(settings, "kind")}
        .lines=${settingNumber(settings, "lines", 20)}
      ></t-tile-logbook>`;
    },
  },
  {
    type: "diagnostics", title: msg("Diagnostics"), about: msg("The diagnostics tree of a robot."), icon: "shield", desktop: [4, 6], phone: [4, 6], least: [2, 3],
    settings: [{ key: "topic", label: msg("Topic"), kind: "topic", standard: "/diagnostics_agg" }],
    past: "moves",
    load: () => import("./topic-board-tiles.js"),
    render: (settings, context) => html`<t-tile-diagnostics .context=${context} topic=${settingText(settings, "topic", "/diagnostics_agg")}></t-tile-diagnostics>`,
  },
  {
    type: "log", title: msg("Robot's log"), about: msg("Lines of /rosout, those that are kept and those that come, by level and node, searchable."), icon: "logbook", desktop: [8, 5], phone: [4, 5], least: [3, 3],
    settings: [
      { key: "topic", label: msg("Topic"), kind: "topic", standard: "/rosout" },
      { key: "level", label: msg("From level"), kind: "choice", standard: "20", options: [["10", msg("Debug")], ["20", msg("Info")], ["30", msg("Warning")], ["40", msg("Error")], ["50", msg("Fatal")]] },
      { key: "node", label: msg("Only nodes with"), kind: "text" },
    ],
    past: "moves",
    load: () => import("./log-board-tile.js"),
    render: (settings, context) =>
      html`<t-tile-log .context=${context} topic=${settingText(settings, "topic", "/rosout")} .level=${Number(settingText(settings, "level", "20"))} node=${settingText(settings, "node")}></t-tile-log>`,
  },
  {
    type: "topic", title: msg("Raw message"), about: msg("The newest message of any topic, as a tree with search, and its fields over the last minute."), icon: "live", desktop: [4, 6], phone: [4, 6], least: [2, 3],
    settings: [
      { key: "topic", label: msg("Topic"), kind: "topic", needed: true },
      { key: "fields", label: msg("Fields to plot"), kind: "lines", hint: msg("A path each line, such as twist.twist.linear.x; four at most") },
    ],
    past: "moves",
    load: () => import("./topic-board-tiles.js"),
    titleOf: (settings) => settingText(settings, "topic") || msg("Raw message"),
    render: (settings, context) => html`<t-tile-topic .context=${context} topic=${settingText(settings, "topic")} .fields=${settingList(settings, "fields")}></t-tile-topic>`,
  },
  {
    type: "graph", title: msg("Nodes and topics"), about: msg("The robot's nodes, and who publishes what to whom, with search."), icon: "devices", desktop: [8, 7], phone: [4, 7], least: [3, 4],
    settings: [{ key: "around", label: msg("Drawn around"), kind: "text", hint: msg("A node or a topic, such as /planner; all where it is empty") }],
    notKept: msg("Which nodes there were is not kept."),
    load: () => import("./graph-board-tile.js"),
    render: (settings, context) => html`<t-tile-graph .context=${context} around=${settingText(settings, "around")}></t-tile-graph>`,
  },
  {
    type: "parameters", title: msg("Parameters"), about: msg("Parameters of a robot's nodes that the description names, with what sets them."), icon: "devices", desktop: [4, 6], phone: [4, 6], least: [2, 3],
    settings: [{ key: "device", label: msg("Of one device"), kind: "device" }],
    past: "moves",
    load: () => import("./node-board-tiles.js"),
    render: (settings, context) => html`<t-tile-parameters .context=${context} .devices=${chosenDevices(settings, context)}></t-tile-parameters>`,
  },
  {
    type: "lifecycle", title: msg("Life cycle"), about: msg("The states of life-cycle nodes that the description names, with the transitions that are possible."), icon: "devices",
    desktop: [4, 6], phone: [4, 6], least: [2, 3],
    settings: [{ key: "device", label: msg("Of one device"), kind: "device" }],
    past: "moves",
    load: () => import("./node-board-tiles.js"),
    render: (settings, context) => html`<t-tile-lifecycle .context=${context} .devices=${chosenDevices(settings, context)}></t-tile-lifecycle>`,
  },
  {
    type: "device", title: msg("Device"), about: msg("All that is drawn of a device: dome, telescope, weather, camera, power."), icon: "devices", desktop: [6, 8], phone: [4, 8], least: [3, 3],
    settings: [{ key: "device", label: msg("Device"), kind: "device", standard: DEVICE }],
    past: "moves",
    load: () => import("./device-board-tile.js"),
    titleOf: deviceTitle(msg("Device")),
    render: (settings, context) => html`<t-tile-device .context=${context} .device=${findDevice(settingText(settings, "device", DEVICE), context)}></t-tile-device>`,
  },
  {
    type: "dome", title: msg("Dome"), about: msg("The dome as it stands, with its commands."), icon: "home", desktop: [4, 8], phone: [4, 8], least: [3, 5],
    settings: [{ key: "device", label: msg("Dome"), kind: "device", kinds: ["dome"], needed: true }],
    past: "moves",
    load: () => import("./device-board-tile.js"),
    titleOf: deviceTitle(msg("Dome")),
    render: (settings, context) => html`<t-tile-device .context=${context} .device=${findDevice(settingText(settings, "device"), context)}></t-tile-device>`,
  },
  {
    type: "weather", title: msg("Weather verdict"), about: msg("Whether the weather lets the roof open, and why."), icon: "shield", desktop: [4, 4], phone: [4, 4], least: [2, 3],
    settings: [{ key: "device", label: msg("Station"), kind: "device", kinds: ["weather"], needed: true }],
    notKept: msg("How the interlocks judged then is not kept; its values are in a table or chart."),
    load: () => import("./night-board-tiles.js"),
    render: (settings, context) =>
      html`<t-tile-verdict .site=${context.site} .detail=${context.detail} .device=${findDevice(settingText(settings, "device"), context)} ?online=${context.online}></t-tile-verdict>`,
  },
  {
    type: "sky", title: msg("Sky"), about: msg("The sky over the site now, and where the telescope looks."), icon: "moon", desktop: [4, 8], phone: [4, 7], least: [3, 5],
    settings: [{ key: "device", label: msg("Telescope"), kind: "device", kinds: ["telescope"], needed: true }],
    past: "moves",
    load: () => import("./night-board-tiles.js"),
    render: (settings, context) => html`<t-tile-sky .context=${context} .device=${findDevice(settingText(settings, "device"), context)}></t-tile-sky>`,
  },
  {
    type: "plan", title: msg("Plan of the night"), about: msg("What was and will be observed tonight, as a line."), icon: "moon", desktop: [12, 4], phone: [4, 5], least: [4, 4],
    settings: [],
    notKept: msg("Former plans are not kept."),
    load: () => import("./night-board-tiles.js"),
    render: (_settings, context) => html`<t-tile-plan .context=${context}></t-tile-plan>`,
  },
  {
    type: "picture", title: msg("Archive picture"), about: msg("The newest picture of the archive, drawn."), icon: "camera", desktop: [4, 5], phone: [4, 5], least: [2, 3],
    settings: [{ key: "device", label: msg("Of one camera"), kind: "device", kinds: ["camera"] }],
    past: "moves",
    load: () => import("./night-board-tiles.js"),
    render: (settings, context) => {
      const device = settingText(settings, "device");
      return html`<t-tile-picture .context=${context} device=${device === "" ? "" : (findDevice(device, context)?.id ?? "")}></t-tile-picture>`;
    },
  },
  {
    type: "extension", title: msg("Extension"), about: msg("A tile of the hub's administrator."), icon: "devices", desktop: [3, 4], phone: [4, 4], least: [1, 2],
    settings: [
      { key: "tile", label: msg("Tile"), kind: "extension", needed: true },
      { key: "device", label: msg("Device"), kind: "device", standard: DEVICE },
    ],
    past: "moves",
    load: () => import("../extension-tile.js"),
    titleOf: (settings, context) => context.extensions.find(({ name }) => name === settingText(settings, "tile"))?.title ?? msg("Extension"),
    render: (settings, context) =>
      html`<t-extension-tile
        bare
        .site=${context.site}
        .device=${findDevice(settingText(settings, "device", DEVICE), context)}
        .tile=${context.extensions.find(({ name }) => name === settingText(settings, "tile")) ?? null}
        ?online=${context.online}
      ></t-extension-tile>`,
  },
];

const BY_TYPE: ReadonlyMap<string, BoardTileEntry> = new Map(BOARD_TILES.map((entry) => [entry.type, entry]));

/** The entry of a type; null where there is none. */
export function boardTileEntry(type: string): BoardTileEntry | null {
  return BY_TYPE.get(type) ?? null;
}
