/** Leaflet, loaded when a map is first shown: panning, zooming, touch and keys. We draw ourselves. */

import { msg } from "@lit/localize";
import * as L from "leaflet";
import leafletStyles from "leaflet/dist/leaflet.css?inline";
import { unsafeCSS, type CSSResult } from "lit";

export const styles: CSSResult = unsafeCSS(leafletStyles);

/** Zoom 0 shows a metre as one pixel; each step doubles it. */
const ZOOM = { least: -2, start: 6, most: 10 } as const;

/** Of every map: what we draw ourselves is redrawn at each step, and an animated stretch of it would lag. */
export const DRAWN_BY_US: L.MapOptions = {
  attributionControl: false,
  zoomAnimation: false,
  fadeAnimation: false,
  inertia: false,
  zoomControl: false,
};

export function addZoom(map: L.Map): void {
  L.control.zoom({ position: "topleft", zoomInTitle: msg("Closer"), zoomOutTitle: msg("Farther") }).addTo(map);
}

export interface LocalMap {
  readonly map: L.Map;
  centerOn(x: number, y: number): void;
}

/** A map of a flat local plane in metres, x to the right and y up. */
export function localMap(place: HTMLElement): LocalMap {
  const map = L.map(place, {
    crs: L.CRS.Simple,
    center: [0, 0],
    zoom: ZOOM.start,
    minZoom: ZOOM.least,
    maxZoom: ZOOM.most,
    ...DRAWN_BY_US,
  });
  addZoom(map);
  return {
    map,
    centerOn: (x, y) => {
      map.setView([y, x], map.getZoom(), { animate: false });
    },
  };
}
