/**
 * The lease of a device as this page knows it. Pure: news and times in, what to ask out.
 *
 * A lease counts as mine only while I want it: an answer that arrives after I let go changes
 * nothing, and a lease whose time has run out by our own clock is lost without asking anyone.
 */

import type { Halt } from "./machine.js";

export const RENEW_MS = 1000;
/** An ask without an answer for so long has failed. */
export const ANSWER_MS = 3000;

export type LeaseAsk = "take" | "renew" | "free";

/** The fields of `LeaseNews` that decide. */
export interface LeaseWord {
  readonly holder: string;
  readonly yours: boolean;
  readonly epoch: number;
  readonly remains_ms: number;
  readonly refused: string;
}

/** unknown: nobody told us yet. */
export type LeaseState =
  | { readonly kind: "unknown" }
  | { readonly kind: "free" }
  | { readonly kind: "asking"; readonly since: number }
  | { readonly kind: "mine"; readonly epoch: number; readonly until: number }
  | { readonly kind: "other"; readonly holder: string };

export class LeaseDesk {
  private now_: LeaseState = { kind: "unknown" };
  private renewAt = 0;
  /** Why an ask was not granted, or why the lease ended; empty when there is nothing to say. */
  trouble = "";

  get state(): LeaseState {
    return this.now_;
  }

  get epoch(): number {
    return this.now_.kind === "mine" ? this.now_.epoch : 0;
  }

  remains(now: number): number {
    return this.now_.kind === "mine" ? Math.max(0, this.now_.until - now) : 0;
  }

  /** I want it. */
  take(now: number): LeaseAsk | null {
    if (this.now_.kind === "mine" || this.now_.kind === "asking") return null;
    this.now_ = { kind: "asking", since: now };
    this.trouble = "";
    return "take";
  }

  /** I let it go. */
  free(): LeaseAsk | null {
    if (this.now_.kind !== "mine" && this.now_.kind !== "asking") return null;
    this.now_ = { kind: "free" };
    this.trouble = "";
    return "free";
  }

  /** The link is away. Whatever we held is over; nobody can be asked. */
  lose(trouble: string): void {
    const held = this.now_.kind === "mine" || this.now_.kind === "asking";
    this.now_ = { kind: "unknown" };
    this.trouble = held ? trouble : "";
  }

  /** What the gateway says. Gives why the lease ended, when this ended it. */
  news(word: LeaseWord, now: number): Halt | null {
    const wanted = this.now_.kind === "mine" || this.now_.kind === "asking";
    const mine = this.now_.kind === "mine";
    if (word.yours && word.epoch > 0 && wanted) {
      if (!mine) this.renewAt = now + RENEW_MS;
      this.now_ = { kind: "mine", epoch: word.epoch, until: now + word.remains_ms };
      this.trouble = "";
      return null;
    }
    if (this.now_.kind === "asking" && word.refused === "") return null;
    this.trouble = word.refused;
    // Late news of a lease that I freed: the free is already on its way.
    const other = word.holder !== "" && !word.yours;
    this.now_ = other ? { kind: "other", holder: word.holder } : { kind: "free" };
    if (!mine) return null;
    if (this.trouble === "") {
      this.trouble = other
        ? `${word.holder} has control now.`
        : "The gateway ended your control. Take it again to go on.";
    }
    return "lease lost";
  }

  /** Time has passed: what to ask, and whether the lease just ran out. */
  beat(now: number): { readonly ask: LeaseAsk | null; readonly ended: Halt | null } {
    const state = this.now_;
    if (state.kind === "asking" && now - state.since >= ANSWER_MS) {
      this.now_ = { kind: "unknown" };
      this.trouble = "The gateway did not answer. Try again.";
      // It may have been granted on the way: let it go, so that nobody waits for it.
      return { ask: "free", ended: null };
    }
    if (state.kind !== "mine") return { ask: null, ended: null };
    if (now >= state.until) {
      this.now_ = { kind: "unknown" };
      this.trouble = "Your control ran out: the gateway did not answer in time. Take it again.";
      return { ask: null, ended: "lease lost" };
    }
    if (now < this.renewAt) return { ask: null, ended: null };
    this.renewAt = now + RENEW_MS;
    return { ask: "renew", ended: null };
  }
}
