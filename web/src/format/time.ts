/** Moments in a site's own time zone, with UTC beside it. */

import { intlLocale } from "../words/locale.js";

export interface TimeText {
  /** `14:05:09`, or with the date before it when it is another day than `today`. */
  readonly local: string;
  /** `CEST`, `GMT+2`: what the zone is called at that moment. */
  readonly zone: string;
  /** `12:05:09 UTC` */
  readonly utc: string;
  /** For the `datetime` attribute. */
  readonly machine: string;
}

const formats = new Map<string, Intl.DateTimeFormat>();

// Building one takes far longer than using it.
function formatterOf(zone: string, options: Intl.DateTimeFormatOptions): Intl.DateTimeFormat {
  const key = `${intlLocale()} ${zone} ${JSON.stringify(options)}`;
  let made = formats.get(key);
  if (made === undefined) {
    made = new Intl.DateTimeFormat(intlLocale(), { timeZone: knownZone(zone), ...options });
    formats.set(key, made);
  }
  return made;
}

const zones = new Map<string, string>();

/** The zone itself, or UTC when this browser does not know it. */
export function knownZone(zone: string): string {
  let known = zones.get(zone);
  if (known === undefined) {
    known = isKnown(zone) ? zone : "UTC";
    zones.set(zone, known);
  }
  return known;
}

function isKnown(zone: string): boolean {
  try {
    new Intl.DateTimeFormat("en-GB", { timeZone: zone });
    return true;
  } catch {
    return false;
  }
}

const DAY = { year: "numeric", month: "short", day: "numeric" } as const;
const CLOCK = { hour: "2-digit", minute: "2-digit", second: "2-digit", hourCycle: "h23" } as const;

export function formatClock(us: number, zone: string): string {
  return formatterOf(zone, CLOCK).format(us / 1000);
}

export function formatDate(us: number, zone: string): string {
  return formatterOf(zone, DAY).format(us / 1000);
}

/** What the zone is called at a moment: it changes with summer time. */
export function zoneName(us: number, zone: string): string {
  const parts = formatterOf(zone, { timeZoneName: "short" }).formatToParts(us / 1000);
  return parts.find((part) => part.type === "timeZoneName")?.value ?? "UTC";
}

/** @param nowUs to leave the date away when it is today's */
export function timeText(us: number, zone: string, nowUs: number): TimeText {
  const clockText = (where: string): string => {
    const day = formatDate(us, where);
    const clock = formatClock(us, where);
    return day === formatDate(nowUs, where) ? clock : `${day}, ${clock}`;
  };
  return {
    local: clockText(zone),
    zone: zoneName(us, zone),
    utc: `${clockText("UTC")} UTC`,
    machine: new Date(us / 1000).toISOString(),
  };
}

/** A stretch of time by the site's clock, as the axes have it. */
export function localSpan(span: { readonly fromUs: number; readonly toUs: number }, zone: string, nowUs: number): string {
  const [from, to] = [span.fromUs, span.toUs].map((us) => timeText(us, zone, nowUs).local);
  return `${from ?? ""} – ${to ?? ""} ${zoneName(span.toUs, zone)}`;
}

/** A stretch of time in UTC, to stand beside the site's own; empty where the site's is UTC. */
export function utcSpan(span: { readonly fromUs: number; readonly toUs: number }, zone: string, nowUs: number): string {
  if (zoneName(span.toUs, zone) === "UTC") return "";
  const from = timeText(span.fromUs, "UTC", nowUs);
  return `${from.local} – ${timeText(span.toUs, "UTC", nowUs).utc}`;
}
