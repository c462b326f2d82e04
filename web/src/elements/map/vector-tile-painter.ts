/** Draws a vector tile on a canvas by the names of its layers, as the schemas of Protomaps and OpenMapTiles have them. */

import { VectorTile, type VectorTileFeature } from "@mapbox/vector-tile";
import { PbfReader } from "pbf";
import type { GeoColours } from "./geo-painter.js";

type Look = "land" | "green" | "water" | "building" | "road" | "rail" | "border" | "places";

/** By the layer's name, in the order of drawing. What is not there is not drawn. */
const LOOKS: ReadonlyMap<string, Look> = new Map<string, Look>([
  ["earth", "land"],
  ["land", "land"],
  ["landcover", "green"],
  ["landuse", "green"],
  ["park", "green"],
  ["water", "water"],
  ["waterway", "water"],
  ["buildings", "building"],
  ["building", "building"],
  ["roads", "road"],
  ["road", "road"],
  ["transportation", "road"],
  ["transit", "rail"],
  ["boundaries", "border"],
  ["boundary", "border"],
  ["places", "places"],
  ["place", "places"],
]);

const AREA = 3;
const LINE = 2;
const SMALL_ROADS = new Set(["path", "footway", "minor", "minor_road", "service", "track", "other"]);

/** @param size side of the tile (px) */
export function paintVectorTile(pen: CanvasRenderingContext2D, data: ArrayBuffer, size: number, colours: GeoColours, font: string): void {
  const { layers } = new VectorTile(new PbfReader(new Uint8Array(data)));
  for (const [name, look] of LOOKS) {
    const layer = layers[name];
    if (layer === undefined) continue;
    for (let i = 0; i < layer.length; i++) {
      const feature = layer.feature(i);
      if (look === "places") writePlace(pen, feature, size / layer.extent, colours, font);
      else paintFeature(pen, feature, look, size / layer.extent, colours);
    }
  }
}

function paintFeature(pen: CanvasRenderingContext2D, feature: VectorTileFeature, look: Look, scale: number, colours: GeoColours): void {
  if (feature.type !== AREA && feature.type !== LINE) return;
  pen.beginPath();
  for (const ring of feature.loadGeometry()) {
    ring.forEach(({ x, y }, i) => {
      if (i === 0) pen.moveTo(x * scale, y * scale);
      else pen.lineTo(x * scale, y * scale);
    });
  }
  pen.globalAlpha = 1;
  pen.setLineDash(look === "border" ? [4, 3] : []);
  if (feature.type === AREA) {
    const fills: Readonly<Record<Look, readonly [string, number]>> = {
      land: [colours.land, 1],
      green: [colours.ok, 0.1],
      water: [colours.info, 0.22],
      building: [colours.text, 0.25],
      road: [colours.surface, 0.8],
      rail: [colours.surface, 0.5],
      border: [colours.line, 0],
      places: [colours.line, 0],
    };
    [pen.fillStyle, pen.globalAlpha] = fills[look];
    pen.fill("evenodd");
  } else {
    const kind = String(feature.properties["kind"] ?? feature.properties["class"] ?? "");
    pen.lineWidth = look === "road" ? (SMALL_ROADS.has(kind) ? 1 : 2.5) : 1;
    pen.strokeStyle = look === "water" ? colours.info : look === "border" ? colours.text : look === "road" ? colours.strong : colours.line;
    pen.globalAlpha = look === "water" ? 0.4 : 0.8;
    pen.stroke();
  }
  pen.globalAlpha = 1;
}

function writePlace(pen: CanvasRenderingContext2D, feature: VectorTileFeature, scale: number, colours: GeoColours, font: string): void {
  const at = feature.loadGeometry()[0]?.[0];
  const { name } = feature.properties;
  if (at === undefined || typeof name !== "string") return;
  pen.setLineDash([]);
  pen.font = font;
  pen.textAlign = "center";
  pen.textBaseline = "middle";
  pen.lineWidth = 3;
  pen.strokeStyle = colours.surface;
  pen.fillStyle = colours.text;
  pen.strokeText(name, at.x * scale, at.y * scale);
  pen.fillText(name, at.x * scale, at.y * scale);
}
