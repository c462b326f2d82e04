/** Several cameras side by side. */

import { css, html, LitElement, type TemplateResult } from "lit";
import { customElement, property } from "lit/decorators.js";
import { repeat } from "lit/directives/repeat.js";
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
    `,
  ];

  @property({ attribute: false }) context: BoardTileContext | null = null;
  @property({ attribute: false }) streams: readonly StreamShape[] = [];

  override render(): unknown {
    const { context, streams } = this;
    if (streams.length === 0) return html`<t-empty heading="No camera" icon="camera"><p>This site has none that is open to you.</p></t-empty>`;
    return repeat(
      streams,
      ({ address }) => address,
      (stream): TemplateResult =>
        html`<t-camera .site=${context?.site ?? ""} .stream=${stream.address} .name=${stream.name} .detect=${stream.detect} .online=${context?.online ?? false}></t-camera>`,
    );
  }
}

declare global {
  interface HTMLElementTagNameMap {
    "t-tile-cameras": CameraWallTile;
  }
}
