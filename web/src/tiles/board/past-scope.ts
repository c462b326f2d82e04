/** What stands inside shows a past moment: it reads from the history where it would read what comes. */

import { ContextProvider } from "@lit/context";
import { LitElement, css, html, type TemplateResult } from "lit";
import { customElement, property } from "lit/decorators.js";
import { interlocksContext, liveContext, pastContext, reachContext } from "../../state/contexts.js";
import type { PastBoard } from "../../state/past/past-board.js";
import { PAST_LOCKS, PAST_REACH } from "../../state/past/past-guards.js";

/** @slot - the board; it has to be made anew for another `past` */
@customElement("t-past-scope")
export class PastScope extends LitElement {
  static override styles = css`
    :host {
      display: block;
      min-inline-size: 0;
    }
  `;

  private board: PastBoard | null = null;

  get past(): PastBoard | null {
    return this.board;
  }

  /** Said before anything stands inside: whoever asks for values then gets those of the past. */
  @property({ attribute: false })
  set past(board: PastBoard | null) {
    if (board === null || board === this.board) return;
    this.board = board;
    new ContextProvider(this, { context: pastContext, initialValue: board });
    new ContextProvider(this, { context: liveContext, initialValue: board.values });
    new ContextProvider(this, { context: reachContext, initialValue: PAST_REACH });
    new ContextProvider(this, { context: interlocksContext, initialValue: PAST_LOCKS });
  }

  override render(): TemplateResult {
    return html`<slot></slot>`;
  }
}

declare global {
  interface HTMLElementTagNameMap {
    "t-past-scope": PastScope;
  }
}
