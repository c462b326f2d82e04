/** Reads a form, field by field, into what the hub is asked. Pure. */

import { msg } from "@lit/localize";
import type { AbilitiesShape, ConstraintsShape, GroupAsk, RequestAsk, RequestShape, WindowShape } from "../../../generated/api.js";
import { parseMoment } from "../../../format/julian-date.js";
import { parseDec, parseRa, wrapped } from "../../../format/sexagesimal.js";
import { rowField, type GroupDraft, type GroupField, type RequestDraft, type RequestField, type WindowDraft } from "./draft.js";
import { FieldReader } from "./field-reader.js";
import { readFrames } from "./read-frames.js";

const DAY_S = 86_400;
/** Of a period the hub takes so much (s). */
const LONGEST_PERIOD_S = 1e10;

/** By what a form is read. */
export interface DraftReading {
  /** A moment (µs) of what stands in a field of date and time; NaN for none. */
  readonly momentOf: (text: string) => number;
  /** To say that a window is over. */
  readonly nowUs: number;
  /** What the site can do; null while nobody knows. */
  readonly abilities: AbilitiesShape | null;
}

export type ReadConstraints = Required<ConstraintsShape>;

export interface ReadRequest {
  readonly asked: RequestAsk;
  /** While there are any, `asked` is of no use. */
  readonly problems: ReadonlyMap<RequestField, string>;
  /** What of it can be read already, for the chart: a place, or null. */
  readonly target: RequestShape["target"];
  readonly constraints: ReadConstraints;
  /** NaN where it cannot be read. */
  readonly windows: readonly WindowShape[];
  /** Open shutter (s). */
  readonly shutterS: number;
}

export interface ReadGroup {
  /** Null while anything is wrong. */
  readonly asked: GroupAsk | null;
  readonly problems: ReadonlyMap<GroupField, string>;
  readonly requests: readonly ReadRequest[];
  readonly shutterS: number;
}

export function readGroup(draft: GroupDraft, reading: DraftReading): ReadGroup {
  const fields = new FieldReader<GroupField>();
  if (draft.proposal === "") fields.problems.set("proposal", msg("Choose the proposal that pays for it."));
  const priority = fields.number("priority", draft.priority, [0.001, 1000], msg("Priority"));
  if (draft.requests.length === 0) fields.problems.set("requests", msg("A group has at least one request."));
  const requests = draft.requests.map((request) => readRequest(request, reading));
  const isWhole = fields.problems.size === 0 && requests.every(({ problems }) => problems.size === 0);
  const asked: GroupAsk = {
    proposal: draft.proposal,
    name: draft.name.trim(),
    operator: draft.requests.length > 1 && draft.operator === "SINGLE" ? "MANY" : draft.operator,
    urgency: draft.urgency,
    priority,
    requests: requests.map((request) => request.asked),
  };
  return { asked: isWhole ? asked : null, problems: fields.problems, requests, shutterS: requests.reduce((sum, { shutterS }) => sum + shutterS, 0) };
}

export function readRequest(draft: RequestDraft, { momentOf, nowUs, abilities }: DraftReading): ReadRequest {
  const fields = new FieldReader<RequestField>();
  const target = readTarget(draft, fields);
  const configurations = readFrames(draft, fields, abilities);
  const constraints = readConstraints(draft, fields, abilities);
  const windows = draft.windows.map((window) => readWindow(window, momentOf));
  checkWindows(windows, fields, nowUs);
  return {
    asked: { target, configurations, constraints, windows: [...windows] },
    problems: fields.problems,
    target,
    constraints,
    windows,
    shutterS: configurations.reduce((sum, { exposure, count = 1 }) => sum + exposure * count, 0),
  };
}

function readTarget(draft: RequestDraft, fields: FieldReader<RequestField>): RequestShape["target"] {
  const name = draft.target.trim().slice(0, 100);
  switch (draft.way) {
    case "none":
      return null;
    case "body":
      return { type: "SOLAR_SYSTEM", name, body: draft.body };
    case "fixed": {
      const altitude = fields.number("altitude", draft.altitude, [0, 90], msg("Altitude in °"));
      const azimuth = fields.number("azimuth", draft.azimuth, [0, 359.999], msg("Azimuth in °"));
      return fields.problems.has("altitude") || fields.problems.has("azimuth") ? null : { type: "FIXED", name, altitude, azimuth };
    }
    case "stars": {
      const [ra, dec] = [parseRa(draft.ra), parseDec(draft.dec)];
      if (Number.isNaN(ra)) fields.problems.set("ra", msg("Find the target by its name, or write 05:34:32 or 83.63° (J2000)."));
      if (Number.isNaN(dec)) fields.problems.set("dec", msg("Write −05:23:28 or −5.39 (°, J2000)."));
      const motion = {
        proper_motion_ra: fields.optional("motionRa", draft.motionRa, [-20_000, 20_000], msg("Proper motion in mas/year"), 0),
        proper_motion_dec: fields.optional("motionDec", draft.motionDec, [-20_000, 20_000], msg("Proper motion in mas/year"), 0),
        epoch: fields.optional("epoch", draft.epoch, [1800, 2200], msg("Epoch, a year"), 2000),
      };
      const angle = fields.optional("angle", draft.angle, [-360, 360], msg("Position angle in °"), null);
      const isRead = (["ra", "dec", "motionRa", "motionDec", "epoch"] as const).every((field) => !fields.problems.has(field));
      // As it was written, where it can be: a remainder has other last digits.
      const turned = angle === null || Number.isNaN(angle) ? {} : { position_angle: angle >= 0 && angle < 360 ? angle : wrapped(angle, 360) };
      return isRead ? { type: "ICRS", name, ra: (ra * 15) % 360, dec, ...motion, ...turned } : null;
    }
  }
}

function readConstraints(draft: RequestDraft, fields: FieldReader<RequestField>, abilities: AbilitiesShape | null): ReadConstraints {
  const lit = fields.optional("moonLit", draft.moonLit, [0, 100], msg("Moon lit in %"), null);
  if (abilities?.measures_seeing === false && draft.seeing.trim() !== "") fields.problems.set("seeing", msg("This site does not measure the seeing: leave it empty."));
  if (abilities?.measures_clouds === false && draft.clouds.trim() !== "") fields.problems.set("clouds", msg("This site does not measure clouds: leave it empty."));
  return {
    min_altitude: fields.number("minAltitude", draft.minAltitude, [0, 90], msg("Lowest altitude in °")),
    max_airmass: fields.optional("maxAirmass", draft.maxAirmass, [1, 40], msg("Airmass"), 10),
    min_moon_distance: fields.number("moonDistance", draft.moonDistance, [0, 180], msg("Distance from the Moon in °")),
    max_moon_illumination: lit === null ? 1 : lit / 100,
    max_sun_altitude: fields.number("sunAltitude", draft.sunAltitude, [-90, 0], msg("Sun in °")),
    max_hour_angle: fields.optional("hourAngle", draft.hourAngle, [0.01, 12], msg("Hour angle in h"), null),
    max_seeing: fields.optional("seeing", draft.seeing, [0.1, 60], msg("Seeing in ″"), null),
    max_clouds: fields.optional("clouds", draft.clouds, [0, 100], msg("Clouds in %"), null),
    phase: readPhase(draft, fields),
  };
}

function readPhase(draft: RequestDraft, fields: FieldReader<RequestField>): ReadConstraints["phase"] {
  const { phasePeriod, phaseEpoch, phaseStart, phaseEnd } = draft;
  if ([phasePeriod, phaseEpoch, phaseStart, phaseEnd].every((text) => text.trim() === "")) return null;
  const period = fields.number("phasePeriod", phasePeriod, [0.000_01, LONGEST_PERIOD_S / DAY_S], msg("Period in days")) * DAY_S;
  const epoch = parseMoment(phaseEpoch);
  if (Number.isNaN(epoch)) fields.problems.set("phaseEpoch", msg("Write JD 2460000.5 or 2026-12-04 21:30 (UTC)."));
  const start = fields.number("phaseStart", phaseStart, [0, 1], msg("Phase"));
  const end = fields.number("phaseEnd", phaseEnd, [0, 1], msg("Phase"));
  return { epoch_us: sinceEpoch(epoch, period * 1e6), period_s: period, start, end };
}

/** Tables give epochs of long ago; the hub counts from 1970. The phase is the same so many periods later. */
function sinceEpoch(us: number, periodUs: number): number {
  return us >= 0 || !(periodUs > 0) ? us : Math.round(us + Math.ceil(-us / periodUs) * periodUs);
}

function readWindow({ start, end, startUs, endUs }: WindowDraft, momentOf: DraftReading["momentOf"]): WindowShape {
  return { start_us: startUs ?? momentOf(start), end_us: endUs ?? momentOf(end) };
}

function checkWindows(windows: readonly WindowShape[], { problems }: FieldReader<RequestField>, nowUs: number): void {
  if (windows.length === 0) problems.set("windows", msg("Add at least one window."));
  windows.forEach(({ start_us: start, end_us: end }, i) => {
    if (!(start > 0)) problems.set(rowField("start", i), msg("Write a date and a time."));
    if (!(end > 0)) problems.set(rowField("end", i), msg("Write a date and a time."));
    else if (end <= start) problems.set(rowField("end", i), msg("The window ends before it begins."));
  });
  const last = windows.reduce((latest, { end_us: end }) => Math.max(latest, end), 0);
  // Of several some may be over.
  if (last > 0 && last <= nowUs) problems.set(rowField("end", windows.findIndex(({ end_us: end }) => end === last)), windows.length > 1 ? msg("All windows are over.") : msg("This window is over."));
}
