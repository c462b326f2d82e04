/** What a site draws on its map: zones, plans of floors and the robot's own map, each at its place on Earth. */

import { msg } from "@lit/localize";
import type { ReactiveController, ReactiveControllerHost } from "lit";
import type { DrawnPicture, DrawnZone } from "../../elements/map/geo-painter.js";
import { placeOfLocal, type MapFrame } from "../../elements/map/geodesy.js";
import { gridPixels } from "../../elements/scene/grid-pixels.js";
import type { FloorPlanShape, MapZoneShape, SiteMapShape } from "../../generated/api.js";
import type { TopicBytes } from "../../generated/wire.js";
import { MessageReader } from "../../scene/cdr.js";
import { readGrid, type OccupancyGrid } from "../../scene/messages.js";
import { yawOf } from "../../scene/transform.js";
import type { Alarms } from "../../state/alarms.js";
import type { Interlocks } from "../../state/interlocks.js";
import { ByteTopics } from "../../topics/byte-topics.js";

/** Messages a second: a map changes slowly. */
const GRID_RATE = 0.5;

/** A picture's corners by its lower left one (m, local frame), its turn (rad) and its sides (m). */
export function cornersOf(
  corner: { readonly x: number; readonly y: number; readonly turn: number; readonly width: number; readonly height: number },
  frame: MapFrame,
): DrawnPicture["corners"] {
  const [cos, sin] = [Math.cos(corner.turn), Math.sin(corner.turn)];
  const at = (along: number, up: number): ReturnType<typeof placeOfLocal> =>
    placeOfLocal({ x: corner.x + along * cos - up * sin, y: corner.y + along * sin + up * cos }, frame);
  return [at(0, corner.height), at(corner.width, corner.height), at(0, 0)];
}

/** The zones of a site, and what is the matter with each by the alarm and the interlock that it names. */
export function drawnZones(site: string, zones: readonly MapZoneShape[], alarms: Pick<Alarms, "find"> | undefined, interlocks: Pick<Interlocks, "interlockOf"> | undefined): DrawnZone[] {
  return zones.map((zone) => {
    const alarm = zone.alarm === "" ? undefined : alarms?.find(site, zone.alarm);
    const held = zone.interlock !== "" && interlocks?.interlockOf(site, zone.interlock)?.news.locked === true;
    const raised = alarm !== undefined && (alarm.phase === "active" || alarm.phase === "acknowledged");
    return {
      name: zone.name,
      kind: zone.kind,
      type: zone.type,
      lines: zone.lines.map(({ latitudes, longitudes }) => latitudes.map((lat, i) => ({ lat, lon: longitudes[i] ?? 0 }))),
      trouble: raised && alarm.severity === "critical" ? "bad" : raised || held ? "warn" : "",
    };
  });
}

export class SiteOverlays implements ReactiveController {
  /** Why something is missing; empty while nothing is. */
  trouble = "";
  private plans: readonly DrawnPicture[] = [];
  private grid: DrawnPicture | null = null;
  private frame: MapFrame | null = null;
  private asked: SiteMapShape | null = null;
  private site = "";
  private bytes: ByteTopics | null = null;

  constructor(private readonly host: ReactiveControllerHost & HTMLElement) {
    host.addController(this);
  }

  get pictures(): readonly DrawnPicture[] {
    return this.grid === null ? this.plans : [...this.plans, this.grid];
  }

  /** Call it from `willUpdate`; the same again changes nothing. */
  show(site: string, map: SiteMapShape | null): void {
    if (site === this.site && map === this.asked) return;
    this.close();
    [this.site, this.asked] = [site, map];
    this.frame = frameOf(map);
    this.open();
  }

  hostConnected(): void {
    this.open();
  }

  hostDisconnected(): void {
    this.close();
  }

  private open(): void {
    const { asked, frame, site } = this;
    if (asked === null || frame === null || this.bytes !== null || !this.host.isConnected) return;
    void this.loadPlans(site, asked, frame);
    if (asked.grid === "") return;
    this.bytes = new ByteTopics(site, {
      onBytes: (_topic, message) => {
        this.takeGrid(message, frame);
      },
      onState: () => undefined,
    });
    this.bytes.followAll([{ topic: asked.grid, rate: GRID_RATE, points: 0 }]);
  }

  private close(): void {
    this.bytes?.close();
    this.bytes = null;
    [this.plans, this.grid] = [[], null];
  }

  private async loadPlans(site: string, asked: SiteMapShape, frame: MapFrame): Promise<void> {
    const found = await Promise.allSettled(asked.plans.map((plan) => loadPlan(site, plan, frame)));
    if (this.asked !== asked) return;
    this.plans = found.flatMap((settled) => (settled.status === "fulfilled" ? [settled.value] : []));
    this.trouble = found.some(({ status }) => status === "rejected") ? msg("A floor plan could not be had.") : "";
    this.host.requestUpdate();
  }

  private takeGrid(message: TopicBytes, frame: MapFrame): void {
    let grid: OccupancyGrid;
    try {
      grid = readGrid(new MessageReader(message.data, message.encoding));
    } catch {
      this.trouble = msg("The robot's map is no OccupancyGrid.");
      this.host.requestUpdate();
      return;
    }
    this.grid = gridPicture(grid, frame, getComputedStyle(this.host));
    this.host.requestUpdate();
  }
}

/** The frame that a site's map names; null where it names none. */
export function frameOf(map: SiteMapShape | null): MapFrame | null {
  const origin = map?.origin ?? null;
  return origin === null ? null : { lat: origin.latitude, lon: origin.longitude, heading: origin.heading };
}

async function loadPlan(site: string, plan: FloorPlanShape, frame: MapFrame): Promise<DrawnPicture> {
  const query = new URLSearchParams({ uri: plan.picture }).toString();
  const answer = await fetch(`/api/sites/${encodeURIComponent(site)}/assets?${query}`);
  if (!answer.ok) throw new Error(`${plan.picture}: ${String(answer.status)}`);
  const image = await createImageBitmap(await answer.blob());
  const { width, height } = image;
  const corner = { x: plan.x, y: plan.y, turn: (plan.rotation * Math.PI) / 180, width: width * plan.resolution, height: height * plan.resolution };
  return { image, width, height, corners: cornersOf(corner, frame), opacity: 0.85 };
}

function gridPicture(grid: OccupancyGrid, frame: MapFrame, style: CSSStyleDeclaration): DrawnPicture | null {
  const { width, height, cells } = grid;
  if (width * height === 0 || cells.length < width * height) return null;
  const token = (name: string): string => style.getPropertyValue(`--t-${name}`);
  const pixels = gridPixels(grid, { floor: token("surface"), wall: token("text"), unknown: token("muted") });
  const image = new OffscreenCanvas(width, height);
  image.getContext("2d")?.putImageData(new ImageData(upsideDown(pixels, width), width, height), 0, 0);
  return { image, width, height, corners: gridCorners(grid, frame), opacity: 0.8 };
}

/** Pixels with the last row first: rows of a grid count up, those of a picture down. */
export function upsideDown(pixels: Uint8Array, width: number): Uint8ClampedArray<ArrayBuffer> {
  const flipped = new Uint8ClampedArray(pixels.length);
  const row = width * 4;
  for (let at = 0; at < pixels.length; at += row) flipped.set(pixels.subarray(at, at + row), pixels.length - row - at);
  return flipped;
}

/** Where a grid lies on Earth; its origin is the outer corner of its first cell (nav_msgs/MapMetaData). */
export function gridCorners({ width, height, resolution, origin }: Pick<OccupancyGrid, "width" | "height" | "resolution" | "origin">, frame: MapFrame): ReturnType<typeof cornersOf> {
  return cornersOf({ x: origin.at[0], y: origin.at[1], turn: yawOf(origin.turn), width: width * resolution, height: height * resolution }, frame);
}
