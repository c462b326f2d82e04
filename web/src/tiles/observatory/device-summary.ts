/** What tells most of a device, at a glance: a few values, and of the weather the verdict. */

import { css, html, nothing, type TemplateResult } from "lit";
import { customElement } from "lit/decorators.js";
import { map } from "lit/directives/map.js";
import { ContextStoreController } from "../../controllers/context-store.js";
import { base } from "../../elements/base/base-style.js";
import { formatDec, formatRa } from "../../format/sexagesimal.js";
import { interlocksContext } from "../../state/contexts.js";
import type { InterlockUpdate } from "../../generated/wire.js";
import type { RuleInfo, SignalInfo } from "../../wire/api-types.js";
import { NO_DEVICE, DevicePart } from "./device-part.js";
import { summarySignals } from "../catalog.js";
import { outletsOf, telescopeSignals } from "./roles.js";
import { limitLines, rulesAbout, verdictOf, VERDICT_KINDS, VERDICT_WORDS } from "./weather-verdict.js";
import "../../elements/feedback/status.js";
import "../../elements/values/value.js";
import "../signal-value.js";

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
        font-size: var(--t-size-l);
      }
      .one {
        display: grid;
        gap: 2px;
      }
      .name {
        color: var(--t-muted);
        font-size: var(--t-size-s);
      }
    `,
  ];

  private readonly interlocks = new ContextStoreController(this, interlocksContext);

  override willUpdate(): void {
    const device = this.device ?? NO_DEVICE;
    const outlets = device.kind === "power" ? outletsOf(device).map(({ signal }) => signal) : [];
    this.observeSignals(...(device.kind === "weather" ? device.signals : [...summarySignals(device), ...outlets]));
  }

  override render(): TemplateResult | typeof nothing {
    const { device } = this;
    if (device === null) return nothing;
    return html`${this.renderVerdict()} ${this.renderOutlets()} ${map(summarySignals(device), (signal) => this.renderValue(signal))}`;
  }

  private renderValue(signal: SignalInfo): TemplateResult {
    const { ra, dec } = this.device?.kind === "telescope" ? telescopeSignals(this.device) : { ra: undefined, dec: undefined };
    if (signal !== ra && signal !== dec) return html`<t-signal-value size="m" .site=${this.site} .signal=${signal}></t-signal-value>`;
    const { fresh, value } = this.readSignal(signal);
    const text = signal === dec ? formatDec(value) : formatRa(signal.unit === "°" ? value / 15 : value);
    return html`<span class="one"
      ><span class="name">${signal === ra ? "RA" : "Dec"}</span
      ><t-value
        bare
        .state=${fresh ? "live" : this.online ? this.live.freshnessOf(signal.channels[0] ?? "", signal.max_age) : "stale"}
        .text=${text}
      ></t-value
    ></span>`;
  }

  private renderVerdict(): unknown {
    const { device, detail } = this;
    if (device?.kind !== "weather" || detail === null) return nothing;
    const rules = rulesAbout(detail.rules, device.id);
    const news = ({ id }: RuleInfo): InterlockUpdate | undefined => this.interlocks.store?.interlockOf(this.site, id)?.news;
    const lines = limitLines(rules, device.id, device.signals, (signal) => this.readSignal(signal), news);
    const { word } = verdictOf(this.online, rules, news, lines);
    if (word === "none") return nothing;
    return html`<t-status class="verdict" kind=${VERDICT_KINDS[word]} .word=${VERDICT_WORDS[word]}></t-status>`;
  }

  private renderOutlets(): unknown {
    const { device } = this;
    const outlets = device?.kind === "power" ? outletsOf(device) : [];
    if (outlets.length === 0) return nothing;
    const on = outlets.map(({ signal }) => this.isOn(signal));
    const unknown = on.filter((closed) => closed === null).length;
    const text = `${String(on.filter((closed) => closed === true).length)} of ${String(outlets.length)} on`;
    return html`<span class="one"
      ><span class="name">Outlets</span
      ><t-value bare .state=${unknown === outlets.length ? "unknown" : "live"} .text=${unknown === 0 ? text : `${text}, ${String(unknown)} ?`}></t-value
    ></span>`;
  }
}

declare global {
  interface HTMLElementTagNameMap {
    "t-telling": DeviceSummaryValues;
  }
}
