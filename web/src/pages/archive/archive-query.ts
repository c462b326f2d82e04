/** What of the archive is asked for, as the page's address and as the hub's question. Pure. */

import { msg, str } from "@lit/localize";
import { queryTexts, textsQuery } from "../../format/filter-query.js";
import { fixedText } from "../../format/number.js";
import type { FrameShape } from "../../generated/api.js";
import { formatDec, formatRa, parseDec, parseRa, wrapped, writeRa } from "../../format/sexagesimal.js";

export interface ArchiveFilter {
  /** Local date at which the night began; empty for all. */
  readonly night: string;
  readonly target: string;
  readonly filter: string;
  readonly device: string;
  /** Degrees, J2000; both or neither. */
  readonly ra: string;
  readonly dec: string;
  /** Degrees round it. */
  readonly radius: string;
}

export const NO_FILTER: ArchiveFilter = { night: "", target: "", filter: "", device: "", ra: "", dec: "", radius: "" };
export const FILTER_KEYS = ["night", "target", "filter", "device", "ra", "dec", "radius"] as const;

/** Reads the page's address. */
export function readArchiveFilter(search: string): ArchiveFilter {
  return queryTexts(new URLSearchParams(search), FILTER_KEYS);
}

/** The filter as a query, for the address; empty for all. */
export function writeArchiveFilter(filter: ArchiveFilter): string {
  return textsQuery(filter, FILTER_KEYS).toString();
}

/** A place as a person wrote it, in the degrees of the address; what cannot be read stays, for `placeProblem` to say so. */
export function placeInDegrees(written: ArchiveFilter): ArchiveFilter {
  return { ...written, ra: degreesText(written.ra, parseRa(written.ra) * 15, "h"), dec: degreesText(written.dec, parseDec(written.dec), "") };
}

/** @param unit of a plain number in this field, so that it is not taken for degrees */
function degreesText(text: string, degrees: number, unit: string): string {
  if (Number.isFinite(degrees)) return String(Number(degrees.toFixed(6)));
  return /^[\d.]+$/.test(text.trim()) ? `${text.trim()}${unit}` : text;
}

/** Right ascension as the field shows it: in hours, as everywhere. */
export function shownRa({ ra }: ArchiveFilter): string {
  return isWithin(ra, 0, 360) ? writeRa(Number(ra) / 15) : ra;
}

interface PlaceProblem {
  readonly field: "ra" | "dec" | "radius";
  readonly text: string;
}

/** Says what is wrong with a place on the sky as a person wrote it; null when all is well. */
export function placeProblem({ ra, dec, radius }: ArchiveFilter): PlaceProblem | null {
  if (ra === "" && dec === "") return null;
  if (ra === "" || dec === "") return { field: ra === "" ? "ra" : "dec", text: msg("Give both right ascension and declination.") };
  if (!isWithin(ra, 0, 360)) return { field: "ra", text: msg("Right ascension: write 05:34:32 or 83.63° (0 to 360).") };
  if (!isWithin(dec, -90, 90)) return { field: "dec", text: msg("Declination: write -05:23:28 or -5.39 (-90 to 90 degrees).") };
  if (radius !== "" && !isWithin(radius, 0.001, 180)) return { field: "radius", text: msg("Radius: expected 0.001 to 180 degrees.") };
  return null;
}

/** The hub's question. A place that makes no sense is left out: the page says so beside it. */
export function frameQuery(filter: ArchiveFilter, limit: number): string {
  const { ra, dec } = filter;
  const placed = ra !== "" && dec !== "" && placeProblem(filter) === null;
  const asked = new URLSearchParams(writeArchiveFilter(placed ? filter : { ...filter, ra: "", dec: "", radius: "" }));
  asked.set("limit", String(limit));
  return asked.toString();
}

function isWithin(readText: string, low: number, high: number): boolean {
  const value = Number(readText);
  return readText.trim() !== "" && Number.isFinite(value) && value >= low && value <= high;
}

/** Degrees as people read a place: `00h 42m 44s +41° 16′ 09″`. */
export function skyPlace(raDeg: number, decDeg: number): string {
  return `${formatRa(wrapped(raDeg, 360) / 15)} ${formatDec(decDeg)}`;
}

/** A size as people read it. */
export function formatFileSize(bytes: number): string {
  if (bytes < 1e6) return `${(bytes / 1e3).toFixed(0)} kB`;
  return bytes < 1e9 ? `${fixedText(bytes / 1e6, 1)} MB` : `${fixedText(bytes / 1e9, 2)} GB`;
}

/** How good a picture is, as rows of name and value; what is not known is left out. */
export function qualityRows(frame: FrameShape): [string, string][] {
  if (!frame.measured) return [[msg("Quality"), msg("not measured")]];
  const rows: [string, string | null][] = [
    [msg("Width of stars"), frame.fwhm === null ? null : `${fixedText(frame.fwhm, 2)}″`],
    [msg("Stars"), frame.stars === null ? null : String(frame.stars)],
    [msg("Sky"), frame.background === null ? null : msg(str`${frame.background.toFixed(0)} counts`)],
    [msg("Zero point"), frame.zero_point === null ? null : msg(str`${fixedText(frame.zero_point, 2)} mag`)],
    [msg("Plate"), frame.solved ? msg("solved") : frame.note === "" ? null : msg(str`not solved: ${frame.note}`)],
  ];
  return rows.filter((row): row is [string, string] => row[1] !== null);
}
