/** Cameras of a board that looks back: the kept films at the moment, or that there is none. */

import { consume } from "@lit/context";
import { msg, str } from "@lit/localize";
import { css, html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, property } from "lit/decorators.js";
import { repeat } from "lit/directives/repeat.js";
import { LoadController } from "../../controllers/load.js";
import { StoreController } from "../../controllers/store-controller.js";
import { base, quietText } from "../../elements/base/base-style.js";
import { renderAdvice } from "../../elements/feedback/load-state.js";
import { adviceFor } from "../../format/error-advice.js";
import type { FilmListShape, StreamShape } from "../../generated/api.js";
import { apiContext } from "../../state/contexts.js";
import type { HubApi } from "../../wire/hub-api.js";
import { FilmsApi } from "../../wire/films-api.js";
import { filmsByCamera, filmSpanAround, filmStateAt, type CameraFilms } from "../../state/past/film-search.js";
import "../../elements/base/icon.js";
import "../../elements/feedback/loading.js";
import "../camera/film-view.js";
import type { BoardTileContext } from "./board-tile-entry.js";

@customElement("t-tile-films")
export class FilmBoardTile extends LitElement {
  static override styles = [
    base,
    css`
      :host {
        display: grid;
        grid-template-columns: repeat(auto-fill, minmax(min(18rem, 100%), 1fr));
        gap: var(--t-space-2);
        min-block-size: 100%;
      }
      .none {
        display: grid;
        /* Alone it has all of the tile. */
        block-size: 100%;
        grid-column: 1 / -1;
        align-content: center;
        justify-items: center;
        gap: var(--t-space-1);
        min-block-size: 6rem;
        ${quietText}
        text-align: center;
      }
      .none strong {
        color: var(--t-text);
      }
    `,
  ];

  @property({ attribute: false }) context: BoardTileContext | null = null;
  @property({ attribute: false }) streams: readonly StreamShape[] = [];

  @consume({ context: apiContext }) private readonly api: HubApi | undefined;
  private readonly watched = new StoreController(this);
  private readonly list = new LoadController<FilmListShape>(this);
  private isDense = false;

  override willUpdate(): void {
    const { api, context } = this;
    const past = context?.past ?? null;
    this.watched.setStore(past);
    if (api === undefined || context === null || past === null || !past.isSettled) return;
    this.isDense ||= this.list.value?.more === true;
    const { fromUs, toUs } = filmSpanAround(past.us, this.isDense);
    this.list.load(`${context.site} ${String(fromUs)} ${String(toUs)}`, () => new FilmsApi(api).listFilms(context.site, fromUs, toUs));
  }

  override render(): unknown {
    const { context, streams } = this;
    if (context === null || context.past === null) return nothing;
    const { result } = this.list;
    if (result.state === "failed") return renderAdvice(adviceFor(result.error, msg("the films")), this.list.invalidate);
    const list = this.list.value;
    if (list === undefined) return html`<t-loading what=${msg("Looking for films")}></t-loading>`;
    const reels = new Map(filmsByCamera(list, new Map(streams.map(({ address, name }) => [address, name]))).map((reel) => [reel.stream, reel]));
    return repeat(
      streams,
      ({ address }) => address,
      (stream) => this.renderCamera(stream, reels.get(stream.address)),
    );
  }

  private renderCamera({ name }: StreamShape, reel: CameraFilms | undefined): TemplateResult | typeof nothing {
    const past = this.context?.past ?? null;
    if (past === null) return nothing;
    const found = reel === undefined ? null : filmStateAt(reel, past.us);
    if (reel === undefined || found === null || (found.kind === "none" && found.before === null && found.after === null)) {
      return html`<div class="none" data-state="past">
        <t-icon name="camera"></t-icon><strong>${msg("Nothing was recorded at this moment")}</strong><span>${msg(str`${name}: no film was kept.`)}</span>
      </div>`;
    }
    return html`<t-film-view
      .site=${this.context?.site ?? ""}
      .reel=${reel}
      .us=${past.us}
      .speed=${past.speed}
      .zone=${this.context?.zone ?? "UTC"}
      ?playing=${past.playing}
      @t-moment=${this.onMoment}
    ></t-film-view>`;
  }

  private readonly onMoment = (event: CustomEvent<number>): void => {
    this.context?.past?.seek(event.detail);
  };
}

declare global {
  interface HTMLElementTagNameMap {
    "t-tile-films": FilmBoardTile;
  }
}
