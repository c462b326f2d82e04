/**
 * Which tile shows what: by the kind of a device, and by the roles that its description gives or
 * the hub proposes; of a raw topic, by the type of its messages. The one table; whoever adds a tile
 * writes its element and a row here.
 */

import { html, nothing, type TemplateResult } from "lit";
import type { CommandClient } from "../controllers/drive/command-client.js";
import type { CommandRole, DeviceShape, SignalRole, SignalShape, SiteShape, TileShape } from "../generated/api.js";
import type { PaintScheduler } from "../elements/chart/paint-scheduler.js";
import type { AlarmMark } from "../series/alarm-marks.js";
import type { Anomaly, Detector } from "../state/anomaly-detectors.js";
import type { ChartFeed } from "./chart/chart-feed.js";
import { outletsOf } from "./observatory/roles.js";

export interface DeviceTileOptions {
  readonly site: string;
  readonly device: DeviceShape;
  readonly detail: SiteShape;
  readonly line: CommandClient | null;
  readonly online: boolean;
}

/** One kind of device: what is drawn of it, and what tells most of it at a glance. */
export interface CatalogRow {
  /** Makes the tile's element known; empty where the values and commands say it all. */
  readonly load: (() => Promise<unknown>) | null;
  readonly render: (options: DeviceTileOptions) => TemplateResult | typeof nothing;
  /** It is drawn where one of these is there; without any, always. */
  readonly needs: readonly (SignalRole | CommandRole)[];
  /** Commands that the tile shows itself; the rest stands below as forms. */
  readonly commands: readonly CommandRole[];
  /** It shows the device's streams itself. */
  readonly showsStreams: boolean;
  /** Each place takes the first role that is there; at most `most` places. */
  readonly summary: readonly (readonly SignalRole[])[];
  readonly most: number;
}

const NO_MARKS: readonly AlarmMark[] = [];
const NO_DETECTORS: readonly Detector[] = [];
const NO_ANOMALIES: readonly Anomaly[] = [];

const NOTHING_DRAWN: CatalogRow = {
  load: null, render: () => nothing, needs: [], commands: [], showsStreams: false, summary: [], most: 3,
};

export const CATALOG: Readonly<Record<DeviceShape["kind"], CatalogRow>> = {
  dome: {
    load: () => import("./observatory/dome-part.js"),
    render: ({ site, device, detail, line, online }) =>
      html`<t-part-dome .site=${site} .device=${device} .detail=${detail} .line=${line} .online=${online}></t-part-dome>`,
    needs: ["dome.shutter", "dome.azimuth"],
    commands: ["dome.open", "dome.close", "dome.park", "dome.unpark", "dome.stop", "dome.goto"],
    showsStreams: false,
    summary: [["dome.shutter"], ["dome.azimuth"], ["dome.local"]],
    most: 3,
  },
  telescope: {
    load: () => import("./observatory/telescope-part.js"),
    render: ({ site, device, detail, line, online }) =>
      html`<t-part-telescope .site=${site} .device=${device} .detail=${detail} .line=${line} .online=${online}></t-part-telescope>`,
    needs: [],
    commands: ["telescope.goto", "telescope.unpark", "telescope.track", "telescope.untrack", "telescope.park", "telescope.stop"],
    showsStreams: false,
    // Without a word for all of it, parking and tracking are two.
    summary: [["telescope.state", "telescope.parked"], ["telescope.state", "telescope.tracking"], ["telescope.ra"], ["telescope.dec"]],
    most: 4,
  },
  weather: {
    load: () => import("./observatory/weather-part.js"),
    render: ({ site, device, detail, line, online }) =>
      html`<t-part-weather .site=${site} .device=${device} .detail=${detail} .line=${line} .online=${online}></t-part-weather>`,
    needs: [],
    commands: [],
    showsStreams: false,
    summary: [["weather.safety"], ["weather.raining"], ["weather.wind"], ["weather.humidity"], ["weather.temperature"]],
    most: 4,
  },
  camera: {
    load: () => import("./observatory/camera-part.js"),
    render: ({ site, device, detail, line, online }) =>
      html`<t-part-camera .site=${site} .device=${device} .detail=${detail} .line=${line} .online=${online}></t-part-camera>`,
    // One that only watches takes no exposures.
    needs: ["camera.state", "camera.remaining", "camera.expose"],
    commands: ["camera.expose", "camera.abort", "camera.cool", "camera.cooler", "camera.cooler_on", "camera.cooler_off", "camera.filter", "camera.binning", "camera.gain"],
    showsStreams: true,
    summary: [["camera.state", "camera.remaining"], ["camera.temperature"], ["camera.filter"]],
    most: 3,
  },
  power: {
    load: () => import("./observatory/power-part.js"),
    render: ({ site, device, detail, line, online }) =>
      html`<t-part-power
        .site=${site}
        .device=${device}
        .detail=${detail}
        .line=${line}
        .online=${online}
        .readings=${summarySignals(device)}
      ></t-part-power>`,
    needs: ["power.outlet"],
    commands: ["power.switch", "power.on", "power.off"],
    showsStreams: false,
    summary: [["power.total"], ["power.voltage", "battery.voltage"], ["power.current", "battery.current"], ["battery.level", "power.load"]],
    most: 3,
  },
  vehicle: NOTHING_DRAWN,
  other: NOTHING_DRAWN,
};

const TWIN: CatalogRow = {
  ...NOTHING_DRAWN,
  load: () => import("./twin/twin-tile.js"),
  render: ({ site, device, detail, line, online }) =>
    html`<t-twin .site=${site} .device=${device} .detail=${detail} .line=${line} .online=${online}></t-twin>`,
};

/** The row of a device's tile; null where none is drawn for it. */
export function deviceTile(device: DeviceShape): CatalogRow | null {
  // What it is of says more than its kind: a twin of whatever kind is shown as one.
  if ((device.twin_of ?? "") !== "") return TWIN;
  const row = CATALOG[device.kind];
  if (row.load === null) return null;
  const roles = new Set<string>([...device.signals, ...device.commands].map(({ role }) => role));
  return row.needs.length === 0 || row.needs.some((role) => roles.has(role)) ? row : null;
}

/** The commands that the device's tile shows itself, by id; the rest stands below as forms. */
export function commandsShownBy(device: DeviceShape): ReadonlySet<string> {
  const shown = deviceTile(device)?.commands ?? [];
  const switches = new Set(outletsOf(device).flatMap(({ on, off }) => [on?.command.id, off?.command.id]));
  return new Set(
    device.commands
      // A command whose outlet is not there to be seen has no switch either.
      .filter(({ id, role }) => shown.includes(role) && (device.kind !== "power" || switches.has(id)))
      .map(({ id }) => id),
  );
}

/** The signals that tell most of a device at a glance, the first one first. */
export function summarySignals(device: DeviceShape): readonly SignalShape[] {
  const { summary, most } = CATALOG[device.kind];
  if (summary.length === 0) return device.signals.filter(({ primary, type }) => primary && type !== "position").slice(0, most);
  const found = summary.map((roles) =>
    roles.map((role) => device.signals.find((signal) => signal.role === role)).find((signal) => signal !== undefined),
  );
  return [...new Set(found.filter((signal) => signal !== undefined))].slice(0, most);
}

/** What of a device stands on the first page: what tells most of it, then what else is primary; texts and maps want more room. */
export function firstPageSignals(device: DeviceShape, most: number): readonly SignalShape[] {
  return [...new Set([...summarySignals(device), ...device.signals])]
    .filter(({ primary, type }) => primary && type !== "position" && type !== "text")
    .slice(0, most);
}

/** The same of several devices: the first of each, then the second of each, and so on. */
export function firstPageOf(devices: readonly DeviceShape[], most: number): readonly SignalShape[] {
  const columns = devices.map((device) => firstPageSignals(device, most));
  const rows = Array.from({ length: most }, (_, row) => columns.flatMap((column) => column.slice(row, row + 1)));
  return rows.flat().slice(0, most);
}

/** What the tile of a signal is given by every page; more is said by those that have it. */
export interface SignalTileOptions {
  readonly signal: SignalShape;
  readonly feed: ChartFeed | null;
  readonly painter: PaintScheduler;
  readonly colour: number;
  /** Nothing can come, because a link on the way is down. */
  readonly cut: boolean;
  readonly zone: string;
  readonly paused?: boolean;
  readonly outliers?: number;
  readonly marks?: readonly AlarmMark[];
  readonly detectors?: readonly Detector[] | undefined;
  readonly anomalies?: readonly Anomaly[] | undefined;
  readonly mayForgive?: boolean;
  readonly busy?: boolean;
  readonly forbidden?: boolean;
}

/** A signal's tile; `t-chart-tile` has a look for each type. */
export function renderSignalTile({ signal, feed, painter, colour, cut, zone, ...more }: SignalTileOptions): TemplateResult {
  return html`<t-chart-tile
    class=${signal.type}
    .feed=${feed}
    .signal=${signal}
    .painter=${painter}
    .colour=${colour}
    .cut=${cut}
    .paused=${more.paused ?? false}
    .outliers=${more.outliers ?? 0}
    .marks=${more.marks ?? NO_MARKS}
    .detectors=${more.detectors ?? NO_DETECTORS}
    .anomalies=${more.anomalies ?? NO_ANOMALIES}
    ?may-forgive=${more.mayForgive ?? false}
    ?busy=${more.busy ?? false}
    .forbidden=${more.forbidden ?? false}
    zone=${zone}
  ></t-chart-tile>`;
}

export interface TopicTileOptions {
  readonly site: string;
  readonly topic: string;
  readonly online: boolean;
  /** The page around it has a head and a box already. */
  readonly bare?: boolean;
}

/** One type of messages: what is drawn of its topics instead of the messages themselves. */
export interface TopicTileRow {
  readonly load: () => Promise<unknown>;
  readonly render: (options: TopicTileOptions) => TemplateResult;
}

export const TOPIC_TILES: ReadonlyMap<string, TopicTileRow> = new Map([
  [
    "diagnostic_msgs/msg/DiagnosticArray",
    {
      load: () => import("./topic/diagnostics-tile.js"),
      render: ({ site, topic, online, bare = false }: TopicTileOptions) =>
        html`<t-diagnostics-tile .site=${site} .topic=${topic} .online=${online} ?bare=${bare}></t-diagnostics-tile>`,
    },
  ],
]);

/** The tile of a topic's type; null where there is none. */
export function topicTile(type: string): TopicTileRow | null {
  return TOPIC_TILES.get(type) ?? null;
}

/** The signals that an administrator's tile reads of a device, by the tile's own names; null where one is missing. */
export function signalsFor(tile: TileShape, device: DeviceShape): ReadonlyMap<string, SignalShape> | null {
  if (tile.device !== "" && tile.device !== device.kind) return null;
  const found = new Map<string, SignalShape>();
  for (const wanted of tile.signals) {
    const fits = device.signals.find(
      ({ id, type, unit, role }) =>
        (wanted.id === "" || wanted.id === id) &&
        (wanted.type === "" || wanted.type === type) &&
        (wanted.unit === "" || wanted.unit === unit) &&
        (wanted.role === "" || wanted.role === role),
    );
    if (fits === undefined) return null;
    found.set(wanted.name, fits);
  }
  return found;
}
