/** A request group as it is typed: what a form holds, begins with, and what one change makes of it. Pure. */

import { msg } from "@lit/localize";
import type { GroupOperator, Guiding, ImageType, SolarSystemBody, Urgency } from "../../../generated/api.js";

export const IMAGE_WORDS: Readonly<Record<ImageType, string>> = { LIGHT: msg("light"), SKY_FLAT: msg("twilight flat"), DARK: msg("dark"), BIAS: msg("bias") };
export const GUIDING_WORDS: Readonly<Record<Guiding, string>> = { OFF: msg("off", { id: "off.guiding" }), OPTIONAL: msg("optional"), ON: msg("on", { id: "on.guiding" }) };
export const IMAGE_TYPES = ["LIGHT", "SKY_FLAT", "DARK", "BIAS"] as const satisfies readonly ImageType[];
export const GUIDINGS = ["OFF", "OPTIONAL", "ON"] as const satisfies readonly Guiding[];
export const URGENCIES = ["NORMAL", "TIME_CRITICAL", "RAPID_RESPONSE"] as const satisfies readonly Urgency[];
export const BODIES = ["moon", "mercury", "venus", "mars", "jupiter", "saturn", "uranus", "neptune"] as const satisfies readonly SolarSystemBody[];
/** The hub takes no more in one group. */
export const MOST_REQUESTS = 1000;
export type TargetWay = "stars" | "body" | "fixed" | "none";

/** One row of frames, as it is typed. */
export interface FramesDraft {
  readonly type: ImageType;
  readonly filter: string;
  readonly exposure: string;
  readonly count: string;
  readonly binning: string;
  readonly gain: string;
  readonly dither: string;
  readonly guiding: Guiding;
}

/** A window, as the site's clock shows it. */
export interface WindowDraft {
  readonly start: string;
  readonly end: string;
  /** What was kept (µs, UTC), until somebody types another: a clock shows neither fractions of a second nor which of two equal hours. */
  readonly startUs: number | null;
  readonly endUs: number | null;
}

/** One request, as it is typed; angles in degrees. */
export interface RequestDraft {
  readonly way: TargetWay;
  readonly target: string;
  readonly ra: string;
  readonly dec: string;
  readonly motionRa: string;
  readonly motionDec: string;
  readonly epoch: string;
  /** Position angle of the pictures; empty: as the camera stands. */
  readonly angle: string;
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
  /** All of the phase is empty where it does not matter. */
  readonly phasePeriod: string;
  readonly phaseEpoch: string;
  readonly phaseStart: string;
  readonly phaseEnd: string;
  readonly windows: readonly WindowDraft[];
  readonly frames: readonly FramesDraft[];
}

/** All of the form. */
export interface GroupDraft {
  readonly proposal: string;
  readonly name: string;
  /** Of several requests; of one it does not matter. */
  readonly operator: GroupOperator;
  readonly urgency: Urgency;
  readonly priority: string;
  readonly requests: readonly RequestDraft[];
}

export type GroupField = "proposal" | "name" | "priority" | "requests";
export type RowName = Exclude<keyof FramesDraft, "type" | "guiding"> | "type" | "guiding" | "start" | "end";
export type RequestField = Exclude<keyof RequestDraft, "windows"> | "windows" | `${RowName}-${number}`;

/** The name of a field in a row of frames or windows. */
export function rowField(name: RowName, row: number): RequestField {
  return `${name}-${String(row)}` as RequestField;
}

export const NEW_FRAMES: FramesDraft = { type: "LIGHT", filter: "", exposure: "60", count: "10", binning: "1", gain: "", dither: "0", guiding: "OPTIONAL" };

/** What a new request begins with. */
export function newRequest(window: WindowDraft): RequestDraft {
  return {
    way: "stars", target: "", ra: "", dec: "", motionRa: "", motionDec: "", epoch: "", angle: "", body: "moon", altitude: "60", azimuth: "180",
    minAltitude: "30", maxAirmass: "", moonDistance: "20", moonLit: "", sunAltitude: "-12", hourAngle: "", seeing: "", clouds: "",
    phasePeriod: "", phaseEpoch: "", phaseStart: "", phaseEnd: "", windows: [window], frames: [NEW_FRAMES],
  };
}

/** What a new form begins with. */
export function newGroup(proposal: string, window: WindowDraft): GroupDraft {
  return { proposal, name: "", operator: "SINGLE", urgency: "NORMAL", priority: "10", requests: [newRequest(window)] };
}

const ROW_FIELD = /^(\w+)-(\d+)$/;

/** The form after one field was typed in: of the group, of the request at `at`, or of one of its rows. */
export function writeField(draft: GroupDraft, at: number, name: string, value: string): GroupDraft {
  const request = draft.requests[at];
  const [, rowName = "", row = ""] = ROW_FIELD.exec(name) ?? [];
  if (request === undefined) return draft;
  if (rowName === "start" || rowName === "end") {
    const windows = request.windows.map((window, i): WindowDraft => (i === Number(row) ? { ...window, [rowName]: value, [`${rowName}Us`]: null } : window));
    return writeRequest(draft, at, { windows });
  }
  if (rowName !== "") {
    const frames = request.frames.map((before, i): FramesDraft => (i === Number(row) ? writeFrames(before, rowName, value) : before));
    return writeRequest(draft, at, { frames });
  }
  if (name in request) return writeRequest(draft, at, { [name]: value });
  return name in draft ? { ...draft, [name]: value } : draft;
}

/** A bias is no longer than it must be, and neither it nor a dark needs a filter. */
function writeFrames(before: FramesDraft, name: string, value: string): FramesDraft {
  if (name !== "type") return { ...before, [name]: value };
  const type = IMAGE_TYPES.find((known) => known === value) ?? before.type;
  if (type === "BIAS" || type === "DARK") return { ...before, type, filter: "", dither: "0", guiding: "OFF", exposure: type === "BIAS" ? "0" : before.exposure };
  return { ...before, type };
}

export function writeRequest(draft: GroupDraft, at: number, change: Partial<RequestDraft>): GroupDraft {
  return { ...draft, requests: draft.requests.map((before, i) => (i === at ? { ...before, ...change } : before)) };
}

/** In the place of the request at `at` stand others. */
export function replaceRequest(draft: GroupDraft, at: number, others: readonly RequestDraft[]): GroupDraft {
  const requests = [...draft.requests.slice(0, at), ...others, ...draft.requests.slice(at + 1)];
  return { ...draft, requests, operator: requests.length > 1 && draft.operator === "SINGLE" ? "MANY" : draft.operator };
}

/** Two neighbours change places; the order counts in a sequence. */
export function swapRequests(draft: GroupDraft, one: number, other: number): GroupDraft {
  const [a, b] = [draft.requests[one], draft.requests[other]];
  if (a === undefined || b === undefined) return draft;
  return { ...draft, requests: draft.requests.map((request, i) => (i === one ? b : i === other ? a : request)) };
}
