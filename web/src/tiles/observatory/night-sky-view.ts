/** The sky over the site: where the telescope looks now, and what the night still looks at. */

import { msg } from "@lit/localize";
import { css, html, nothing, type TemplateResult } from "lit";
import { customElement, property } from "lit/decorators.js";
import { base } from "../../elements/base/base-style.js";
import type { PlannedAim, TelescopeAim } from "../../elements/observatory/sky-chart.js";
import { toHorizontal, type GeoPlace } from "../../sky/coordinates.js";
import { DevicePart, partStyle } from "./device-part.js";
import { telescopeSignals } from "./roles.js";
import "../../elements/observatory/sky-chart.js";

@customElement("t-night-sky")
export class NightSkyView extends DevicePart {
  static override styles = [
    base,
    partStyle,
    css`
      :host {
        gap: var(--t-space-2);
      }
    `,
  ];

  @property({ attribute: false }) planned: readonly PlannedAim[] = [];
  /** The moment (ms since 1970). */
  @property({ type: Number }) ms = 0;

  override willUpdate(): void {
    if (this.device === null) return;
    const { ra, dec, alt, az } = telescopeSignals(this.device);
    this.observeSignals(ra, dec, alt, az);
  }

  override render(): TemplateResult {
    const place = this.detail?.place ?? null;
    if (place === null) return html`<p class="note">${msg("The chart of the sky needs the site's place. It is not described, or not open to you.")}</p>`;
    const telescope = this.telescopeAim(place);
    return html`<t-sky-chart .place=${place} .ms=${this.ms} .telescope=${telescope} .planned=${this.planned} .limit=${this.device?.pointing?.horizon ?? 0}></t-sky-chart>
      ${telescope === null ? html`<p class="note">${msg("Where the telescope looks is not known now.")}</p>` : nothing}`;
  }

  /** What it says itself, or what follows from its coordinates. */
  private telescopeAim(place: GeoPlace): TelescopeAim | null {
    if (this.device === null) return null;
    const signals = telescopeSignals(this.device);
    const [ra, dec, alt, az] = [signals.ra, signals.dec, signals.alt, signals.az].map((signal) => this.readSignal(signal));
    const { name } = this.device;
    if (alt?.fresh === true && az?.fresh === true) return { name, alt: alt.value, az: az.value };
    if (ra?.fresh !== true || dec?.fresh !== true) return null;
    return { name, ...toHorizontal({ ra: signals.ra?.unit === "°" ? ra.value / 15 : ra.value, dec: dec.value }, place, this.ms) };
  }
}

declare global {
  interface HTMLElementTagNameMap {
    "t-night-sky": NightSkyView;
  }
}
