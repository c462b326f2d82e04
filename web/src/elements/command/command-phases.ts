/** How far a command is, in words and a shape. */

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
  sent: { kind: "busy", word: "sent" },
  accepted: { kind: "busy", word: "accepted" },
  running: { kind: "busy", word: "running" },
  succeeded: { kind: "ok", word: "succeeded" },
  failed: { kind: "bad", word: "failed" },
  refused: { kind: "warn", word: "refused" },
  cancelled: { kind: "warn", word: "cancelled" },
  unknown: { kind: "warn", word: "outcome unknown" },
  offline: { kind: "offline", word: "not connected" },
};
