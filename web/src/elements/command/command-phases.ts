/** How far a command is, in words and a shape. */

import { msg } from "@lit/localize";
import type { StatusKind } from "../feedback/status.js";

export type RequestPhase =
  | "sent"
  | "accepted"
  | "running"
  | "succeeded"
  | "failed"
  | "refused"
  | "cancelled"
  | "unknown"
  | "offline";

export const PHASES: Readonly<Record<RequestPhase, { kind: StatusKind; word: string }>> = {
  sent: { kind: "busy", word: msg("sent") },
  accepted: { kind: "busy", word: msg("accepted") },
  running: { kind: "busy", word: msg("running") },
  succeeded: { kind: "ok", word: msg("succeeded") },
  failed: { kind: "bad", word: msg("failed") },
  refused: { kind: "warn", word: msg("refused") },
  cancelled: { kind: "warn", word: msg("cancelled") },
  unknown: { kind: "warn", word: msg("outcome unknown") },
  offline: { kind: "offline", word: msg("not connected") },
};
