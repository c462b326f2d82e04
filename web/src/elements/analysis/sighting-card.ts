/** One sighting: its picture, what was seen, by which camera, from when to when. */

import { msg, str } from "@lit/localize";
import { css, html, LitElement, nothing, type PropertyValues, type TemplateResult } from "lit";
import { customElement, property, state } from "lit/decorators.js";
import { map } from "lit/directives/map.js";
import { formatDuration } from "../../format/duration.js";
import { countText, confidenceText, storyFacts, type SightingStory } from "../../format/object-names.js";
import { base, quietText } from "../base/base-style.js";
import { onPicture } from "../camera/picture-overlay.js";
import "../base/icon.js";
import "../feedback/status.js";
import "../values/time.js";
import "./path-sketch.js";

/** What is shown of a sighting; times in µs since the epoch, UTC. */
export interface SightingFacts {
  readonly label: string;
  readonly many: number;
  readonly confidence: number;
  readonly began_us: number;
  readonly ended_us: number | null;
  /** What it did, of one that was followed. */
  readonly story?: SightingStory | null;
}

/**
 * @slot - ways that lead on from it
 */
@customElement("t-sighting")
export class SightingCard extends LitElement {
  static override styles = [
    base,
    onPicture,
    css`
      :host {
        display: grid;
        grid-template-columns: 10rem minmax(0, 1fr) auto;
        align-items: start;
        gap: var(--t-space-3) var(--t-space-4);
        min-inline-size: 0;
      }
      .picture {
        display: grid;
        place-content: center;
        justify-items: center;
        gap: var(--t-space-1);
        inline-size: 100%;
        aspect-ratio: 4 / 3;
        overflow: hidden;
        border-radius: var(--t-radius-s);
        background: var(--t-raised);
        ${quietText}
        position: relative;
      }
      .picture.there {
        background: #000;
      }
      .picture t-icon {
        font-size: 1.75rem;
      }
      img {
        position: absolute;
        inset: 0;
        inline-size: 100%;
        block-size: 100%;
        object-fit: contain;
        filter: var(--t-picture-filter, none);
      }
      .told {
        display: grid;
        align-content: start;
        gap: var(--t-space-1);
        min-inline-size: 0;
      }
      .what {
        display: flex;
        flex-wrap: wrap;
        align-items: baseline;
        gap: 0 var(--t-space-3);
        font-size: var(--t-size-l);
        font-weight: var(--t-weight-strong);
        overflow-wrap: anywhere;
      }
      .what t-status {
        font-size: var(--t-size-s);
      }
      .facts {
        display: flex;
        flex-wrap: wrap;
        gap: 0 var(--t-space-4);
        ${quietText}
      }
      .times {
        display: flex;
        flex-wrap: wrap;
        gap: 0 var(--t-space-2);
      }
      @media (max-width: 30rem) {
        :host {
          grid-template-columns: 6.5rem minmax(0, 1fr);
          grid-template-rows: auto 1fr;
          gap: var(--t-space-2) var(--t-space-3);
        }
        .told {
          grid-row: 1 / span 2;
          grid-column: 2;
        }
        /* Below the picture: there is room. */
        t-path-sketch {
          grid-row: 2;
          grid-column: 1;
        }
        /* A date with its zone in one line. */
        .times {
          font-size: var(--t-size-s);
        }
      }
    `,
  ];

  @property({ attribute: false }) sighting: SightingFacts = { label: "", many: 0, confidence: 0, began_us: 0, ended_us: null };
  /** What the camera is called. */
  @property() camera = "";
  /** Address of its picture; empty for none. */
  @property() picture = "";
  @property() zone = "UTC";

  /** The picture did not come. */
  @state() private lost = false;

  override willUpdate(changed: PropertyValues<this>): void {
    if (changed.has("picture")) this.lost = false;
  }

  override render(): TemplateResult {
    const { label, confidence, began_us, ended_us, story } = this.sighting;
    // One that was followed is one thing; of those before it is told how many there were at once.
    const many = story === null || story === undefined ? this.sighting.many : 1;
    const there = this.picture !== "" && !this.lost;
    return html`<div class="picture ${there ? "there" : ""}">
        ${there
          ? html`<img src=${this.picture} alt=${msg(str`${countText(many, label)} on the picture of ${this.camera}`)} loading="lazy" decoding="async" @error=${this.onPictureError} />
              <div class="tint"></div>`
          : html`<t-icon name="camera"></t-icon><span>${this.lost ? msg("picture not kept") : msg("no picture")}</span>`}
      </div>
      <div class="told">
        <div class="what">
          <span>${countText(many, label)}</span>
          ${ended_us === null ? html`<t-status kind="busy" word=${msg("in sight")}></t-status>` : nothing}
        </div>
        <div class="times">
          <t-time .us=${began_us} .zone=${this.zone}></t-time>
          ${ended_us === null
            ? html`<span class="muted">${msg("until now")}</span>`
            : html`<span aria-label=${msg("to")}>–</span><t-time .us=${ended_us} .zone=${this.zone}></t-time>`}
        </div>
        <div class="facts">
          <span>${this.camera}</span>
          ${ended_us === null ? nothing : html`<span>${msg(str`for ${formatDuration(Math.max(1, Math.round((ended_us - began_us) / 1e6)))}`)}</span>`}
          <span title=${msg("Of the surest one")}>${msg(str`${confidenceText(confidence)} sure`)}</span>
          ${many === this.sighting.many ? nothing : html`<span>${msg(str`at most ${this.sighting.many} at once`)}</span>`}
          ${map(storyFacts(story), (fact) => html`<span>${fact}</span>`)}
        </div>
        <slot></slot>
      </div>
      ${story && (story.path?.length ?? 0) > 1 ? html`<t-path-sketch .path=${story.path}></t-path-sketch>` : nothing}`;
  }

  private readonly onPictureError = (): void => {
    this.lost = true;
  };
}

declare global {
  interface HTMLElementTagNameMap {
    "t-sighting": SightingCard;
  }
}
