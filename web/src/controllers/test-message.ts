/** Sends test messages for an element, one after the other, and keeps how the last one went. */

import { msg } from "@lit/localize";
import type { ReactiveControllerHost } from "lit";
import type { WentShape } from "../generated/api.js";
import type { ActionController } from "./action.js";

export class TestMessageController {
  private last: { readonly id: string; readonly how: WentShape } | null = null;

  /**
   * @param action of the same element: a test waits for whatever else is under way
   * @param send sends a test by the way or rule of this id
   */
  constructor(
    private readonly host: ReactiveControllerHost,
    private readonly action: ActionController,
    private readonly send: (id: string) => Promise<WentShape>,
  ) {}

  /** How the last test went, if it was of this one. */
  lastResult(id: string): WentShape | null {
    return this.last?.id === id ? this.last.how : null;
  }

  isRunning(id: string): boolean {
    return this.action.runningKey === keyOf(id);
  }

  /** What a press of its button does. */
  testAction(id: string): () => void {
    return () => {
      this.last = null;
      void this.action.run(
        msg("send the test"),
        async () => {
          this.last = { id, how: await this.send(id) };
        },
        "",
        keyOf(id),
      );
      this.host.requestUpdate();
    };
  }
}

function keyOf(id: string): string {
  return `test ${id}`;
}
