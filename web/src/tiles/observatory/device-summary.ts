/** What tells most of a device, at a glance: a few values, and of the weather the verdict. */

import { msg, str } from "@lit/localize";
import { css, html, nothing, type TemplateResult } from "lit";
import { customElement, property } from "lit/decorators.js";
import { repeat } from "lit/directives/repeat.js";
import { ContextStoreController } from "../../controllers/context-store.js";
import { base, quietText } from "../../elements/base/base-style.js";
import { interlocksContext } from "../../state/contexts.js";
import type { SignalRole, SignalShape } from "../../generated/api.js";
import { NO_DEVICE, DevicePart } from "./device-part.js";
import { summarySignals } from "../catalog.js";
import { outletsOf } from "./roles.js";
import { judgeStation, VERDICT_KINDS, VERDICT_WORDS } from "./weather-verdict.js";
import "../../elements/feedback/status.js";
import "../../elements/values/value.js";
import "../signal-value.js";

/** Short names, where both stand beside each other. */
const SHORT_NAMES: Readonly<Partial<Record<SignalRole, string>>> = { "telescope.ra": "RA", "telescope.dec": "Dec" };

@customElement("t-telling")
export class DeviceSummaryValues extends DevicePart {
  static override styles = [
    base,
    css`
      :host {
        display: flex;
        flex-wrap: wrap;
        align-items: start;
        gap: var(--t-space-2) var(--t-space-5);
        min-inline-size: 0;
      }
      .verdict {
        flex: 1 0 100%;
        grid-column: 1 / -1;
        font-size: var(--t-size-l);
      }
      .one {
        display: grid;
        gap: 2px;
      }
      .name {
        ${quietText}
      }
    `,
  ];

  /** In the place of the values that the catalogue names. */
  @property({ attribute: false }) signals: readonly SignalShape[] | null = null;
  @property() size: "m" | "xl" = "m";

  private readonly interlocks = new ContextStoreController(this, interlocksContext);

  override willUpdate(): void {
    const device = this.device ?? NO_DEVICE;
    const outlets = device.kind === "power" ? outletsOf(device).map(({ signal }) => signal) : [];
    this.observeSignals(...(device.kind === "weather" ? device.signals : outlets));
  }

  override render(): TemplateResult | typeof nothing {
    const { device } = this;
    if (device === null) return nothing;
    return html`${this.renderVerdict()} ${this.renderOutlets()} ${repeat(
      this.signals ?? summarySignals(device),
      ({ address }) => address,
      (signal) => html`<t-signal-value .size=${this.size} .site=${this.site} .signal=${signal} .label=${SHORT_NAMES[signal.role] ?? ""}></t-signal-value>`,
    )}`;
  }

  private renderVerdict(): unknown {
    const { device, detail } = this;
    if (device?.kind !== "weather" || detail === null) return nothing;
    const { verdict: { word } } = judgeStation({
      rules: detail.rules,
      device,
      online: this.online,
      news: ({ id }) => this.interlocks.store?.interlockOf(this.site, id)?.news,
      known: (signal) => this.readSignal(signal),
    });
    if (word === "none") return nothing;
    return html`<t-status class="verdict" kind=${VERDICT_KINDS[word]} .word=${VERDICT_WORDS[word]}></t-status>`;
  }

  private renderOutlets(): unknown {
    const { device } = this;
    const outlets = device?.kind === "power" ? outletsOf(device) : [];
    if (outlets.length === 0) return nothing;
    const on = outlets.map(({ signal }) => this.isOn(signal));
    const unknown = on.filter((closed) => closed === null).length;
    const text = msg(str`${String(on.filter((closed) => closed === true).length)} of ${String(outlets.length)} on`);
    return html`<span class="one"
      ><span class="name">${msg("Outlets")}</span
      ><t-value bare .size=${this.size} .state=${unknown === outlets.length ? "unknown" : "live"} .text=${unknown === 0 ? text : `${text}, ${String(unknown)} ?`}></t-value
    ></span>`;
  }
}

declare global {
  interface HTMLElementTagNameMap {
    "t-telling": DeviceSummaryValues;
  }
}
