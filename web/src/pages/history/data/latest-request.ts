/**
 * One question at a time, always the newest: what is asked while an answer is on its way waits, and
 * of several that wait only the last is asked. So a window that is dragged is filled again and again
 * while it moves, and the hub never gets more than one question ahead of what is seen.
 */

import { comeback } from "../../../wire/backoff.js";

export type RequestStatus = "idle" | "loading" | "ready" | "failed";

export interface RequestTask<Q, A> {
  fetch(question: Q, signal: AbortSignal): Promise<A>;
  /** An answer to `running` would still be worth something to who asks `next`; otherwise it is cancelled. */
  isStillUseful(running: Q, next: Q): boolean;
  onAnswer(answer: A, question: Q): void;
  onChange(): void;
}

export class LatestRequest<Q, A> {
  state: RequestStatus = "idle";
  error: unknown = null;
  private asked = "";
  private running: { readonly question: Q; readonly stop: AbortController } | null = null;
  private waiting: Q | null = null;
  private stopWaiting: () => void = () => undefined;

  constructor(private readonly errand: RequestTask<Q, A>) {}

  /** Ask, unless this was the last question. */
  request(question: Q): void {
    const key = JSON.stringify(question);
    if (key === this.asked) return;
    this.asked = key;
    if (this.running !== null && this.errand.isStillUseful(this.running.question, question)) {
      this.waiting = question;
      return;
    }
    this.running?.stop.abort();
    void this.runRequest(question);
  }

  /** Nothing is wanted any more; what is under way is cancelled. */
  cancelRequest(state: RequestStatus = "idle"): void {
    this.asked = "";
    this.waiting = null;
    this.stopWaiting();
    this.running?.stop.abort();
    this.running = null;
    this.state = state;
    this.error = null;
  }

  /** The next `ask` asks, also when the question is the same. */
  invalidate(): void {
    this.asked = "";
  }

  private async runRequest(question: Q): Promise<void> {
    const stop = new AbortController();
    this.running = { question, stop };
    this.waiting = null;
    this.stopWaiting();
    this.setState("loading", null);
    let said: { readonly answer: A } | { readonly error: unknown };
    try {
      said = { answer: await this.errand.fetch(question, stop.signal) };
    } catch (error) {
      said = { error };
    }
    // Cancelled: somebody else has gone on already.
    if (stop.signal.aborted) return;
    this.running = null;
    if ("answer" in said) this.errand.onAnswer(said.answer, question);
    const next = this.waiting as Q | null;
    if (next !== null) void this.runRequest(next);
    else if ("answer" in said) this.setState("ready", null);
    else {
      // Asked once more by itself when the hub is there again.
      this.stopWaiting = comeback.subscribe(() => void this.runRequest(question));
      this.setState("failed", said.error);
    }
  }

  private setState(state: RequestStatus, error: unknown): void {
    this.state = state;
    this.error = error;
    this.errand.onChange();
  }
}
