/** Warns a person who holds a device before the session ends: nobody is cut off while driving without a word. */

import { msg, str } from "@lit/localize";
import { html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, state } from "lit/decorators.js";
import { ContextConsumer } from "@lit/context";
import { ConnectionStateController } from "../../controllers/connection-state.js";
import { ContextStoreController } from "../../controllers/context-store.js";
import { TickerController } from "../../controllers/ticker.js";
import { base } from "../../elements/base/base-style.js";
import { formatDuration } from "../../format/duration.js";
import { robotNewsContext, sessionContext } from "../../state/contexts.js";
import { isNear, sessionTimeLeft, type SessionTimeLeft } from "../../state/session-time-left.js";
import "../../elements/feedback/banner.js";
import "../../elements/forms/button.js";

/** Whoever holds a device is asked about this often: the end moves with what the person does. */
const ASK_EVERY_MS = 30_000;

@customElement("t-session-end")
export class SessionWarning extends LitElement {
  static override styles = [base];

  @state() private failed = false;
  private askedAt = 0;
  private hubAheadUs = 0;
  private readonly session = new ContextStoreController(this, sessionContext);
  private readonly news = new ContextConsumer(this, { context: robotNewsContext });

  constructor() {
    super();
    new TickerController(this);
    new ConnectionStateController(this, (connection) => [
      connection.onMessage("greeting", ({ time_us }) => {
        this.hubAheadUs = time_us - Date.now() * 1000;
      }),
    ]);
  }

  override willUpdate(): void {
    if (this.news.value?.holdsAny() !== true || performance.now() - this.askedAt < ASK_EVERY_MS) return;
    this.askedAt = performance.now();
    void this.session.store?.refresh().catch(() => undefined);
  }

  override render(): TemplateResult | typeof nothing {
    const person = this.session.store?.person ?? null;
    if (person === null || this.news.value?.holdsAny() !== true) return nothing;
    const left = sessionTimeLeft(person, Date.now() * 1000 + this.hubAheadUs);
    return isNear(left) ? this.renderWarning(left) : nothing;
  }

  private renderWarning(left: SessionTimeLeft): TemplateResult {
    const time = formatDuration(left.seconds);
    if (left.kind === "whole") {
      return html`<t-banner kind="warn"
        >${msg(str`This session has lasted as long as it may and ends in ${time}; you will lose control then. Bring the vehicle to rest, and sign in anew.`)}</t-banner
      >`;
    }
    return html`<t-banner kind="warn"
      >${msg(str`You will be signed out in ${time}, and lose control then.`)}
      <t-button @click=${this.extendSession}>${msg("Stay signed in")}</t-button>
      ${this.failed ? html`<strong>${msg("The hub did not answer.")}</strong>` : nothing}</t-banner
    >`;
  }

  private readonly extendSession = (): void => {
    void this.loadSessionEnd();
  };

  private async loadSessionEnd(): Promise<void> {
    try {
      await this.session.store?.extend();
      this.failed = false;
    } catch {
      this.failed = true;
    }
    this.requestUpdate();
  }
}

declare global {
  interface HTMLElementTagNameMap {
    "t-session-end": SessionWarning;
  }
}
