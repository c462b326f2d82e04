/** Where a vehicle is: on the map, in space, or both where there is room. */

import { msg } from "@lit/localize";
import { css, html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, property, state } from "lit/decorators.js";
import { LoadController } from "../../controllers/load.js";
import { base } from "../../elements/base/base-style.js";
import { renderLoaded } from "../../elements/feedback/load-state.js";
import type { SignalShape, SiteShape } from "../../generated/api.js";
import { readBrowserChoice, saveBrowserChoice } from "../../controllers/browser-choice.js";
import "../../elements/forms/choice.js";
import "../map/position-map.js";

type Surroundings = "map" | "scene";

const KEY = "talaia.surroundings";
const OPTIONS = [
  { id: "map", label: msg("Map") },
  { id: "scene", label: msg("Scene") },
] as const;
/** There is room for both beside a large picture. */
const WIDE = "(min-width: 110rem)";

@customElement("t-surroundings")
export class VehicleSurroundings extends LitElement {
  static override styles = [
    base,
    css`
      :host {
        display: flex;
        flex-direction: column;
        gap: var(--t-space-2);
        min-inline-size: 0;
      }
      t-choice {
        align-self: start;
      }
      .box {
        flex: 1 1 0;
        display: grid;
        min-block-size: var(--t-around-height, 15rem);
        min-inline-size: 0;
      }
      t-scene-tile {
        block-size: 100%;
      }
    `,
  ];

  @property() site = "";
  @property({ attribute: false }) detail: SiteShape | null = null;
  @property({ attribute: false }) signal: SignalShape | null = null;
  @property({ type: Boolean }) online = false;

  @state() private chosen: Surroundings = readBrowserChoice(KEY, ["map", "scene"]);
  @state() private wide = false;
  /** The scene's code comes when somebody wants it, and the robot is heard for it only then. */
  private readonly sceneElement = new LoadController<unknown>(this);
  private readonly room = window.matchMedia(WIDE);

  override connectedCallback(): void {
    super.connectedCallback();
    this.room.addEventListener("change", this.onRoom);
    this.onRoom();
  }

  override disconnectedCallback(): void {
    super.disconnectedCallback();
    this.room.removeEventListener("change", this.onRoom);
  }

  protected override willUpdate(): void {
    if (this.wide || this.chosen === "scene") this.sceneElement.load("scene", () => import("../scene/scene-tile.js"));
  }

  override render(): TemplateResult {
    const shows = (which: Surroundings): boolean => this.wide || this.chosen === which;
    return html`${this.wide ? nothing : html`<t-choice label=${msg("Surroundings")} .options=${OPTIONS} .chosen=${this.chosen} @t-choose=${this.onChoose}></t-choice>`}
      ${shows("map") ? html`<div class="box"><t-map class="map" .site=${this.site} .signal=${this.signal} .online=${this.online}></t-map></div>` : nothing}
      ${shows("scene")
        ? html`<div class="box">
            ${renderLoaded(this.sceneElement, msg("the scene"), () => html`<t-scene-tile bare .site=${this.site} .detail=${this.detail} .online=${this.online}></t-scene-tile>`)}
          </div>`
        : nothing}`;
  }

  private readonly onRoom = (): void => {
    this.wide = this.room.matches;
  };

  private readonly onChoose = (event: CustomEvent<string>): void => {
    this.chosen = event.detail === "scene" ? "scene" : "map";
    saveBrowserChoice(KEY, this.chosen);
  };
}

declare global {
  interface HTMLElementTagNameMap {
    "t-surroundings": VehicleSurroundings;
  }
}
