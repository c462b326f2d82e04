/** The archive of pictures of a site: by night, searched by target, filter, camera and place. */

import { consume } from "@lit/context";
import { msg, str } from "@lit/localize";
import { css, html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, property, state } from "lit/decorators.js";
import { repeat } from "lit/directives/repeat.js";
import { FilterForm } from "../../controllers/filter-form.js";
import { LoadController } from "../../controllers/load.js";
import { ContextStoreController } from "../../controllers/context-store.js";
import { base, panelBox, plainList } from "../../elements/base/base-style.js";
import { renderOptions } from "../../elements/forms/form-parts.js";
import { forms } from "../../elements/forms/form-style.js";
import { renderPageHead } from "../../elements/layout/page-head.js";
import { sheets } from "../../elements/layout/page-sections.js";
import { formTexts } from "../../format/filter-query.js";
import { fixedText, roundText } from "../../format/number.js";
import { plural } from "../../words/plural.js";
import { apiContext, routerContext, sitesContext } from "../../state/contexts.js";
import { sitePath, withQuery } from "../../state/router.js";
import { ArchiveApi, obscorePath, previewPath } from "../../wire/archive-api.js";
import type { FrameList, FrameShape, NightList } from "../../generated/api.js";
import type { HubApi } from "../../wire/hub-api.js";
import {
  FILTER_KEYS,
  formatFileSize,
  frameQuery,
  NO_FILTER,
  placeInDegrees,
  placeProblem,
  shownRa,
  readArchiveFilter,
  skyPlace,
  writeArchiveFilter,
  type ArchiveFilter,
} from "./archive-query.js";
import { renderLoaded } from "../../elements/feedback/load-state.js";
import "../../elements/forms/button.js";
import "../../elements/feedback/empty.js";
import "../../elements/forms/field.js";
import "../../elements/base/icon.js";
import "../../elements/feedback/status.js";
import "../../elements/values/time.js";
import "./frame-detail.js";

const FIRST = 48;
const MOST = 480;
const SMALL_PX = 320;

@customElement("t-page-archive")
export class PageArchive extends LitElement {
  static override styles = [
    base,
    sheets,
    forms,
    css`
      .frames {
        display: grid;
        grid-template-columns: repeat(auto-fill, minmax(min(14rem, 100%), 1fr));
        gap: var(--t-space-3);
        ${plainList}
      }
      .frames a {
        display: grid;
        gap: var(--t-space-1);
        block-size: 100%;
        align-content: start;
        padding: var(--t-space-3);
        ${panelBox}
        color: inherit;
        text-decoration: none;
      }
      .frames a:hover {
        background: var(--t-raised);
      }
      .frames img {
        display: block;
        inline-size: 100%;
        aspect-ratio: 4 / 3;
        object-fit: contain;
        background: #000;
        border-radius: var(--t-radius-s);
      }
      @media (max-width: 45rem) {
        .frames {
          grid-template-columns: 1fr 1fr;
        }
      }
    `,
  ];

  @property() site = "";
  @state() private limit = FIRST;

  @consume({ context: apiContext }) private readonly api!: HubApi;
  private readonly router = new ContextStoreController(this, routerContext);
  private readonly sites = new ContextStoreController(this, sitesContext);
  private readonly nights = new LoadController<NightList>(this);
  private readonly found = new LoadController<FrameList>(this);
  private readonly form = new FilterForm<ArchiveFilter>(
    this,
    (said) => placeInDegrees(formTexts(said, FILTER_KEYS)),
    (filter) => {
      this.limit = FIRST;
      this.router.store?.replace(this.pathOf("", filter));
    },
    NO_FILTER,
  );

  override willUpdate(): void {
    const archive = new ArchiveApi(this.api, this.site);
    this.nights.load(this.site, () => archive.nights());
    const asked = frameQuery(this.filter(), this.limit);
    this.found.load(`${this.site} ${asked}`, () => archive.findFrames(asked));
  }

  override render(): TemplateResult {
    const frame = new URLSearchParams(this.router.store?.search ?? "").get("frame") ?? "";
    const nights = this.nights.value?.nights ?? [];
    const total = nights.reduce((sum, night) => sum + night.frames, 0);
    const bytes = nights.reduce((sum, night) => sum + night.bytes, 0);
    return html`${renderPageHead(
        msg("Archive"),
        this.nights.value === undefined
          ? msg("Pictures that the cameras took, by night.")
          : plural(total, plural(nights.length, msg(str`${String(total)} picture of ${String(nights.length)} night, ${formatFileSize(bytes)}. A night lasts from noon to noon.`), msg(str`${String(total)} picture of ${String(nights.length)} nights, ${formatFileSize(bytes)}. A night lasts from noon to noon.`)), plural(nights.length, msg(str`${String(total)} pictures of ${String(nights.length)} night, ${formatFileSize(bytes)}. A night lasts from noon to noon.`), msg(str`${String(total)} pictures of ${String(nights.length)} nights, ${formatFileSize(bytes)}. A night lasts from noon to noon.`))),
      )}
      ${frame === ""
        ? nothing
        : html`<t-frame-detail .site=${this.site} .frame=${frame} .zone=${this.zone()} @t-close=${this.closeFrame}></t-frame-detail>`}
      ${this.renderSearch()} ${renderLoaded(this.found, msg("the archive"), (found) => this.renderPictures(found))}`;
  }

  private renderSearch(): TemplateResult {
    const filter = this.filter();
    const nights = this.nights.value?.nights ?? [];
    const problem = placeProblem(filter);
    const errorOf = (field: string): string => (problem?.field === field ? problem.text : "");
    return html`<form class="sheet filter" @submit=${this.form.onSubmit} @change=${this.form.onSubmit}>
      <t-field label=${msg("Night")}>
        <select name="night">
          ${renderOptions([["", msg("all", { id: "all.nights" })], ...nights.map(({ night, frames }) => [night, `${night} (${String(frames)})`] as const)], filter.night)}
        </select>
      </t-field>
      <t-field label=${msg("Target")}><input name="target" autocomplete="off" maxlength="200" .value=${filter.target} /></t-field>
      <t-field label=${msg("Filter", { id: "filter.optical" })}><input name="filter" autocomplete="off" maxlength="200" .value=${filter.filter} /></t-field>
      <t-field label=${msg("Camera")}><input name="device" autocomplete="off" maxlength="200" .value=${filter.device} /></t-field>
      <t-field label="RA (J2000)" hint=${msg("05:34:32 or 83.63°")} error=${errorOf("ra")}>
        <input name="ra" autocomplete="off" .value=${shownRa(filter)} />
      </t-field>
      <t-field label="Dec (J2000)" hint=${msg("\u221205:23:28 or \u22125.39")} error=${errorOf("dec")}>
        <input name="dec" inputmode="decimal" autocomplete="off" .value=${filter.dec} />
      </t-field>
      <t-field label=${msg("Within (°)")} error=${errorOf("radius")}>
        <input name="radius" inputmode="decimal" autocomplete="off" placeholder="1" .value=${filter.radius} />
      </t-field>
      <div class="actions">
        <t-button type="submit">${msg("Search")}</t-button>
        <t-button kind="quiet" ?disabled=${writeArchiveFilter(filter) === ""} @click=${this.form.clearFilter}>${msg("Clear")}</t-button>
        <a download href=${obscorePath(this.site, "votable")} title=${msg("All pictures that you may see, as a table of the Virtual Observatory")}>${msg("ObsCore (VOTable)")}</a>
        <a download href=${obscorePath(this.site, "csv")}>${msg("ObsCore (CSV)")}</a>
      </div>
    </form>`;
  }

  private renderPictures(found: FrameList): TemplateResult {
    if (found.frames.length === 0) {
      const all = writeArchiveFilter(this.filter()) === "";
      return html`<t-empty heading=${all ? msg("No pictures yet") : msg("No matches")} icon="camera">
        <p>
          ${all
            ? msg("A picture comes here by itself after each exposure of a camera that you may see.")
            : msg("No picture is like this; take one of the words away.")}
        </p>
      </t-empty>`;
    }
    return html`<ul class="frames" aria-label=${msg("Pictures")} aria-busy=${this.found.result.state === "loading"}>
        ${repeat(
          found.frames,
          (frame) => frame.id,
          (frame) => this.renderCard(frame),
        )}
      </ul>
      ${found.more && this.limit < MOST
        ? html`<div class="actions"><t-button @click=${this.showMore}>${msg("Show more")}</t-button></div>`
        : nothing}`;
  }

  private renderCard(frame: FrameShape): TemplateResult {
    const exposure = frame.exposure_s === null ? "" : `${roundText(frame.exposure_s, 3)} s`;
    return html`<li>
      <a href=${this.pathOf(frame.id)}>
        <img alt="" loading="lazy" decoding="async" src=${previewPath(this.site, frame.id, "asinh", SMALL_PX)} />
        <span class="name">${frame.target === "" ? msg("No target named") : frame.target}</span>
        <span class="facts">
          <span>${[frame.kind, frame.filter, exposure].filter(Boolean).join(" · ")}</span>
        </span>
        ${frame.stars === null
          ? nothing
          : html`<span class="muted small">
              ${[plural(frame.stars, msg("1 star"), msg(str`${String(frame.stars)} stars`)), frame.fwhm === null ? "" : `${fixedText(frame.fwhm, 1)}″`, frame.solved ? msg("solved") : ""].filter(Boolean).join(" · ")}
            </span>`}
        <span class="small"><t-time short .us=${frame.time_us} .zone=${this.zone()}></t-time></span>
        ${frame.ra_deg === null || frame.dec_deg === null
          ? nothing
          : html`<span class="muted small">${skyPlace(frame.ra_deg, frame.dec_deg)}</span>`}
        ${frame.problems.length === 0 ? nothing : html`<t-status kind="warn" word=${msg("departs from FITS")}></t-status>`}
      </a>
    </li>`;
  }

  private zone(): string {
    return this.sites.store?.zoneOf(this.site) ?? "UTC";
  }

  private filter(): ArchiveFilter {
    return readArchiveFilter(this.router.store?.search ?? "");
  }

  private pathOf(frame: string, filter = this.filter()): string {
    const asked = new URLSearchParams(writeArchiveFilter(filter));
    if (frame !== "") asked.set("frame", frame);
    return withQuery(sitePath(this.site, "archive"), asked.toString());
  }

  private readonly closeFrame = (): void => {
    this.router.store?.navigate(this.pathOf(""));
  };

  private readonly showMore = (): void => {
    this.limit = Math.min(MOST, this.limit * 2);
  };
}

declare global {
  interface HTMLElementTagNameMap {
    "t-page-archive": PageArchive;
  }
}
