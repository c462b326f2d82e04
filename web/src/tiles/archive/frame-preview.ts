/** How one picture of the archive looks: drawn with a stretch, and how its values lie. */

import { msg, str } from "@lit/localize";
import { css, html, LitElement, type TemplateResult } from "lit";
import { customElement, property, state } from "lit/decorators.js";
import { base } from "../../elements/base/base-style.js";
import { onPicture } from "../../elements/camera/picture-overlay.js";
import { roundText } from "../../format/number.js";
import { previewPath, STRETCHES, type Stretch } from "../../wire/archive-api.js";
import type { HistogramShape } from "../../generated/api.js";
import "../../elements/forms/choice.js";
import "../../elements/values/histogram.js";
import "../../elements/feedback/problem.js";

const DRAWN_PX = 1024;

/** The ways to stretch a picture, as a choice shows them. */
const STRETCH_OPTIONS = STRETCHES.map((id) => ({ id, label: id }));

/** The picture, with the choice of how it is stretched. */
@customElement("t-frame-look")
export class FramePreview extends LitElement {
  static override styles = [
    base,
    onPicture,
    css`
      :host {
        display: grid;
        grid-template-columns: minmax(0, 1fr);
        gap: var(--t-space-4);
        min-inline-size: 0;
      }
      .picture {
        position: relative;
        background: #000;
        border-radius: var(--t-radius-s);
        overflow: hidden;
      }
      img {
        display: block;
        inline-size: 100%;
        max-block-size: 75vh;
        object-fit: contain;
        filter: var(--t-picture-filter, none);
      }
    `,
  ];

  @property() site = "";
  @property() frame = "";
  /** What the picture shows. */
  @property() target = "";
  @state() private stretch: Stretch = "asinh";
  @state() private broken = "";

  override render(): TemplateResult {
    const path = previewPath(this.site, this.frame, this.stretch, DRAWN_PX);
    return html`<t-choice
        label=${msg("Stretch")}
        .options=${STRETCH_OPTIONS}
        .chosen=${this.stretch}
        @t-choose=${this.onChoose}
      ></t-choice>
      ${this.broken === path
        ? html`<t-problem what=${msg("The picture cannot be drawn.")} how=${msg("Download the file to look at it.")}></t-problem>`
        : html`<div class="picture">
            <img
              alt=${msg(str`The picture of ${this.target || msg("no named target")}, drawn with the ${this.stretch} stretch`)}
              src=${path}
              @error=${this.onImageError}
            />
            <div class="tint"></div>
          </div>`}`;
  }

  private readonly onImageError = (event: Event): void => {
    if (event.target instanceof HTMLImageElement) this.broken = event.target.getAttribute("src") ?? "";
  };

  private readonly onChoose = (event: CustomEvent<string>): void => {
    this.stretch = STRETCHES.find((stretch) => stretch === event.detail) ?? "asinh";
  };
}

/** How a picture's values lie, as bars and in numbers. */
export function renderPixelValues(histogram: HistogramShape): TemplateResult {
  const valueText = (value: number | null): string => (value === null ? "–" : roundText(value, 6));
  return html`<div>
    <h3>${msg("Pixel values")}</h3>
    <t-histogram
      .counts=${histogram.counts}
      .low=${histogram.low ?? Number.NaN}
      .high=${histogram.high ?? Number.NaN}
    ></t-histogram>
    <p class="muted">
      ${msg(str`least ${valueText(histogram.minimum)}, median ${valueText(histogram.median)}, greatest ${valueText(histogram.maximum)}, deviation ${valueText(histogram.deviation)}`)}
    </p>
  </div>`;
}

declare global {
  interface HTMLElementTagNameMap {
    "t-frame-look": FramePreview;
  }
}
