/** Does one thing after the other for an element, and keeps what went wrong. */

import type { ReactiveController, ReactiveControllerHost } from "lit";
import { actionAdvice, type Advice } from "../format/error-advice.js";

export class ActionController implements ReactiveController {
  private current = "";
  private failure: Advice | null = null;
  private success = "";

  constructor(private readonly host: ReactiveControllerHost) {
    host.addController(this);
  }

  /** What is under way, by its key; empty for nothing. */
  get runningKey(): string {
    return this.current;
  }

  get busy(): boolean {
    return this.current !== "";
  }

  /** What the last one failed of; null when it did not. */
  get problem(): Advice | null {
    return this.failure;
  }

  /** What was done last, for screen readers and eyes; empty when nothing was. */
  get doneText(): string {
    return this.success;
  }

  /**
   * Does something, unless something else is under way. Gives whether it was done.
   *
   * @param asked what it is, as the object of "did not": `change the password`
   * @param done what to say afterwards
   * @param key tells it from others of the same words while it is under way
   */
  async run(asked: string, action: () => Promise<unknown>, done = "", key = asked): Promise<boolean> {
    if (this.busy) return false;
    this.setState(key, null, "");
    try {
      await action();
      this.setState("", null, done);
      return true;
    } catch (error) {
      this.setState("", actionAdvice(error, asked), "");
      return false;
    }
  }

  /** Forgets what was said. */
  readonly clear = (): void => {
    if (this.failure !== null || this.success !== "") this.setState(this.current, null, "");
  };

  hostConnected(): void {
    this.failure = null;
    this.success = "";
  }

  private setState(current: string, failure: Advice | null, success: string): void {
    this.current = current;
    this.failure = failure;
    this.success = success;
    this.host.requestUpdate();
  }
}
