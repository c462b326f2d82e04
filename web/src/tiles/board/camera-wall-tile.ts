/** Cameras of a board: one, or several side by side. When their pictures were taken, who drives by them is told. */

import { msg } from "@lit/localize";
import { css, html, LitElement, type TemplateResult } from "lit";
import { customElement, property } from "lit/decorators.js";
import { repeat } from "lit/directives/repeat.js";
import { StoreController } from "../../controllers/store-controller.js";
import { base } from "../../elements/base/base-style.js";
import type { StreamShape } from "../../generated/api.js";
import "../camera/camera-tile.js";
import "../../elements/feedback/empty.js";
import type { BoardTileContext } from "./board-tile-entry.js";

@customElement("t-tile-cameras")
export class CameraWallTile extends LitElement {
  static override styles = [
    base,
    css`
      :host {
        display: grid;
        grid-template-columns: repeat(auto-fill, minmax(min(18rem, 100%), 1fr));
        align-content: start;
        gap: var(--t-space-2);
      }
      :host(:is([alone], [single])) {
        grid-template-columns: minmax(0, 1fr);
        grid-template-rows: minmax(0, 1fr);
        align-content: stretch;
        block-size: 100%;
      }
    `,
  ];

  @property({ attribute: false }) context: BoardTileContext | null = null;
  @property({ attribute: false }) streams: readonly StreamShape[] = [];
  /** One camera that has the tile to itself. */
  @property({ type: Boolean, reflect: true }) alone = false;

  /** A wall of one camera is no wall. */
  @property({ type: Boolean, reflect: true }) single = false;

  private readonly watched = new StoreController(this);

  override willUpdate(): void {
    this.watched.setStore(this.context?.pictures ?? null);
    this.single = this.streams.length === 1;
  }

  override render(): unknown {
    const { context, streams } = this;
    if (streams.length === 0) return html`<t-empty heading=${msg("No camera")} icon="camera"><p>${msg("This site has none that is open to you.")}</p></t-empty>`;
    return repeat(
      streams,
      ({ address }) => address,
      (stream): TemplateResult =>
        html`<t-camera
          .site=${context?.site ?? ""}
          .stream=${stream.address}
          .name=${stream.name}
          .detect=${stream.detect}
          .lane=${stream.lane}
          .models=${stream.models}
          .online=${context?.online ?? false}
          ?filling=${this.alone || this.single}
          ?driving=${context?.pictures.isDriven(stream.address) ?? false}
          @t-picture=${this.reporter(stream)}
        ></t-camera>`,
    );
  }

  private reporter({ address }: StreamShape): (event: CustomEvent<number | null>) => void {
    return (event) => {
      this.context?.pictures.reportPicture(address, event.detail);
    };
  }
}

declare global {
  interface HTMLElementTagNameMap {
    "t-tile-cameras": CameraWallTile;
  }
}
