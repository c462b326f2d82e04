/** Actuate page of one site: see, drive, stop, find and command a device. */

import { ContextConsumer } from "@lit/context";
import { msg } from "@lit/localize";
import { html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, property, query, state } from "lit/decorators.js";
import { DriveController } from "../../controllers/drive/drive-controller.js";
import { CommandClient } from "../../controllers/drive/command-client.js";
import type { StopClient } from "../../controllers/drive/stop-client.js";
import { ConnectionStateController } from "../../controllers/connection-state.js";
import { LoadController } from "../../controllers/load.js";
import { ContextStoreController } from "../../controllers/context-store.js";
import { base } from "../../elements/base/base-style.js";
import "../../elements/layout/card.js";
import "../../elements/forms/choice.js";
import "../../elements/feedback/empty.js";
import { renderLoaded } from "../../elements/feedback/load-state.js";
import { robotNewsContext, sessionContext, sitesContext } from "../../state/contexts.js";
import { armParts, type ArmParts } from "../../tiles/arm/arm-parts.js";
import { ptzParts } from "../../tiles/ptz/ptz-parts.js";
import "../../tiles/camera/camera-tile.js";
import "../../tiles/command/command-list.js";
import "../../tiles/command/command-sections.js";
import "../../tiles/drive/drive-pad.js";
import "../../tiles/drive/surroundings.js";
import "../../tiles/drive/vehicle-hud.js";
import "../../tiles/stop/stop-panel.js";
import type { DeviceShape, SignalShape, SiteShape, StreamShape } from "../../generated/api.js";
import { layout } from "./drive-layout.js";

@customElement("t-page-drive")
export class PageActuate extends LitElement {
  static override styles = [base, layout];

  @property() site = "";
  @state() private chosen = "";
  @state() private full = false;
  @query(".page") private readonly pageBox!: HTMLElement | null;

  private readonly session = new ContextStoreController(this, sessionContext);
  private readonly sites = new ContextStoreController(this, sitesContext);
  private readonly news = new ContextConsumer(this, { context: robotNewsContext });
  private readonly link = new ConnectionStateController(this);
  private readonly detail = new LoadController<SiteShape>(this);
  /** The arm's code comes with the first arm. */
  private readonly armElement = new LoadController<unknown>(this);
  /** Likewise. */
  private readonly ptzElement = new LoadController<unknown>(this);
  private cockpit: DriveController | null = null;
  private commands: CommandClient | null = null;
  private built = "";
  private pictureAt: number | null = null;
  private leavingFull = false;
  private unwatch: (() => void) | null = null;
  private head: ResizeObserver | null = null;

  override connectedCallback(): void {
    super.connectedCallback();
    this.stayBelowHead();
    document.addEventListener("fullscreenchange", this.onFullScreenChange);
    this.requestUpdate();
  }

  override disconnectedCallback(): void {
    super.disconnectedCallback();
    document.removeEventListener("fullscreenchange", this.onFullScreenChange);
    this.head?.disconnect();
    this.closeController();
  }

  override willUpdate(): void {
    const sites = this.sites.store;
    if (sites && this.site !== "") {
      this.detail.load(`${this.site} ${sites.catalogueOf(this.site)}`, () => sites.loadDetail(this.site));
    }
    if (this.detail.value !== undefined && this.chosenArm(this.detail.value) !== null) this.armElement.load("arm", () => import("../../tiles/arm/arm-cockpit.js"));
    if (this.detail.value !== undefined && this.chosenDevice(this.detail.value)?.drive?.ptz === true) this.ptzElement.load("ptz", () => import("../../tiles/ptz/ptz-pad.js"));
    this.buildController();
  }

  override render(): unknown {
    return renderLoaded(this.detail, msg("the site"), (detail) => this.renderPage(detail));
  }

  private renderPage(detail: SiteShape): TemplateResult {
    const arm = this.chosenArm(detail);
    const device = arm === null ? this.chosenDevice(detail) : arm.device;
    const online = this.isOnline(detail);
    const options = detail.devices.filter((candidate) => candidate.drive !== null || armParts(candidate) !== null).map(({ id, name }) => ({ id, label: name }));
    return html`
      <div class="page ${this.full ? "full" : ""}">
        <div class="top ${options.length > 1 || !device ? "" : "plain"}">
          <h1>${device?.name ?? msg("Actuate")}</h1>
          ${options.length > 1
            ? html`<t-choice
                label=${msg("Device")}
                .options=${options}
                .chosen=${device?.id ?? ""}
                @t-choose=${this.onChoose}
              ></t-choice>`
            : nothing}
        </div>
        ${arm === null
          ? device
            ? this.renderDriveView(detail, device, online)
            : this.renderNothingToDrive(detail, online)
          : this.renderArm(detail, arm, online)}
      </div>
    `;
  }

  private renderArm(detail: SiteShape, { device, jog, poses }: ArmParts, online: boolean): unknown {
    const shown = new Set([...(jog === null ? [] : [jog]), ...poses].map(({ id }) => id));
    return renderLoaded(
      this.armElement,
      msg("the arm"),
      () => html`${device.drive === null ? nothing : this.renderStop(detail, device)}
        <t-arm-cockpit
          .site=${this.site}
          .device=${device}
          .detail=${detail}
          .line=${this.commands}
          .online=${online}
          .seat=${this.cockpit?.seat ?? null}
          .stopped=${this.cockpit?.stop.desk.blocksDriving ?? false}
        ></t-arm-cockpit>
        <t-commands heading=${msg("Other commands")} .site=${this.site} .devices=${[device]} .line=${this.commands} .online=${online} .shownElsewhere=${shown}></t-commands>`,
    );
  }

  private renderNothingToDrive(detail: SiteShape, online: boolean): TemplateResult {
    const commanded = detail.devices.filter(({ commands }) => commands.length > 0);
    if (commanded.length === 0) {
      // Who administers the hub sees all of the site: nobody could give them more.
      const admin = this.session.store?.person?.admin === true;
      return html`<t-empty heading=${msg("Nothing to drive or command here")} icon="drive">
        <p>
          ${admin
            ? msg("No device of this site's description can be driven, and none takes commands.")
            : msg("None of the devices that you may see can be driven or takes commands. An admin can give you the right to see more of this site.")}
        </p>
      </t-empty>`;
    }
    return html`<t-command-sections .site=${this.site} .devices=${commanded} .line=${this.commands} .online=${online}></t-command-sections>`;
  }

  private renderDriveView(detail: SiteShape, device: DeviceShape, online: boolean): TemplateResult {
    const stream = streamOf(detail, device.drive?.picture ?? "");
    const seat = this.cockpit?.seat ?? null;
    const stop = this.cockpit?.stop ?? null;
    const ptz = device.drive?.ptz === true;
    // In the order of weight: who goes by Tab comes to STOP and the hands before the commands.
    return html`<div class="cockpit">
        <t-camera
          class="camera"
          .site=${this.site}
          .stream=${stream?.address ?? ""}
          .name=${stream?.name ?? ""}
          .detect=${stream?.detect}
          .lane=${stream?.lane}
          .models=${stream?.models}
          ?blurred=${stream?.blurred}
          ?unblurrable=${stream?.may_unblur}
          ?driving=${seat !== null && seat.machine.phase !== "idle"}
          .online=${online}
          paged
          .full=${this.full}
          @t-picture=${this.onPicture}
          @t-fullscreen=${this.toggleFullScreen}
          >${ptz
            ? nothing
            : html`<t-vehicle-hud
                slot="hud"
                .site=${this.site}
                .detail=${detail}
                .device=${device}
                .seat=${seat}
                .stopped=${stop?.desk.blocksDriving ?? false}
                .pictureAge=${this.pictureAge}
                .online=${online}
              ></t-vehicle-hud>`}</t-camera>
      <div class="right">
        ${this.renderStop(detail, device)}
        ${ptz ? this.renderPtz(device, online) : nothing}
        ${ptz && seat ? nothing : seat
          ? html`<t-card class="hands">
              <t-drive-pad
                .site=${this.site}
                .device=${device}
                .seat=${seat}
                .stopped=${stop?.desk.blocksDriving ?? false}
                .pictureAge=${this.pictureAge}
              ></t-drive-pad>
            </t-card>`
          : this.renderOnlooker(device)}
      </div>
      ${ptz ? nothing : html`<t-surroundings class="around" .site=${this.site} .detail=${detail} .signal=${signalOf(detail, device.drive?.position ?? "")} .online=${online}></t-surroundings>`}
      <t-commands
        class="commands"
        .site=${this.site}
        .devices=${ptz ? [device] : detail.devices}
        .line=${this.commands}
        .online=${online}
        .shownElsewhere=${ptz ? shownOnPad(device) : NONE_SHOWN}
      ></t-commands>
    </div>`;
  }

  private renderPtz(device: DeviceShape, online: boolean): unknown {
    return renderLoaded(
      this.ptzElement,
      msg("the pad"),
      () => html`<t-card class="hands">
        <t-ptz-pad
          .site=${this.site}
          .device=${device}
          .seat=${this.cockpit?.seat ?? null}
          .line=${this.commands}
          .stopped=${this.cockpit?.stop.desk.blocksDriving ?? false}
          .online=${online}
          .pictureAge=${this.pictureAge}
        ></t-ptz-pad>
      </t-card>`,
    );
  }

  private renderStop(detail: SiteShape, device: DeviceShape): TemplateResult {
    const stop = this.cockpit?.stop ?? null;
    return html`<t-stop-bar class="stop" .line=${stop}></t-stop-bar>
      <div class="stopped ${stop === null || isStopIdle(stop) ? "calm" : ""}">
        <t-stop .line=${stop} .zone=${detail.zone} .epoch=${this.cockpit?.seat?.lease.epoch ?? 0} .mayUse=${device.rights.includes("use")}></t-stop>
      </div>`;
  }

  private renderOnlooker(device: DeviceShape): TemplateResult {
    return html`<t-empty class="hands" heading=${msg("You may look, but not drive")} icon="lock">
      <p>
        ${msg(html`Driving ${device.name} needs the right <strong>use</strong>; an admin can give it to you. STOP works for everyone who sees it.`)}
      </p>
    </t-empty>`;
  }

  private isOnline(detail: SiteShape): boolean {
    const row = this.sites.store?.siteRow(this.site);
    return (row?.online ?? detail.online) && this.link.state === "open";
  }

  /** The arm that was chosen, or the first one where nothing else can be driven. */
  private chosenArm(detail: SiteShape): ArmParts | null {
    const arms = detail.devices.map(armParts).filter((arm) => arm !== null);
    const chosen = arms.find(({ device }) => device.id === this.chosen) ?? null;
    return chosen ?? (this.chosenDevice(detail) !== undefined ? null : (arms[0] ?? null));
  }

  private chosenDevice(detail: SiteShape): DeviceShape | undefined {
    const drivable = detail.devices.filter((device) => device.drive !== null && (device.drive.ptz || device.drive.joints.length === 0));
    return drivable.find(({ id }) => id === this.chosen) ?? drivable[0];
  }

  /** One cockpit for each device as it is described; built anew when that changes, not for others' sake. */
  private buildController(): void {
    const detail = this.detail.value;
    const { connection } = this.link;
    // While an arm is in front of somebody, no vehicle is in their hands, but the arm's own joints may be.
    const arm = detail ? this.chosenArm(detail) : null;
    const device = detail && arm === null ? this.chosenDevice(detail) : arm?.device.drive ? arm.device : undefined;
    const wanted = detail && connection && this.isConnected ? `${detail.site} ${JSON.stringify(device ?? null)}` : "";
    if (wanted === this.built) return;
    this.closeController();
    this.built = wanted;
    if (!detail || !connection || wanted === "") return;
    this.commands = new CommandClient(connection, this.site);
    this.commands.open();
    if (!device) return;
    const online = this.sites.store?.siteRow(this.site)?.online ?? detail.online;
    this.cockpit = new DriveController(connection, this.site, device, online);
    const news = this.news.value;
    this.cockpit.openAll({
      lease: news?.leaseOf(this.site, device.id),
      stop: news?.stopOf(this.site, device.id),
      heldStop: news?.heldStopOf(this.site, device.id),
    });
    const redraw = (): void => {
      this.requestUpdate();
    };
    const stops = [this.cockpit.stop.subscribe(redraw), this.cockpit.seat?.subscribe(redraw)];
    this.unwatch = () => {
      for (const stop of stops) stop?.();
    };
  }

  private closeController(): void {
    this.unwatch?.();
    this.unwatch = null;
    this.cockpit?.closeAll();
    this.commands?.close();
    this.cockpit = null;
    this.commands = null;
    this.built = "";
  }

  /** STOP sticks below the frame's head, which grows by a banner at times and must not cover it. */
  private stayBelowHead(): void {
    const root = this.getRootNode();
    const head = root instanceof ShadowRoot ? root.querySelector<HTMLElement>(".top") : null;
    if (!head) return;
    this.head = new ResizeObserver(() => {
      this.style.setProperty("--t-header", `${head.offsetHeight.toFixed(0)}px`);
    });
    this.head.observe(head);
  }

  private readonly onChoose = (event: CustomEvent<string>): void => {
    this.chosen = event.detail;
  };

  private readonly onPicture = (event: CustomEvent<number | null>): void => {
    this.pictureAt = event.detail;
    this.cockpit?.seat?.setPictureTime(event.detail);
  };

  private readonly pictureAge = (): number => (this.pictureAt === null ? -1 : performance.now() - this.pictureAt);

  private readonly toggleFullScreen = (): void => {
    if (document.fullscreenElement) {
      this.leavingFull = true;
      void document.exitFullscreen();
    } else {
      // The whole page, not the picture alone: STOP stays in sight.
      this.pageBox?.requestFullscreen().catch(() => {
        this.full = false;
      });
    }
  };

  /**
   * In full screen the browser keeps Escape for itself and tells only that it was left. Escape is
   * STOP on this page, so leaving by anything but our button is taken as that.
   */
  private readonly onFullScreenChange = (): void => {
    const was = this.full;
    this.full = document.fullscreenElement !== null;
    if (was && !this.full && !this.leavingFull) this.cockpit?.stop.pressStop();
    this.leavingFull = false;
  };
}

const NONE_SHOWN: ReadonlySet<string> = new Set();

/** The commands that the pad of a camera has buttons for. */
function shownOnPad(device: DeviceShape): ReadonlySet<string> {
  return new Set(Object.values({ ...ptzParts(device), presets: undefined }).flatMap((command) => (command === undefined ? [] : [command.id])));
}

/** Nothing is to be said of STOP but that it is there. */
function isStopIdle(stop: StopClient): boolean {
  const { phase, trouble } = stop.desk;
  return stop.online && trouble === "" && (phase === "clear" || phase === "unknown");
}

function streamOf(detail: SiteShape, address: string): StreamShape | undefined {
  return detail.devices.flatMap((device) => device.streams).find((stream) => stream.address === address);
}

function signalOf(detail: SiteShape, address: string): SignalShape | null {
  return detail.devices.flatMap((device) => device.signals).find((signal) => signal.address === address) ?? null;
}

declare global {
  interface HTMLElementTagNameMap {
    "t-page-drive": PageActuate;
  }
}
