/** Where a part of the picture lies in the view: pure sums, in CSS pixels. */

import type { Zoom } from "./zoom.js";

export interface PixelSize {
  readonly width: number;
  readonly height: number;
}

/** Parts of the picture's width and height, from its left upper corner. */
export interface PicturePart {
  readonly left: number;
  readonly top: number;
  readonly right: number;
  readonly bottom: number;
}

export interface PixelPlace extends PixelSize {
  readonly x: number;
  readonly y: number;
}

/** The picture is shown whole in the middle of the view (`object-fit: contain`), then looked closer at. */
export function placeOf(part: PicturePart, view: PixelSize, picture: PixelSize, zoom: Zoom): PixelPlace {
  const fit = Math.min(view.width / picture.width, view.height / picture.height);
  const width = picture.width * fit;
  const height = picture.height * fit;
  const x = ((view.width - width) / 2 + part.left * width) * zoom.scale + zoom.x * view.width;
  const y = ((view.height - height) / 2 + part.top * height) * zoom.scale + zoom.y * view.height;
  return {
    x,
    y,
    width: Math.max(0, part.right - part.left) * width * zoom.scale,
    height: Math.max(0, part.bottom - part.top) * height * zoom.scale,
  };
}

/** Which part of the picture (from the left, from the top) lies at a place of the view; beside it, less than 0 or more than 1. */
export function partAt(at: { readonly x: number; readonly y: number }, view: PixelSize, picture: PixelSize, zoom: Zoom): readonly [number, number] {
  const fit = Math.min(view.width / picture.width, view.height / picture.height);
  const width = picture.width * fit;
  const height = picture.height * fit;
  const x = (at.x - zoom.x * view.width) / zoom.scale - (view.width - width) / 2;
  const y = (at.y - zoom.y * view.height) / zoom.scale - (view.height - height) / 2;
  return [x / width, y / height];
}

/** Something of it is in the view. */
export function isInView(place: PixelPlace, view: PixelSize): boolean {
  return place.x < view.width && place.y < view.height && place.x + place.width > 0 && place.y + place.height > 0;
}

/** Over the picture's upper edge lie buttons so high (px). */
const HEAD_PX = 60;
/** A plate with the words of a box is so high (px). */
export const PLATE_PX = 20;

/**
 * Where the plate of a box lies, from the box's own corner: above it; where that is out of sight or
 * below the buttons, inside it; and where the box is too low for that, below it.
 */
export function labelPlace(box: PixelPlace): { readonly x: number; readonly y: number } {
  const above = box.y - PLATE_PX;
  const y = above >= HEAD_PX ? above : Math.max(box.y, HEAD_PX);
  const fits = y < box.y || y + PLATE_PX <= box.y + box.height;
  return { x: Math.max(0, -box.x), y: fits ? y - box.y : box.height };
}
