/** The form of a request group that is there: all of it, so that reading the form asks the same. Pure. */

import type { GroupShape, RequestShape, WindowShape } from "../../../generated/api.js";
import { formatMoment } from "../../../format/julian-date.js";
import { formatDec, formatRa, parseDec, parseRa } from "../../../format/sexagesimal.js";
import { newRequest, type FramesDraft, type GroupDraft, type RequestDraft, type WindowDraft } from "./draft.js";

const DAY_S = 86_400;

/**
 * The form of a group.
 *
 * @param textOf what a field of date and time shows for a moment (µs)
 */
export function draftOf(group: GroupShape, textOf: (us: number) => string): GroupDraft {
  return {
    proposal: group.proposal,
    name: group.name,
    operator: group.operator,
    urgency: group.urgency,
    priority: numberText(group.priority),
    requests: group.requests.map((request) => requestDraft(request, textOf)),
  };
}

/** The same group once more: what is over by now begins now, and keeps its lengths and distances. */
export function movedToNow(group: GroupShape, nowUs: number): GroupShape {
  const windows = group.requests.flatMap((request) => request.windows);
  const isOver = group.requests.some((request) => request.windows.every(({ end_us: end }) => end <= nowUs));
  if (!isOver) return group;
  // All by the same way, so that a sequence or a cadence stays one.
  const by = nowUs - Math.min(...windows.map(({ start_us: start }) => start));
  return { ...group, requests: group.requests.map((request) => ({ ...request, windows: request.windows.map(({ start_us: start, end_us: end }) => ({ start_us: start + by, end_us: end + by })) })) };
}

export function windowDraft({ start_us: startUs, end_us: endUs }: WindowShape, textOf: (us: number) => string): WindowDraft {
  return { start: textOf(startUs), end: textOf(endUs), startUs, endUs };
}

/** The same draft by another clock: what was not typed is written anew. */
export function withZone(draft: GroupDraft, textOf: (us: number) => string): GroupDraft {
  const rewrite = (window: WindowDraft): WindowDraft => ({
    ...window,
    start: window.startUs === null ? window.start : textOf(window.startUs),
    end: window.endUs === null ? window.end : textOf(window.endUs),
  });
  return { ...draft, requests: draft.requests.map((request) => ({ ...request, windows: request.windows.map(rewrite) })) };
}

function requestDraft({ target, constraints, windows, configurations }: RequestShape, textOf: (us: number) => string): RequestDraft {
  const shown = windows.map((window) => windowDraft(window, textOf));
  const { phase } = constraints;
  return {
    ...newRequest({ start: "", end: "", startUs: null, endUs: null }),
    ...targetFields(target),
    minAltitude: numberText(constraints.min_altitude ?? 15),
    maxAirmass: numberText(constraints.max_airmass === 10 ? null : constraints.max_airmass),
    moonDistance: numberText(constraints.min_moon_distance ?? 0),
    moonLit: numberText(constraints.max_moon_illumination === undefined || constraints.max_moon_illumination === 1 ? null : constraints.max_moon_illumination * 100),
    sunAltitude: numberText(constraints.max_sun_altitude ?? -12),
    hourAngle: numberText(constraints.max_hour_angle),
    seeing: numberText(constraints.max_seeing),
    clouds: numberText(constraints.max_clouds),
    ...(phase == null
      ? {}
      : { phasePeriod: numberText(phase.period_s / DAY_S), phaseEpoch: formatMoment(phase.epoch_us), phaseStart: numberText(phase.start), phaseEnd: numberText(phase.end) }),
    windows: shown,
    frames: configurations.map(({ type = "LIGHT", filter = "", exposure, count = 1, binning = 1, gain, dither = 0, guiding = "OFF" }): FramesDraft => ({
      type, filter, guiding, exposure: numberText(exposure), count: numberText(count), binning: numberText(binning), gain: numberText(gain), dither: numberText(dither),
    })),
  };
}

/** Twelve digits: a period's error grows with its cycles. */
function numberText(value: number | null | undefined): string {
  return value === null || value === undefined ? "" : String(Number(value.toPrecision(12)));
}

function targetFields(target: RequestShape["target"]): Partial<RequestDraft> {
  if (target === null) return { way: "none" };
  const name = target.name ?? "";
  switch (target.type) {
    case "ICRS": {
      const { proper_motion_ra: ra = 0, proper_motion_dec: dec = 0, epoch = 2000 } = target;
      const moves = ra !== 0 || dec !== 0 || epoch !== 2000;
      const motion = moves ? { motionRa: numberText(ra), motionDec: numberText(dec), epoch: numberText(epoch) } : {};
      return { way: "stars", target: name, ...coordinateTexts(target.ra, target.dec), ...motion, angle: numberText(target.position_angle) };
    }
    case "SOLAR_SYSTEM":
      return { way: "body", target: name, body: target.body };
    case "FIXED":
      return { way: "fixed", target: name, altitude: numberText(target.altitude), azimuth: numberText(target.azimuth) };
  }
}

/** A place (°, J2000) as the fields show it: so exact that reading them gives the same place within 0.001″. */
export function coordinateTexts(raDeg: number, dec: number): { readonly ra: string; readonly dec: string } {
  const [ra, size] = [Number(raDeg.toFixed(8)), Number(dec.toFixed(8))];
  const exact = Math.abs(parseRa(formatRa(raDeg / 15)) * 15 - raDeg) < 2e-7 && Math.abs(parseDec(formatDec(dec)) - dec) < 2e-7;
  return exact ? { ra: formatRa(raDeg / 15), dec: formatDec(dec) } : { ra: `${String(ra)}°`, dec: String(size) };
}
