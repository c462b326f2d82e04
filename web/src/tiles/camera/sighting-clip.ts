/** One sighting, large: the film around its beginning where there is one, its picture where not. */

import { msg, str } from "@lit/localize";
import { css, html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, property, query, state } from "lit/decorators.js";
import { base, quietText } from "../../elements/base/base-style.js";
import { onPicture, pictureFrame } from "../../elements/camera/picture-overlay.js";
import { filmPath } from "../../wire/films-api.js";
import type { FilmShape } from "../../generated/api.js";
import "../../elements/base/icon.js";

@customElement("t-sighting-clip")
export class SightingClip extends LitElement {
  static override styles = [
    base,
    onPicture,
    pictureFrame,
    css`
      .veil {
        background: var(--t-raised);
        ${quietText}
      }
      .note {
        position: absolute;
        inset-block-end: var(--t-space-2);
        inset-inline-start: var(--t-space-2);
      }
    `,
  ];

  @property() site = "";
  /** What is to be seen, for who does not see it. */
  @property() what = "";
  /** Address of its picture; empty for none. */
  @property() picture = "";
  /** The film that has it; null for none. */
  @property({ attribute: false }) film: FilmShape | null = null;
  /** Where in the film it is shown from (s). */
  @property({ type: Number }) from = 0;

  @state() private broken = false;
  @query("video") private readonly video!: HTMLVideoElement | null;

  override willUpdate(changed: Map<PropertyKey, unknown>): void {
    if (changed.has("film") || changed.has("picture")) this.broken = false;
  }

  override render(): TemplateResult {
    const { film } = this;
    if (film?.state === "complete" && !this.broken) {
      return html`<video
          src=${filmPath(this.site, film.id)}
          poster=${this.picture}
          controls
          playsinline
          preload="auto"
          .muted=${true}
          aria-label=${msg(str`Clip of ${this.what}`)}
          @loadedmetadata=${this.onLoaded}
          @error=${this.onBroken}
        ></video>
        <div class="tint"></div>`;
    }
    const coming = film !== null && film.state !== "complete" && film.state !== "failed";
    return html`${this.picture === "" || (this.broken && film === null)
        ? html`<div class="veil"><t-icon name="camera"></t-icon><p>${msg("No picture of it is kept")}</p></div>`
        : html`<img src=${this.picture} alt=${this.what} @error=${this.onBroken} /><div class="tint"></div>`}
      ${coming ? html`<span class="badge note">${msg("The clip is still on its way")}</span>` : nothing}
      ${film !== null && this.broken ? html`<span class="badge note">${msg("This browser cannot play the clip")}</span>` : nothing}`;
  }

  /** Plays or pauses; gives whether there is something to play. */
  togglePlay(): boolean {
    const { video } = this;
    if (video === null) return false;
    // It may be told to pause before it has begun, which is no failure.
    if (video.paused) video.play().catch(() => undefined);
    else video.pause();
    return true;
  }

  private readonly onLoaded = (): void => {
    if (this.video !== null) this.video.currentTime = this.from;
  };

  private readonly onBroken = (): void => {
    this.broken = true;
  };
}

declare global {
  interface HTMLElementTagNameMap {
    "t-sighting-clip": SightingClip;
  }
}
