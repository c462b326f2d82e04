/** Who acts on a device now and since when, calmly, in the words of the refusal. */

import { msg, str } from "@lit/localize";
import { css, html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, property } from "lit/decorators.js";
import { ContextStoreController } from "../../controllers/context-store.js";
import { TickerController } from "../../controllers/ticker.js";
import { base } from "../../elements/base/base-style.js";
import { formatDuration } from "../../format/duration.js";
import { deviceHoldersContext } from "../../state/contexts.js";

@customElement("t-device-holder")
export class DeviceHolderLine extends LitElement {
  static override styles = [
    base,
    css`
      :host {
        min-inline-size: 0;
      }
      span {
        display: block;
        color: var(--t-muted);
        font-variant-numeric: tabular-nums;
        overflow-wrap: anywhere;
      }
    `,
  ];

  @property() site = "";
  @property() device = "";

  private readonly holders = new ContextStoreController(this, deviceHoldersContext);

  constructor() {
    super();
    new TickerController(this);
  }

  override render(): readonly TemplateResult[] | typeof nothing {
    const found = this.holders.store?.holdersOf(this.site, this.device) ?? [];
    if (found.length === 0) return nothing;
    // Not spoken each second: it is looked up, and the dialog asks where it matters.
    return found.map(
      ({ words, since }) =>
        html`<span role="note">${msg(str`${words} (since ${formatDuration((performance.now() - since) / 1000)})`)}</span>`,
    );
  }
}

declare global {
  interface HTMLElementTagNameMap {
    "t-device-holder": DeviceHolderLine;
  }
}
