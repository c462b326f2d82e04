/** One device: its values live, its cameras, and what the person may do with it. */

import { consume } from "@lit/context";
import { msg, str } from "@lit/localize";
import { css, html, LitElement, nothing, type PropertyValues, type TemplateResult } from "lit";
import { customElement, property } from "lit/decorators.js";
import { repeat } from "lit/directives/repeat.js";
import { CommandClient } from "../../controllers/drive/command-client.js";
import { ConnectionStateController } from "../../controllers/connection-state.js";
import { LoadController } from "../../controllers/load.js";
import { ContextStoreController } from "../../controllers/context-store.js";
import { base } from "../../elements/base/base-style.js";
import { PaintScheduler } from "../../elements/chart/paint-scheduler.js";
import { sheets } from "../../elements/layout/page-sections.js";
import { adviceFor } from "../../format/error-advice.js";
import { plural } from "../../words/plural.js";
import { formatClock } from "../../format/time.js";
import { MINUTE_US } from "../../series/zone-clock.js";
import { apiContext, reachContext, sitesContext } from "../../state/contexts.js";
import { archivePath, sitePath, withQuery } from "../../state/router.js";
import { ChartFeed } from "../../tiles/chart/chart-feed.js";
import { commandsShownBy, deviceTile, renderSignalTile, signalsFor } from "../../tiles/catalog.js";
import type { DeviceShape, SiteShape, TileList } from "../../generated/api.js";
import type { HubApi } from "../../wire/hub-api.js";
import { renderAdvice, renderLoaded } from "../../elements/feedback/load-state.js";
import "../../elements/values/clock.js";
import "../../elements/feedback/empty.js";
import "../../elements/base/icon.js";
import "../../elements/feedback/loading.js";
import "../../elements/feedback/status.js";
import "../../tiles/camera/camera-tile.js";
import "../../tiles/chart/chart-tile.js";
import "../../tiles/command/command-list.js";
import "../../tiles/command/device-holder.js";
import "../../tiles/extension-tile.js";

/** What the small charts show. */
const LENGTH_US = MINUTE_US;

@customElement("t-page-device")
export class PageDevice extends LitElement {
  static override styles = [
    base,
    sheets,
    css`
      .among {
        display: flex;
        flex-wrap: wrap;
        align-items: baseline;
        gap: var(--t-space-1) var(--t-space-4);
      }
      .charts,
      .cameras {
        display: grid;
        grid-template-columns: repeat(auto-fill, minmax(min(23rem, 100%), 1fr));
        gap: var(--t-space-3);
      }
      .ways {
        display: flex;
        flex-wrap: wrap;
        gap: var(--t-space-2);
      }
      .ways a {
        display: inline-flex;
        align-items: center;
        gap: var(--t-space-2);
        min-block-size: var(--t-touch);
        padding-inline: var(--t-space-4);
        border: 1px solid var(--t-edge);
        border-radius: var(--t-radius-s);
        background: var(--t-surface);
        font-weight: var(--t-weight-strong);
        text-decoration: none;
      }
      .ways a:hover {
        background: var(--t-raised);
      }
      section {
        display: grid;
        gap: var(--t-space-3);
        min-inline-size: 0;
      }
      .where {
        display: flex;
        flex-wrap: wrap;
        align-items: baseline;
        gap: 0 var(--t-space-3);
      }
    `,
  ];

  @property() site = "";
  @property() device = "";

  @consume({ context: apiContext }) private readonly api: HubApi | undefined;
  private readonly painter = new PaintScheduler();
  private readonly sites = new ContextStoreController(this, sitesContext);
  private readonly reach = new ContextStoreController(this, reachContext);
  private readonly link = new ConnectionStateController(this);
  private readonly detail = new LoadController<SiteShape>(this);
  private readonly tiles = new LoadController<TileList>(this);
  /** The element of the device's tile comes when a device of its kind is opened. */
  private readonly tileElement = new LoadController<unknown>(this);
  private feed: ChartFeed | null = null;
  private commands: CommandClient | null = null;

  override connectedCallback(): void {
    super.connectedCallback();
    this.requestUpdate();
  }

  override disconnectedCallback(): void {
    super.disconnectedCallback();
    this.closeClients();
  }

  protected override willUpdate(changed: PropertyValues<this>): void {
    if (changed.has("site") || changed.has("device")) this.closeClients();
    const sites = this.sites.store;
    const { connection } = this.link;
    if (sites === undefined || connection === undefined || this.api === undefined) return;
    this.detail.load(`${this.site} ${sites.catalogueOf(this.site)}`, () => sites.loadDetail(this.site));
    const { api } = this;
    this.tiles.load("tiles", () => api.request<TileList>("GET", "/api/tiles"));
    const device = this.findDevice();
    const load = device === undefined ? null : (deviceTile(device)?.load ?? null);
    if (device !== undefined && load !== null) this.tileElement.load(device.kind, load);
    if (device === undefined || !this.isConnected) return;
    this.feed ??= new ChartFeed(this.site, connection, this.api, this.onSiteLoaded, LENGTH_US);
    this.feed.subscribeSignals(device.signals);
    if (this.commands !== null || !device.rights.includes("use")) return;
    this.commands = new CommandClient(connection, this.site);
    this.commands.open();
  }

  override render(): TemplateResult {
    const detail = this.detail.value;
    const device = this.findDevice();
    if (detail === undefined) return html`${this.renderProblem()}`;
    if (device === undefined) return this.renderForbidden(detail.name);
    return html`<div class="head">
        <div>
          <p class="muted"><a href="/devices">${msg("Devices")}</a> · ${detail.name}</p>
          <h1>${device.name}</h1>
          <div class="where">
            ${this.renderStatus(detail, device)}
            <t-clock zone=${detail.zone}></t-clock>
            <span class="muted">${deviceRightsText(device)}</span>
            <t-device-holder .site=${this.site} .device=${this.device}></t-device-holder>
          </div>
        </div>
        <nav class="ways" aria-label=${device.name}>
          ${device.drive !== null && device.rights.includes("view")
            ? html`<a href=${sitePath(this.site, "drive")}
                ><t-icon name="drive"></t-icon>${device.rights.includes("use") ? msg("Drive it") : msg("See it drive, or stop it")}</a
              >`
            : nothing}
          ${device.kind === "camera" && device.rights.includes("view")
            ? html`<a href=${archivePath(this.site, this.device)}><t-icon name="camera"></t-icon>${msg("Archive")}</a>`
            : nothing}
          <a href=${this.historyPath(device)}><t-icon name="history"></t-icon>${msg("History")}</a>
        </nav>
      </div>
      ${this.renderProblem()} ${this.renderUnguarded(device)} ${this.renderDrawn(device, detail)} ${this.renderExtensions(device, detail)} ${this.renderCameras(device, detail)} ${this.renderActions(device, detail)}
      ${this.renderSignals(device, detail)}`;
  }

  /** A roof or telescope that does not close or park by itself says so, calmly. */
  private renderUnguarded(device: DeviceShape): unknown {
    if (!device.unguarded) return nothing;
    return html`<p class="unguarded" role="note">
      <t-icon name="info"></t-icon>
      <span>
        ${msg(html`This does not close or park by itself. In rain, in wind or without weather data only a person closes or parks it. Whoever keeps the site's description can change that with interlocks and an enclosure (docs: <em>Make a robot safe by itself</em>).`)}
      </span>
    </p>`;
  }

  private renderStatus(detail: SiteShape, device: DeviceShape): TemplateResult {
    const away = this.reach.store?.unreachableSince(this.site, device.id);
    if (away === undefined || !this.isOnline(detail)) {
      return html`<t-status kind=${this.isOnline(detail) ? "online" : "offline"}></t-status>`;
    }
    return html`<t-status kind="unknown" word=${msg("not reached")}></t-status>
      <span class="muted">${msg(str`since ${formatClock(away.since_us, detail.zone)}:`)} ${away.why}</span>`;
  }

  private renderProblem(): unknown {
    const { result } = this.detail;
    if (result.state === "failed") {
      const { error } = result;
      if (error instanceof Error && "status" in error && (error.status === 403 || error.status === 404)) {
        return this.renderForbidden(this.site);
      }
      return renderAdvice(adviceFor(error, msg("this device")), this.detail.invalidate);
    }
    return this.detail.value === undefined ? html`<t-loading what=${msg("Loading the device")}></t-loading>` : nothing;
  }

  /** The hub does not tell what is hidden from what does not exist, and neither can this page. */
  private renderForbidden(site: string): TemplateResult {
    return html`<t-empty heading=${msg("This device is not open to you")} icon="lock">
      <p>
        ${msg(str`There is no device ${this.device} at ${site}, or your role may not view it. An admin of this hub can give you the right.`)}
      </p>
      <p><a href="/devices">${msg("See the devices that are open to you")}</a></p>
    </t-empty>`;
  }

  private renderDrawn(device: DeviceShape, detail: SiteShape): unknown {
    const tile = deviceTile(device);
    if (tile === null) return nothing;
    return renderLoaded(this.tileElement, msg("the device"), () =>
      tile.render({ site: this.site, device, detail, line: this.commands, online: this.isReachable(detail) }),
    );
  }

  /** Tiles of the hub's administrator; what of them is broken, the hub tells admins only. */
  private renderExtensions(device: DeviceShape, detail: SiteShape): unknown {
    const { tiles = [], broken = [] } = this.tiles.value ?? {};
    const shown = tiles.filter((tile) => signalsFor(tile, device) !== null);
    if (shown.length === 0 && broken.length === 0) return nothing;
    return html`<section aria-label=${msg("Extensions")}>
      ${repeat(
        broken,
        ({ name }) => name,
        ({ name, problem }) => html`<p role="alert">${msg(str`The tile “${name}” in the hub's extensions folder cannot be used:`)} ${problem}</p>`,
      )}
      <div class="charts">
        ${repeat(
          shown,
          ({ name }) => name,
          (tile) => html`<t-extension-tile .site=${this.site} .device=${device} .tile=${tile} .online=${this.isReachable(detail)}></t-extension-tile>`,
        )}
      </div>
    </section>`;
  }

  private renderSignals(device: DeviceShape, detail: SiteShape): unknown {
    if (device.signals.length === 0) {
      return device.streams.length > 0
        ? nothing
        : html`<t-empty heading=${msg("No values to show")} icon="live"><p>${msg("It has none that you may see.")}</p></t-empty>`;
    }
    return html`<section aria-labelledby="values">
      <h2 id="values">${msg("Values")}</h2>
      <div class="charts">
        ${repeat(
          device.signals,
          (signal) => signal.address,
          (signal, colour) => renderSignalTile({ signal, feed: this.feed, painter: this.painter, colour, cut: !this.isOnline(detail), zone: detail.zone }),
        )}
      </div>
    </section>`;
  }

  private renderCameras(device: DeviceShape, detail: SiteShape): unknown {
    // A camera that takes exposures shows its pictures itself.
    if (device.streams.length === 0 || deviceTile(device)?.showsStreams === true) return nothing;
    return html`<section aria-labelledby="cameras">
      <div class="among">
        <h2 id="cameras">${plural(device.streams.length, msg("Camera"), msg("Cameras"))}</h2>
        ${this.others(device, detail)
          ? html`<a href=${sitePath(this.site, "cameras")}>${msg(str`All cameras of ${detail.name}`)}</a>`
          : nothing}
        ${device.streams.some(({ detect }) => detect != null)
          ? html`<a href=${sitePath(this.site, "sightings")}>${plural(device.streams.length, msg("What it has seen"), msg("What they have seen"))}</a>`
          : nothing}
      </div>
      <div class="cameras">
        ${repeat(
          device.streams,
          (stream) => stream.address,
          (stream) => html`<t-camera
            data-stream=${stream.address}
            .site=${this.site}
            .stream=${stream.address}
            .name=${stream.name}
            .detect=${stream.detect}
            .lane=${stream.lane}
            .models=${stream.models}
            ?blurred=${stream.blurred}
            ?unblurrable=${stream.may_unblur}
            .online=${this.isOnline(detail)}
          ></t-camera>`,
        )}
      </div>
    </section>`;
  }

  /** There are cameras beside this device's own. */
  private others(device: DeviceShape, detail: SiteShape): boolean {
    return detail.devices.some((other) => other.id !== device.id && other.streams.length > 0);
  }

  /** What can be done with it stands here only for who may do it. */
  private renderActions(device: DeviceShape, detail: SiteShape): unknown {
    if (!device.rights.includes("use")) return nothing;
    const shown = commandsShownBy(device);
    return html`<t-commands
      .site=${this.site}
      .devices=${[device]}
      .line=${this.commands}
      .online=${this.isOnline(detail)}
      .heading=${shown.size === 0 ? msg("Commands") : msg("Other commands")}
      .shownElsewhere=${shown}
    ></t-commands>`;
  }

  private findDevice(): DeviceShape | undefined {
    return this.detail.value?.devices.find(({ id }) => id === this.device);
  }

  private isOnline(detail: SiteShape): boolean {
    return (this.sites.store?.siteRow(this.site)?.online ?? detail.online) && this.link.state === "open";
  }

  /** What a device last said is not true any more once its gateway does not reach it. */
  private isReachable(detail: SiteShape): boolean {
    return this.isOnline(detail) && this.reach.store?.unreachableSince(this.site, this.device) === undefined;
  }

  private historyPath(device: DeviceShape): string {
    const channels = device.signals.filter(({ primary }) => primary).flatMap((signal) => signal.channels.slice(0, 1));
    const query = new URLSearchParams(channels.slice(0, 4).map((channel) => ["c", channel])).toString();
    return withQuery(sitePath(this.site, "history"), query);
  }

  private closeClients(): void {
    this.feed?.close();
    this.commands?.close();
    this.feed = null;
    this.commands = null;
  }

  private readonly onSiteLoaded = (): void => {
    this.painter.wakeUp();
  };
}

function deviceRightsText(device: DeviceShape): string {
  if (device.rights.includes("admin")) return msg("you may manage it");
  if (device.rights.includes("use")) return msg("you may use it");
  return device.rights.includes("view") ? msg("you may view it") : msg("you see what is public");
}

declare global {
  interface HTMLElementTagNameMap {
    "t-page-device": PageDevice;
  }
}
