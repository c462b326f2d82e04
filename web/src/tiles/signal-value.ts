import { msg } from "@lit/localize";
import { css, html, LitElement, type TemplateResult } from "lit";
import { customElement, property } from "lit/decorators.js";
import { LiveValuesController } from "../controllers/live-values.js";
import { messageLevel, stateLevel, type SeverityLevel } from "../format/severity.js";
import { formatNumber } from "../format/number.js";
import { shownText, shownUnit, toShown } from "../format/unit.js";
import { outOfRange, stateWord } from "../format/state-label.js";
import { base, quietText } from "../elements/base/base-style.js";
import { angleText } from "./observatory/roles.js";
import "../elements/values/value.js";
import type { ValueState } from "../elements/values/value.js";
import type { SignalShape } from "../generated/api.js";

/** A signal's name and its newest value, live. */
@customElement("t-signal-value")
export class SignalValue extends LitElement {
  static override styles = [
    base,
    css`
      :host {
        display: grid;
        align-content: start;
        gap: 2px;
        min-inline-size: 0;
      }
      .name {
        ${quietText}
        overflow: hidden;
        text-overflow: ellipsis;
        white-space: nowrap;
      }
    `,
  ];

  @property() site = "";
  @property({ attribute: false }) signal: SignalShape | null = null;
  @property() size: "s" | "m" | "l" | "xl" = "m";
  /** Said instead of the signal's own name, where that alone would not tell which. */
  @property() label = "";
  /** Without the name, where it stands beside already. */
  @property({ type: Boolean }) bare = false;

  private readonly live = new LiveValuesController(this);

  override willUpdate(): void {
    this.live.observeChannels(this.site, this.signal?.channels ?? []);
  }

  override render(): TemplateResult | null {
    const signal = this.signal;
    if (signal === null) return null;
    const channel = signal.channels[0] ?? signal.address;
    const reading = this.live.readingOf(channel);
    const name = this.label === "" ? signal.name : this.label;
    // Twice as long as other values: in their size it would reach into the next column.
    const isLong = signal.type === "number" && this.readingText(signal) !== "";
    return html`
      ${this.bare ? null : html`<span class="name" title=${name}>${name}</span>`}
      <t-value
        size=${isLong && this.size !== "s" ? "m" : this.size}
        state=${this.freshness(signal, channel)}
        .value=${toShown(signal.shown, reading?.value ?? Number.NaN)}
        .text=${this.readingText(signal)}
        .unit=${shownUnit(signal).unit}
        .decimals=${shownUnit(signal).decimals}
        .age=${this.live.ageS(channel)}
        .level=${this.level(signal)}
        .missing=${this.live.isPast ? msg("nothing recorded") : msg("no data yet")}
      ></t-value>
    `;
  }

  private freshness(signal: SignalShape, channel: string): ValueState {
    const now = this.live.freshnessOf(channel, signal.max_age);
    return now === "live" && outOfRange(signal, this.live.readingOf(channel)?.value ?? Number.NaN) ? "outside" : now;
  }

  private level(signal: SignalShape): SeverityLevel {
    const first = this.live.readingOf(signal.channels[0] ?? signal.address);
    if (signal.type === "text") return messageLevel(first?.text ?? "");
    return signal.type === "state" ? stateLevel(signal, first?.value ?? Number.NaN) : "";
  }

  private readingText(signal: SignalShape): string {
    const first = this.live.readingOf(signal.channels[0] ?? signal.address);
    if (first === undefined) return "";
    switch (signal.type) {
      case "number":
        return angleText(signal, first.value);
      case "text":
        return first.text ?? "";
      case "state":
        return stateWord(signal.states, first.value);
      case "position":
        return this.positionText(signal);
    }
  }

  private positionText(signal: SignalShape): string {
    const [a, b] = signal.channels.map((channel) => this.live.readingOf(channel)?.value ?? Number.NaN);
    if (signal.frame === "wgs84") {
      const decimals = signal.decimals >= 0 ? signal.decimals : 5;
      return `${formatNumber(a ?? Number.NaN, decimals)}°, ${formatNumber(b ?? Number.NaN, decimals)}°`;
    }
    const metres = { unit: "m", decimals: signal.decimals, shown: signal.shown };
    return `${shownText(metres, a ?? Number.NaN)}, ${shownText(metres, b ?? Number.NaN)}`;
  }
}

declare global {
  interface HTMLElementTagNameMap {
    "t-signal-value": SignalValue;
  }
}
