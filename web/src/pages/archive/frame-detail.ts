/** One picture of the archive: drawn, with its histogram, its facts and its header. */

import { consume } from "@lit/context";
import { msg, str } from "@lit/localize";
import { css, html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, property } from "lit/decorators.js";
import { map } from "lit/directives/map.js";
import { LoadController } from "../../controllers/load.js";
import { base } from "../../elements/base/base-style.js";
import { sheets } from "../../elements/layout/page-sections.js";
import { roundText } from "../../format/number.js";
import { apiContext } from "../../state/contexts.js";
import { ArchiveApi, filePath } from "../../wire/archive-api.js";
import type { FrameDetail, FrameShape } from "../../generated/api.js";
import type { HubApi } from "../../wire/hub-api.js";
import { renderPixelValues } from "../../tiles/archive/frame-preview.js";
import { formatFileSize, qualityRows, skyPlace } from "./archive-query.js";
import { renderLoaded } from "../../elements/feedback/load-state.js";
import "../../elements/forms/button.js";
import "../../elements/feedback/loading.js";
import "../../elements/feedback/status.js";
import "../../elements/values/time.js";

/** @fires t-close when it is to be closed */
@customElement("t-frame-detail")
export class FrameDetailSheet extends LitElement {
  static override styles = [
    base,
    sheets,
    css`
      .split {
        display: grid;
        grid-template-columns: minmax(0, 3fr) minmax(16rem, 2fr);
        gap: var(--t-space-5);
        align-items: start;
      }
      .side {
        display: grid;
        gap: var(--t-space-4);
        min-inline-size: 0;
      }
      dl {
        display: grid;
        grid-template-columns: auto minmax(0, 1fr);
        gap: var(--t-space-1) var(--t-space-4);
        margin: 0;
      }
      dt {
        color: var(--t-muted);
      }
      dd {
        margin: 0;
        overflow-wrap: anywhere;
        font-variant-numeric: tabular-nums;
      }
      .cards {
        overflow: auto;
        max-block-size: 24rem;
        font-family: var(--t-mono, monospace);
        font-size: var(--t-size-s);
      }
      .cards td {
        padding: 0 var(--t-space-3) 0 0;
        vertical-align: top;
        white-space: nowrap;
      }
      @media (max-width: 60rem) {
        .split {
          grid-template-columns: minmax(0, 1fr);
        }
      }
    `,
  ];

  @property() site = "";
  @property() frame = "";
  @property() zone = "UTC";

  @consume({ context: apiContext }) private readonly api!: HubApi;
  private readonly detail = new LoadController<FrameDetail>(this);

  override willUpdate(): void {
    this.detail.load(`${this.site} ${this.frame}`, () => new ArchiveApi(this.api, this.site).frameDetail(this.frame));
  }

  override render(): TemplateResult {
    const { result, value } = this.detail;
    if (result.state === "failed") {
      return html`<div class="sheet">
        ${renderLoaded(this.detail, msg("this picture"), () => nothing)}
        <div class="actions"><t-button @click=${this.close}>${msg("Back to the list")}</t-button></div>
      </div>`;
    }
    // The picture before this one is of no use here.
    if (value?.frame.id !== this.frame) return html`<t-loading what=${msg("Loading this picture")}></t-loading>`;
    return this.renderPicture(value);
  }

  private renderPicture(found: FrameDetail): TemplateResult {
    return html`<section class="sheet" aria-labelledby="name">
      <div class="head">
        <div>
          <h2 id="name">${found.frame.target === "" ? msg("No target named") : found.frame.target}</h2>
          <p class="muted">${found.frame.name}</p>
        </div>
        <div class="actions">
          <a download=${found.frame.name} href=${filePath(this.site, this.frame)}
            >${msg(str`Download FITS (${formatFileSize(found.frame.bytes)})`)}</a
          >
          <t-button @click=${this.close}>${msg("Close")}</t-button>
        </div>
      </div>
      <div class="split">
        <div class="side">
          <t-frame-look .site=${this.site} .frame=${this.frame} .target=${found.frame.target}></t-frame-look>
        </div>
        <div class="side">${this.renderFacts(found.frame)} ${renderPixelValues(found.histogram)} ${this.renderCheck(found.frame)}</div>
      </div>
      <details>
        <summary>${msg(str`Header, ${found.header.length} cards`)}</summary>
        <div class="cards" tabindex="0" role="region" aria-label=${msg("FITS header")}>
          <table>
            ${map(
              found.header,
              (card) =>
                html`<tr>
                  <td>${card.key}</td>
                  <td>${card.value}</td>
                  <td class="muted">${card.comment}</td>
                </tr>`,
            )}
          </table>
        </div>
      </details>
    </section>`;
  }

  private renderFacts(frame: FrameShape): TemplateResult {
    const rows: [string, unknown][] = [
      [msg("Taken"), html`<t-time .us=${frame.time_us} .zone=${this.zone}></t-time>`],
      [msg("Night of"), frame.night],
      [msg("Exposure"), frame.exposure_s === null ? "–" : `${roundText(frame.exposure_s, 4)} s`],
      [msg("Frame"), frame.kind],
      [msg("Filter", { id: "filter.optical" }), frame.filter || "–"],
      [msg("Place (J2000)"), frame.ra_deg === null || frame.dec_deg === null ? "–" : skyPlace(frame.ra_deg, frame.dec_deg)],
      [msg("Size"), `${String(frame.width)} × ${String(frame.height)} px`],
      [msg("Camera"), frame.device],
      ...qualityRows(frame),
    ];
    return html`<dl>${map(rows, ([name, value]) => html`<dt>${name}</dt><dd>${value}</dd>`)}</dl>`;
  }

  private renderCheck(frame: FrameShape): unknown {
    if (frame.problems.length === 0) {
      return html`<t-status kind="ok" word=${msg("Follows the FITS standard (checked by astropy)")}></t-status>`;
    }
    return html`<div>
      <t-status kind="warn" word=${msg("Departs from the FITS standard")}></t-status>
      <ul>
        ${map(frame.problems, (problem) => html`<li class="muted">${problem}</li>`)}
      </ul>
    </div>`;
  }

  private readonly close = (): void => {
    this.dispatchEvent(new CustomEvent("t-close"));
  };
}

declare global {
  interface HTMLElementTagNameMap {
    "t-frame-detail": FrameDetailSheet;
  }
}
