/**
 * One-shot commands asked by this page. Pure: asks, news and times in, what to show out.
 *
 * An id is used once. Nothing here ever sends a command again: what became of one that nobody
 * answered is *unknown*, and a person decides.
 */

import { msg } from "@lit/localize";

export type RequestStage =
  | "sent"
  | "accepted"
  | "running"
  | "succeeded"
  | "failed"
  | "refused"
  | "cancelled"
  | "unknown"
  | "offline";

const FINAL: ReadonlySet<RequestStage> = new Set<RequestStage>([
  "succeeded",
  "failed",
  "refused",
  "cancelled",
  "unknown",
  "offline",
]);

/** One command that was asked for. */
export interface CommandRequest {
  readonly id: string;
  readonly device: string;
  readonly command: string;
  readonly phase: RequestStage;
  readonly message: string;
  /** 0 to 1 */
  readonly progress: number;
  readonly since: number;
  /** Refused because of this command (its id) of somebody else; it may be interrupted by `over`. */
  readonly blockedBy: string;
}

/** The fields of `CommandUpdate` that decide. */
export interface CommandReport {
  readonly id: string;
  readonly phase: Exclude<RequestStage, "sent" | "offline">;
  readonly message: string;
  readonly progress: number;
  readonly blocked_by?: string;
}

const MESSAGE_UNHEARD =
  msg("No answer. It may or may not have been done: look at the device before you ask again.");
/** Accepted or refused must come within the command's own time limit; this much grace on top. */
const GRACE_MS = 1000;

export function isFinal(phase: RequestStage): boolean {
  return FINAL.has(phase);
}

export class CommandMachine {
  /** Newest ask of each command, by device and command. */
  private readonly newest = new Map<string, CommandRequest>();
  private readonly limits = new Map<string, number>();

  latestRequest(device: string, command: string): CommandRequest | null {
    return this.newest.get(`${device}/${command}`) ?? null;
  }

  /** @param ttlMs - not accepted within this time, it is refused */
  addRequest(id: string, device: string, command: string, ttlMs: number, now: number): void {
    const asked: CommandRequest = {
      id, device, command, phase: "sent", message: "", progress: 0, since: now, blockedBy: "",
    };
    this.newest.set(`${device}/${command}`, asked);
    this.limits.set(id, ttlMs);
  }

  /** The ask did not leave this page. */
  markUnsent(id: string): void {
    this.updateRequest(id, { phase: "offline", message: msg("Not connected. Nothing was sent.") });
  }

  markRefused(id: string, message: string, offline: boolean): void {
    this.updateRequest(id, { phase: offline ? "offline" : "refused", message });
  }

  /** A problem about commands that names no id belongs to the newest one still unanswered. */
  newestUnanswered(): CommandRequest | null {
    let found: CommandRequest | null = null;
    for (const asked of this.newest.values()) {
      if (asked.phase === "sent" && (!found || asked.since >= found.since)) found = asked;
    }
    return found;
  }

  /** It was seen that somebody else acts; the question is answered. */
  markAnswered(id: string): void {
    for (const [key, asked] of this.newest) {
      if (asked.id === id) this.newest.set(key, { ...asked, blockedBy: "" });
    }
  }

  applyUpdate(word: CommandReport): void {
    const { phase, message, progress, blocked_by: blockedBy = "" } = word;
    this.updateRequest(word.id, { phase, message, progress, blockedBy });
  }

  /** The link is away: of what was under way, nobody knows the end. */
  onLinkLost(): void {
    for (const asked of this.newest.values()) {
      if (!isFinal(asked.phase)) {
        this.updateRequest(asked.id, { phase: "unknown", message: MESSAGE_UNHEARD });
      }
    }
  }

  /** Time has passed. True when something changed. */
  advance(now: number): boolean {
    let changed = false;
    for (const asked of this.newest.values()) {
      const limit = (this.limits.get(asked.id) ?? 0) + GRACE_MS;
      if (asked.phase === "sent" && now - asked.since >= limit) {
        this.updateRequest(asked.id, { phase: "unknown", message: MESSAGE_UNHEARD });
        changed = true;
      }
    }
    return changed;
  }

  private updateRequest(id: string, change: Partial<CommandRequest>): void {
    for (const [key, asked] of this.newest) {
      if (asked.id !== id) continue;
      // News of an end is the last word, but "unknown" may still be cleared up by a late one.
      if (isFinal(asked.phase) && asked.phase !== "unknown") return;
      this.newest.set(key, { ...asked, ...change });
    }
  }
}
