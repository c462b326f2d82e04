/** Draws the world, zones, plans, trails and robots on a map of Earth. No Leaflet here: it is told where places are. */

import { inkMark, type Colours } from "./map-painter.js";
import type { MapPlace } from "./geodesy.js";
import type { OutlineLine, WorldOutline } from "./world.js";

export interface GeoSight {
  /** px */
  readonly width: number;
  readonly height: number;
  /** Where a place is (px from the left top). */
  readonly project: (place: MapPlace) => readonly [x: number, y: number];
}

export interface MapRobot {
  readonly id: string;
  readonly name: string;
  readonly place: MapPlace;
  /** ° clockwise from true north; NaN when it is not known */
  readonly heading: number;
  readonly stale: boolean;
  /** Of the worst that is the matter with it. */
  readonly trouble: "" | "warn" | "bad";
}

export interface TrailPoint extends MapPlace {
  readonly timeUs: number;
  /** 0 to 1 on the scale of the signal that colours it; NaN where that says nothing */
  readonly share: number;
  /** Nothing is known of the way from the point before. */
  readonly apart: boolean;
}

export interface DrawnZone {
  readonly name: string;
  readonly kind: "zone" | "fence" | "dock";
  readonly type: "Point" | "LineString" | "Polygon";
  /** One line; a polygon has one for each ring, and a point one place. */
  readonly lines: readonly (readonly MapPlace[])[];
  readonly trouble: "" | "warn" | "bad";
}

/** A picture by three of its corners: left top, right top, left bottom. */
export interface DrawnPicture {
  readonly image: CanvasImageSource;
  readonly width: number;
  readonly height: number;
  readonly corners: readonly [MapPlace, MapPlace, MapPlace];
  readonly opacity: number;
}

export interface GeoScene {
  readonly pictures: readonly DrawnPicture[];
  readonly zones: readonly DrawnZone[];
  readonly trails: readonly (readonly TrailPoint[])[];
  readonly robots: readonly MapRobot[];
  /** Each robot's name is written beside it, where there is room. */
  readonly named: boolean;
}

export interface GeoColours extends Colours {
  readonly bad: string;
  readonly warn: string;
  readonly ok: string;
  readonly info: string;
  readonly land: string;
  /** Of names. */
  readonly label: string;
}


/** Web Mercator ends there (°). */
const MOST_LAT = 85.05;

export function paintWorld(pen: CanvasRenderingContext2D, sight: GeoSight, world: WorldOutline, colours: GeoColours): void {
  pen.clearRect(0, 0, sight.width, sight.height);
  // The world stands beside itself: whoever looks over the antimeridian sees it on both sides.
  for (const shift of [-360, 0, 360]) {
    const [left] = sight.project({ lat: 0, lon: shift - 180 });
    const [right] = sight.project({ lat: 0, lon: shift + 180 });
    if (right < 0 || left > sight.width) continue;
    pen.beginPath();
    for (const ring of world.land) traceOutline(pen, sight, ring, shift);
    pen.fillStyle = colours.land;
    pen.fill("evenodd");
    pen.strokeStyle = colours.strong;
    pen.lineWidth = 1;
    pen.stroke();
    pen.beginPath();
    for (const line of world.borders) traceOutline(pen, sight, line, shift);
    pen.strokeStyle = colours.line;
    pen.stroke();
  }
}

function traceOutline(pen: CanvasRenderingContext2D, sight: GeoSight, line: OutlineLine, shift: number): void {
  for (let i = 0; i + 1 < line.length; i += 2) {
    const lat = Math.max(-MOST_LAT, Math.min(MOST_LAT, line[i + 1] ?? 0));
    const [x, y] = sight.project({ lat, lon: (line[i] ?? 0) + shift });
    if (i === 0) pen.moveTo(x, y);
    else pen.lineTo(x, y);
  }
}

export function paintScene(pen: CanvasRenderingContext2D, sight: GeoSight, scene: GeoScene, colours: GeoColours, font: string): void {
  pen.clearRect(0, 0, sight.width, sight.height);
  for (const picture of scene.pictures) paintPicture(pen, sight, picture);
  for (const zone of scene.zones) paintZone(pen, sight, zone, colours);
  for (const trail of scene.trails) paintTrail(pen, sight, trail, colours);
  const boxes: LabelBox[] = [];
  for (const robot of scene.robots) paintRobot(pen, sight, robot, colours);
  pen.font = font;
  for (const robot of scene.named ? scene.robots : []) {
    const [x, y] = sight.project(robot.place);
    writeLabel(pen, sight, { text: robot.name, x: x + 18, y, strong: true }, boxes, colours);
  }
  for (const zone of scene.zones) {
    const middle = middleOf(zone.lines[0] ?? []);
    if (middle === null) continue;
    const [x, y] = sight.project(middle);
    writeLabel(pen, sight, { text: zone.name, x: zone.type === "Point" ? x + 12 : x, y, strong: false }, boxes, colours);
  }
}

function paintPicture(pen: CanvasRenderingContext2D, sight: GeoSight, { image, width, height, corners, opacity }: DrawnPicture): void {
  const [[x, y], [rightX, rightY], [belowX, belowY]] = [sight.project(corners[0]), sight.project(corners[1]), sight.project(corners[2])];
  pen.save();
  pen.transform((rightX - x) / width, (rightY - y) / width, (belowX - x) / height, (belowY - y) / height, x, y);
  pen.globalAlpha = opacity;
  // Cells of a grid are squares, however near one looks.
  pen.imageSmoothingEnabled = Math.hypot(rightX - x, rightY - y) < width;
  pen.drawImage(image, 0, 0);
  pen.restore();
}

function zoneColour({ kind, trouble }: DrawnZone, colours: GeoColours): string {
  if (trouble !== "") return colours[trouble];
  return { zone: colours.info, fence: colours.strong, dock: colours.ok }[kind];
}

function paintZone(pen: CanvasRenderingContext2D, sight: GeoSight, zone: DrawnZone, colours: GeoColours): void {
  const colour = zoneColour(zone, colours);
  pen.beginPath();
  for (const line of zone.lines) {
    line.forEach((place, i) => {
      const [x, y] = sight.project(place);
      if (zone.type === "Point") pen.rect(x - 6, y - 6, 12, 12);
      else if (i === 0) pen.moveTo(x, y);
      else pen.lineTo(x, y);
    });
  }
  pen.fillStyle = colour;
  pen.strokeStyle = colour;
  pen.lineJoin = "round";
  if (zone.type !== "LineString") {
    pen.globalAlpha = zone.trouble === "" ? 0.12 : 0.3;
    pen.fill("evenodd");
    pen.globalAlpha = 1;
  }
  // A fence is dashed: its kind is told without colour, and trouble by a thick line.
  pen.setLineDash(zone.kind === "fence" ? [8, 5] : []);
  pen.lineWidth = zone.trouble === "" ? 2 : 4;
  pen.stroke();
  pen.setLineDash([]);
}

/** From blue over grey to orange: told apart by everyone who sees colours, and by brightness. */
export function shareColour(share: number): string {
  const at = Math.max(0, Math.min(1, share));
  const hue = at < 0.5 ? 220 : 25;
  const chroma = Math.abs(at - 0.5) * 2;
  return `hsl(${String(hue)} ${String(Math.round(20 + 75 * chroma))}% ${String(Math.round(38 + 24 * at))}%)`;
}

function paintTrail(pen: CanvasRenderingContext2D, sight: GeoSight, trail: readonly TrailPoint[], colours: GeoColours): void {
  pen.lineJoin = "round";
  pen.lineCap = "round";
  pen.lineWidth = 3;
  let [colour, open] = ["", false];
  const finish = (): void => {
    if (open) pen.stroke();
    open = false;
  };
  for (let i = 1; i < trail.length; i++) {
    const [before, point] = [trail[i - 1], trail[i]];
    if (before === undefined || point === undefined || point.apart) {
      finish();
      continue;
    }
    const wanted = Number.isFinite(point.share) ? shareColour(Math.round(point.share * 24) / 24) : colours.accent;
    if (wanted !== colour) finish();
    if (!open) {
      pen.beginPath();
      pen.moveTo(...sight.project(before));
      pen.strokeStyle = wanted;
      [colour, open] = [wanted, true];
    }
    pen.lineTo(...sight.project(point));
  }
  finish();
}

function paintRobot(pen: CanvasRenderingContext2D, sight: GeoSight, robot: MapRobot, colours: GeoColours): void {
  const [x, y] = sight.project(robot.place);
  if (x < -40 || y < -40 || x > sight.width + 40 || y > sight.height + 40) return;
  const colour = robot.trouble === "" ? colours.accent : colours[robot.trouble];
  pen.save();
  pen.translate(x, y);
  pen.beginPath();
  if (Number.isFinite(robot.heading)) {
    pen.rotate((robot.heading * Math.PI) / 180);
    pen.moveTo(0, -14);
    pen.lineTo(9, 9);
    pen.lineTo(0, 4);
    pen.lineTo(-9, 9);
    pen.closePath();
  } else {
    pen.arc(0, 0, 7, 0, Math.PI * 2);
  }
  inkMark(pen, colours, robot.stale, colour);
  pen.restore();
}

interface LabelBox {
  readonly left: number;
  readonly right: number;
  readonly top: number;
  readonly bottom: number;
}

interface MapLabel {
  readonly text: string;
  readonly x: number;
  readonly y: number;
  readonly strong: boolean;
}

/** Writes a text unless it would lie over another: among hundreds of robots the nearer look tells. */
function writeLabel(pen: CanvasRenderingContext2D, sight: GeoSight, label: MapLabel, boxes: LabelBox[], colours: GeoColours): void {
  if (label.x < 0 || label.y < 0 || label.x > sight.width || label.y > sight.height || boxes.length > 80) return;
  const width = pen.measureText(label.text).width;
  const box = { left: label.x - 2, right: label.x + width + 2, top: label.y - 8, bottom: label.y + 8 };
  if (boxes.some((other) => box.left < other.right && box.right > other.left && box.top < other.bottom && box.bottom > other.top)) return;
  boxes.push(box);
  pen.textAlign = "left";
  pen.textBaseline = "middle";
  pen.lineWidth = 4;
  pen.lineJoin = "round";
  pen.strokeStyle = colours.surface;
  pen.strokeText(label.text, label.x, label.y);
  pen.fillStyle = label.strong ? colours.label : colours.text;
  pen.fillText(label.text, label.x, label.y);
}

function middleOf(places: readonly MapPlace[]): MapPlace | null {
  if (places.length === 0) return null;
  const [lats, lons] = [places.map(({ lat }) => lat), places.map(({ lon }) => lon)];
  return { lat: (Math.min(...lats) + Math.max(...lats)) / 2, lon: (Math.min(...lons) + Math.max(...lons)) / 2 };
}
