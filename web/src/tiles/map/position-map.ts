/** The position of a device on the map: live values, and the trail from the history. */

import { ContextConsumer } from "@lit/context";
import { css, html, LitElement, type TemplateResult } from "lit";
import { customElement, property, state } from "lit/decorators.js";
import { ConnectionStateController } from "../../controllers/connection-state.js";
import type { Pose } from "../../elements/map/map-painter.js";
import "../../elements/map/track-map.js";
import { mergeTracks, courseOf, extendTrack, flatPosition, joinTrack, type MapPlace, type TrackPoint } from "../../elements/map/track.js";
import { formatAge } from "../../format/duration.js";
import { formatNumber } from "../../format/number.js";
import { ContextStoreController } from "../../controllers/context-store.js";
import { apiContext, pastContext } from "../../state/contexts.js";
import type { SeriesShape, SignalShape } from "../../generated/api.js";
import type { HubApi } from "../../wire/hub-api.js";
import type { Batch } from "../../wire/subscriptions.js";

const EVERY_MS = 50;
/** The trail reaches back so far. */
const TRAIL_MIN = 10;
const TRAIL_US = TRAIL_MIN * 60e6;
/** Two points a pixel come at the most: enough for ten samples a second. */
const HISTORY_WIDTH = 3000;

interface PositionSample {
  readonly numbers: readonly number[];
  readonly timeUs: number;
}

@customElement("t-map")
export class PositionMap extends LitElement {
  static override styles = css`
    :host {
      display: grid;
    }
  `;

  @property() site = "";
  @property({ attribute: false }) signal: SignalShape | null = null;
  @property({ type: Boolean }) online = true;

  @state() private trail: readonly TrackPoint[] = [];
  @state() private pose: Pose | null = null;
  @state() private sample: PositionSample | null = null;
  @state() private stale = "";
  private freshAt = 0;
  private origin: MapPlace | null = null;
  private opened = "";
  private cancel: (() => void) | null = null;
  private api: HubApi | undefined;
  private timer: ReturnType<typeof setInterval> | undefined;
  private readonly latest = new Map<string, number>();
  private readonly link = new ConnectionStateController(this);
  /** Undefined where all is of now. */
  private readonly past = new ContextStoreController(this, pastContext);

  constructor() {
    super();
    new ContextConsumer(this, {
      context: apiContext,
      callback: (api) => {
        this.api = api;
        this.requestUpdate();
      },
    });
  }

  override connectedCallback(): void {
    super.connectedCallback();
    this.timer = setInterval(this.updateAge, 500);
  }

  override disconnectedCallback(): void {
    super.disconnectedCallback();
    clearInterval(this.timer);
    this.closeFeed();
  }

  override willUpdate(): void {
    const { connection } = this.link;
    const past = this.past.store;
    // While somebody moves the moment about there is no place of it; then the trail is of what was before it.
    const moment = past === undefined ? "" : past.isSettled ? String(past.jumps) : null;
    const wanted = this.signal && connection && this.api && moment !== null ? `${this.site} ${this.signal.address} ${moment}` : "";
    if (wanted === this.opened) return;
    this.closeFeed();
    this.opened = wanted;
    if (wanted === "" || !connection || !this.signal) return;
    const receive = (batch: Batch): void => {
      this.receiveBatch(batch);
    };
    this.cancel = past === undefined ? connection.subscribe(this.site, this.signal.channels, EVERY_MS, receive) : past.replayChannels(this.site, this.signal.channels, receive);
    void this.loadTrail(this.signal);
  }

  override render(): TemplateResult {
    const note = this.signal
      ? this.online
        ? (this.past.store === undefined ? "Waiting for the first position" : "No position was recorded at this moment")
        : "The site is offline: no position"
      : "The description names no position for this device";
    return html`<t-track-map
      .pose=${this.pose}
      .trail=${this.trail}
      .note=${note}
      .stale=${this.stale}
      .where=${this.positionText()}
    ></t-track-map>`;
  }

  /** A clock (ms): this page's own, or that of the moment that is shown. */
  private nowMs(): number {
    const past = this.past.store;
    return past === undefined ? performance.now() : past.us / 1000;
  }

  private get degrees(): boolean {
    return this.signal?.frame === "wgs84";
  }

  private positionText(): string {
    if (!this.sample) return "";
    const [first = Number.NaN, second = Number.NaN, third = Number.NaN] = this.sample.numbers;
    if (this.degrees) return `${formatNumber(first, 6)}°, ${formatNumber(second, 6)}° (WGS 84)`;
    const heading = Number.isFinite(third) ? `, heading ${formatNumber((third * 180) / Math.PI, 0)}°` : "";
    return `x ${formatNumber(first, 2)} m, y ${formatNumber(second, 2)} m${heading}`;
  }

  private receiveBatch(batch: Batch): void {
    const { channel, timeUs, value, ageMs } = batch.columns;
    const channels = this.signal?.channels ?? [];
    let newest = 0;
    let age = 0;
    for (let i = 0; i < channel.length; i++) {
      const address = batch.channels[channel[i] ?? -1];
      if (address !== undefined) this.latest.set(address, value[i] ?? Number.NaN);
      if ((timeUs[i] ?? 0) >= newest) {
        newest = timeUs[i] ?? 0;
        age = ageMs[i] ?? 0;
      }
    }
    const numbers = channels.map((address) => this.latest.get(address) ?? Number.NaN);
    const place = this.placeOf(numbers[0] ?? Number.NaN, numbers[1] ?? Number.NaN);
    if (newest === 0 || !place) return;
    this.freshAt = this.nowMs() - age;
    this.sample = { numbers, timeUs: newest };
    this.trail = extendTrack(this.trail, { ...place, timeUs: newest }, TRAIL_US);
    const yaw = this.degrees ? courseOf(this.trail) : (numbers[2] ?? Number.NaN);
    this.pose = { ...place, yaw };
    this.updateAge();
  }

  private placeOf(first: number, second: number): { x: number; y: number } | null {
    if (!Number.isFinite(first) || !Number.isFinite(second)) return null;
    if (!this.degrees) return { x: first, y: second };
    this.origin ??= { lat: first, lon: second };
    return flatPosition({ lat: first, lon: second }, this.origin);
  }

  private async loadTrail(signal: SignalShape): Promise<void> {
    const [first, second] = signal.channels;
    if (!this.api || first === undefined || second === undefined) return;
    const toUs = this.past.store?.us ?? Date.now() * 1000;
    const query = { channels: [first, second], fromUs: toUs - TRAIL_US, toUs, width: HISTORY_WIDTH };
    const opened = this.opened;
    try {
      const { series } = await this.api.history(this.site, query);
      if (opened === this.opened) this.trail = mergeTracks(this.pointsOf(series, first, second), this.trail);
    } catch {
      // The trail then starts now; the map itself does not depend on the past.
    }
  }

  private pointsOf(series: readonly SeriesShape[], first: string, second: string): TrackPoint[] {
    const x = series.find((series) => series.address === first);
    const y = series.find((series) => series.address === second);
    if (!x || !y) return [];
    return joinTrack(x, y).flatMap((point) => {
      const place = this.placeOf(point.x, point.y);
      return place ? [{ ...place, timeUs: point.timeUs }] : [];
    });
  }

  private readonly updateAge = (): void => {
    if (!this.sample || !this.signal) return;
    const seconds = (this.nowMs() - this.freshAt) / 1000;
    this.stale = seconds > this.signal.max_age ? `Stale: from ${formatAge(seconds)}` : "";
  };

  private closeFeed(): void {
    this.cancel?.();
    this.cancel = null;
    this.opened = "";
    this.latest.clear();
    this.trail = [];
    this.pose = null;
    this.sample = null;
    this.origin = null;
  }
}

declare global {
  interface HTMLElementTagNameMap {
    "t-map": PositionMap;
  }
}
