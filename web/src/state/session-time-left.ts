/** How long a session still lasts. Pure. Times are µs since the epoch, UTC. */

/**
 * - `idle`: it ends unless the person does something
 * - `whole`: it has lasted as long as a session may
 */
export type EndKind = "idle" | "whole";

export interface SessionTimeLeft {
  readonly kind: EndKind;
  /** Until it ends (s); not below zero. */
  readonly seconds: number;
  readonly endsUs: number;
}

/** A person who holds a device is told this long (s) before. */
const WARN = 300;

/** Which end comes first. */
export function sessionTimeLeft(ends: { readonly idle_ends_us: number; readonly ends_us: number }, nowUs: number): SessionTimeLeft {
  const kind: EndKind = ends.idle_ends_us < ends.ends_us ? "idle" : "whole";
  const endsUs = Math.min(ends.idle_ends_us, ends.ends_us);
  return { kind, endsUs, seconds: Math.max(0, (endsUs - nowUs) / 1e6) };
}

export function isNear(left: SessionTimeLeft): boolean {
  return left.seconds <= WARN;
}
