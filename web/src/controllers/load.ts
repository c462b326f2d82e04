/** Loads something for an element, once for each question; what failed is asked again once the hub is there again. */

import type { ReactiveController, ReactiveControllerHost } from "lit";
import { comeback } from "../wire/backoff.js";

export type Loaded<T> =
  | { readonly state: "idle" }
  | { readonly state: "loading"; readonly before: T | undefined }
  | { readonly state: "ready"; readonly value: T }
  | { readonly state: "failed"; readonly error: unknown };

export class LoadController<T> implements ReactiveController {
  private now: Loaded<T> = { state: "idle" };
  private question: string | undefined;
  private run = 0;
  private stopWaiting: () => void = () => undefined;

  constructor(private readonly host: ReactiveControllerHost) {
    host.addController(this);
  }

  get result(): Loaded<T> {
    return this.now;
  }

  /** Newest value, also while the next one is loading. */
  get value(): T | undefined {
    if (this.now.state === "ready") return this.now.value;
    return this.now.state === "loading" ? this.now.before : undefined;
  }

  /** Loads when the question is another than the last; call it from `willUpdate`. */
  load(question: string, load: () => Promise<T>): void {
    if (question !== this.question) {
      this.question = question;
      void this.start(load);
    }
  }

  /** The next `load` loads, also when the question is the same. */
  readonly invalidate = (): void => {
    this.question = undefined;
    this.host.requestUpdate();
  };

  hostConnected(): void {
    this.stopWaiting = comeback.subscribe(() => {
      if (this.now.state === "failed") this.invalidate();
    });
  }

  hostDisconnected(): void {
    this.stopWaiting();
    this.question = undefined;
    this.run += 1;
  }

  private async start(load: () => Promise<T>): Promise<void> {
    const run = ++this.run;
    this.setResult({ state: "loading", before: this.value });
    try {
      const value = await load();
      if (run === this.run) this.setResult({ state: "ready", value });
    } catch (error) {
      if (run === this.run) this.setResult({ state: "failed", error });
    }
  }

  private setResult(now: Loaded<T>): void {
    this.now = now;
    this.host.requestUpdate();
  }
}
