/** Leaflet for a map of Earth, loaded when one is first shown: Web Mercator, tiles, touch and keys. */

import * as L from "leaflet";
import type { GeoColours } from "./geo-painter.js";
import type { MapPlace } from "./geodesy.js";
import { addZoom, DRAWN_BY_US, styles } from "./leaflet.js";
import { PmtilesFile, rangesOf } from "./pmtiles.js";
import { paintVectorTile } from "./vector-tile-painter.js";

export { styles };

/** At the nearest a pixel is about half a centimetre. */
const ZOOM = { least: 1, start: 2, most: 25 } as const;

export interface GeoMap {
  readonly map: L.Map;
  readonly project: (place: MapPlace) => readonly [x: number, y: number];
  /** Length of a pixel in the middle (m). */
  readonly resolution: () => number;
  /** Takes another ground; null for none. */
  readonly lay: (layer: L.Layer | null) => void;
}

export function geoMap(place: HTMLElement): GeoMap {
  const map = L.map(place, {
    center: [20, 0],
    zoom: ZOOM.start,
    minZoom: ZOOM.least,
    maxZoom: ZOOM.most,
    ...DRAWN_BY_US,
    worldCopyJump: true,
  });
  addZoom(map);
  let ground: L.Layer | null = null;
  return {
    map,
    project: ({ lat, lon }) => {
      const { x, y } = map.latLngToContainerPoint([lat, lon]);
      return [x, y];
    },
    resolution: () => {
      const { lat, lng } = map.getCenter();
      // Along a meridian, at this latitude; by a step that is small at any zoom.
      const middle = map.project([lat, lng]);
      return map.distance([lat, lng], map.unproject(middle.add([0, 100]))) / 100;
    },
    lay: (layer) => {
      if (ground) map.removeLayer(ground);
      ground = layer;
      if (layer) map.addLayer(layer);
    },
  };
}

/** Pictures of a tile server. */
export function pictureTiles(address: string, mostZoom: number, onTrouble: () => void, referrer = false): L.Layer {
  return L.tileLayer(address, {
    maxNativeZoom: mostZoom,
    maxZoom: ZOOM.most,
    // A key that is limited to this hub's address goes by it; others are told nothing.
    referrerPolicy: referrer ? "origin" : "no-referrer",
  }).on("tileerror", onTrouble);
}

export interface FileGround {
  readonly layer: L.Layer;
  readonly attribution: string;
  /** Its least and greatest longitude and latitude. */
  readonly bounds: L.LatLngBoundsExpression;
}

/**
 * Tiles of a PMTiles file, pictures or vectors, read by ranges.
 *
 * @throws Error where it is none
 */
export async function fileTiles(url: string, colours: () => GeoColours, font: string, onTrouble: () => void): Promise<FileGround> {
  const file = await PmtilesFile.open(rangesOf(url));
  const { header } = file;
  if (header.kind === "unknown") throw new Error("its tiles are of a kind that is not read");
  const about = (await file.metadata()) as { readonly attribution?: unknown };
  const Layer = L.GridLayer.extend({
    createTile(this: L.GridLayer, at: L.Coords, done: L.DoneCallback): HTMLElement {
      const size = this.getTileSize().x;
      const ratio = window.devicePixelRatio || 1;
      const canvas = L.DomUtil.create("canvas", "leaflet-tile");
      canvas.width = Math.round(size * ratio);
      canvas.height = Math.round(size * ratio);
      const draw = async (): Promise<void> => {
        const tile = await file.tile(at.z, at.x, at.y);
        const pen = canvas.getContext("2d");
        // A tile that is not in the file is empty there: sea, or beyond its edge.
        if (tile === null || pen === null) return;
        pen.scale(ratio, ratio);
        if (header.kind === "vector") paintVectorTile(pen, tile, size, colours(), font);
        else {
          const image = await createImageBitmap(new Blob([tile], { type: header.kind }));
          pen.drawImage(image, 0, 0, size, size);
          image.close();
        }
      };
      draw().then(
        () => {
          done(undefined, canvas);
        },
        (error: unknown) => {
          onTrouble();
          done(error instanceof Error ? error : new Error("no tile"), canvas);
        },
      );
      return canvas;
    },
  }) as new (options: L.GridLayerOptions) => L.GridLayer;
  const bounds: L.LatLngBoundsExpression = [
    [header.south, header.west],
    [header.north, header.east],
  ];
  return {
    layer: new Layer({ minNativeZoom: header.minZoom, maxNativeZoom: header.maxZoom, maxZoom: ZOOM.most, bounds }),
    attribution: typeof about.attribution === "string" ? textOf(about.attribution) : "",
    bounds,
  };
}

/** What a file says of its makers may be HTML; only its words are shown. */
function textOf(html: string): string {
  return new DOMParser().parseFromString(html, "text/html").body.textContent.trim();
}
