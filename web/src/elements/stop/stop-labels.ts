/** How STOP stands, in words. */

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
      return online ? "Not latched" : "Cannot be confirmed now";
    case "unknown":
      return online ? "Press to stop the robot" : "Cannot be confirmed now";
    case "sent":
      return (stop.waiting ?? 0) > LATE_MS || !online ? "Sent, no answer yet: sending again" : "Sent…";
    case "latched":
      return "Latched at the gateway";
    case "confirmed":
      return "Latched; the robot is stopped";
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
  const who = held === 1 ? "A second gateway with the same key waits." : `${String(held)} more gateways with the same key wait.`;
  if (confirmed >= held) return `${who} STOP is latched there, too, and the robot there stands still.`;
  if (latched >= held) return `${who} STOP is latched there, too; that the robot there stands still is not confirmed.`;
  if (held === 1) return `${who} STOP was sent there, too, and is not answered.`;
  return `${who} STOP was sent to them, too; ${String(held - latched)} of them ${held - latched === 1 ? "has" : "have"} not answered.`;
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
