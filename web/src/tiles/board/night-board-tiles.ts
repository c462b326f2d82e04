/** An observatory's night as tiles: the weather's verdict, the sky, the plan, the newest picture. */

import { consume } from "@lit/context";
import { msg, str } from "@lit/localize";
import { css, html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, property } from "lit/decorators.js";
import { map } from "lit/directives/map.js";
import { ConnectionStateController } from "../../controllers/connection-state.js";
import { ContextStoreController } from "../../controllers/context-store.js";
import { LoadController } from "../../controllers/load.js";
import { StoreController } from "../../controllers/store-controller.js";
import { TickerController } from "../../controllers/ticker.js";
import { base, quietText } from "../../elements/base/base-style.js";
import { renderLoaded } from "../../elements/feedback/load-state.js";
import type { DeviceShape, FrameList, SiteNightShape } from "../../generated/api.js";
import { plannedBlocks } from "../../series/night-blocks.js";
import { nightWindow, proposalMarks } from "../../series/plan-layout.js";
import { nextMorning, nightSky } from "../../sky/night-sky.js";
import { apiContext, interlocksContext } from "../../state/contexts.js";
import { sitePath } from "../../state/router.js";
import { ArchiveApi, previewPath } from "../../wire/archive-api.js";
import type { HubApi } from "../../wire/hub-api.js";
import { ObservingApi } from "../../wire/observing-api.js";
import "../../elements/feedback/status.js";
import "../../elements/observatory/plan-timeline.js";
import "../../elements/values/time.js";
import { DevicePart } from "../observatory/device-part.js";
import "../observatory/night-sky-view.js";
import { judgeStation, VERDICT_KINDS, VERDICT_WORDS } from "../observatory/weather-verdict.js";
import { pastTurn, type BoardTileContext } from "./board-tile-entry.js";

const EVERY_MS = 15_000;
const AGAIN_MS = 60_000;
const HALF_DAY_MS = 43_200_000;

@customElement("t-tile-verdict")
export class VerdictBoardTile extends DevicePart {
  static override styles = [
    base,
    css`
      :host {
        display: grid;
        grid-template-columns: minmax(0, 1fr);
        align-content: start;
        gap: var(--t-space-2);
      }
      t-status {
        font-size: var(--t-size-xl);
        font-weight: var(--t-weight-strong);
      }
      ul {
        display: grid;
        gap: var(--t-space-1);
        margin: 0;
        padding: 0;
        list-style: none;
      }
      li {
        display: flex;
        flex-wrap: wrap;
        justify-content: space-between;
        gap: 0 var(--t-space-3);
        ${quietText}
      }
      li.beyond,
      li.unknown {
        color: var(--t-bad);
      }
    `,
  ];

  private readonly interlocks = new ContextStoreController(this, interlocksContext);

  override willUpdate(): void {
    this.observeSignals(...(this.device?.signals ?? []));
  }

  override render(): TemplateResult | typeof nothing {
    const { device, detail } = this;
    if (device === null || detail === null) return nothing;
    const { lines, verdict: { word, why } } = judgeStation({
      rules: detail.rules,
      device,
      online: this.online,
      news: ({ id }) => this.interlocks.store?.interlockOf(this.site, id)?.news,
      known: (signal) => this.readSignal(signal),
    });
    return html`<div role="status"><t-status kind=${VERDICT_KINDS[word]} word=${VERDICT_WORDS[word]}></t-status></div>
      <p>${word === "none" ? msg("No interlock of this site reads this station: nothing here decides whether a roof may open.") : why}</p>
      <ul aria-label=${msg("What closes the roof")}>
        ${map(lines, ({ name, now, limit, stands }) => html`<li class=${stands}><span>${name} ${now}</span><span>${msg(str`closes ${limit}`)}</span></li>`)}
      </ul>`;
  }
}

/** Draws again as time passes, and knows a site's night. */
abstract class NightTile extends LitElement {
  @property({ attribute: false }) context: BoardTileContext | null = null;
  @consume({ context: apiContext }) protected readonly api: HubApi | undefined;
  protected readonly watched = new StoreController(this);
  protected readonly night = new LoadController<SiteNightShape>(this);

  constructor() {
    super();
    new TickerController(this, EVERY_MS);
    new ConnectionStateController(this, (connection) => {
      const refresh = (news: { readonly site: string }): void => {
        if (news.site === this.context?.site) this.night.invalidate();
      };
      return [connection.onMessage("night", refresh), connection.onMessage("night_plan", refresh)];
    });
  }

  protected loadNight(): void {
    const { api, context } = this;
    if (api !== undefined && context !== null) this.night.load(context.site, () => new ObservingApi(api, context.site).nightOverview());
  }

  /** What time it is at the site: of a simulated one that lives faster, as it said last. */
  protected siteMs(): number {
    const { past } = this.context ?? { past: null };
    if (past !== null) return past.us / 1000;
    const us = this.night.value?.state?.site_time_us ?? 0;
    return us > 0 ? us / 1000 : Date.now();
  }
}

@customElement("t-tile-sky")
export class SkyBoardTile extends NightTile {
  static override styles = css`
    :host {
      display: block;
    }
  `;

  @property({ attribute: false }) device: DeviceShape | null = null;

  override willUpdate(): void {
    this.watched.setStore(this.context?.past ?? null);
    this.loadNight();
  }

  override render(): TemplateResult | typeof nothing {
    const { context } = this;
    if (context === null) return nothing;
    return html`<t-night-sky .site=${context.site} .detail=${context.detail} .device=${this.device} .ms=${this.siteMs()} ?online=${context.online}></t-night-sky>`;
  }
}

@customElement("t-tile-plan")
export class PlanBoardTile extends NightTile {
  static override styles = [
    base,
    css`
      :host {
        display: block;
      }
      p {
        ${quietText}
      }
    `,
  ];

  override willUpdate(): void {
    this.loadNight();
  }

  override render(): unknown {
    return renderLoaded(this.night, msg("the plan"), (night) => this.renderPlan(night));
  }

  private renderPlan({ plan, state }: SiteNightShape): TemplateResult {
    const { context } = this;
    const ms = this.siteMs();
    const blocks = plannedBlocks(plan, state, ms);
    const place = context?.detail.place ?? null;
    const morning = (place === null ? null : nextMorning(place, ms)) ?? ms + HALF_DAY_MS;
    const span = nightWindow(
      plan !== null && plan.night_end_us / 1000 > ms - HALF_DAY_MS ? { from: plan.night_start_us / 1000, to: plan.night_end_us / 1000 } : { from: morning - 1.2 * HALF_DAY_MS, to: morning },
      blocks,
    );
    const zone = context?.zone ?? "UTC";
    return html`<p>
        ${context?.online === true ? nothing : msg("The site is not linked: this plan may be old. ")}${plan === null
          ? html`${msg("No plan yet.")} <a href=${sitePath(context?.site ?? "", "night")}>${msg("The night")}</a>`
          : html`${msg(html`Planned at <t-time short .us=${plan.made_us} .zone=${zone}></t-time>.`)} <a href=${sitePath(context?.site ?? "", "night")}>${msg("The night")}</a>`}
      </p>
      <t-plan-timeline .span=${span} .sky=${place === null ? null : nightSky(place, span)} .blocks=${blocks} .marks=${proposalMarks(blocks.map(({ proposal }) => proposal).filter(Boolean))} .ms=${ms} .zone=${zone}></t-plan-timeline>`;
  }
}

@customElement("t-tile-picture")
export class PictureBoardTile extends LitElement {
  static override styles = [
    base,
    css`
      :host {
        display: grid;
        grid-template-rows: minmax(0, 1fr) auto;
        block-size: 100%;
        min-block-size: 0;
      }
      img {
        inline-size: 100%;
        block-size: 100%;
        min-block-size: 0;
        object-fit: contain;
        background: #000;
        filter: var(--t-still-filter, none);
      }
      p {
        ${quietText}
      }
    `,
  ];

  @property({ attribute: false }) context: BoardTileContext | null = null;
  /** Of one camera; empty for all. */
  @property() device = "";
  @consume({ context: apiContext }) private readonly api: HubApi | undefined;
  private readonly watched = new StoreController(this);
  private readonly frames = new LoadController<FrameList>(this);
  private readonly picture = new LoadController<string>(this);
  /** The address in this page of the picture that is drawn; empty for none. */
  private drawn = "";

  constructor() {
    super();
    new TickerController(this, EVERY_MS);
  }

  override willUpdate(): void {
    const { api, context, device } = this;
    if (api === undefined || context === null) return;
    this.watched.setStore(context.past);
    const turn = context.past === null ? Math.floor(Date.now() / AGAIN_MS) : 0;
    const until = context.past === null ? {} : { to_us: String(pastTurn(context.past)) };
    const query = new URLSearchParams({ limit: "1", ...(device === "" ? {} : { device }), ...until }).toString();
    this.frames.load(`${context.site} ${query} ${String(turn)}`, () => new ArchiveApi(api, context.site).findFrames(query));
    const frame = this.frames.value?.frames[0];
    if (frame !== undefined) this.picture.load(`${context.site} ${frame.id}`, () => this.loadPicture(api, previewPath(context.site, frame.id, "asinh", 640)));
  }

  override disconnectedCallback(): void {
    super.disconnectedCallback();
    URL.revokeObjectURL(this.drawn);
  }

  private async loadPicture(api: HubApi, path: string): Promise<string> {
    const bytes = await api.requestBytes(path);
    URL.revokeObjectURL(this.drawn);
    this.drawn = URL.createObjectURL(new Blob([bytes]));
    return this.drawn;
  }

  override render(): unknown {
    const site = this.context?.site ?? "";
    return renderLoaded(this.frames, msg("the newest picture"), ({ frames }) => {
      const [frame] = frames;
      if (frame === undefined) return html`<p>${msg("No picture is archived, or none is open to you.")}</p>`;
      const what = frame.target === "" ? frame.kind || msg("No target named") : frame.target;
      return html`${renderLoaded(this.picture, msg("the newest picture"), (src) => html`<img alt=${msg(str`The newest picture: ${what}`)} src=${src} />`)}
        <p><a href=${`${sitePath(site, "archive")}?frame=${encodeURIComponent(frame.id)}`}>${what}</a> <t-time short .us=${frame.time_us} .zone=${this.context?.zone ?? "UTC"}></t-time></p>`;
    });
  }
}

declare global {
  interface HTMLElementTagNameMap {
    "t-tile-verdict": VerdictBoardTile;
    "t-tile-sky": SkyBoardTile;
    "t-tile-plan": PlanBoardTile;
    "t-tile-picture": PictureBoardTile;
  }
}
