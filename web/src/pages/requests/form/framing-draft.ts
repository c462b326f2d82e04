/** Framing as it is typed: the size of the field where nobody has described it, panels and their overlap. Pure. */

import { msg, str } from "@lit/localize";
import { fixedText } from "../../../format/number.js";
import type { FieldShape } from "../../../generated/api.js";
import { formatDec, formatRa, writeDec, writeRa } from "../../../format/sexagesimal.js";
import { mosaicOf, type FieldSize, type Mosaic } from "../../../sky/mosaic.js";
import type { SkyPoint } from "../../../sky/tangent-plane.js";
import { FieldReader } from "./field-reader.js";
import type { RequestDraft } from "./draft.js";

/** More in one direction is a survey, which is asked for by a file. */
export const MOST_PANELS = 20;
/** The drawing shows so many times what the camera, or its mosaic, does. */
const ROOM = 3;
/** Less of the sky has hardly a star of the catalogue in it, and more is no plane (°). */
const SPANS = [1.5, 40] as const;

export interface FramingDraft {
  readonly across: string;
  readonly down: string;
  readonly overlap: string;
  /** Of the field, where the site's description does not say it (°). */
  readonly width: string;
  readonly height: string;
}

export type FramingField = keyof FramingDraft;

export const NEW_FRAMING: FramingDraft = { across: "1", down: "1", overlap: "15", width: "", height: "" };

export interface ReadFraming {
  /** Null while nobody knows how large a picture is. */
  readonly field: FieldSize | null;
  /** Null while something is wrong, or there is no field. */
  readonly mosaic: Mosaic | null;
  readonly problems: ReadonlyMap<FramingField, string>;
}

/**
 * @param described what the site's description says of the field; null: nothing
 * @param angle where the top of the pictures points (°); null: as the camera stands
 */
export function readFraming(draft: FramingDraft, centre: SkyPoint, described: FieldShape | null, angle: number | null): ReadFraming {
  const fields = new FieldReader<FramingField>();
  const across = fields.whole("across", draft.across, [1, MOST_PANELS], msg("Panels across"));
  const down = fields.whole("down", draft.down, [1, MOST_PANELS], msg("Panels down"));
  const overlap = fields.number("overlap", draft.overlap, [0, 90], msg("Overlap in %")) / 100;
  const isTyped = described === null && draft.width.trim() !== "" && draft.height.trim() !== "";
  const typed = isTyped
    ? { width: fields.number("width", draft.width, [0.001, 60], msg("Width in °")), height: fields.number("height", draft.height, [0.001, 60], msg("Height in °")) }
    : null;
  const field = described ?? (fields.problems.has("width") || fields.problems.has("height") ? null : typed);
  const rotates = described?.rotates ?? false;
  const isWhole = field !== null && fields.problems.size === 0;
  const mosaic = isWhole ? mosaicOf(centre, field, { across, down, overlap, rotates, angle: (rotates ? angle : null) ?? described?.position_angle ?? 0 }) : null;
  return { field, mosaic, problems: fields.problems };
}

/** How much of the sky is drawn from side to side (°), so that all of the mosaic and its surroundings are seen. */
export function framingSpan({ width, height }: FieldSize, zoom: number): number {
  const [least, most] = SPANS;
  return Math.max(least / 8, Math.min(most, Math.max(least, Math.hypot(width, height) * ROOM) * zoom));
}

/** The radius for which stars are asked (°): in few steps, so that a little more or less asks nobody anew. */
export function starRadius(span: number): number {
  return Math.min(20, 2 ** Math.ceil(Math.log2(span * 0.72)));
}

/** A request for each panel, which differs from the one before only in where it looks. */
export function panelRequests(request: RequestDraft, { panels }: Mosaic, rotates: boolean): readonly RequestDraft[] {
  const name = request.target.trim().slice(0, 80);
  return panels.map(({ centre, angle, row, column }) => ({
    ...request,
    target: name === "" ? msg(str`panel ${String(row)}-${String(column)}`) : msg(str`${name} panel ${String(row)}-${String(column)}`),
    ...placeTexts(centre),
    angle: rotates ? angleText(angle) : "",
  }));
}

/** To a hundredth of a degree: a third of an arc second at the edge of a small field. */
export function angleText(angle: number): string {
  return String(Number((Math.round(angle * 100) / 100 % 360).toFixed(2)));
}

/** As people write coordinates: nobody frames to a tenth of an arc second. */
export function placeTexts({ raDeg, decDeg }: SkyPoint): { readonly ra: string; readonly dec: string } {
  return { ra: writeRa(raDeg / 15), dec: writeDec(decDeg) };
}

export function placeText({ raDeg, decDeg }: SkyPoint): string {
  return `${formatRa(raDeg / 15)} ${formatDec(decDeg)}`;
}

/** So wide and so high, in the unit that has few digits. */
export function sizeText({ width, height }: FieldSize): string {
  const small = Math.max(width, height) < 1;
  const text = (size: number): string => (small ? `${fixedText(size * 60, 1)}′` : `${fixedText(size, 2)}°`);
  return `${text(width)} × ${text(height)}`;
}
