/** States of nights and requests as people read them. Pure. */

import type { ObservationState, RequestState, Urgency } from "../generated/api.js";
import type { NightPhase } from "../generated/wire.js";

/** What a phase is called, and how it looks. */
interface StateWords {
  readonly word: string;
  readonly kind: "ok" | "warn" | "bad" | "busy" | "unknown" | "online";
}

export const PHASE_WORDS: Readonly<Record<NightPhase, StateWords & { readonly meaning: string }>> = {
  disarmed: { word: "Disarmed", kind: "unknown", meaning: "Nothing opens by itself." },
  waiting: { word: "Armed, waiting", kind: "ok", meaning: "It opens by itself when the Sun is low enough, conditions allow it and there is something to observe." },
  opening: { word: "Opening", kind: "busy", meaning: "Roof and telescope are made ready." },
  observing: { word: "Observing", kind: "online", meaning: "Requests are observed, one after the other." },
  closed: { word: "Armed, closed", kind: "warn", meaning: "A condition keeps the roof closed; it goes on by itself after that." },
  calibrating: { word: "Calibrating", kind: "busy", meaning: "Flats, darks or bias are taken." },
  parking: { word: "Parking and closing", kind: "busy", meaning: "Telescope and roof go to where they are safe." },
  fault: { word: "Fault", kind: "bad", meaning: "A device failed, and nothing goes on by itself: a person must look at it." },
};

export const REQUEST_WORDS: Readonly<Record<RequestState, StateWords>> = {
  DRAFT: { word: "draft", kind: "unknown" },
  PENDING: { word: "pending", kind: "busy" },
  COMPLETED: { word: "completed", kind: "ok" },
  WINDOW_EXPIRED: { word: "window expired", kind: "warn" },
  CANCELED: { word: "canceled", kind: "unknown" },
  FAILURE_LIMIT_REACHED: { word: "failed too often", kind: "bad" },
};

export const OBSERVATION_WORDS: Readonly<Record<ObservationState, StateWords>> = {
  PENDING: { word: "planned", kind: "unknown" },
  IN_PROGRESS: { word: "in progress", kind: "busy" },
  SUSPENDED: { word: "interrupted, goes on later", kind: "warn" },
  COMPLETED: { word: "completed", kind: "ok" },
  ABORTED: { word: "ended by a person", kind: "warn" },
  FAILED: { word: "failed", kind: "bad" },
  NOT_ATTEMPTED: { word: "not tried", kind: "unknown" },
  CANCELED: { word: "canceled", kind: "unknown" },
  BAD_DATA: { word: "of no use", kind: "bad" },
};

export const URGENCY_WORDS: Readonly<Record<Urgency, string>> = {
  NORMAL: "normal",
  TIME_CRITICAL: "time-critical",
  RAPID_RESPONSE: "rapid response",
};
