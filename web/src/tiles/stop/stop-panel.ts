/** STOP (software) tied to its line: `t-stop` is the panel, `t-stop-bar` the button alone. */

import { msg } from "@lit/localize";
import { html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, property } from "lit/decorators.js";
import type { StopClient } from "../../controllers/drive/stop-client.js";
import "../../elements/stop/stop-button.js";
import "../../elements/stop/stop-state.js";

/** Draws an element again when its line changes, and while time matters. */
abstract class StopElement extends LitElement {
  @property({ attribute: false }) line: StopClient | null = null;
  private stopWatching: (() => void) | null = null;
  private watched: StopClient | null = null;

  override disconnectedCallback(): void {
    super.disconnectedCallback();
    this.stopWatching?.();
    this.stopWatching = null;
    this.watched = null;
  }

  override connectedCallback(): void {
    super.connectedCallback();
    this.requestUpdate();
  }

  override willUpdate(): void {
    if (this.watched === this.line) return;
    this.stopWatching?.();
    this.watched = this.line;
    this.stopWatching =
      this.line?.subscribe(() => {
        this.requestUpdate();
      }) ?? null;
  }
}

@customElement("t-stop-bar")
export class StopBar extends StopElement {
  override render(): TemplateResult | typeof nothing {
    const { line } = this;
    if (!line) return nothing;
    return html`<t-stop-button
      .stop=${{ phase: line.desk.phase, waiting: line.waitingMs }}
      .online=${line.online}
      @t-stop=${this.onPress}
    ></t-stop-button>`;
  }

  private readonly onPress = (): void => {
    this.line?.pressStop();
  };
}

@customElement("t-stop")
export class StopPanel extends StopElement {
  @property() zone = "UTC";
  /** Epoch of my lease; 0 without one. */
  @property({ type: Number }) epoch = 0;
  @property({ type: Boolean, attribute: "may-use" }) mayUse = false;

  override render(): TemplateResult | typeof nothing {
    const { line } = this;
    if (!line) return nothing;
    const { desk } = line;
    return html`<t-stop-state
      .phase=${desk.phase}
      .who=${desk.latchedBy?.who ?? ""}
      .time=${desk.latchedBy?.time_us ?? 0}
      .zone=${this.zone}
      .answered=${desk.answerMs ?? Number.NaN}
      .trouble=${desk.trouble}
      .online=${line.online}
      .step=${desk.reset.kind}
      .armed=${line.armedForMs}
      .held=${line.held}
      .hindrance=${this.releaseObstacle()}
      @t-reset-ask=${this.askReset}
      @t-reset-go=${this.releaseStop}
      @t-reset-keep=${this.keepStopped}
    ></t-stop-state>`;
  }

  private releaseObstacle(): string {
    if (!this.mayUse) return msg("Only people who may use this device can release STOP.");
    if (this.line?.online !== true) return msg("The site is offline: STOP stays latched.");
    return this.epoch === 0 ? msg("Take control first: the person who releases STOP is responsible for what moves next.") : "";
  }

  private readonly askReset = (): void => {
    this.line?.askReset(this.epoch);
  };

  private readonly releaseStop = (): void => {
    this.line?.releaseStop(this.epoch);
  };

  private readonly keepStopped = (): void => {
    this.line?.keepStopped();
  };
}

declare global {
  interface HTMLElementTagNameMap {
    "t-stop-bar": StopBar;
    "t-stop": StopPanel;
  }
}
