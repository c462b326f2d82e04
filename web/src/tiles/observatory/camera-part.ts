/** A camera that takes exposures: the form, how far it is, the newest picture, its cooler. */

import { consume } from "@lit/context";
import { msg, str } from "@lit/localize";
import { css, html, nothing, type TemplateResult } from "lit";
import { customElement } from "lit/decorators.js";
import { map } from "lit/directives/map.js";
import { isFinal } from "../../controllers/drive/command-machine.js";
import { LoadController } from "../../controllers/load.js";
import { StoreController } from "../../controllers/store-controller.js";
import { base, quietText } from "../../elements/base/base-style.js";
import { formatBytes } from "../../format/bytes.js";
import { formatDuration } from "../../format/duration.js";
import { roundText } from "../../format/number.js";
import { formatDec, formatRa } from "../../format/sexagesimal.js";
import { apiContext } from "../../state/contexts.js";
import { archivePath } from "../../state/router.js";
import { ArchiveApi, filePath, previewPath } from "../../wire/archive-api.js";
import type { CommandShape, DeviceShape, FrameDetail, SignalShape } from "../../generated/api.js";
import type { HubApi } from "../../wire/hub-api.js";
import { renderPixelValues } from "../archive/frame-preview.js";
import { NO_DEVICE, DevicePart, partStyle } from "./device-part.js";
import { newestTurn } from "./newest-turn.js";
import { cameraCommands, cameraSignals, meaningOf, type CameraSignals, type CommandButton } from "./roles.js";
import "../../elements/layout/card.js";
import "../../elements/feedback/empty.js";
import "../../elements/feedback/loading.js";
import "../../elements/feedback/status.js";
import "../../elements/values/time.js";
import "../camera/camera-tile.js";
import "../command/command-card.js";
import "../command/command-buttons.js";
import "../signal-value.js";

/** A countdown that has not moved for so long (ms) is none. */
const COUNTS_MS = 3000;

@customElement("t-part-camera")
export class CameraPart extends DevicePart {
  static override styles = [
    base,
    partStyle,
    css`
      .two {
        grid-template-rows: auto 1fr;
      }
      @container (min-width: 54.01rem) {
        .exposure {
          grid-column: 2;
          grid-row: 1 / span 2;
        }
      }
      .forms {
        display: grid;
        gap: var(--t-space-5);
      }
      .forms > * + * {
        padding-block-start: var(--t-space-4);
        border-block-start: 1px solid var(--t-line);
      }
      .newest {
        display: grid;
        gap: var(--t-space-1);
        font-size: var(--t-size-s);
      }
      img {
        inline-size: 100%;
        max-block-size: 9rem;
        object-fit: contain;
        background: #000;
        filter: var(--t-still-filter, none);
      }
      .progress {
        display: grid;
        gap: var(--t-space-1);
        font-variant-numeric: tabular-nums;
      }
      progress {
        inline-size: 100%;
        block-size: 0.75rem;
        accent-color: var(--t-accent);
      }
      .facts {
        display: flex;
        flex-wrap: wrap;
        gap: var(--t-space-1) var(--t-space-4);
        ${quietText}
      }
      .ways {
        display: flex;
        flex-wrap: wrap;
        gap: var(--t-space-4);
      }
      .ways a {
        display: inline-flex;
        align-items: center;
        min-block-size: var(--t-touch);
        font-weight: var(--t-weight-strong);
      }
    `,
  ];

  @consume({ context: apiContext }) private readonly api!: HubApi;
  private readonly newest = new LoadController<FrameDetail | null>(this);
  private readonly watched = new StoreController(this);
  private longest = 0;
  private left = Number.NaN;
  private movedMs = 0;
  private under = false;
  private ends = 0;

  override willUpdate(): void {
    const signals = cameraSignals(this.device ?? NO_DEVICE);
    this.observeSignals(...Object.values<SignalShape | undefined>({ ...signals }));
    this.watched.setStore(this.line);
    this.trackExposure(signals);
    const device = this.device?.id ?? "";
    if (device === "") return;
    this.newest.load(`${this.site} ${device} ${newestTurn(Date.now(), this.ends)}`, () => this.loadNewestFrame(device));
  }

  /** The length of an exposure is the most that was ever left of it. */
  private trackExposure({ state, remaining }: CameraSignals): void {
    const { fresh, value } = this.readSignal(remaining);
    const now = Date.now();
    if (fresh && value !== this.left) {
      // What stands there when the page opens may be the length of the next one, or of the last.
      this.movedMs = Number.isNaN(this.left) ? 0 : now;
      this.left = value;
    }
    const before = this.under;
    const told = this.readSignal(state);
    const counts = now - this.movedMs < COUNTS_MS || this.isExposureRequested();
    this.under = state === undefined ? fresh && value > 0 && counts : told.fresh && meaningOf(state, told.value) === "exposing";
    if (this.under && fresh) this.longest = Math.max(this.longest, value);
    if (before && !this.under) {
      this.longest = 0;
      this.ends = now;
    }
  }

  /** An exposure was asked for here, and its end is not known yet. */
  private isExposureRequested(): boolean {
    const device = this.device ?? NO_DEVICE;
    const asks = cameraCommands(device).expose.map(({ id }) => this.line?.desk.latestRequest(device.id, id) ?? null);
    return asks.some((request) => request !== null && !isFinal(request.phase));
  }

  private async loadNewestFrame(device: string): Promise<FrameDetail | null> {
    const archive = new ArchiveApi(this.api, this.site);
    const { frames } = await archive.findFrames(new URLSearchParams({ device, limit: "1" }).toString());
    const [frame] = frames;
    if (frame === undefined) return null;
    const held = this.newest.value;
    return held?.frame.id === frame.id ? held : archive.frameDetail(frame.id);
  }

  override render(): TemplateResult | typeof nothing {
    const { device } = this;
    if (device === null) return nothing;
    if (this.compact) return this.renderGlance(device);
    return html`<div class="two" role="group" aria-label=${msg("Camera")}>
      <div class="card">${this.renderPicture()}</div>
      <div class="card exposure">${this.renderExposure()}</div>
      ${this.renderCooler()} ${this.renderSettings()}
    </div>`;
  }

  private renderGlance(device: DeviceShape): TemplateResult {
    const { state, remaining, temperature } = cameraSignals(device);
    const frame = this.newest.value?.frame;
    return html`<div class="readings">${map([state, temperature], (signal) => this.renderReading(signal, "m"))}</div>
      ${this.renderProgress(remaining)}
      ${frame === undefined
        ? html`<p class="note">${msg("No picture is archived, or none is open to you.")}</p>`
        : html`<a class="newest" href=${archivePath(this.site, device.id)}
            ><img alt=${msg(str`The newest picture: ${frame.target === "" ? frame.kind || msg("no target named") : frame.target}`)} src=${previewPath(this.site, frame.id, "asinh", 320)} />
            <span>${frame.target === "" ? msg("Newest picture") : frame.target}, <t-time short .us=${frame.time_us} .zone=${this.detail?.zone ?? "UTC"}></t-time></span></a
          >`}`;
  }

  private renderPicture(): unknown {
    const found = this.newest.value;
    if (found === undefined) {
      return this.newest.result.state === "failed" ? this.renderStreams() : html`<t-loading what=${msg("Loading the newest picture")}></t-loading>`;
    }
    if (found === null) return this.renderStreams();
    const { frame, histogram } = found;
    const exposure = frame.exposure_s === null ? "" : `${roundText(frame.exposure_s, 4)} s`;
    return html`<div>
        <h2>${frame.target === "" ? msg("Newest picture") : frame.target}</h2>
        <div class="facts">
          <span><t-time .us=${frame.time_us} .zone=${this.detail?.zone ?? "UTC"}></t-time></span>
          <span>${[frame.kind, frame.filter, exposure].filter(Boolean).join(" · ")}</span>
          ${frame.ra_deg === null || frame.dec_deg === null
            ? nothing
            : html`<span>${formatRa(frame.ra_deg / 15)} ${formatDec(frame.dec_deg)}</span>`}
          <span>${frame.width} × ${frame.height} px</span>
        </div>
      </div>
      <t-frame-look .site=${this.site} .frame=${frame.id} .target=${frame.target}></t-frame-look>
      ${renderPixelValues(histogram)}
      <div class="ways">
        <a download=${frame.name} href=${filePath(this.site, frame.id)}>${msg(str`Download FITS (${formatBytes(frame.bytes)})`)}</a>
        <a href=${archivePath(this.site, frame.device)}>${msg("All its pictures")}</a>
      </div>`;
  }

  /** Without a picture in the archive, what it shows now. */
  private renderStreams(): unknown {
    const streams = this.device?.streams ?? [];
    if (streams.length === 0) {
      return html`<t-empty heading=${msg("No picture yet")} icon="camera">
        <p>${msg("A picture comes here by itself after an exposure, and into the archive.")}</p>
      </t-empty>`;
    }
    return html`<div>
        <h2>${msg("Newest picture")}</h2>
        <p class="note">${msg("None of its files is in the archive; this is what it shows itself.")}</p>
      </div>
      ${map(
        streams,
        ({ address, name, detect, lane, models, blurred, may_unblur: unblurrable }) => html`<t-camera
          .site=${this.site}
          .stream=${address}
          .name=${name}
          .detect=${detect}
          .lane=${lane}
          .models=${models}
          ?blurred=${blurred}
          ?unblurrable=${unblurrable}
          .online=${this.online}
          still
        ></t-camera>`,
      )}`;
  }

  private renderExposure(): TemplateResult {
    const { state, remaining, filter } = cameraSignals(this.device ?? NO_DEVICE);
    const { expose, abort } = cameraCommands(this.device ?? NO_DEVICE);
    const stops = abort.map((deed): CommandButton => ({ ...deed, kind: this.under ? "danger" : "plain" }));
    return html`<h2>${msg("Exposure")}</h2>
      <div class="readings">${map([state, filter], (signal) => this.renderReading(signal, "l"))}</div>
      ${this.renderProgress(remaining)} ${this.renderLookOnly()}
      <t-deeds .site=${this.site} .device=${this.device} .line=${this.line} .deeds=${stops} .online=${this.online}></t-deeds>
      <div class="forms">${map(expose, (command) => this.renderForm(command))}</div>`;
  }

  private renderProgress(remaining: SignalShape | undefined): unknown {
    const { fresh, value } = this.readSignal(remaining);
    if (remaining === undefined) return nothing;
    if (!fresh) return html`<t-status kind="unknown" word=${msg("How far it is, is not known")}></t-status>`;
    if (!this.under) return html`<t-status kind="ok" word=${msg("No exposure under way")}></t-status>`;
    return html`<div class="progress">
      <t-status kind="busy" .word=${msg(str`Exposing, ${formatDuration(Math.ceil(value))} left`)}></t-status>
      <progress max=${this.longest} .value=${this.longest - value} aria-label=${msg("Exposure")}></progress>
    </div>`;
  }

  private renderCooler(): unknown {
    const { temperature, cooler, power } = cameraSignals(this.device ?? NO_DEVICE);
    const { cool, cooler: deeds } = cameraCommands(this.device ?? NO_DEVICE);
    if (temperature === undefined && cooler === undefined && cool.length === 0) return nothing;
    return html`<div class="card">
      <h2>${msg("Cooler")}</h2>
      <div class="readings">${map([temperature, cooler, power], (signal) => this.renderReading(signal, "l"))}</div>
      <t-deeds .site=${this.site} .device=${this.device} .line=${this.line} .deeds=${deeds} .online=${this.online}></t-deeds>
      ${map(cool, (command) => this.renderForm(command))}
    </div>`;
  }

  private renderSettings(): unknown {
    const { filter, binning, gain } = cameraSignals(this.device ?? NO_DEVICE);
    const { settings } = cameraCommands(this.device ?? NO_DEVICE);
    if (settings.length === 0) return nothing;
    return html`<div class="card">
      <h2>${msg("For the next exposure")}</h2>
      <div class="readings">${map([filter, binning, gain], (signal) => this.renderReading(signal, "l"))}</div>
      ${map(settings, (command) => this.renderForm(command))}
    </div>`;
  }

  private renderForm(command: CommandShape): TemplateResult {
    return html`<t-command-card
      .site=${this.site}
      .device=${this.device}
      .command=${command}
      .line=${this.line}
      .online=${this.online}
    ></t-command-card>`;
  }

  private renderReading(signal: SignalShape | undefined, size: "m" | "l"): unknown {
    return signal === undefined ? nothing : html`<t-signal-value size=${size} .site=${this.site} .signal=${signal}></t-signal-value>`;
  }
}

declare global {
  interface HTMLElementTagNameMap {
    "t-part-camera": CameraPart;
  }
}
