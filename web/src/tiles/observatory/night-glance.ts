/** An observatory's night at a glance: weather, dome, sky, telescope with its target, camera. Only to look at. */

import { msg } from "@lit/localize";
import { css, html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, property } from "lit/decorators.js";
import { map } from "lit/directives/map.js";
import { base, panelBox } from "../../elements/base/base-style.js";
import type { PlannedAim } from "../../elements/observatory/sky-chart.js";
import type { DeviceShape, SignalShape, SiteShape } from "../../generated/api.js";
import { devicePath } from "../../state/router.js";
import { telescopeSignals } from "./roles.js";
import "../../elements/feedback/status.js";
import "../board/night-board-tiles.js";
import "../signal-value.js";
import "./camera-part.js";
import "./dome-part.js";
import "./night-sky-view.js";

@customElement("t-night-glance")
export class NightGlance extends LitElement {
  static override styles = [
    base,
    css`
      :host {
        display: grid;
        grid-template-columns: repeat(auto-fit, minmax(min(15rem, 100%), 1fr));
        gap: var(--t-space-3);
        min-inline-size: 0;
      }
      section {
        display: grid;
        grid-template-columns: minmax(0, 1fr);
        align-content: start;
        gap: var(--t-space-2);
        padding: var(--t-space-3);
        ${panelBox}
        min-inline-size: 0;
      }
      /* So that the plan stands below it on the same screen; a station with many limits scrolls. */
      @media (min-width: 75rem) {
        section {
          max-block-size: 21rem;
          overflow: auto;
        }
      }
      h2 {
        font-size: var(--t-size-m);
      }
      h2 a {
        color: inherit;
      }
      .readings {
        display: grid;
        grid-template-columns: repeat(auto-fill, minmax(min(10rem, 100%), 1fr));
        gap: var(--t-space-2) var(--t-space-3);
      }
      .target {
        font-size: var(--t-size-l);
        font-weight: var(--t-weight-strong);
        overflow-wrap: anywhere;
      }
      .muted {
        color: var(--t-muted);
      }
    `,
  ];

  @property() site = "";
  @property({ attribute: false }) detail: SiteShape | null = null;
  @property({ attribute: false }) planned: readonly PlannedAim[] = [];
  /** What is observed now; empty where nothing is, or where it is not open to the person. */
  @property() target = "";
  /** What is done with it. */
  @property() step = "";
  /** The moment at the site (ms since 1970). */
  @property({ type: Number }) ms = 0;
  @property({ type: Boolean }) online = false;

  override render(): TemplateResult | typeof nothing {
    const { detail } = this;
    if (detail === null) return nothing;
    const first = (kind: DeviceShape["kind"]): DeviceShape | undefined => detail.devices.find((device) => device.kind === kind);
    const [weather, dome, telescope, camera] = [first("weather"), first("dome"), first("telescope"), first("camera")];
    return html`${this.renderPart(msg("Weather"), weather, (device) => html`<t-tile-verdict .site=${this.site} .device=${device} .detail=${detail} ?online=${this.online}></t-tile-verdict>`)}
      ${this.renderPart(msg("Dome"), dome, (device) => html`<t-part-dome compact .site=${this.site} .device=${device} .detail=${detail} ?online=${this.online}></t-part-dome>`)}
      ${this.renderPart(
        msg("Sky now"),
        telescope,
        (device) => html`<t-night-sky .site=${this.site} .detail=${detail} .device=${device} .planned=${this.planned} .ms=${this.ms} ?online=${this.online}></t-night-sky>`,
      )}
      ${this.renderPart(msg("Target"), telescope, (device) => this.renderTarget(device))}
      ${this.renderPart(msg("Camera"), camera, (device) => html`<t-part-camera compact .site=${this.site} .device=${device} .detail=${detail} ?online=${this.online}></t-part-camera>`)}`;
  }

  /** What is not there, or not open to the person, leaves no hole. */
  private renderPart(heading: string, device: DeviceShape | undefined, content: (device: DeviceShape) => TemplateResult): unknown {
    if (device === undefined) return nothing;
    return html`<section aria-label=${heading}>
      <h2><a href=${devicePath(this.site, device.id)}>${heading}</a></h2>
      ${content(device)}
    </section>`;
  }

  private renderTarget(device: DeviceShape): TemplateResult {
    const { state, tracking, ra, dec, alt, az } = telescopeSignals(device);
    return html`<p class="target">${this.target === "" ? html`<span class="muted">${msg("Nothing is observed")}</span>` : this.target}</p>
      ${this.step === "" ? nothing : html`<p>${this.step}</p>`}
      <div class="readings">${map([state ?? tracking, ra, dec, alt, az], (signal) => this.renderReading(signal))}</div>`;
  }

  private renderReading(signal: SignalShape | undefined): unknown {
    return signal === undefined ? nothing : html`<t-signal-value .site=${this.site} .signal=${signal}></t-signal-value>`;
  }
}

declare global {
  interface HTMLElementTagNameMap {
    "t-night-glance": NightGlance;
  }
}
