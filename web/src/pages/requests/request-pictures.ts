/** The pictures that were taken for a request, small, with how good each is. */

import { consume } from "@lit/context";
import { msg, str } from "@lit/localize";
import { css, html, LitElement, type TemplateResult } from "lit";
import { customElement, property } from "lit/decorators.js";
import { repeat } from "lit/directives/repeat.js";
import { LoadController } from "../../controllers/load.js";
import { base, panelBox, plainList } from "../../elements/base/base-style.js";
import { renderLoaded } from "../../elements/feedback/load-state.js";
import { fixedText } from "../../format/number.js";
import type { FrameList, FrameShape } from "../../generated/api.js";
import { apiContext } from "../../state/contexts.js";
import { sitePath } from "../../state/router.js";
import { plural } from "../../words/plural.js";
import { ArchiveApi, previewPath } from "../../wire/archive-api.js";
import type { HubApi } from "../../wire/hub-api.js";
import "../../elements/values/time.js";

const SMALL_PX = 320;

@customElement("t-request-pictures")
export class RequestPictures extends LitElement {
  static override styles = [
    base,
    css`
      ul {
        display: grid;
        grid-template-columns: repeat(auto-fill, minmax(min(11rem, 45%), 1fr));
        gap: var(--t-space-3);
        ${plainList}
      }
      a {
        display: grid;
        gap: var(--t-space-1);
        padding: var(--t-space-2);
        ${panelBox}
        color: inherit;
        text-decoration: none;
      }
      a:hover {
        background: var(--t-raised);
      }
      img {
        display: block;
        inline-size: 100%;
        aspect-ratio: 3 / 2;
        object-fit: contain;
        background: #000;
        border-radius: var(--t-radius-s);
      }
    `,
  ];

  @property() site = "";
  @property() request = "";
  @property() zone = "UTC";
  /** Frames that were read out so far; pictures are asked for again when there are more. */
  @property({ type: Number }) taken = 0;

  @consume({ context: apiContext }) private readonly api!: HubApi;
  private readonly found = new LoadController<FrameList>(this);

  override willUpdate(): void {
    this.found.load(`${this.site} ${this.request} ${String(this.taken)}`, () => new ArchiveApi(this.api, this.site).framesOfRequest(this.request));
  }

  override render(): TemplateResult {
    return html`${renderLoaded(this.found, msg("its pictures"), ({ frames }) =>
      frames.length === 0
        ? html`<p class="muted">${msg("There are none yet that you may see.")}</p>`
        : html`<ul aria-label=${msg("Pictures")}>
            ${repeat(
              frames,
              ({ id }) => id,
              (frame) => this.renderPicture(frame),
            )}
          </ul>`,
    )}`;
  }

  private renderPicture(frame: FrameShape): TemplateResult {
    const quality = [frame.filter, frame.fwhm === null ? "" : `${fixedText(frame.fwhm, 1)}″`, frame.stars === null ? "" : plural(frame.stars, msg("1 star"), msg(str`${String(frame.stars)} stars`))];
    return html`<li>
      <a href=${`${sitePath(this.site, "archive")}?frame=${frame.id}`}>
        <img alt="" loading="lazy" decoding="async" src=${previewPath(this.site, frame.id, "asinh", SMALL_PX)} />
        <span class="small"><t-time short .us=${frame.time_us} .zone=${this.zone}></t-time></span>
        <span class="muted small">${quality.filter(Boolean).join(" · ")}</span>
      </a>
    </li>`;
  }
}

declare global {
  interface HTMLElementTagNameMap {
    "t-request-pictures": RequestPictures;
  }
}
