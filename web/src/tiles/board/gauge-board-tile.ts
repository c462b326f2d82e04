/** A signal between its least and its greatest, live. */

import { msg } from "@lit/localize";
import { html, LitElement, nothing, css, type TemplateResult } from "lit";
import { customElement, property } from "lit/decorators.js";
import { LiveValuesController } from "../../controllers/live-values.js";
import type { ValueState } from "../../elements/values/value.js";
import { shownUnit, toShown } from "../../format/unit.js";
import { outOfRange } from "../../format/state-label.js";
import type { SignalShape } from "../../generated/api.js";
import "../../elements/values/gauge.js";
import type { BoardTileContext } from "./board-tile-entry.js";

@customElement("t-tile-gauge")
export class GaugeBoardTile extends LitElement {
  static override styles = css`
    :host {
      display: block;
      block-size: 100%;
      min-block-size: 0;
    }
  `;

  @property({ attribute: false }) context: BoardTileContext | null = null;
  @property({ attribute: false }) signal: SignalShape | null = null;
  @property() look = "gauge";
  /** NaN: the signal's own. */
  @property({ type: Number }) least = Number.NaN;
  @property({ type: Number }) most = Number.NaN;
  @property({ type: Number, attribute: "warn-below" }) warnBelow = Number.NaN;
  @property({ type: Number, attribute: "warn-above" }) warnAbove = Number.NaN;

  private readonly live = new LiveValuesController(this);

  override willUpdate(): void {
    this.live.observeChannels(this.context?.site ?? "", this.signal?.channels ?? []);
  }

  override render(): TemplateResult | typeof nothing {
    const { signal } = this;
    if (signal === null) return nothing;
    const channel = signal.channels[0] ?? signal.address;
    const value = this.live.readingOf(channel)?.value ?? Number.NaN;
    const [low, high] = [Number.isNaN(this.least) ? (signal.minimum ?? 0) : this.least, Number.isNaN(this.most) ? (signal.maximum ?? 100) : this.most];
    return html`<t-gauge
      .look=${this.look}
      .value=${toShown(signal.shown, value)}
      .unit=${shownUnit(signal).unit}
      .decimals=${shownUnit(signal).decimals}
      .least=${toShown(signal.shown, low)}
      .most=${toShown(signal.shown, high > low ? high : low + 1)}
      .state=${this.state(signal, channel, value)}
      .age=${this.live.ageS(channel)}
      .missing=${this.live.isPast ? msg("nothing recorded") : msg("no data yet")}
      .level=${value < this.warnBelow || value > this.warnAbove ? "warn" : ""}
    ></t-gauge>`;
  }

  private state(signal: SignalShape, channel: string, value: number): ValueState {
    const now = this.live.freshnessOf(channel, signal.max_age);
    if (now !== "live") return now;
    if (this.context?.online !== true) return "stale";
    return outOfRange(signal, value) ? "outside" : "live";
  }
}

declare global {
  interface HTMLElementTagNameMap {
    "t-tile-gauge": GaugeBoardTile;
  }
}
