/**
 * Boards made of a site's description, by the kinds of its devices and the roles of their signals, so
 * that the first one is there before anybody has arranged anything. Pure.
 */

import { msg, str } from "@lit/localize";
import type { BoardShape, BoardTileShape, DeviceShape, SignalShape, SiteShape } from "../generated/api.js";
import { TEMPLATE_KEY } from "../state/router.js";
import { COLUMNS, firstFree, type GridItem } from "./grid.js";
import { DEVICE } from "./references.js";
import type { TileSettings } from "./tile-settings.js";

export interface TemplateBoard {
  readonly key: string;
  readonly board: BoardShape;
}

type TemplateSize = readonly [desktopW: number, desktopH: number, phoneW: number, phoneH: number];

class TemplateTiles {
  readonly tiles: BoardTileShape[] = [];
  private readonly desktop: GridItem[] = [];
  private readonly phone: GridItem[] = [];

  add(type: string, settings: TileSettings, [dw, dh, pw, ph]: TemplateSize, title = ""): void {
    const id = `t${String(this.tiles.length + 1)}`;
    const desktop = firstFree(this.desktop, dw, dh, COLUMNS.desktop);
    const phone = firstFree(this.phone, pw, ph, COLUMNS.phone);
    this.desktop.push({ id, ...desktop });
    this.phone.push({ id, ...phone });
    this.tiles.push({ id, type, title, settings, desktop, phone });
  }
}

function siteTemplateKey(site: string): string {
  return `${TEMPLATE_KEY}${site}`;
}

/** The site and the device of a template's key; null where it is none. */
export function readTemplateKey(key: string): { readonly site: string; readonly device: string } | null {
  if (!key.startsWith(TEMPLATE_KEY)) return null;
  const [site = "", device = ""] = key.slice(TEMPLATE_KEY.length).split(":");
  return site === "" ? null : { site, device };
}

/** All of a site's templates: of the whole site first, then one for each device that is driven. */
export function templatesOf(detail: SiteShape): readonly TemplateBoard[] {
  const driven = detail.devices.filter(({ drive }) => drive !== null);
  const whole: TemplateBoard = { key: siteTemplateKey(detail.site), board: siteBoard(detail) };
  return [
    whole,
    ...(driven.length < 2 ? [] : driven.map((device) => ({ key: `${siteTemplateKey(detail.site)}:${device.id}`, board: vehicleBoard(detail, device) }))),
  ];
}

export function templateOf(detail: SiteShape, key: string): BoardShape | null {
  return templatesOf(detail).find((template) => template.key === key)?.board ?? null;
}

function siteBoard(detail: SiteShape): BoardShape {
  const driven = detail.devices.find(({ drive }) => drive !== null);
  if (detail.devices.some(({ kind }) => kind === "dome" || kind === "telescope")) return observatoryBoard(detail);
  return driven === undefined ? overviewBoard(detail) : vehicleBoard(detail, driven);
}

function plainBoard(detail: SiteShape, name: string, note: string, tiles: readonly BoardTileShape[], device?: DeviceShape): BoardShape {
  return { name, note, site: detail.site, kind: device?.kind ?? "", device: device?.id ?? "", tiles };
}

/** Of an address only the signal where it is of the board's device: so the board serves its sisters, too. */
function nameOf(signal: SignalShape, device: DeviceShape | undefined): string {
  return device?.signals.includes(signal) === true ? `${DEVICE}/${signal.id}` : signal.address;
}

function primaryOf(devices: readonly DeviceShape[], ...types: readonly string[]): readonly SignalShape[] {
  return devices.flatMap(({ signals }) => signals.filter(({ primary, type }) => primary && types.includes(type)));
}

function addCharts(made: TemplateTiles, signals: readonly SignalShape[], device: DeviceShape | undefined, most: number): void {
  const units = [...new Set(signals.map(({ unit }) => unit))].slice(0, most);
  for (const unit of units) {
    const names = signals.filter((signal) => signal.unit === unit).slice(0, 4).map((signal) => nameOf(signal, device));
    made.add("chart", { signals: names, seconds: 300 }, [6, 4, 4, 4]);
  }
}

/** Rows for so many states below each other, and their axis. */
function timelineRows(states: number): number {
  return Math.max(2, Math.ceil((66 + 44 * states) / 76));
}

function vehicleBoard(detail: SiteShape, device: DeviceShape): BoardShape {
  const made = new TemplateTiles();
  const numbers = device.signals.filter(({ type, primary }) => type === "number" && primary);
  const battery = device.signals.find(({ role }) => role === "battery.level") ?? detail.devices.flatMap(({ signals }) => signals).find(({ role }) => role === "battery.level");
  const stream = device.drive?.picture ?? "";
  const camera = detail.devices.some(({ streams }) => streams.some(({ address }) => address === stream)) ? stream : (detail.devices.flatMap(({ streams }) => streams)[0]?.address ?? "");
  if (camera !== "") made.add("camera", { stream: device.streams.some(({ address }) => address === camera) ? `${DEVICE}/${camera.split("/")[1] ?? ""}` : camera }, [6, 8, 4, 5]);
  if (device.rights.includes("view")) made.add("drive", { device: DEVICE }, [6, 8, 4, 9]);
  const position = detail.devices.flatMap(({ signals }) => signals).find(({ address }) => address === device.drive?.position);
  if (position !== undefined) made.add("trail", { signal: nameOf(position, device) }, [5, 4, 4, 5]);
  if (battery !== undefined) made.add("gauge", { signal: nameOf(battery, device), look: "level" }, [2, 4, 2, 4]);
  for (const signal of numbers.filter((number) => number !== battery).slice(0, 2)) made.add("value", { signal: nameOf(signal, device) }, [5, 2, 2, 2]);
  addCharts(made, numbers, device, 2);
  const states = primaryOf([device, ...detail.devices.filter((other) => other !== device)], "state");
  const shown = states.slice(0, 6).map((signal) => nameOf(signal, device));
  const rows = timelineRows(shown.length);
  if (shown.length > 0) made.add("timeline", { signals: shown, seconds: 300 }, [6, rows, 4, rows]);
  made.add("alarms", {}, [shown.length > 0 ? 6 : 12, rows, 4, 2]);
  made.add("logbook", {}, [12, 4, 4, 4]);
  return plainBoard(detail, msg(str`Cockpit of ${device.name}`), msg("Camera, hands and what the vehicle says."), made.tiles, device);
}

function observatoryBoard(detail: SiteShape): BoardShape {
  const made = new TemplateTiles();
  const { devices } = detail;
  const first = (kind: string): DeviceShape | undefined => devices.find((device) => device.kind === kind);
  const [weather, dome, telescope] = [first("weather"), first("dome"), first("telescope")];
  if (weather !== undefined) made.add("weather", { device: weather.id }, [6, 5, 4, 6]);
  const watching = devices.flatMap(({ kind, streams }) => (kind === "camera" ? [] : streams))[0] ?? devices.flatMap(({ streams }) => streams)[0];
  if (watching !== undefined) made.add("camera", { stream: watching.address }, [6, 5, 4, 4]);
  if (dome !== undefined) made.add("dome", { device: dome.id }, [6, 9, 4, 13]);
  if (telescope !== undefined && detail.place !== null) made.add("sky", { device: telescope.id }, [6, 9, 4, 6]);
  if (telescope !== undefined && devices.some(({ kind }) => kind === "camera")) made.add("plan", {}, [12, 4, 4, 6]);
  if (telescope !== undefined) made.add("table", { device: telescope.id }, [4, 5, 4, 5]);
  if (devices.some(({ kind }) => kind === "camera")) made.add("picture", {}, [4, 5, 4, 5]);
  made.add("alarms", {}, [4, 5, 4, 3]);
  if (weather !== undefined) {
    const numbers = weather.signals.filter(({ type }) => type === "number");
    addCharts(made, numbers, undefined, 1);
  }
  made.add("logbook", {}, [6, 4, 4, 5]);
  return plainBoard(detail, msg(str`Night at ${detail.name}`), msg("Weather, dome, sky and plan at a glance."), made.tiles);
}

function overviewBoard(detail: SiteShape): BoardShape {
  const made = new TemplateTiles();
  for (const signal of primaryOf(detail.devices, "number", "state").slice(0, 8)) made.add("value", { signal: signal.address }, [3, 2, 2, 2]);
  for (const { address } of detail.devices.flatMap(({ streams }) => streams).slice(0, 2)) made.add("camera", { stream: address }, [6, 6, 4, 4]);
  addCharts(made, primaryOf(detail.devices, "number"), undefined, 4);
  const states = primaryOf(detail.devices, "state");
  if (states.length > 0) made.add("timeline", { signals: states.slice(0, 6).map(({ address }) => address), seconds: 300 }, [6, 4, 4, 4]);
  made.add("alarms", {}, [6, 4, 4, 4]);
  made.add("logbook", {}, [6, 4, 4, 4]);
  return plainBoard(detail, msg(str`Overview of ${detail.name}`), msg("What the site says first."), made.tiles);
}
