/**
 * Every tile that a board can have. The one table: whoever adds a tile writes its element and an entry
 * here, and its settings, its states and its place in the gallery follow from that.
 */

import { html, type TemplateResult } from "lit";
import { DEVICE, findCommand, findDevice, findSignal, findSignals, findStream, findStreams, type BoardSubjects } from "../../boards/references.js";
import { settingFlag, settingList, settingNumber, settingText, type SettingField, type TileSettings } from "../../boards/tile-settings.js";
import type { DeviceShape } from "../../generated/api.js";
import type { BoardTileContext, BoardTileEntry, TileFeed } from "./board-tile-entry.js";

const SECONDS: SettingField = { key: "seconds", label: "Time shown (s)", kind: "number", standard: 300, least: 10, most: 3600 };
const LINES: SettingField = { key: "lines", label: "Lines", kind: "number", standard: 20, least: 1, most: 200 };

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
    type: "value", title: "Value", about: "One signal's newest value, large.", icon: "live", desktop: [3, 2], phone: [2, 2], least: [1, 2],
    settings: [
      { key: "signal", label: "Signal", kind: "signal", needed: true },
      { key: "size", label: "Size", kind: "choice", standard: "xl", options: [["m", "Small"], ["l", "Middle"], ["xl", "Large"]] },
    ],
    past: "moves",
    load: () => import("../signal-value.js"),
    titleOf: signalTitle("Value"),
    render: (settings, context) =>
      html`<t-signal-value bare .site=${context.site} .signal=${findSignal(settingText(settings, "signal"), context)} .size=${settingText(settings, "size", "xl")}></t-signal-value>`,
  },
  {
    type: "chart", title: "Chart", about: "Several numbers over time, on one axis or one for each unit, with the band between a least and a greatest.", icon: "live",
    desktop: [6, 4], phone: [4, 4], least: [2, 3],
    settings: [
      { key: "signals", label: "Signals", kind: "signals", types: ["number"], needed: true },
      SECONDS,
      { key: "axes", label: "An axis for each unit", kind: "flag", standard: true },
      { key: "least", label: "Band from", kind: "number", hint: "In the first signal's unit; drawn dashed" },
      { key: "most", label: "Band to", kind: "number" },
    ],
    past: "moves",
    load: () => import("./chart-board-tile.js"),
    titleOf: namesTitle("Chart"),
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
    type: "xy", title: "X-Y plot", about: "One number over another: a path, a curve of a motor.", icon: "live", desktop: [4, 5], phone: [4, 5], least: [2, 3],
    settings: [
      { key: "x", label: "Across", kind: "signal", types: ["number"], needed: true },
      { key: "y", label: "Upwards", kind: "signal", types: ["number"], needed: true },
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
    type: "timeline", title: "State timeline", about: "States over time, a band for each.", icon: "history", desktop: [6, 4], phone: [4, 4], least: [2, 2],
    settings: [{ key: "signals", label: "States", kind: "signals", types: ["state"], needed: true }, SECONDS],
    past: "moves",
    load: () => import("./chart-board-tile.js"),
    feeds: feedOf,
    render: (settings, context) =>
      html`<t-tile-timeline .context=${context} .signals=${findSignals(settingList(settings, "signals"), context)} .seconds=${settingNumber(settings, "seconds", 300)}></t-tile-timeline>`,
  },
  {
    type: "gauge", title: "Gauge or level", about: "A number between its least and its greatest.", icon: "live", desktop: [3, 4], phone: [2, 4], least: [1, 2],
    settings: [
      { key: "signal", label: "Signal", kind: "signal", types: ["number"], needed: true },
      { key: "look", label: "Look", kind: "choice", standard: "gauge", options: [["gauge", "Gauge"], ["level", "Level"]] },
      { key: "least", label: "From", kind: "number", hint: "The signal's own limits where it is empty" },
      { key: "most", label: "To", kind: "number" },
      { key: "warn_below", label: "Warn below", kind: "number" },
      { key: "warn_above", label: "Warn above", kind: "number" },
    ],
    past: "moves",
    load: () => import("./gauge-board-tile.js"),
    titleOf: signalTitle("Gauge or level"),
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
    type: "table", title: "Table", about: "Signals with their newest values, one below the other; all of a device, or those that you choose.", icon: "logbook",
    desktop: [4, 5], phone: [4, 5], least: [2, 2],
    settings: [
      { key: "device", label: "All of a device", kind: "device" },
      { key: "signals", label: "Signals", kind: "signals" },
    ],
    past: "moves",
    load: () => import("./list-board-tiles.js"),
    titleOf: (settings, subjects) => (settingText(settings, "device") === "" ? "Table" : deviceTitle("Table")(settings, subjects)),
    render: (settings, context) => {
      const device = settingText(settings, "device") === "" ? null : findDevice(settingText(settings, "device"), context);
      return html`<t-tile-table .context=${context} .signals=${[...(device?.signals ?? []), ...findSignals(settingList(settings, "signals"), context)]}></t-tile-table>`;
    },
  },
  {
    type: "text", title: "Text and links", about: "Words of your own, and links to pages.", icon: "info", desktop: [3, 3], phone: [4, 2], least: [1, 1],
    settings: [
      { key: "text", label: "Text", kind: "lines" },
      { key: "links", label: "Links", kind: "lines", hint: "A line each: Manual | https://example.org" },
    ],
    past: "moves",
    load: () => import("./list-board-tiles.js"),
    render: (settings) => html`<t-tile-text .lines=${settingList(settings, "text")} .links=${settingList(settings, "links")}></t-tile-text>`,
  },
  {
    type: "camera", title: "Camera", about: "One camera, live.", icon: "camera", desktop: [6, 6], phone: [4, 4], least: [2, 3],
    settings: [{ key: "stream", label: "Camera", kind: "stream", needed: true }],
    past: (settings, context) => renderFilms([settingText(settings, "stream")], context),
    load: () => Promise.all([import("./camera-wall-tile.js"), import("./film-board-tile.js")]),
    titleOf: (settings, subjects) => findStream(settingText(settings, "stream"), subjects)?.name ?? "Camera",
    render: (settings, context) => html`<t-tile-cameras alone .context=${context} .streams=${findStreams([settingText(settings, "stream")], context)}></t-tile-cameras>`,
  },
  {
    type: "cameras", title: "Camera wall", about: "Several cameras side by side: all of the site, or those that you choose.", icon: "camera", desktop: [12, 6], phone: [4, 6], least: [2, 3],
    settings: [{ key: "streams", label: "Cameras", kind: "streams", hint: "All where none is chosen" }],
    past: (settings, context) => renderFilms(settingList(settings, "streams"), context),
    load: () => Promise.all([import("./camera-wall-tile.js"), import("./film-board-tile.js")]),
    render: (settings, context) => html`<t-tile-cameras .context=${context} .streams=${findStreams(settingList(settings, "streams"), context)}></t-tile-cameras>`,
  },
  {
    type: "trail", title: "Position and trail", about: "Where a device is and where it was: on a map where its place on Earth is known, else on a plain grid.", icon: "drive", desktop: [5, 5], phone: [4, 5], least: [2, 3],
    settings: [{ key: "signal", label: "Position", kind: "signal", types: ["position"], needed: true }, { key: "colour", label: "Trail coloured by", kind: "signal", types: ["number"], hint: "On a map: from blue for its least to orange for its most" }],
    past: "moves",
    load: () => import("../map/position-map.js"),
    titleOf: signalTitle("Position and trail"),
    render: (settings, context) => html`<t-map .site=${context.site} .signal=${findSignal(settingText(settings, "signal"), context)} .colour=${findSignal(settingText(settings, "colour"), context)} .online=${context.online}></t-map>`,
  },
  {
    type: "scene", title: "3D scene", about: "The robot in space: frames, model, scans, clouds, maps and paths of its topics.", icon: "live", desktop: [6, 7], phone: [4, 6], least: [3, 3],
    settings: [
      { key: "topics", label: "Only these layers", kind: "lines", hint: "A topic each line, such as /scan; all that there are where it is empty" },
      { key: "lists", label: "Lists, goals and STOP beside it", kind: "flag" },
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
    type: "drive", title: "Drive pad", about: "Lease, pad, speed and STOP of a device that is driven.", icon: "drive", desktop: [5, 8], phone: [4, 9], least: [3, 5],
    settings: [{ key: "device", label: "Device", kind: "device", standard: DEVICE }],
    past: "moves",
    load: () => import("./drive-board-tile.js"),
    rests: true,
    titleOf: deviceTitle("Drive"),
    render: (settings, context) => html`<t-tile-drive .context=${context} .device=${findDevice(settingText(settings, "device", DEVICE), context)}></t-tile-drive>`,
  },
  {
    type: "command", title: "Command", about: "A button or form that asks a device for something, once.", icon: "drive", desktop: [3, 3], phone: [4, 3], least: [2, 2],
    settings: [{ key: "command", label: "Command", kind: "command", needed: true }],
    past: "moves",
    load: () => import("../command/command-card.js"),
    titleOf: (settings, subjects) => findCommand(settingText(settings, "command"), subjects)?.device.name ?? "Command",
    render: (settings, context) => {
      const found = findCommand(settingText(settings, "command"), context);
      return html`<t-command-card .site=${context.site} .device=${found?.device ?? null} .command=${found?.command ?? null} .line=${context.line} .online=${context.online}></t-command-card>`;
    },
  },
  {
    type: "alarms", title: "Alarms", about: "The alarms of the site, the worst first.", icon: "bell", desktop: [4, 4], phone: [4, 4], least: [2, 2],
    settings: [{ key: "all", label: "Those that are well, too", kind: "flag" }],
    past: "moves",
    load: () => import("./event-board-tiles.js"),
    render: (settings, context) => html`<t-tile-alarms .context=${context} ?all=${settingFlag(settings, "all")}></t-tile-alarms>`,
  },
  {
    type: "logbook", title: "Logbook", about: "What happened, the newest first.", icon: "logbook", desktop: [6, 4], phone: [4, 4], least: [2, 2],
    settings: [{ key: "device", label: "Of one device", kind: "device" }, { key: "kind", label: "Only kinds that begin with", kind: "text", hint: "alarm, command, stop" }, LINES],
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
    type: "diagnostics", title: "Diagnostics", about: "The diagnostics tree of a robot.", icon: "shield", desktop: [4, 6], phone: [4, 6], least: [2, 3],
    settings: [{ key: "topic", label: "Topic", kind: "topic", standard: "/diagnostics_agg" }],
    past: "moves",
    load: () => import("./topic-board-tiles.js"),
    render: (settings, context) => html`<t-tile-diagnostics .context=${context} topic=${settingText(settings, "topic", "/diagnostics_agg")}></t-tile-diagnostics>`,
  },
  {
    type: "log", title: "Robot's log", about: "Lines of /rosout, those that are kept and those that come, by level and node, searchable.", icon: "logbook", desktop: [8, 5], phone: [4, 5], least: [3, 3],
    settings: [
      { key: "topic", label: "Topic", kind: "topic", standard: "/rosout" },
      { key: "level", label: "From level", kind: "choice", standard: "20", options: [["10", "Debug"], ["20", "Info"], ["30", "Warning"], ["40", "Error"], ["50", "Fatal"]] },
      { key: "node", label: "Only nodes with", kind: "text" },
    ],
    past: "moves",
    load: () => import("./log-board-tile.js"),
    render: (settings, context) =>
      html`<t-tile-log .context=${context} topic=${settingText(settings, "topic", "/rosout")} .level=${Number(settingText(settings, "level", "20"))} node=${settingText(settings, "node")}></t-tile-log>`,
  },
  {
    type: "topic", title: "Raw message", about: "The newest message of any topic, as a tree with search, and its fields over the last minute.", icon: "live", desktop: [4, 6], phone: [4, 6], least: [2, 3],
    settings: [
      { key: "topic", label: "Topic", kind: "topic", needed: true },
      { key: "fields", label: "Fields to plot", kind: "lines", hint: "A path each line, such as twist.twist.linear.x; four at most" },
    ],
    past: "moves",
    load: () => import("./topic-board-tiles.js"),
    titleOf: (settings) => settingText(settings, "topic") || "Raw message",
    render: (settings, context) => html`<t-tile-topic .context=${context} topic=${settingText(settings, "topic")} .fields=${settingList(settings, "fields")}></t-tile-topic>`,
  },
  {
    type: "graph", title: "Nodes and topics", about: "The robot's nodes, and who publishes what to whom, with search.", icon: "devices", desktop: [8, 7], phone: [4, 7], least: [3, 4],
    settings: [{ key: "around", label: "Drawn around", kind: "text", hint: "A node or a topic, such as /planner; all where it is empty" }],
    notKept: "Which nodes there were is not kept.",
    load: () => import("./graph-board-tile.js"),
    render: (settings, context) => html`<t-tile-graph .context=${context} around=${settingText(settings, "around")}></t-tile-graph>`,
  },
  {
    type: "parameters", title: "Parameters", about: "Parameters of a robot's nodes that the description names, with what sets them.", icon: "devices", desktop: [4, 6], phone: [4, 6], least: [2, 3],
    settings: [{ key: "device", label: "Of one device", kind: "device" }],
    past: "moves",
    load: () => import("./node-board-tiles.js"),
    render: (settings, context) => html`<t-tile-parameters .context=${context} .devices=${chosenDevices(settings, context)}></t-tile-parameters>`,
  },
  {
    type: "lifecycle", title: "Life cycle", about: "The states of life-cycle nodes that the description names, with the transitions that are possible.", icon: "devices",
    desktop: [4, 6], phone: [4, 6], least: [2, 3],
    settings: [{ key: "device", label: "Of one device", kind: "device" }],
    past: "moves",
    load: () => import("./node-board-tiles.js"),
    render: (settings, context) => html`<t-tile-lifecycle .context=${context} .devices=${chosenDevices(settings, context)}></t-tile-lifecycle>`,
  },
  {
    type: "device", title: "Device", about: "All that is drawn of a device: dome, telescope, weather, camera, power.", icon: "devices", desktop: [6, 8], phone: [4, 8], least: [3, 3],
    settings: [{ key: "device", label: "Device", kind: "device", standard: DEVICE }],
    past: "moves",
    load: () => import("./device-board-tile.js"),
    titleOf: deviceTitle("Device"),
    render: (settings, context) => html`<t-tile-device .context=${context} .device=${findDevice(settingText(settings, "device", DEVICE), context)}></t-tile-device>`,
  },
  {
    type: "dome", title: "Dome", about: "The dome as it stands, with its commands.", icon: "home", desktop: [4, 8], phone: [4, 8], least: [3, 5],
    settings: [{ key: "device", label: "Dome", kind: "device", kinds: ["dome"], needed: true }],
    past: "moves",
    load: () => import("./device-board-tile.js"),
    titleOf: deviceTitle("Dome"),
    render: (settings, context) => html`<t-tile-device .context=${context} .device=${findDevice(settingText(settings, "device"), context)}></t-tile-device>`,
  },
  {
    type: "weather", title: "Weather verdict", about: "Whether the weather lets the roof open, and why.", icon: "shield", desktop: [4, 4], phone: [4, 4], least: [2, 3],
    settings: [{ key: "device", label: "Station", kind: "device", kinds: ["weather"], needed: true }],
    notKept: "How the interlocks judged then is not kept; its values are in a table or chart.",
    load: () => import("./night-board-tiles.js"),
    render: (settings, context) =>
      html`<t-tile-verdict .site=${context.site} .detail=${context.detail} .device=${findDevice(settingText(settings, "device"), context)} ?online=${context.online}></t-tile-verdict>`,
  },
  {
    type: "sky", title: "Sky", about: "The sky over the site now, and where the telescope looks.", icon: "moon", desktop: [4, 8], phone: [4, 7], least: [3, 5],
    settings: [{ key: "device", label: "Telescope", kind: "device", kinds: ["telescope"], needed: true }],
    past: "moves",
    load: () => import("./night-board-tiles.js"),
    render: (settings, context) => html`<t-tile-sky .context=${context} .device=${findDevice(settingText(settings, "device"), context)}></t-tile-sky>`,
  },
  {
    type: "plan", title: "Plan of the night", about: "What was and will be observed tonight, as a line.", icon: "moon", desktop: [12, 4], phone: [4, 5], least: [4, 4],
    settings: [],
    notKept: "Former plans are not kept.",
    load: () => import("./night-board-tiles.js"),
    render: (_settings, context) => html`<t-tile-plan .context=${context}></t-tile-plan>`,
  },
  {
    type: "picture", title: "Archive picture", about: "The newest picture of the archive, drawn.", icon: "camera", desktop: [4, 5], phone: [4, 5], least: [2, 3],
    settings: [{ key: "device", label: "Of one camera", kind: "device", kinds: ["camera"] }],
    past: "moves",
    load: () => import("./night-board-tiles.js"),
    render: (settings, context) => {
      const device = settingText(settings, "device");
      return html`<t-tile-picture .context=${context} device=${device === "" ? "" : (findDevice(device, context)?.id ?? "")}></t-tile-picture>`;
    },
  },
  {
    type: "extension", title: "Extension", about: "A tile of the hub's administrator.", icon: "devices", desktop: [3, 4], phone: [4, 4], least: [1, 2],
    settings: [
      { key: "tile", label: "Tile", kind: "extension", needed: true },
      { key: "device", label: "Device", kind: "device", standard: DEVICE },
    ],
    past: "moves",
    load: () => import("../extension-tile.js"),
    titleOf: (settings, context) => context.extensions.find(({ name }) => name === settingText(settings, "tile"))?.title ?? "Extension",
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
