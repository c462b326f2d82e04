/** A vehicle's speed, heading and battery over its picture, from its live values and the driver's seat. */

import { msg } from "@lit/localize";
import { html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, property } from "lit/decorators.js";
import { ContextStoreController } from "../../controllers/context-store.js";
import { capWords } from "../../controllers/drive/drive-messages.js";
import type { DriveSession } from "../../controllers/drive/drive-session.js";
import { LiveValuesController } from "../../controllers/live-values.js";
import { StoreController } from "../../controllers/store-controller.js";
import { TickerController } from "../../controllers/ticker.js";
import { NO_NUMBER, type HudNumber } from "../../elements/drive/drive-hud.js";
import { lockText } from "../../format/interlock-reason.js";
import { shownUnit, toShown } from "../../format/unit.js";
import type { DeviceShape, SignalShape, SiteShape } from "../../generated/api.js";
import { interlocksContext } from "../../state/contexts.js";
import { vehicleHeading, vehicleSignals } from "./vehicle-signals.js";

const DRAW_EVERY_MS = 200;

@customElement("t-vehicle-hud")
export class VehicleHud extends LitElement {
  @property() site = "";
  @property({ attribute: false }) detail: SiteShape | null = null;
  @property({ attribute: false }) device: DeviceShape | null = null;
  @property({ attribute: false }) seat: DriveSession | null = null;
  @property({ type: Boolean }) stopped = false;
  /** Age of the picture (ms); negative: none. */
  @property({ attribute: false }) pictureAge: () => number = () => -1;
  @property({ type: Boolean }) online = false;

  private readonly interlocks = new ContextStoreController(this, interlocksContext);
  private readonly live = new LiveValuesController(this);
  private readonly watched = new StoreController(this);

  constructor() {
    super();
    new TickerController(this, DRAW_EVERY_MS);
  }

  override willUpdate(): void {
    this.watched.setStore(this.seat);
    const { detail, device } = this;
    if (detail === null || device === null) return;
    const { speed, position, battery } = vehicleSignals(detail, device);
    this.live.observeChannels(this.site, [speed, position, battery].flatMap((signal) => signal?.channels ?? []));
  }

  override render(): TemplateResult | typeof nothing {
    const { detail, device } = this;
    if (detail === null || device === null) return nothing;
    const { speed, position, battery } = vehicleSignals(detail, device);
    const yaw = position?.frame === "wgs84" ? undefined : position?.channels[2];
    const heading = vehicleHeading(detail, this.freshValue(position, yaw));
    return html`<t-drive-hud
      .speed=${this.shownNumber(speed)}
      .limit=${this.limitNow(device)}
      .heading=${heading.degrees}
      ?local=${heading.local}
      ?steers=${yaw !== undefined}
      .battery=${battery === undefined ? null : this.shownNumber(battery)}
      .note=${this.obstacle(device)}
    ></t-drive-hud>`;
  }

  /** What is old is no number to drive by. */
  private freshValue(signal: SignalShape | undefined, channel = signal?.channels[0]): number {
    if (!this.online || signal === undefined || channel === undefined || this.live.freshnessOf(channel, signal.max_age) !== "live") return Number.NaN;
    return this.live.readingOf(channel)?.value ?? Number.NaN;
  }

  private shownNumber(signal: SignalShape | undefined): HudNumber {
    if (signal === undefined) return NO_NUMBER;
    const { unit, decimals } = shownUnit(signal);
    return { unit, decimals, value: toShown(signal.shown, this.freshValue(signal)) };
  }

  /** What a full push gives now: the driver's own choice, and what the gateway makes of it. */
  private limitNow({ drive }: DeviceShape): HudNumber {
    const { seat } = this;
    if (drive === null || seat?.lease.state.kind !== "mine") return NO_NUMBER;
    const { unit, decimals } = shownUnit({ unit: "m/s", decimals: 2, shown: drive.shown_speed });
    const most = drive.max_speed * seat.machine.speedLevel * (seat.told?.cap ?? 1);
    return { unit, decimals, value: toShown(drive.shown_speed, most) };
  }

  private obstacle({ id }: DeviceShape): string {
    if (this.stopped) return msg("STOP is on");
    const lock = this.interlocks.store?.lockOf(this.site, id, "drive") ?? null;
    if (lock !== null) return lockText(lock);
    const { seat } = this;
    if (!seat?.told || seat.lease.state.kind !== "mine") return "";
    return capWords(seat.told.cap, seat.told.loop_ms, this.pictureAge(), this.interlocks.store?.slowOf(this.site, id)?.name);
  }
}

declare global {
  interface HTMLElementTagNameMap {
    "t-vehicle-hud": VehicleHud;
  }
}
