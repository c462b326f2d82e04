/** A map of Earth with robots, their trails, zones and plans; the ground under them is chosen. */

import { msg, str } from "@lit/localize";
import { css, html, LitElement, nothing, type PropertyValues, type TemplateResult } from "lit";
import { plural } from "../../words/plural.js";
import { customElement, property, query, state } from "lit/decorators.js";
import { ContextConsumer } from "@lit/context";
import { FrameSchedule } from "../base/frame-schedule.js";
import type { MapOffer } from "../../generated/api.js";
import { apiContext } from "../../state/contexts.js";
import type { HubApi } from "../../wire/hub-api.js";
import "../feedback/loading.js";
import "../forms/button.js";
import { control } from "../forms/input-style.js";
import { renderOptions } from "../forms/form-parts.js";
import type * as GeoLeaflet from "./geo-leaflet.js";
import { paintScene, paintWorld, type DrawnPicture, type DrawnZone, type GeoColours, type GeoScene, type MapRobot, type TrailPoint } from "./geo-painter.js";
import { mapFrame } from "./map-style.js";
import { scaleBar } from "./map-painter.js";
import { chosenGround, groundChoices, loadOffer, openSession, WORLD } from "./map-offer.js";
import type { MapPlace } from "./geodesy.js";
import { worldOutline } from "./world.js";
import { base } from "../base/base-style.js";

/** A browser remembers which ground was chosen. */
const KEY = "talaia.ground";
/** px around a click in which a robot is meant. */
const REACH = 22;

@customElement("t-geo-map")
export class GeoMapElement extends LitElement {
  static override styles = [
    base,
    control,
    mapFrame,
    css`
      .under {
        background: var(--t-bg);
      }
      .over {
        z-index: 2;
        pointer-events: none;
      }
      .leaflet .leaflet-tile-pane {
        filter: var(--t-picture-filter, none);
      }
      .tint {
        display: var(--t-picture-tinted, none);
        position: absolute;
        inset: 0;
        z-index: 1;
        mix-blend-mode: multiply;
        background: var(--t-picture-tint, transparent);
        pointer-events: none;
      }
      .ground {
        position: absolute;
        z-index: 3;
        inset: var(--t-space-2) var(--t-space-2) auto auto;
        display: flex;
        flex-wrap: wrap;
        justify-content: end;
        gap: var(--t-space-1);
        max-inline-size: calc(100% - 5rem);
      }
      select {
        max-inline-size: 12rem;
      }
      .legend {
        display: inline-flex;
        align-items: center;
        gap: var(--t-space-1);
      }
      .legend i {
        inline-size: 5rem;
        block-size: 0.5rem;
        background: linear-gradient(to right, hsl(220 95% 38%), hsl(220 20% 50%), hsl(25 20% 50%), hsl(25 95% 62%));
      }
    `,
  ];

  @property({ attribute: false }) robots: readonly MapRobot[] = [];
  @property({ attribute: false }) trails: readonly (readonly TrailPoint[])[] = [];
  @property({ attribute: false }) zones: readonly DrawnZone[] = [];
  @property({ attribute: false }) pictures: readonly DrawnPicture[] = [];
  /** Why there is no position; shown while there is no robot. */
  @property() note = msg("Waiting for the first position");
  @property() stale = "";
  @property() where = "";
  /** Name of the signal that colours the trail, and the ends of its scale. */
  @property({ attribute: false }) legend: { readonly name: string; readonly least: string; readonly most: string } | null = null;
  /** All robots are brought into view, instead of one that is followed. */
  @property({ type: Boolean }) fleet = false;
  /** Looked at while there is no robot. */
  @property({ attribute: false }) home: MapPlace | null = null;

  @state() private follow = true;
  @state() private ready = false;
  @state() private bar = { text: "", px: 0 };
  @state() private offer: MapOffer | null = null;
  @state() private wanted = localStorage.getItem(KEY) ?? "";
  @state() private attribution = "";
  @state() private trouble = "";
  @query(".under") private readonly under!: HTMLCanvasElement;
  @query(".over") private readonly over!: HTMLCanvasElement;
  @query(".leaflet") private readonly place!: HTMLElement;
  @query(".scale i") private readonly ruler!: HTMLElement;

  private leaflet: typeof GeoLeaflet | null = null;
  private geo: GeoLeaflet.GeoMap | null = null;
  private laid = "";
  private placed = false;
  private sizes: ResizeObserver | null = null;
  private themes: MutationObserver | null = null;
  private colours: GeoColours | null = null;
  private api: HubApi | undefined;
  private readonly frames = new FrameSchedule(() => {
    this.paintNow();
  });

  constructor() {
    super();
    new ContextConsumer(this, {
      context: apiContext,
      callback: (api) => {
        this.api = api;
        loadOffer(api).then(
          (offer) => {
            this.offer = offer;
          },
          () => {
            // The coarse world is there in any case.
            this.trouble = msg("The list of maps could not be had.");
          },
        );
      },
    });
  }

  override render(): TemplateResult {
    const choices = groundChoices(this.offer);
    const ground = chosenGround(choices, this.wanted);
    return html`
      <div class="frame">
        <canvas class="under" aria-hidden="true"></canvas>
        <div class="leaflet" data-keys="own" aria-label=${msg("Map: arrow keys move it, plus and minus zoom")}></div>
        <div class="tint" aria-hidden="true"></div>
        <canvas class="over" role="img" aria-label=${this.pictureText()}></canvas>
        <div class="scale" aria-hidden="true" ?hidden=${!this.ready}>${this.bar.text}<i></i></div>
        ${this.ready ? nothing : html`<div class="note"><t-loading what=${msg("Loading the map")}></t-loading></div>`}
        ${this.ready && this.robots.length === 0 ? html`<div class="note" role="status">${this.note}</div>` : nothing}
        <div class="ground">
          ${choices.length > 1
            ? html`<select aria-label=${msg("Map under the robots")} @change=${this.onGround}>
                ${renderOptions(choices.map(({ key, label, host }) => [key, host === "" ? label : msg(str`${label} (asks ${host})`)] as const), ground.key)}
              </select>`
            : nothing}
          <t-button .pressed=${this.follow ? "true" : "false"} @click=${this.toggleFollow}>${this.followWord()}</t-button>
        </div>
        ${this.renderWords()}
      </div>
    `;
  }

  private renderWords(): unknown {
    const { where, stale, attribution, trouble, legend } = this;
    if (`${where}${stale}${attribution}${trouble}` === "" && legend === null) return nothing;
    return html`<div class="where">
      ${legend === null ? nothing : html`<span class="legend">${legend.name} ${legend.least}<i></i>${legend.most}</span>`} ${where}
      ${stale === "" ? nothing : html`<span class="stale" role="status">${stale}</span>`}
      ${trouble === "" ? nothing : html`<span class="stale" role="status">${trouble}</span>`}
      ${attribution === "" ? nothing : html`<small>${attribution}</small>`}
    </div>`;
  }

  private followWord(): string {
    if (this.fleet) return this.follow ? msg("All in view") : msg("Show all");
    return this.follow ? msg("Following") : msg("Follow");
  }

  private pictureText(): string {
    const { robots, zones } = this;
    const who = robots.length === 1 ? (robots[0]?.name ?? "") : robots.length === 0 ? msg("no robot") : msg(str`${String(robots.length)} robots`);
    if (zones.length === 0) return msg(str`Map with ${who}`);
    return plural(zones.length, msg(str`Map with ${who} and 1 zone`), msg(str`Map with ${who} and ${String(zones.length)} zones`));
  }

  override firstUpdated(): void {
    void this.start();
  }

  override connectedCallback(): void {
    super.connectedCallback();
    if (this.hasUpdated) void this.start();
  }

  override disconnectedCallback(): void {
    super.disconnectedCallback();
    this.sizes?.disconnect();
    this.themes?.disconnect();
    matchMedia("(prefers-color-scheme: dark)").removeEventListener("change", this.recolour);
    this.geo?.map.remove();
    this.geo = null;
    this.laid = "";
    this.placed = false;
    this.ready = false;
    this.frames.cancel();
  }

  override updated(changed: PropertyValues<this>): void {
    this.ruler.style.inlineSize = `${this.bar.px.toFixed(0)}px`;
    void this.layGround();
    if (changed.has("robots") || changed.has("home")) this.centre();
    this.frames.schedule();
  }

  private async start(): Promise<void> {
    const leaflet = await import("./geo-leaflet.js");
    if (!this.isConnected || this.geo) return;
    this.leaflet = leaflet;
    const root = this.renderRoot;
    const sheet = leaflet.styles.styleSheet;
    // Before ours, so that our colours win.
    if (root instanceof ShadowRoot && sheet && !root.adoptedStyleSheets.includes(sheet)) root.adoptedStyleSheets = [sheet, ...root.adoptedStyleSheets];
    this.geo = leaflet.geoMap(this.place);
    const { map } = this.geo;
    map.on("move zoom viewreset resize", this.frames.schedule);
    map.on("dragstart", this.stopFollowing);
    map.on("click", (event) => {
      this.openRobotAt(event.containerPoint.x, event.containerPoint.y);
    });
    this.place.addEventListener("keydown", (event) => {
      if (event.key.startsWith("Arrow")) this.stopFollowing();
    });
    this.sizes = new ResizeObserver(() => {
      map.invalidateSize({ animate: false });
      this.frames.schedule();
    });
    this.sizes.observe(this.place);
    this.themes = new MutationObserver(this.recolour);
    this.themes.observe(document.documentElement, { attributeFilter: ["data-theme"] });
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", this.recolour);
    this.ready = true;
    this.centre();
  }

  /** Brings what is followed into view; the first time near enough to tell one robot's way. */
  private centre(): void {
    const { geo, robots, home } = this;
    if (!geo || !this.follow) return;
    const places = robots.map(({ place }) => place);
    if (this.fleet && places.length > 1) {
      geo.map.fitBounds(places.map(({ lat, lon }) => [lat, lon] as [number, number]), { animate: false, maxZoom: 17, padding: [40, 40] });
      return;
    }
    const at = places[0] ?? home;
    if (at === null) return;
    const zoom = this.placed ? geo.map.getZoom() : this.fleet ? 17 : 19;
    this.placed = true;
    geo.map.setView([at.lat, at.lon], zoom, { animate: false });
  }

  private async layGround(): Promise<void> {
    const { geo, leaflet, api, offer } = this;
    if (!geo || !leaflet || !api) return;
    const { key } = chosenGround(groundChoices(offer), this.wanted);
    if (key === this.laid || (offer === null && key === WORLD)) return;
    this.laid = key;
    [this.attribution, this.trouble] = ["", ""];
    geo.lay(null);
    const onTrouble = (): void => {
      if (this.laid === key) this.trouble = msg("Some of the map could not be had.");
    };
    try {
      const file = offer?.files.find(({ name }) => key === `file ${name}`);
      const source = offer?.sources.find(({ id }) => key === `source ${id}`);
      if (file !== undefined) {
        const font = `11px ${getComputedStyle(this).fontFamily}`;
        const ground = await leaflet.fileTiles(file.url, () => this.themeColours(), font, onTrouble);
        if (this.laid !== key || this.geo !== geo) return;
        geo.lay(ground.layer);
        this.attribution = ground.attribution;
        if (this.robots.length === 0 && this.home === null) geo.map.fitBounds(ground.bounds, { animate: false });
      } else if (source !== undefined) {
        const tiles = source.kind === "google" ? (await openSession(api, source.id)).tiles : source.tiles;
        if (this.laid !== key || this.geo !== geo) return;
        geo.lay(leaflet.pictureTiles(tiles, source.most_zoom, onTrouble, source.kind === "google"));
        this.attribution = source.attribution;
      }
    } catch (error) {
      // The coarse world stays below.
      if (this.laid === key) this.trouble = msg(str`This map could not be had: ${error instanceof Error ? error.message : msg("no answer")}`);
    }
    this.frames.schedule();
  }

  private readonly onGround = (event: Event): void => {
    if (!(event.target instanceof HTMLSelectElement)) return;
    this.wanted = event.target.value;
    localStorage.setItem(KEY, this.wanted);
  };

  private readonly recolour = (): void => {
    this.colours = null;
    // Vector tiles are painted in the theme's colours.
    this.laid = "";
    this.requestUpdate();
  };

  /** Whoever moves the map wants to look elsewhere. */
  private readonly stopFollowing = (): void => {
    this.follow = false;
  };

  private readonly toggleFollow = (): void => {
    this.follow = !this.follow;
    this.centre();
  };

  private openRobotAt(x: number, y: number): void {
    const { geo } = this;
    if (!geo) return;
    const near = this.robots
      .map(({ id, place }) => {
        const [px, py] = geo.project(place);
        return { id, far: Math.hypot(px - x, py - y) };
      })
      .sort((a, b) => a.far - b.far)[0];
    if (near !== undefined && near.far <= REACH) this.dispatchEvent(new CustomEvent("robot-chosen", { detail: near.id, bubbles: true, composed: true }));
  }

  private themeColours(): GeoColours {
    this.colours ??= geoColours(getComputedStyle(this));
    return this.colours;
  }

  private paintNow(): void {
    const { geo } = this;
    const [below, above] = [this.under.getContext("2d"), this.over.getContext("2d")];
    if (!geo || !below || !above) return;
    const { x: width, y: height } = geo.map.getSize();
    const ratio = window.devicePixelRatio || 1;
    for (const canvas of [this.under, this.over]) {
      if (canvas.width !== Math.round(width * ratio)) canvas.width = Math.round(width * ratio);
      if (canvas.height !== Math.round(height * ratio)) canvas.height = Math.round(height * ratio);
    }
    const sight = { width, height, project: geo.project };
    const scene: GeoScene = { pictures: this.pictures, zones: this.zones, trails: this.trails, robots: this.robots, named: true };
    below.setTransform(ratio, 0, 0, ratio, 0, 0);
    above.setTransform(ratio, 0, 0, ratio, 0, 0);
    const colours = this.themeColours();
    paintWorld(below, sight, worldOutline(), colours);
    paintScene(above, sight, scene, colours, `13px ${getComputedStyle(this).fontFamily}`);
    const bar = scaleBar(1 / geo.resolution());
    if (bar.text !== this.bar.text || Math.abs(bar.px - this.bar.px) > 1) this.bar = bar;
  }
}

function geoColours(style: CSSStyleDeclaration): GeoColours {
  const token = (name: string): string => style.getPropertyValue(`--t-${name}`).trim();
  return {
    line: token("line"),
    strong: token("edge"),
    text: token("muted"),
    label: token("text"),
    accent: token("accent"),
    stale: token("stale"),
    surface: token("surface"),
    bad: token("bad"),
    warn: token("warn"),
    ok: token("ok"),
    info: token("info"),
    land: token("raised"),
  };
}

declare global {
  interface HTMLElementTagNameMap {
    "t-geo-map": GeoMapElement;
  }
}
