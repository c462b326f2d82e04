/** States of nights and requests as people read them. Pure. */

import { msg } from "@lit/localize";
import type { ObservationState, RequestState, Urgency } from "../generated/api.js";
import type { NightPhase } from "../generated/wire.js";

/** What a phase is called, and how it looks. */
interface StateWords {
  readonly word: string;
  readonly kind: "ok" | "warn" | "bad" | "busy" | "unknown" | "online";
}

export const PHASE_WORDS: Readonly<Record<NightPhase, StateWords & { readonly meaning: string }>> = {
  disarmed: { word: msg("Disarmed"), kind: "unknown", meaning: msg("Nothing opens by itself.") },
  waiting: { word: msg("Armed, waiting"), kind: "ok", meaning: msg("It opens by itself when the Sun is low enough, conditions allow it and there is something to observe.") },
  opening: { word: msg("Opening"), kind: "busy", meaning: msg("Roof and telescope are made ready.") },
  observing: { word: msg("Observing"), kind: "online", meaning: msg("Requests are observed, one after the other.") },
  closed: { word: msg("Armed, closed"), kind: "warn", meaning: msg("A condition keeps the roof closed; it goes on by itself after that.") },
  calibrating: { word: msg("Calibrating"), kind: "busy", meaning: msg("Flats, darks or bias are taken.") },
  parking: { word: msg("Parking and closing"), kind: "busy", meaning: msg("Telescope and roof go to where they are safe.") },
  fault: { word: msg("Fault"), kind: "bad", meaning: msg("A device failed, and nothing goes on by itself: a person must look at it.") },
};

export const REQUEST_WORDS: Readonly<Record<RequestState, StateWords>> = {
  DRAFT: { word: msg("draft"), kind: "unknown" },
  PENDING: { word: msg("pending"), kind: "busy" },
  COMPLETED: { word: msg("completed"), kind: "ok" },
  WINDOW_EXPIRED: { word: msg("window expired"), kind: "warn" },
  CANCELED: { word: msg("canceled"), kind: "unknown" },
  FAILURE_LIMIT_REACHED: { word: msg("failed too often"), kind: "bad" },
};

export const OBSERVATION_WORDS: Readonly<Record<ObservationState, StateWords>> = {
  PENDING: { word: msg("planned"), kind: "unknown" },
  IN_PROGRESS: { word: msg("in progress"), kind: "busy" },
  SUSPENDED: { word: msg("interrupted, goes on later"), kind: "warn" },
  COMPLETED: { word: msg("completed"), kind: "ok" },
  ABORTED: { word: msg("ended by a person"), kind: "warn" },
  FAILED: { word: msg("failed"), kind: "bad" },
  NOT_ATTEMPTED: { word: msg("not tried"), kind: "unknown" },
  CANCELED: { word: msg("canceled"), kind: "unknown" },
  BAD_DATA: { word: msg("of no use"), kind: "bad" },
};

export const URGENCY_WORDS: Readonly<Record<Urgency, string>> = {
  NORMAL: msg("normal"),
  TIME_CRITICAL: msg("time-critical"),
  RAPID_RESPONSE: msg("rapid response"),
};
