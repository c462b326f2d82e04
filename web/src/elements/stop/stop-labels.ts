/** How STOP stands, in words. */

import { msg, str } from "@lit/localize";
import { plural } from "../../words/plural.js";

export type StopPhase = "unknown" | "clear" | "sent" | "latched" | "confirmed";

export interface StopShown {
  readonly phase: StopPhase;
  /** Since the press (ms), while it is sent and not answered. */
  readonly waiting?: number;
}

/** Longer than this without an answer is worth a word. */
const LATE_MS = 1000;

/** One short line, for the button itself. */
export function stopLabel(stop: StopShown, online: boolean): string {
  switch (stop.phase) {
    case "clear":
      return online ? msg("Not latched") : msg("Cannot be confirmed now");
    case "unknown":
      return online ? msg("Press to stop the robot") : msg("Cannot be confirmed now");
    case "sent":
      return (stop.waiting ?? 0) > LATE_MS || !online ? msg("Sent, no answer yet: sending again") : msg("Sent…");
    case "latched":
      return msg("Latched at the gateway");
    case "confirmed":
      return msg("Latched; the robot is stopped");
  }
}

/** How far STOP got at gateways with the key of the linked one, which wait. */
export interface HeldStop {
  readonly held: number;
  readonly latched: number;
  readonly confirmed: number;
}

/** What is said of them: either may be the one that moves the robot. */
export function heldStopLabel({ held, latched, confirmed }: HeldStop): string {
  const who = plural(held, msg("A second gateway with the same key waits."), msg(str`${String(held)} more gateways with the same key wait.`));
  if (confirmed >= held) return msg(str`${who} STOP is latched there, too, and the robot there stands still.`);
  if (latched >= held) return msg(str`${who} STOP is latched there, too; that the robot there stands still is not confirmed.`);
  if (held === 1) return msg(str`${who} STOP was sent there, too, and is not answered.`);
  return plural(held - latched, msg(str`${who} STOP was sent to them, too; ${String(held - latched)} of them has not answered.`), msg(str`${who} STOP was sent to them, too; ${String(held - latched)} of them have not answered.`));
}

/** 0 not begun, 1 under way, 2 done; for sent, latched, confirmed. */
export function stopSteps(phase: StopPhase): readonly [0 | 1 | 2, 0 | 1 | 2, 0 | 1 | 2] {
  switch (phase) {
    case "unknown":
    case "clear":
      return [0, 0, 0];
    case "sent":
      return [2, 1, 0];
    case "latched":
      return [2, 2, 1];
    case "confirmed":
      return [2, 2, 2];
  }
}
