/** What every drawn part of a device is given, and how it reads the device's signals. */

import { msg } from "@lit/localize";
import { css, html, LitElement, nothing } from "lit";
import { property } from "lit/decorators.js";
import { raisedBox, quietText } from "../../elements/base/base-style.js";
import type { CommandClient } from "../../controllers/drive/command-client.js";
import { LiveValuesController } from "../../controllers/live-values.js";
import { outOfRange, stateWord } from "../../format/state-label.js";
import type { DeviceShape, SignalShape, SiteShape } from "../../generated/api.js";
import type { KnownValue } from "./weather-verdict.js";

/** Stands in before the page has handed a device over. */
export const NO_DEVICE: DeviceShape = {
  id: "", name: "", kind: "other", signals: [], streams: [], commands: [], drive: null, public: false, link_loss: "",
  pointing: null, slew: null, unguarded: false, rights: [],
};

export const partStyle = css`
  :host {
    display: grid;
    grid-template-columns: minmax(0, 1fr);
    gap: var(--t-space-4);
    min-inline-size: 0;
    /* By the part's own width: in a tile of a board it is narrow on a wide screen. */
    container-type: inline-size;
  }
  .two {
    display: grid;
    grid-template-columns: minmax(0, 5fr) minmax(0, 4fr);
    gap: var(--t-space-4);
    align-items: start;
  }
  .card {
    display: grid;
    grid-template-columns: minmax(0, 1fr);
    gap: var(--t-space-4);
    align-content: start;
    padding: var(--t-space-4);
    ${raisedBox}
    min-inline-size: 0;
  }
  .readings {
    display: grid;
    grid-template-columns: repeat(auto-fill, minmax(min(9.5rem, 100%), 1fr));
    gap: var(--t-space-3) var(--t-space-4);
  }
  .note {
    ${quietText}
  }
  @container (max-width: 54rem) {
    .two {
      grid-template-columns: minmax(0, 1fr);
    }
  }
`;

export abstract class DevicePart extends LitElement {
  @property() site = "";
  @property({ attribute: false }) device: DeviceShape | null = null;
  @property({ attribute: false }) detail: SiteShape | null = null;
  @property({ attribute: false }) line: CommandClient | null = null;
  @property({ type: Boolean }) online = false;
  /** Only how it stands, in little room; nothing can be asked of it. */
  @property({ type: Boolean, reflect: true }) compact = false;

  protected readonly live = new LiveValuesController(this);

  /** The signals that this part reads; some of them may not be there. */
  protected observeSignals(...signals: readonly (SignalShape | undefined)[]): void {
    this.live.observeChannels(this.site, signals.flatMap((signal) => signal?.channels.slice(0, 1) ?? []));
  }

  /** A value that is old or impossible, or whose link is down, is not fresh: its number is not to be believed. */
  protected readSignal(signal: SignalShape | undefined): KnownValue {
    const channel = signal?.channels[0];
    if (signal === undefined || channel === undefined) return { fresh: false, value: Number.NaN, word: "" };
    const reading = this.live.readingOf(channel);
    const value = reading?.value ?? Number.NaN;
    const fresh = this.online && this.live.freshnessOf(channel, signal.max_age) === "live" && !outOfRange(signal, value);
    const word = signal.type === "state" ? stateWord(signal.states, value) : (reading?.text ?? "");
    return { fresh, value, word };
  }

  /** Whether it is on, of a state that is off or on; null when that is not known. */
  protected isOn(signal: SignalShape | undefined): boolean | null {
    const now = this.readSignal(signal);
    return now.fresh && !Number.isNaN(now.value) ? Math.round(now.value) === 1 : null;
  }

  protected get mayUse(): boolean {
    return this.device?.rights.includes("use") ?? false;
  }

  /** Said in the place of the buttons to whoever may only look. */
  protected renderLookOnly(): unknown {
    return this.mayUse ? nothing : html`<p class="note">${msg("You can view this device. Its commands are shown to users with the right to use it.")}</p>`;
  }
}
