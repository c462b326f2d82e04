/** Which signals made an anomaly so: a bar for each, as long as its share. */

import { msg, str } from "@lit/localize";
import { css, html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, property } from "lit/decorators.js";
import { map } from "lit/directives/map.js";
import { formatNumber } from "../../format/number.js";
import type { ShareShape } from "../../generated/api.js";
import { base, plainList, quietText } from "../base/base-style.js";

/** Bars of smaller shares would tell nothing. */
const LEAST = 0.02;
const MOST_ROWS = 6;

/** What a signal has of an anomaly; `spreads` where one detector says how far it is off, `on` where it may be over by itself. */
export type SignalPart = Pick<ShareShape, "signal" | "share"> & { readonly spreads?: number; readonly on?: boolean };

@customElement("t-signal-shares")
export class SignalShares extends LitElement {
  static override styles = [
    base,
    css`
      ul {
        display: grid;
        gap: var(--t-space-1);
        max-inline-size: 44rem;
        ${plainList}
        font-size: var(--t-size-s);
      }
      li {
        display: grid;
        /* The last one of a fixed share: bars of several rows are compared with each other. */
        grid-template-columns: minmax(6rem, 14rem) minmax(3rem, 1fr) minmax(0, 16rem);
        align-items: center;
        gap: var(--t-space-3);
      }
      .name {
        overflow-wrap: anywhere;
      }
      svg {
        inline-size: 100%;
        block-size: 0.6rem;
        border-radius: var(--t-radius-s);
        background: var(--t-line);
      }
      rect {
        fill: var(--t-warn);
      }
      .said {
        font-variant-numeric: tabular-nums;
      }
      .far {
        ${quietText}
      }
      @media (max-width: 34rem) {
        ul {
          gap: var(--t-space-2);
        }
        li {
          row-gap: 0;
          grid-template-columns: minmax(3rem, 1fr) minmax(0, 15rem);
        }
        .name {
          grid-column: 1 / -1;
        }
      }
    `,
  ];

  @property({ attribute: false }) shares: readonly SignalPart[] = [];
  /** Names by addresses; an address without one stands for itself. */
  @property({ attribute: false }) labels: ReadonlyMap<string, string> = new Map();

  override render(): TemplateResult | typeof nothing {
    const shown = this.shares.filter(({ share }, place) => place === 0 || share >= LEAST).slice(0, MOST_ROWS);
    if (shown.length === 0) return nothing;
    return html`<ul aria-label=${msg("What made it so")}>
      ${map(shown, (share) => this.renderShare(share))}
    </ul>`;
  }

  private renderShare({ signal, share, spreads, on }: SignalPart): TemplateResult {
    const percent = formatNumber(share * 100, 0);
    const far = spreads === undefined ? "" : spreads >= 0 ? msg(str`${formatNumber(Math.abs(spreads), 1)} spreads above its level`) : msg(str`${formatNumber(Math.abs(spreads), 1)} spreads below its level`);
    const text = on === false ? msg("as usual again") : far;
    return html`<li>
      <span class="name">${this.labels.get(signal) ?? signal}</span>
      <svg aria-hidden="true"><rect height="100%" width=${`${String(Math.round(share * 1000) / 10)}%`}></rect></svg>
      <span class="said">${percent} % ${text === "" ? nothing : html`<span class="far">${text}</span>`}</span>
    </li>`;
  }
}

declare global {
  interface HTMLElementTagNameMap {
    "t-signal-shares": SignalShares;
  }
}
