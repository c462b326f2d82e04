/** A request as it is typed: read, checked field by field, and made from one that is there. Pure. */

import type {
  ConfigurationShape, ConstraintsShape, GroupAsk, GroupShape, Guiding, ImageType, RequestAsk, RequestShape, SolarSystemBody, Urgency,
} from "../../generated/api.js";
import { formatDec, formatRa, parseDec, parseRa } from "../../format/sexagesimal.js";

export const IMAGE_TYPES = ["LIGHT", "SKY_FLAT", "DARK", "BIAS"] as const satisfies readonly ImageType[];
export const GUIDINGS = ["OFF", "OPTIONAL", "ON"] as const satisfies readonly Guiding[];
export const URGENCIES = ["NORMAL", "TIME_CRITICAL", "RAPID_RESPONSE"] as const satisfies readonly Urgency[];
export const BODIES = ["moon", "mercury", "venus", "mars", "jupiter", "saturn", "uranus", "neptune"] as const satisfies readonly SolarSystemBody[];
export type TargetWay = "stars" | "body" | "fixed" | "none";

/** One row of the table of configurations, as it is typed. */
export interface ConfigurationDraft {
  readonly type: ImageType;
  readonly filter: string;
  readonly exposure: string;
  readonly count: string;
  readonly binning: string;
  readonly dither: string;
  readonly guiding: Guiding;
}

/** All of the form, as it is typed; angles in degrees, times as the site's clock shows them. */
export interface RequestDraft {
  readonly proposal: string;
  readonly name: string;
  readonly urgency: Urgency;
  readonly priority: string;
  readonly way: TargetWay;
  readonly target: string;
  readonly ra: string;
  readonly dec: string;
  readonly body: SolarSystemBody;
  readonly altitude: string;
  readonly azimuth: string;
  readonly minAltitude: string;
  readonly maxAirmass: string;
  readonly moonDistance: string;
  readonly moonLit: string;
  readonly sunAltitude: string;
  readonly hourAngle: string;
  readonly seeing: string;
  readonly clouds: string;
  readonly windowStart: string;
  readonly windowEnd: string;
  readonly configurations: readonly ConfigurationDraft[];
}

export type DraftField = Exclude<keyof RequestDraft, "configurations"> | "configurations" | `${"exposure" | "count" | "binning" | "dither"}-${number}`;

/** The name of a field in a row of frames. */
export function rowField(name: "exposure" | "count" | "binning" | "dither", row: number): DraftField {
  return `${name}-${String(row)}` as DraftField;
}

export const NEW_CONFIGURATION: ConfigurationDraft = { type: "LIGHT", filter: "", exposure: "60", count: "10", binning: "1", dither: "0", guiding: "OPTIONAL" };

/** What a new form begins with. */
export function newDraft(proposal: string, window: { readonly start: string; readonly end: string }): RequestDraft {
  return {
    proposal, name: "", urgency: "NORMAL", priority: "10", way: "stars", target: "", ra: "", dec: "", body: "moon", altitude: "60", azimuth: "180",
    minAltitude: "30", maxAirmass: "", moonDistance: "20", moonLit: "", sunAltitude: "-12", hourAngle: "", seeing: "", clouds: "",
    windowStart: window.start, windowEnd: window.end, configurations: [NEW_CONFIGURATION],
  };
}

export interface ReadDraft {
  /** Null while anything is wrong. */
  readonly asked: GroupAsk | null;
  readonly problems: ReadonlyMap<DraftField, string>;
  /** What of it can be read already, for the chart: a place, or null. */
  readonly target: RequestShape["target"];
  readonly constraints: Required<Omit<ConstraintsShape, "phase">>;
  /** µs since the epoch, UTC; NaN where it cannot be read. */
  readonly window: { readonly startUs: number; readonly endUs: number };
  /** Open shutter (s). */
  readonly shutterS: number;
}

/**
 * Reads a form.
 *
 * @param momentOf a moment (µs) of what stands in a field of date and time; NaN for none
 * @param nowUs to say that a window is over
 */
export function readDraft(draft: RequestDraft, momentOf: (text: string) => number, nowUs: number): ReadDraft {
  const problems = new Map<DraftField, string>();
  const number = (field: DraftField, text: string, [low, high]: readonly [number, number], what: string): number => {
    const value = text.trim() === "" ? Number.NaN : Number(text.trim().replace(/[−–]/, "-").replace(",", "."));
    if (!(value >= low && value <= high)) problems.set(field, `${what}: expected ${String(low)} to ${String(high)}.`);
    return value;
  };
  const optional = (field: DraftField, text: string, range: readonly [number, number], what: string): number | null =>
    text.trim() === "" ? null : number(field, text, range, what);
  if (draft.proposal === "") problems.set("proposal", "Choose the proposal that pays for it.");
  const target = readTarget(draft, problems, number);
  const configurations = draft.configurations.map((row, i): ConfigurationShape => ({
    type: row.type,
    filter: row.filter.trim(),
    exposure: number(rowField("exposure", i), row.exposure, [0, 86_400], "Exposure in s"),
    count: wholeNumber(number(rowField("count", i), row.count, [1, 10_000], "Frames"), rowField("count", i), problems),
    binning: wholeNumber(number(rowField("binning", i), row.binning, [1, 16], "Binning"), rowField("binning", i), problems),
    dither: number(rowField("dither", i), row.dither, [0, 600], "Dither in ″"),
    guiding: row.guiding,
  }));
  if (configurations.length === 0) problems.set("configurations", "Add at least one row of frames.");
  if (target === null && configurations.some(({ type }) => type === "LIGHT")) {
    if (draft.way === "none") problems.set("way", "Light frames need a target; without one only darks, bias and flats are taken.");
  }
  const lit = optional("moonLit", draft.moonLit, [0, 100], "Moon lit in %");
  const constraints = {
    min_altitude: number("minAltitude", draft.minAltitude, [0, 90], "Lowest altitude in °"),
    max_airmass: optional("maxAirmass", draft.maxAirmass, [1, 40], "Airmass") ?? 10,
    min_moon_distance: number("moonDistance", draft.moonDistance, [0, 180], "Distance from the Moon in °"),
    max_moon_illumination: lit === null ? 1 : lit / 100,
    max_sun_altitude: number("sunAltitude", draft.sunAltitude, [-90, 0], "Sun in °"),
    max_hour_angle: optional("hourAngle", draft.hourAngle, [0.01, 12], "Hour angle in h"),
    max_seeing: optional("seeing", draft.seeing, [0.1, 60], "Seeing in ″"),
    max_clouds: optional("clouds", draft.clouds, [0, 100], "Clouds in %"),
  };
  const window = { startUs: momentOf(draft.windowStart), endUs: momentOf(draft.windowEnd) };
  checkWindow(window, problems, nowUs);
  const priority = number("priority", draft.priority, [0.001, 1000], "Priority");
  const request: RequestAsk = { target, configurations, constraints, windows: [{ start_us: window.startUs, end_us: window.endUs }] };
  return {
    asked: problems.size > 0 ? null : { proposal: draft.proposal, name: draft.name.trim(), urgency: draft.urgency, priority, requests: [request] },
    problems,
    target,
    constraints,
    window,
    shutterS: configurations.reduce((sum, { exposure, count = 1 }) => sum + exposure * count, 0),
  };
}

type NumberReader = (field: DraftField, text: string, range: readonly [number, number], what: string) => number;

function readTarget(draft: RequestDraft, problems: Map<DraftField, string>, number: NumberReader): RequestShape["target"] {
  const name = draft.target.trim().slice(0, 100);
  switch (draft.way) {
    case "none":
      return null;
    case "body":
      return { type: "SOLAR_SYSTEM", name, body: draft.body };
    case "fixed": {
      const altitude = number("altitude", draft.altitude, [0, 90], "Altitude in °");
      const azimuth = number("azimuth", draft.azimuth, [0, 359.999], "Azimuth in °");
      return problems.has("altitude") || problems.has("azimuth") ? null : { type: "FIXED", name, altitude, azimuth };
    }
    case "stars": {
      const [ra, dec] = [parseRa(draft.ra), parseDec(draft.dec)];
      if (Number.isNaN(ra)) problems.set("ra", "Find the target by its name, or write 05:34:32 or 83.63° (J2000).");
      if (Number.isNaN(dec)) problems.set("dec", "Write −05:23:28 or −5.39 (°, J2000).");
      return Number.isNaN(ra) || Number.isNaN(dec) ? null : { type: "ICRS", name, ra: (ra * 15) % 360, dec };
    }
  }
}

function wholeNumber(value: number, field: DraftField, problems: Map<DraftField, string>): number {
  if (Number.isFinite(value) && !Number.isInteger(value)) problems.set(field, "Expected a whole number.");
  return value;
}

function checkWindow({ startUs, endUs }: ReadDraft["window"], problems: Map<DraftField, string>, nowUs: number): void {
  if (!(startUs > 0)) problems.set("windowStart", "Write a date and a time.");
  if (!(endUs > 0)) problems.set("windowEnd", "Write a date and a time.");
  else if (endUs <= startUs) problems.set("windowEnd", "The window ends before it begins.");
  else if (endUs <= nowUs) problems.set("windowEnd", "This window is over.");
}

/**
 * The form of a group of one request that is there; null for what the form cannot say.
 *
 * @param textOf what a field of date and time shows for a moment (µs)
 */
export function draftOf(group: GroupShape, textOf: (us: number) => string): RequestDraft | null {
  const [request, ...more] = group.requests;
  const [window, ...windows] = request?.windows ?? [];
  if (request === undefined || more.length > 0 || window === undefined || windows.length > 0 || request.constraints.phase != null) return null;
  const { target, constraints } = request;
  const text = (value: number | null | undefined): string => (value === null || value === undefined ? "" : String(Number(value.toPrecision(10))));
  const empty = newDraft(group.proposal, { start: textOf(window.start_us), end: textOf(window.end_us) });
  return {
    ...empty,
    name: group.name,
    urgency: group.urgency,
    priority: text(group.priority),
    ...targetFields(target),
    minAltitude: text(constraints.min_altitude ?? 15),
    maxAirmass: text(constraints.max_airmass === 10 ? null : constraints.max_airmass),
    moonDistance: text(constraints.min_moon_distance ?? 0),
    moonLit: text(constraints.max_moon_illumination === undefined || constraints.max_moon_illumination === 1 ? null : constraints.max_moon_illumination * 100),
    sunAltitude: text(constraints.max_sun_altitude ?? -12),
    hourAngle: text(constraints.max_hour_angle),
    seeing: text(constraints.max_seeing),
    clouds: text(constraints.max_clouds),
    configurations: request.configurations.map(({ type = "LIGHT", filter = "", exposure, count = 1, binning = 1, dither = 0, guiding = "OFF" }) => ({
      type, filter, guiding, exposure: text(exposure), count: text(count), binning: text(binning), dither: text(dither),
    })),
  };
}

function targetFields(target: RequestShape["target"]): Partial<RequestDraft> {
  if (target === null) return { way: "none" };
  const name = target.name ?? "";
  switch (target.type) {
    case "ICRS":
      return { way: "stars", target: name, ...coordinateTexts(target.ra, target.dec) };
    case "SOLAR_SYSTEM":
      return { way: "body", target: name, body: target.body };
    case "FIXED":
      return { way: "fixed", target: name, altitude: String(target.altitude), azimuth: String(target.azimuth) };
  }
}

/** A place (°, J2000) as the fields show it: so exact that reading them gives the same place within 0.01″. */
export function coordinateTexts(raDeg: number, dec: number): { readonly ra: string; readonly dec: string } {
  const [ra, size] = [Number(raDeg.toFixed(6)), Number(dec.toFixed(6))];
  const exact = Math.abs(parseRa(formatRa(raDeg / 15)) * 15 - raDeg) < 3e-6 && Math.abs(parseDec(formatDec(dec)) - dec) < 3e-6;
  return exact ? { ra: formatRa(raDeg / 15), dec: formatDec(dec) } : { ra: `${String(ra)}°`, dec: String(size) };
}
