/** All that is drawn of a device; its values where nothing is drawn of its kind. */

import { msg } from "@lit/localize";
import { css, html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, property } from "lit/decorators.js";
import { LoadController } from "../../controllers/load.js";
import { renderLoaded } from "../../elements/feedback/load-state.js";
import type { DeviceShape } from "../../generated/api.js";
import { deviceTile } from "../catalog.js";
import "./list-board-tiles.js";
import type { BoardTileContext } from "./board-tile-entry.js";

@customElement("t-tile-device")
export class DeviceBoardTile extends LitElement {
  static override styles = css`
    :host {
      display: block;
    }
  `;

  @property({ attribute: false }) context: BoardTileContext | null = null;
  @property({ attribute: false }) device: DeviceShape | null = null;

  private readonly element = new LoadController<unknown>(this);

  override willUpdate(): void {
    const { device } = this;
    const load = device === null ? null : (deviceTile(device)?.load ?? null);
    if (device !== null && load !== null) this.element.load(device.kind, load);
  }

  override render(): unknown {
    const { context, device } = this;
    if (context === null || device === null) return nothing;
    const tile = deviceTile(device);
    if (tile === null) return html`<t-tile-table .context=${context} .signals=${device.signals}></t-tile-table>`;
    return renderLoaded(this.element, msg("the device"), (): TemplateResult | typeof nothing =>
      tile.render({ site: context.site, device, detail: context.detail, line: context.line, online: context.online }),
    );
  }
}

declare global {
  interface HTMLElementTagNameMap {
    "t-tile-device": DeviceBoardTile;
  }
}
