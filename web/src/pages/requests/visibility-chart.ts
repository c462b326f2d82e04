/** When a request may be observed in a night: its height over the twilights, and the same in words. */

import { msg } from "@lit/localize";
import { css, html, LitElement, type TemplateResult } from "lit";
import { customElement, property, state } from "lit/decorators.js";
import { base } from "../../elements/base/base-style.js";
import { formatDuration } from "../../format/duration.js";
import { formatClock, formatDate } from "../../format/time.js";
import type { ConstraintsShape, RequestShape } from "../../generated/api.js";
import { clockOf } from "../../series/zone-clock.js";
import type { GeoPlace } from "../../sky/coordinates.js";
import { momentsBetween } from "../../sky/night-sky.js";
import { bandsOf, type NightTrack, type Visibility } from "../../sky/night-visibility.js";
import { bestNight, eveningOf, horizontalOf, nightAround, requestVisibility, requestVisibilityText, type RequestVisibility, type VisibilityQuestion } from "../../sky/request-visibility.js";
import { moonFrom, sunFrom } from "../../sky/sun-and-moon.js";
import { targetPlace } from "../../sky/target-place.js";
import "../../elements/forms/field.js";
import "../../elements/observatory/night-curve.js";

const STEP_MS = 600_000;

interface DrawnNight {
  readonly night: NightTrack;
  readonly seen: Visibility;
  readonly moon: readonly number[];
  readonly found: RequestVisibility;
  readonly words: string;
}

@customElement("t-visibility-chart")
export class VisibilityChart extends LitElement {
  static override styles = [
    base,
    css`
      :host {
        display: grid;
        gap: var(--t-space-3);
      }
      t-night-curve {
        max-inline-size: 48rem;
      }
      t-field {
        max-inline-size: 14rem;
      }
    `,
  ];

  @property({ attribute: false }) target: RequestShape["target"] = null;
  @property({ attribute: false }) constraints: ConstraintsShape = {};
  /** When it may be observed (µs since the epoch, UTC). */
  @property({ attribute: false }) windows: readonly { readonly start_us: number; readonly end_us: number }[] = [];
  @property({ attribute: false }) place: GeoPlace | null = null;
  @property() zone = "UTC";
  @state() private day = "";
  private drawn: DrawnNight | null = null;
  private drawnFor = "";

  override willUpdate(): void {
    const key = JSON.stringify([this.target, this.constraints, this.windows, this.place, this.day, this.zone]);
    if (key === this.drawnFor) return;
    this.drawnFor = key;
    this.drawn = this.drawNight();
  }

  override render(): TemplateResult {
    const { drawn } = this;
    if (drawn === null) return html`<p class="muted">${this.missingText()}</p>`;
    const evening = this.day === "" ? eveningOf(drawn.night) : this.moment();
    return html`<p role="status">${drawn.words}</p>
      <t-night-curve
        .night=${drawn.night}
        .seen=${drawn.seen}
        .moon=${drawn.moon}
        .allowed=${drawn.found.spans}
        .limit=${this.constraints.min_altitude ?? 0}
        .ms=${Date.now()}
        .zone=${this.zone}
        .words=${drawn.words}
      ></t-night-curve>
      <t-field label=${msg("Night that begins on")} hint=${`${this.zone}; UTC: ${formatDate(evening * 1000, "UTC")}`}>
        <input type="date" .value=${clockOf(this.zone).toInput(evening * 1000).slice(0, 10)} @change=${this.onDay} />
      </t-field>`;
  }

  private missingText(): string {
    if (this.target === null) return msg("The chart is drawn once there is a target.");
    if (this.place === null) return msg("The chart needs the site's position, which is not described or not open to you.");
    return msg("This page does not work out where planets stand; the planner does.");
  }

  /** Within the night: the evening of the day that was chosen; else now, or when the first window opens. */
  private moment(): number {
    const evening = clockOf(this.zone).fromInput(`${this.day}T20:00:00`) / 1000;
    if (!Number.isNaN(evening)) return evening;
    const starts = this.windows.map(({ start_us: start }) => start / 1000).filter((ms) => !Number.isNaN(ms));
    return Math.max(Date.now(), ...(starts.length > 0 ? [Math.min(...starts)] : []));
  }

  private drawNight(): DrawnNight | null {
    const { place } = this;
    const target = targetPlace(this.target);
    if (place === null || target === null) return null;
    const { min_altitude = 15, max_airmass = 10, min_moon_distance = 0, max_moon_illumination = 1, max_sun_altitude = -12 } = this.constraints;
    const constraints = { min_altitude, max_airmass, min_moon_distance, max_moon_illumination, max_sun_altitude };
    if (Object.values(constraints).some((value) => Number.isNaN(value))) return null;
    const windows = this.windows.filter(({ start_us: start, end_us: end }) => end > start).map(({ start_us: start, end_us: end }) => ({ from: start / 1000, to: end / 1000 }));
    const question: VisibilityQuestion = { target, place, constraints, windows };
    const span = nightAround(this.moment(), place);
    const found = requestVisibility(question, span);
    const better = found.spans.length > 0 ? null : bestNight(question, Date.now());
    const points = momentsBetween(span, STEP_MS).map((ms) => ({ ms, alt: horizontalOf(target, place, ms).alt, sun: sunFrom(place, ms).alt }));
    const alts = points.map(({ alt }) => alt);
    const seen: Visibility = {
      seen: found.spans.length > 0, best: found.best, bestMs: found.bestMs, highest: Math.max(...alts), lowest: Math.min(...alts),
      fromMs: found.spans[0]?.from ?? Number.NaN, toMs: found.spans.at(-1)?.to ?? Number.NaN,
    };
    const words = requestVisibilityText(found, constraints, better, {
      clock: (ms) => formatClock(ms * 1000, this.zone).slice(0, 5),
      date: (ms) => formatDate(ms * 1000, this.zone),
      lasting: (ms) => formatDuration(ms / 1000),
    });
    return { night: { ...span, points, bands: bandsOf(points) }, seen, moon: points.map(({ ms }) => moonFrom(place, ms).alt), found, words };
  }

  private readonly onDay = (event: Event): void => {
    if (event.target instanceof HTMLInputElement) this.day = event.target.value;
  };
}

declare global {
  interface HTMLElementTagNameMap {
    "t-visibility-chart": VisibilityChart;
  }
}
