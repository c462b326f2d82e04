/** The whole sky over the site: horizon, heights, Sun, Moon, stars, where the telescope looks and where it shall. */

import { msg, str } from "@lit/localize";
import { css, html, LitElement, nothing, svg, type SVGTemplateResult, type TemplateResult } from "lit";
import { customElement, property } from "lit/decorators.js";
import { map } from "lit/directives/map.js";
import { formatAzimuth } from "../../format/sexagesimal.js";
import { moonFrom, moonPhase, sunFrom } from "../../sky/sun-and-moon.js";
import { STARS } from "../../sky/bright-stars.js";
import { skyGrid, type SkyGridLine } from "../../sky/sky-grid.js";
import { toHorizontal, precessedFromJ2000, radians, type Horizontal, type GeoPlace } from "../../sky/coordinates.js";
import { base } from "../base/base-style.js";
import { styled } from "../base/style-directive.js";

const R = 100;
const NAMED_BELOW = 1.3;
const WINDS = [[msg("N"), 0], [msg("NE"), 45], [msg("E"), 90], [msg("SE"), 135], [msg("S"), 180], [msg("SW"), 225], [msg("W"), 270], [msg("NW"), 315]] as const;

/** A direction with a name. */
export interface TelescopeAim extends Horizontal {
  readonly name: string;
}

/** A place that is looked at in this night: where, and how it is marked. */
export interface PlannedAim extends TelescopeAim {
  /** Of its proposal: a letter, and one of the eight colours. */
  readonly letter: string;
  readonly colour: number;
}

@customElement("t-sky-chart")
export class SkyChart extends LitElement {
  static override styles = [
    base,
    css`
      :host {
        display: block;
      }
      svg {
        display: block;
        inline-size: 100%;
        max-inline-size: 34rem;
        margin-inline: auto;
        overflow: visible;
      }
      text {
        fill: var(--t-muted);
        font-size: 7px;
        text-anchor: middle;
        dominant-baseline: middle;
      }
      .wind {
        font-size: 9px;
        font-weight: var(--t-weight-strong);
        fill: var(--t-text);
      }
      .low {
        fill: var(--t-sky-low);
      }
      .sky {
        fill: var(--t-sky);
      }
      .ring {
        fill: none;
        stroke: var(--t-line);
        stroke-width: 0.8;
      }
      .limit {
        fill: none;
        stroke: var(--t-warn);
        stroke-width: 0.9;
        stroke-dasharray: 3 2.5;
      }
      .horizon {
        fill: none;
        stroke: var(--t-edge);
        stroke-width: 1.5;
      }
      /* Of right ascension and declination; those of altitude and azimuth are stronger. */
      .grid {
        fill: none;
        stroke: var(--t-muted);
        stroke-width: 0.4;
        stroke-opacity: 0.5;
      }
      .equator {
        stroke-width: 0.8;
        stroke-dasharray: 4 2;
      }
      .mark {
        font-size: 4.6px;
      }
      .star {
        fill: var(--t-star);
      }
      .day circle {
        opacity: 0.5;
      }
      .name {
        font-size: 5.4px;
        text-anchor: start;
      }
      .sun {
        fill: var(--t-sun);
        stroke: var(--t-edge);
      }
      .moon {
        fill: var(--t-moon);
        stroke: var(--t-edge);
        stroke-width: 0.6;
      }
      .dark {
        fill: var(--t-moon-dark);
      }
      .body {
        font-size: 6.5px;
        font-weight: var(--t-weight-strong);
        fill: var(--t-text);
      }
      .scope {
        fill: none;
        stroke: var(--t-accent);
        stroke-width: 2;
      }
      .stale .scope {
        stroke: var(--t-stale);
        stroke-dasharray: 2.5 2;
      }
      .way {
        stroke: var(--t-accent);
        stroke-width: 0.9;
        stroke-dasharray: 1.5 2;
      }
      .target {
        fill: none;
        stroke: var(--t-bad);
        stroke-width: 1.8;
      }
      .planned circle {
        fill: var(--t-surface);
        stroke: var(--colour);
        stroke-width: 1.6;
      }
      .planned text {
        font-size: 5px;
        font-weight: var(--t-weight-strong);
        fill: var(--t-text);
      }
      .aim {
        font-size: 7px;
        font-weight: var(--t-weight-strong);
        fill: var(--t-text);
        paint-order: stroke;
        stroke: var(--t-sky);
        stroke-width: 2.5px;
      }
    `,
  ];

  @property({ attribute: false }) place: GeoPlace | null = null;
  /** The moment (ms since 1970). */
  @property({ type: Number }) ms = 0;
  /** Where the telescope looks; null when nobody knows. */
  @property({ attribute: false }) telescope: TelescopeAim | null = null;
  /** That is the last that was known. */
  @property({ type: Boolean }) stale = false;
  @property({ attribute: false }) target: TelescopeAim | null = null;
  /** What else this night looks at. */
  @property({ attribute: false }) planned: readonly PlannedAim[] = [];
  /** The telescope may not look lower (°). */
  @property({ type: Number }) limit = 0;

  override render(): TemplateResult | typeof nothing {
    const { place } = this;
    if (place === null) return nothing;
    const sun = sunFrom(place, this.ms);
    const moon = moonFrom(place, this.ms);
    return html`<svg viewBox="-118 -114 236 228" role="img" aria-label=${this.describeSky(sun, moon)} class=${this.stale ? "stale" : ""}>
      <circle class=${this.limit > 0 ? "low" : "sky"} r=${R}></circle>
      ${this.limit > 0 ? svg`<circle class="sky" r=${zenithDistance(this.limit)}></circle>` : nothing}
      ${map([30, 60], (alt) => svg`<circle class="ring" r=${zenithDistance(alt)}></circle><text x="2" y=${-zenithDistance(alt) + 4}>${alt}°</text>`)}
      <path class="ring" d="M0 ${-R}V${R}M${-R} 0H${R}"></path>
      ${this.limit > 0 ? svg`<circle class="limit" r=${zenithDistance(this.limit)}></circle>` : nothing}
      ${this.renderGrid(place)}
      <circle class="horizon" r=${R}></circle>
      ${map(WINDS, ([name, az]) => {
        const { x, y } = chartPosition({ alt: 0, az }, 108);
        return svg`<text class=${name.length === 1 ? "wind" : ""} x=${x} y=${y}>${name}</text>`;
      })}
      <g class=${sun.alt > 0 ? "day" : ""}>${this.renderStars(place)}</g>
      ${this.renderMoon(moon)} ${this.renderSun(sun)} ${this.renderPlanned()} ${this.renderAims()}
    </svg>`;
  }

  /** Behind all else: it is there to be read, not to be looked at. */
  private renderGrid(place: GeoPlace): SVGTemplateResult {
    const { lines, equator, names } = skyGrid(place, this.ms);
    const path = (drawn: readonly SkyGridLine[]): string => drawn.map(({ points }) => `M${points.map(gridPosition).join("L")}`).join("");
    return svg`<clipPath id="up"><circle r=${R}></circle></clipPath>
      <g clip-path="url(#up)">
        <path class="grid" d=${path(lines)}></path><path class="grid equator" d=${path(equator)}></path>
        ${map(names, ({ name, at }) => {
          const { x, y } = chartPosition(at);
          return svg`<text class="mark" x=${x} y=${y + 3.5}>${name}</text>`;
        })}
      </g>`;
  }

  private renderStars(place: GeoPlace): SVGTemplateResult[] {
    return STARS.flatMap(({ name, raDeg, decDeg, magnitude }) => {
      const seen = toHorizontal(precessedFromJ2000({ ra: raDeg / 15, dec: decDeg }, this.ms), place, this.ms);
      if (seen.alt <= 0) return [];
      const { x, y } = chartPosition(seen);
      const size = Math.max(0.5, 2.3 - 0.55 * magnitude);
      const label = magnitude < NAMED_BELOW ? svg`<text class="name" x=${x + size + 1.5} y=${y}>${name}</text>` : nothing;
      return [svg`<circle class="star" cx=${x} cy=${y} r=${size}><title>${name}</title></circle>${label}`];
    });
  }

  private renderSun(sun: Horizontal): unknown {
    if (sun.alt < 0) return nothing;
    const { x, y } = chartPosition(sun);
    const rays = Array.from({ length: 8 }, (_, i) => {
      const a = (i * Math.PI) / 4;
      return `M${String(x + 6.5 * Math.cos(a))} ${String(y + 6.5 * Math.sin(a))}l${String(2.5 * Math.cos(a))} ${String(2.5 * Math.sin(a))}`;
    });
    return svg`<circle class="sun" cx=${x} cy=${y} r="5"></circle><path class="sun" d=${rays.join("")}></path>
      <text class="body" x=${x} y=${y + 13}>${msg("Sun")}</text>`;
  }

  /** The lit part stands to the right while it waxes, as north of the tropics. */
  private renderMoon(moon: Horizontal): unknown {
    if (moon.alt < 0) return nothing;
    const { x, y } = chartPosition(moon);
    const { lit, waxing } = moonPhase(this.ms);
    const bulge = Math.abs(1 - 2 * lit) * 5;
    const path = `M0 -5A5 5 0 0 1 0 5A${String(bulge)} 5 0 0 ${lit < 0.5 ? "0" : "1"} 0 -5Z`;
    return svg`<g transform="translate(${x} ${y})">
        <circle class="dark" r="5"></circle>
        <path class="moon" d=${path} transform=${waxing ? "" : "scale(-1 1)"}></path>
      </g>
      <text class="body" x=${x} y=${y + 10}>${msg("Moon")}</text>`;
  }

  private renderPlanned(): SVGTemplateResult[] {
    return this.planned.flatMap((aim) => {
      if (aim.alt < 0) return [];
      const { x, y } = chartPosition(aim);
      return [
        svg`<g class="planned" transform="translate(${x} ${y})" ${styled({ "--colour": `var(--t-series-${String(aim.colour)})` })}>
          <circle r="4.2"></circle><text>${aim.letter}</text><title>${aim.name}</title>
        </g>`,
      ];
    });
  }

  private renderAims(): unknown {
    const { telescope, target } = this;
    const from = telescope === null || telescope.alt < -1 ? null : chartPosition(telescope);
    const to = target === null || target.alt < 0 ? null : chartPosition(target);
    return svg`
      ${from !== null && to !== null ? svg`<path class="way" d="M${from.x} ${from.y}L${to.x} ${to.y}"></path>` : nothing}
      ${to === null
          ? nothing
          : svg`<path class="target" d="M${to.x} ${to.y - 6}l6 6l-6 6l-6 -6z"></path>
              <text class="aim" x=${to.x} y=${to.y + 12}>${target?.name}</text>`}
      ${from === null
          ? nothing
          : svg`<circle class="scope" cx=${from.x} cy=${from.y} r="7"></circle>
              <path class="scope" d="M${from.x - 11} ${from.y}h6M${from.x + 5} ${from.y}h6M${from.x} ${from.y - 11}v6M${from.x} ${from.y + 5}v6"></path>
              <text class="aim" x=${from.x} y=${from.y - 15}>${telescope?.name}</text>`}`;
  }

  private describeSky(sun: Horizontal, moon: Horizontal): string {
    const positionText = (what: string, at: Horizontal | null): string => {
      if (at === null) return "";
      if (at.alt < 0) return msg(str`${what}: below the horizon. `);
      return msg(str`${what}: ${at.alt.toFixed(0)}° high, azimuth ${formatAzimuth(at.az, 0)}. `);
    };
    const scope = this.telescope === null ? msg("Where the telescope looks is not known. ") : positionText(msg("Telescope"), this.telescope);
    const target = this.target === null ? "" : positionText(msg(str`Target ${this.target.name}`), this.target);
    const lit = msg(str`${(moonPhase(this.ms).lit * 100).toFixed(0)} % lit`);
    const limit = this.limit > 0 ? msg(str`It may not look below ${this.limit.toFixed(0)}°.`) : "";
    const up = this.planned.filter(({ alt }) => alt >= 0);
    const planned = up.length === 0 ? "" : msg(str`Planned and up now: ${up.map(({ name }) => name).join(", ")}. `);
    return msg(str`The sky over the site, north up and east to the left. ${scope}${target}${planned}${positionText(msg("Sun"), sun)}${positionText(msg(str`Moon (${lit})`), moon)}${limit}`);
  }
}

/** Distance from the zenith in the drawing: the same for each degree. */
function zenithDistance(alt: number): number {
  return (R * (90 - Math.max(-2, alt))) / 90;
}

/** Of a point that may be below the horizon: there a line goes on, and is cut off. */
function gridPosition(at: Horizontal): string {
  const { x, y } = chartPosition(at, (R * (90 - at.alt)) / 90);
  return `${String(x)} ${String(y)}`;
}

/** As one sees it looking up: north at the top, east to the left. */
function chartPosition({ alt, az }: Horizontal, far = zenithDistance(alt)): { readonly x: number; readonly y: number } {
  const a = radians(az);
  const round = (value: number): number => Math.round(value * 10) / 10;
  return { x: round(-far * Math.sin(a)), y: round(-far * Math.cos(a)) };
}

declare global {
  interface HTMLElementTagNameMap {
    "t-sky-chart": SkyChart;
  }
}
