/** Lease, pad, speed and STOP of one device: what the page *Actuate* has, as a tile. */

import { ContextConsumer } from "@lit/context";
import { msg, str } from "@lit/localize";
import { css, html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, property } from "lit/decorators.js";
import { DriveController } from "../../controllers/drive/drive-controller.js";
import { ConnectionStateController } from "../../controllers/connection-state.js";
import { base, quietText } from "../../elements/base/base-style.js";
import type { DeviceShape } from "../../generated/api.js";
import { robotNewsContext } from "../../state/contexts.js";
import "../../elements/feedback/empty.js";
import "../drive/drive-pad.js";
import "../stop/stop-panel.js";
import type { BoardTileContext } from "./board-tile-entry.js";

/**
 * Keys are heard by all of a page: only the first of the pads of a connection to the hub has them, so that no two robots
 * are driven at once. A page has one connection; the gallery makes up several that lead nowhere.
 */
const pads: DriveBoardTile[] = [];

@customElement("t-tile-drive")
export class DriveBoardTile extends LitElement {
  static override styles = [
    base,
    css`
      :host {
        display: grid;
        grid-template-columns: minmax(0, 1fr);
        align-content: start;
        gap: var(--t-space-3);
        /* As on the page Actuate: a pad as wide as a tile pushes the speed out of it. */
        --t-pad-size: 11rem;
        --t-arrows-size: 10rem;
      }
      p {
        ${quietText}
      }
    `,
  ];

  @property({ attribute: false }) context: BoardTileContext | null = null;
  @property({ attribute: false }) device: DeviceShape | null = null;

  private readonly news = new ContextConsumer(this, { context: robotNewsContext });
  private readonly link = new ConnectionStateController(this);
  private controller: DriveController | null = null;
  private unwatch: (() => void)[] = [];
  private built = "";

  override connectedCallback(): void {
    super.connectedCallback();
    pads.push(this);
    this.requestUpdate();
  }

  override disconnectedCallback(): void {
    super.disconnectedCallback();
    this.closeController();
    pads.splice(pads.indexOf(this), 1);
    for (const pad of pads) pad.requestUpdate();
  }

  private get isFirst(): boolean {
    return pads.find(({ link }) => link.connection === this.link.connection) === this;
  }

  override willUpdate(): void {
    const { device, context } = this;
    const { connection } = this.link;
    const drives = device !== null && device.drive !== null && device.rights.includes("view");
    const wanted = drives && this.isFirst && context !== null && connection !== undefined && this.isConnected ? `${context.site} ${JSON.stringify(device)}` : "";
    if (wanted === this.built) return;
    this.closeController();
    this.built = wanted;
    if (wanted === "" || device === null || context === null || connection === undefined) return;
    // In the past there are no hands: Escape and STOP alone are heard.
    const held = context.past === null ? device : { ...device, rights: device.rights.filter((right) => right !== "use") };
    this.controller = new DriveController(connection, context.site, held, context.linked);
    const news = this.news.value;
    this.controller.openAll({ lease: news?.leaseOf(context.site, device.id), stop: news?.stopOf(context.site, device.id), heldStop: news?.heldStopOf(context.site, device.id) });
    const { seat } = this.controller;
    const { pictures } = context;
    const stream = device.drive?.picture ?? "";
    const redraw = (): void => {
      pictures.setDriven(seat !== null && seat.machine.phase !== "idle" ? stream : "");
      this.requestUpdate();
    };
    const followPicture = (): void => {
      seat?.setPictureTime(pictures.takenAt(stream));
    };
    followPicture();
    this.unwatch = [pictures.subscribe(followPicture), this.controller.stop.subscribe(redraw), ...(seat === null ? [] : [seat.subscribe(redraw)])];
  }

  override render(): TemplateResult | typeof nothing {
    const { device, controller, context } = this;
    if (device === null || context === null) return nothing;
    if (device.drive === null) return html`<t-empty heading=${msg("Nothing to drive")} icon="drive"><p>${msg(str`${device.name} cannot be driven.`)}</p></t-empty>`;
    if (!this.isFirst) return html`<t-empty heading=${msg("One drive pad at a time")} icon="drive"><p>${msg("Keys drive one robot only: the first pad of this board has them.")}</p></t-empty>`;
    if (controller === null) return html`<t-empty heading=${msg("Not open to you")} icon="lock"><p>${msg(html`To see ${device.name} drive takes the right <strong>view</strong>.`)}</p></t-empty>`;
    const { seat, stop } = controller;
    // First of all: who goes by Tab comes to STOP before the hands.
    return html`<t-stop-bar .line=${stop}></t-stop-bar>
      <t-stop .line=${stop} .zone=${context.zone} .epoch=${seat?.lease.epoch ?? 0} .mayUse=${device.rights.includes("use")}></t-stop>
      ${context.past !== null
        ? html`<p>${msg("This board shows a past moment: nothing is driven from it. Go back to now to drive. STOP works as ever.")}</p>`
        : seat === null
        ? html`<p>${msg(html`Driving ${device.name} needs the right <strong>use</strong>. STOP works for everyone who sees it.`)}</p>`
        : html`<t-drive-pad .site=${context.site} .device=${device} .seat=${seat} .stopped=${stop.desk.blocksDriving} .pictureAge=${this.pictureAge}></t-drive-pad>`}`;
  }

  private readonly pictureAge = (): number => {
    const at = this.context?.pictures.takenAt(this.device?.drive?.picture ?? "") ?? null;
    return at === null ? -1 : performance.now() - at;
  };

  private closeController(): void {
    for (const stop of this.unwatch) stop();
    if (this.controller !== null) this.context?.pictures.setDriven("");
    this.unwatch = [];
    this.controller?.closeAll();
    this.controller = null;
    this.built = "";
  }
}

declare global {
  interface HTMLElementTagNameMap {
    "t-tile-drive": DriveBoardTile;
  }
}
