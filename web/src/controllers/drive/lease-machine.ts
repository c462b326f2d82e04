/**
 * The lease of a device as this page knows it. Pure: news and times in, what to ask out.
 *
 * A lease counts as mine only while I want it: an answer that arrives after I let go changes
 * nothing, and a lease whose time has run out by our own clock is lost without asking anyone.
 */

import { msg, str } from "@lit/localize";
import type { HaltReason } from "./drive-machine.js";

export const RENEW_MS = 1000;
/** An ask without an answer for so long has failed. */
export const ANSWER_MS = 3000;
/** The gateway tells by itself that an ask was in vain; so long after its end we no longer wait. */
export const VAIN_MS = 1500;

export type LeaseAsk = "take" | "renew" | "free" | "ask" | "accept" | "deny" | "force";

/** The fields of `LeaseUpdate` that decide. */
export interface LeaseReport {
  readonly holder: string;
  readonly yours: boolean;
  readonly epoch: number;
  readonly remains_ms: number;
  readonly rival: string;
  readonly asking: boolean;
  readonly answer_ms: number;
  readonly refused: string;
  readonly forceable: boolean;
}

/** Somebody who asks me for control, and until when I may answer. */
export interface LeaseRival {
  readonly who: string;
  readonly until: number;
}

/** unknown: nobody told us yet; waiting: the holder was asked and may answer. */
export type LeaseState =
  | { readonly kind: "unknown" }
  | { readonly kind: "free" }
  | { readonly kind: "asking"; readonly since: number }
  | { readonly kind: "mine"; readonly epoch: number; readonly until: number; readonly rival: LeaseRival | null }
  | { readonly kind: "waiting"; readonly holder: string; readonly until: number }
  | { readonly kind: "other"; readonly holder: string; readonly forceable: boolean };

const ENDED = msg("The gateway ended your control. Take control again to continue.");

export class LeaseMachine {
  private now_: LeaseState = { kind: "unknown" };
  private renewAt = 0;
  private handedOver = false;
  /** My time was out before the gateway said who has it; what it says then is still the answer. */
  private ranOut = false;
  /** Why an ask was not granted, or why the lease ended; empty when there is nothing to say. */
  trouble = "";

  get state(): LeaseState {
    return this.now_;
  }

  get epoch(): number {
    return this.now_.kind === "mine" ? this.now_.epoch : 0;
  }

  remainingMs(now: number): number {
    return this.now_.kind === "mine" ? Math.max(0, this.now_.until - now) : 0;
  }

  /** I hold it, or something of mine is under way to get it. */
  get isWanted(): boolean {
    return this.now_.kind === "mine" || this.now_.kind === "asking" || this.now_.kind === "waiting";
  }

  /** How long the one who is asked may answer yet (ms): I, or the holder whom I ask. */
  answerRemainingMs(now: number): number {
    if (this.now_.kind === "waiting") return Math.max(0, this.now_.until - now);
    return this.now_.kind === "mine" && this.now_.rival ? Math.max(0, this.now_.rival.until - now) : 0;
  }

  /** I want it: from whoever has it, or from nobody. */
  requestLease(now: number): LeaseAsk | null {
    if (this.isWanted) return null;
    const op = this.now_.kind === "other" ? "ask" : "take";
    this.now_ = { kind: "asking", since: now };
    this.trouble = "";
    return op;
  }

  /** I answer who asks me. Nothing of mine changes before the gateway says so. */
  answerRequest(yes: boolean): LeaseAsk | null {
    if (this.now_.kind !== "mine" || this.now_.rival === null) return null;
    this.handedOver = yes;
    this.now_ = { ...this.now_, rival: null };
    return yes ? "accept" : "deny";
  }

  /** I take it from a holder who said no, or nothing. */
  forceTakeover(now: number): LeaseAsk | null {
    if (this.now_.kind !== "other" || !this.now_.forceable) return null;
    this.now_ = { kind: "asking", since: now };
    this.trouble = "";
    return "force";
  }

  /** I let it go, or no longer ask for it. */
  releaseLease(): LeaseAsk | null {
    if (!this.isWanted) return null;
    const { now_ } = this;
    this.now_ = now_.kind === "waiting" ? { kind: "other", holder: now_.holder, forceable: false } : { kind: "free" };
    this.trouble = "";
    return "free";
  }

  /** The link is away. Whatever we held is over; nobody can be asked. */
  onLinkLost(trouble: string): void {
    const held = this.isWanted;
    this.now_ = { kind: "unknown" };
    this.trouble = held ? trouble : "";
  }

  /** What the gateway says. Gives why the lease ended, when this ended it. */
  applyUpdate(word: LeaseReport, now: number): HaltReason | null {
    const mine = this.now_.kind === "mine";
    const ranOut = this.ranOut && this.now_.kind === "unknown";
    this.ranOut = false;
    if (word.yours && word.epoch > 0 && this.isWanted) {
      if (!mine) {
        this.renewAt = now + RENEW_MS;
        this.handedOver = false;
      }
      const rival = word.rival === "" ? null : { who: word.rival, until: now + word.answer_ms };
      this.now_ = { kind: "mine", epoch: word.epoch, until: now + word.remains_ms, rival };
      this.trouble = "";
      return null;
    }
    if (word.asking && this.isWanted && !mine) {
      this.now_ = { kind: "waiting", holder: word.holder, until: now + word.answer_ms };
      return null;
    }
    if (this.now_.kind === "asking" && word.refused === "") return null;
    // Late news of a lease that I freed: the free is already on its way.
    const other = word.holder !== "" && !word.yours;
    const before = this.now_;
    if (!word.forceable && other && before.kind === "other" && before.holder === word.holder) {
      // The same as before, said to all, or to a renewal that crossed the loss: what happened
      // stays to be read.
      return null;
    }
    this.trouble = word.refused;
    this.now_ = other ? { kind: "other", holder: word.holder, forceable: word.forceable } : { kind: "free" };
    if (ranOut && other && this.trouble === "") this.trouble = this.lostToText(word.holder);
    if (!mine) return null;
    if (this.trouble === "") this.trouble = other ? this.lostToText(word.holder) : ENDED;
    return "lease lost";
  }

  private lostToText(holder: string): string {
    return this.handedOver ? msg(str`You handed control to ${holder}.`) : msg(str`${holder} has control now.`);
  }

  /** Time has passed: what to ask, and whether the lease just ran out. */
  advance(now: number): { readonly ask: LeaseAsk | null; readonly ended: HaltReason | null } {
    const state = this.now_;
    if (state.kind === "asking" && now - state.since >= ANSWER_MS) {
      this.now_ = { kind: "unknown" };
      this.trouble = msg("The gateway did not answer. Try again.");
      // It may have been granted on the way: let it go, so that nobody waits for it.
      return { ask: "free", ended: null };
    }
    if (state.kind === "waiting" && now - state.until >= VAIN_MS) {
      this.now_ = { kind: "other", holder: state.holder, forceable: false };
      this.trouble = msg("The gateway did not answer your request. Try again.");
      return { ask: "free", ended: null };
    }
    if (state.kind !== "mine") return { ask: null, ended: null };
    if (now >= state.until) {
      this.now_ = { kind: "unknown" };
      this.ranOut = true;
      this.trouble = msg("Your control ran out: the gateway did not answer in time. Take it again.");
      return { ask: null, ended: "lease lost" };
    }
    if (now < this.renewAt) return { ask: null, ended: null };
    this.renewAt = now + RENEW_MS;
    return { ask: "renew", ended: null };
  }
}
