/**
 * STOP (software) as this page knows it. Pure: presses, news and times in, messages out.
 *
 * A press is repeated until the gateway names its id. What is shown keeps three things apart:
 * *sent* by this page, *latched* at the gateway, *confirmed* by the robot itself.
 */

import { msg } from "@lit/localize";

export const REPEAT_MS = 200;
/** How long the second step of a reset stays open. */
export const ARMED_MS = 10_000;
export const RESET_ANSWER_MS = 3000;

/** The fields of `StopUpdate` that decide. */
export interface StopReport {
  readonly latched: boolean;
  readonly confirmed: boolean;
  readonly who: string;
  readonly time_us: number;
  readonly id: string;
}

/** unknown: nobody told us yet. */
export type StopMachinePhase = "unknown" | "clear" | "sent" | "latched" | "confirmed";

/** none: STOP is to be released by two steps, of which neither is taken. */
export type ResetPhase =
  | { readonly kind: "none" }
  | { readonly kind: "asking"; readonly since: number }
  | { readonly kind: "armed"; readonly token: string; readonly until: number }
  | { readonly kind: "releasing"; readonly since: number };

export class StopMachine {
  private pending: { readonly id: string; readonly since: number } | null = null;
  private repeatAt = 0;
  private word: StopReport | null = null;
  private reset_: ResetPhase = { kind: "none" };
  private answeredIn_: number | null = null;
  /** Why STOP or its reset was not done; empty when there is nothing to say. */
  trouble = "";

  get phase(): StopMachinePhase {
    if (this.pending) return "sent";
    if (!this.word) return "unknown";
    if (!this.word.latched) return "clear";
    return this.word.confirmed ? "confirmed" : "latched";
  }

  /** Driving must not begin: STOP is latched, or asked for and not answered. */
  get blocksDriving(): boolean {
    return this.pending !== null || this.word?.latched === true;
  }

  get reset(): ResetPhase {
    return this.reset_;
  }

  /** Who latched it, and when (µs since the epoch); null while it is not latched. */
  get latchedBy(): { readonly who: string; readonly time_us: number } | null {
    return this.word?.latched ? { who: this.word.who, time_us: this.word.time_us } : null;
  }

  /** From the press to the gateway's answer (ms); null before. */
  get answerMs(): number | null {
    return this.answeredIn_;
  }

  waitingMs(now: number): number {
    return this.pending ? now - this.pending.since : 0;
  }

  /** STOP. Gives the id to send at once; a press while one is under way sends that again. */
  pressStop(id: string, now: number): string {
    this.pending ??= { id, since: now };
    this.repeatAt = now + REPEAT_MS;
    this.reset_ = { kind: "none" };
    this.answeredIn_ = null;
    this.trouble = "";
    return this.pending.id;
  }

  /** It was sent and could not be passed on now; it goes on being repeated. */
  markDelayed(why: string): void {
    if (this.pending) this.trouble = why;
  }

  /** The hub will not pass it on; repeating it would change nothing. */
  markRefused(why: string): void {
    if (!this.pending) return;
    this.pending = null;
    this.trouble = why;
  }

  applyUpdate(word: StopReport, now: number): void {
    if (this.pending?.id === word.id) {
      this.answeredIn_ = now - this.pending.since;
      this.pending = null;
      this.trouble = "";
    }
    this.word = word;
    if (!word.latched || this.reset_.kind !== "armed") this.reset_ = { kind: "none" };
    if (!word.latched) this.trouble = "";
  }

  /** The link is away: what we knew of the robot is no longer known. A press stays wanted. */
  onLinkLost(): void {
    this.word = null;
    this.reset_ = { kind: "none" };
  }

  /** First step of a reset. False when there is nothing to release. */
  askReset(now: number): boolean {
    if (this.pending || !this.word?.latched || this.reset_.kind !== "none") return false;
    this.reset_ = { kind: "asking", since: now };
    this.trouble = "";
    return true;
  }

  /** The key to the second step, or why there is none. */
  receiveResetKey(token: string, refused: string, now: number): void {
    if (this.reset_.kind !== "asking" && this.reset_.kind !== "releasing") return;
    const armed = token !== "" && this.reset_.kind === "asking";
    this.reset_ = armed ? { kind: "armed", token, until: now + ARMED_MS } : { kind: "none" };
    if (!armed) this.trouble = refused === "" ? msg("The gateway gave no key for the release.") : refused;
  }

  /** Second step. Gives the token to send. */
  releaseStop(now: number): string | null {
    if (this.reset_.kind !== "armed" || now >= this.reset_.until) return null;
    const { token } = this.reset_;
    this.reset_ = { kind: "releasing", since: now };
    return token;
  }

  keepStopped(): void {
    this.reset_ = { kind: "none" };
  }

  /** Time has passed. Gives the id of a STOP that is to be sent again. */
  advance(now: number): string | null {
    const reset = this.reset_;
    if (reset.kind === "armed" && now >= reset.until) this.reset_ = { kind: "none" };
    if (
      (reset.kind === "asking" || reset.kind === "releasing") &&
      now - reset.since >= RESET_ANSWER_MS
    ) {
      this.reset_ = { kind: "none" };
      this.trouble = msg("The gateway did not answer the release. STOP may still be latched.");
    }
    if (!this.pending || now < this.repeatAt) return null;
    this.repeatAt = now + REPEAT_MS;
    return this.pending.id;
  }
}
