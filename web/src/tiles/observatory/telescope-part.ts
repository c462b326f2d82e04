/** A telescope: where it looks, drawn on the sky, and what it can be asked. */

import { msg } from "@lit/localize";
import { css, html, nothing, type TemplateResult } from "lit";
import { customElement, state } from "lit/decorators.js";
import { map } from "lit/directives/map.js";
import { base } from "../../elements/base/base-style.js";
import { fixedText, formatNumber } from "../../format/number.js";
import { formatAzimuth, formatDec, formatRa } from "../../format/sexagesimal.js";
import { formatClock } from "../../format/time.js";
import { moonPhase, sunFrom } from "../../sky/sun-and-moon.js";
import { darknessOf, DARKNESS } from "../../sky/night-visibility.js";
import { toHorizontal, type Equatorial, type Horizontal, type GeoPlace } from "../../sky/coordinates.js";
import type { TelescopeAim } from "../../elements/observatory/sky-chart.js";
import type { SignalShape } from "../../generated/api.js";
import { NO_DEVICE, DevicePart, partStyle } from "./device-part.js";
import { slewOf, telescopeCommands, telescopeSignals, type TelescopeSignals } from "./roles.js";
import { aimOf, type SkyTarget } from "./sky-target.js";
import "../../elements/observatory/sky-chart.js";
import "../../elements/feedback/status.js";
import "../../elements/values/value.js";
import "../command/command-buttons.js";
import "../signal-value.js";
import "./goto-form.js";

/** The sky moves a twentieth of a degree in this time. */
const EVERY_MS = 10_000;

@customElement("t-part-telescope")
export class TelescopePart extends DevicePart {
  static override styles = [
    base,
    partStyle,
    css`
      .side {
        display: grid;
        grid-template-columns: minmax(0, 1fr);
        gap: var(--t-space-4);
        min-inline-size: 0;
      }
      .looks {
        display: grid;
        grid-template-columns: minmax(0, 1fr) minmax(0, 2fr);
        gap: var(--t-space-3) var(--t-space-5);
      }
      .place {
        display: grid;
        grid-template-columns: auto minmax(0, 1fr);
        align-items: baseline;
        gap: var(--t-space-1) var(--t-space-4);
        margin: 0;
        font-variant-numeric: tabular-nums;
      }
      dt {
        color: var(--t-muted);
      }
      dd {
        margin: 0;
        font-size: var(--t-size-l);
        font-weight: var(--t-weight-strong);
      }
      dd.large {
        font-size: var(--t-size-xl);
        line-height: 1.2;
      }
      @container (max-width: 28rem) {
        .looks {
          grid-template-columns: minmax(0, 1fr);
        }
      }
      dd.old {
        color: var(--t-stale);
        font-weight: var(--t-weight);
      }
    `,
  ];

  @state() private target: SkyTarget | null = null;

  override willUpdate(): void {
    this.observeSignals(...Object.values<SignalShape | undefined>({ ...this.signals() }));
  }

  override render(): TemplateResult | typeof nothing {
    const { device, detail } = this;
    if (device === null || detail === null) return nothing;
    const { place } = detail;
    const ms = Math.floor(Date.now() / EVERY_MS) * EVERY_MS;
    const looks = this.pointingOf(place, ms);
    const scope: TelescopeAim | null = looks.horizontal === null ? null : { ...looks.horizontal, name: device.name };
    const target = this.target === null || place === null ? null : { ...aimOf(this.target, place, ms), name: this.target.name };
    return html`<div class="two" role="group" aria-label=${msg("Telescope")}>
      <div class="side">
        <div class="card">
          ${this.renderReadings(looks)} ${this.renderLookOnly()}
          <t-deeds
            .site=${this.site}
            .device=${device}
            .line=${this.line}
            .deeds=${telescopeCommands(device)}
            .online=${this.online}
          ></t-deeds>
        </div>
        <div class="card">
          ${place === null
            ? html`<p class="note">${msg("The chart of the sky needs the site's place. It is not described, or not open to you.")}</p>`
            : html`<t-sky-chart .place=${place} .ms=${ms} .telescope=${scope} .target=${target} .limit=${device.pointing?.horizon ?? 0}></t-sky-chart>
                ${this.renderSkyWords(place, ms)}`}
        </div>
      </div>
      <t-goto
        .site=${this.site}
        .device=${device}
        .line=${this.line}
        .online=${this.online}
        .place=${place}
        .slew=${slewOf(device) ?? null}
        .zone=${detail.zone}
        .ms=${ms}
        @t-target=${this.onTargetChoice}
      ></t-goto>
    </div>`;
  }

  private renderReadings({ equatorial, horizontal: at }: TelescopePointing): TemplateResult {
    const { state: how, parked, tracking } = this.signals();
    const old = equatorial === null ? "old" : "";
    return html`<div class="looks">
      <div class="readings">
        ${map([how, parked, tracking], (signal) =>
          signal === undefined ? nothing : html`<t-signal-value size="l" .site=${this.site} .signal=${signal}></t-signal-value>`,
        )}
      </div>
      <dl class="place">
        <dt>RA</dt>
        <dd class="large ${old}">${formatRa(equatorial?.ra ?? Number.NaN)}</dd>
        <dt>Dec</dt>
        <dd class="large ${old}">${formatDec(equatorial?.dec ?? Number.NaN)}</dd>
        <dt>${msg("Altitude")}</dt>
        <dd class=${at === null ? "old" : ""}>${at === null ? "–" : `${fixedText(at.alt, 2)}°`}</dd>
        <dt>${msg("Azimuth")}</dt>
        <dd class=${at === null ? "old" : ""}>${at === null ? "–" : formatAzimuth(at.az, 2)}</dd>
      </dl>
      </div>
      <p class="note">
        ${equatorial === null && at === null
          ? msg("Where it looks is not known now.")
          : msg("Right ascension and declination are of date, as the telescope says them.")}
      </p>`;
  }

  private renderSkyWords(place: GeoPlace, ms: number): TemplateResult {
    const sun = sunFrom(place, ms);
    const dark = DARKNESS.find(({ id }) => id === darknessOf(sun.alt));
    const { lit, waxing } = moonPhase(ms);
    return html`<p class="note">
      ${waxing ? msg(html`${formatClock(ms * 1000, this.detail?.zone ?? "UTC").slice(0, 5)}: ${dark?.name}, the Sun ${formatNumber(sun.alt, 1)}° high; Moon ${(lit * 100).toFixed(0)}% lit, waxing. As one looks up: north at the top, east to the left.`) : msg(html`${formatClock(ms * 1000, this.detail?.zone ?? "UTC").slice(0, 5)}: ${dark?.name}, the Sun ${formatNumber(sun.alt, 1)}° high; Moon ${(lit * 100).toFixed(0)}% lit, waning. As one looks up: north at the top, east to the left.`)}
    </p>`;
  }

  /** What it says itself; the one that it does not say comes of the other, of place and time. */
  private pointingOf(place: GeoPlace | null, ms: number): TelescopePointing {
    const { ra, dec, alt, az } = this.signals();
    const [r, d, a, z] = [this.readSignal(ra), this.readSignal(dec), this.readSignal(alt), this.readSignal(az)];
    const equatorial = r.fresh && d.fresh ? { ra: ra?.unit === "°" ? r.value / 15 : r.value, dec: d.value } : null;
    if (a.fresh && z.fresh) return { equatorial, horizontal: { alt: a.value, az: z.value } };
    return { equatorial, horizontal: equatorial === null || place === null ? null : toHorizontal(equatorial, place, ms) };
  }

  private signals(): TelescopeSignals {
    return telescopeSignals(this.device ?? NO_DEVICE);
  }

  private readonly onTargetChoice = (event: CustomEvent<SkyTarget | null>): void => {
    this.target = event.detail;
  };
}

interface TelescopePointing {
  readonly equatorial: Equatorial | null;
  readonly horizontal: Horizontal | null;
}

declare global {
  interface HTMLElementTagNameMap {
    "t-part-telescope": TelescopePart;
  }
}
