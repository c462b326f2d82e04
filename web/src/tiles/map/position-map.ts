/**
 * The position of a device on the map: live values, and the trail from the history. On Earth where the position is of
 * Earth or the site says where its frame lies; else on a plain grid in metres.
 */

import { ContextConsumer } from "@lit/context";
import { msg, str } from "@lit/localize";
import { css, html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, property, state } from "lit/decorators.js";
import { ConnectionStateController } from "../../controllers/connection-state.js";
import type { MapRobot } from "../../elements/map/geo-painter.js";
import { flatPosition, headingOfYaw, placeOfFlat, placeOfLocal, type MapFrame, type MapPlace } from "../../elements/map/geodesy.js";
import type { Pose } from "../../elements/map/map-painter.js";
import "../../elements/map/track-map.js";
import { mergeTracks, courseOf, extendTrack, joinTrack, type TrackPoint } from "../../elements/map/track.js";
import { formatAge } from "../../format/duration.js";
import { formatNumber } from "../../format/number.js";
import { alarmsContext, apiContext, interlocksContext, pastContext, sitesContext } from "../../state/contexts.js";
import { ContextStoreController } from "../../controllers/context-store.js";
import { LiveValuesController } from "../../controllers/live-values.js";
import { LoadController } from "../../controllers/load.js";
import type { SeriesShape, SignalShape, SiteShape } from "../../generated/api.js";
import type { HubApi } from "../../wire/hub-api.js";
import type { Batch } from "../../wire/subscriptions.js";
import { drawnZones, frameOf, SiteOverlays } from "./site-overlays.js";
import { scaleOf, sharesAt, trailOnEarth, type SignalSample } from "./trail-shares.js";
import "../../elements/map/geo-map.js";

const EVERY_MS = 50;
/** The trail reaches back so far. */
const TRAIL_MIN = 10;
const TRAIL_US = TRAIL_MIN * 60e6;
/** Two points a pixel come at the most: enough for ten samples a second. */
const HISTORY_WIDTH = 3000;
/** Samples of what colours the trail. */
const MOST_TINTS = 12_000;

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
  /** Colours the trail; null for one colour. */
  @property({ attribute: false }) colour: SignalShape | null = null;
  @property() name = "";

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
  private tints: readonly SignalSample[] = [];
  private readonly sites = new ContextStoreController(this, sitesContext);
  private readonly alarms = new ContextStoreController(this, alarmsContext);
  private readonly interlocks = new ContextStoreController(this, interlocksContext);
  private readonly detail = new LoadController<SiteShape>(this);
  private readonly twin = new LiveValuesController(this);
  private readonly overlays = new SiteOverlays(this);
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
    const sites = this.sites.store;
    if (sites !== undefined && this.site !== "") this.detail.load(`${this.site} ${sites.catalogueOf(this.site)}`, () => sites.loadDetail(this.site));
    this.twin.observeChannels(this.site, this.twinSignal()?.channels ?? []);
    this.overlays.show(this.site, this.detail.value?.map ?? null);
    const past = this.past.store;
    // While somebody moves the moment about there is no place of it; then the trail is of what was before it.
    const moment = past === undefined ? "" : past.isSettled ? String(past.jumps) : null;
    const wanted = this.signal && connection && this.api && moment !== null ? `${this.site} ${this.signal.address} ${this.colour?.address ?? ""} ${moment}` : "";
    if (wanted === this.opened) return;
    this.closeFeed();
    this.opened = wanted;
    if (wanted === "" || !connection || !this.signal) return;
    const receive = (batch: Batch): void => {
      this.receiveBatch(batch);
    };
    const channels = [...this.signal.channels, ...this.tintChannels()];
    this.cancel = past === undefined ? connection.subscribe(this.site, channels, EVERY_MS, receive) : past.replayChannels(this.site, channels, receive);
    void this.loadTrail(this.signal);
  }

  override render(): TemplateResult | typeof nothing {
    const note = this.signal
      ? this.online
        ? (this.past.store === undefined ? msg("Waiting for the first position") : msg("No position was recorded at this moment"))
        : msg("The site is offline: no position")
      : msg("The description names no position for this device");
    // Which of the two maps it is waits for the site's description: neither flashes up for the other.
    if (!this.degrees && sitesLoading(this.detail.result.state)) return nothing;
    if (this.degrees || frameOf(this.detail.value?.map ?? null) !== null) return this.renderEarth(note);
    return html`<t-track-map
      .pose=${this.pose}
      .ghost=${this.ghostPose()}
      .trail=${this.trail}
      .note=${note}
      .stale=${this.stale}
      .where=${this.positionText()}
    ></t-track-map>`;
  }

  private renderEarth(note: string): TemplateResult {
    const frame = this.earthFrame();
    const map = this.detail.value?.map ?? null;
    const scale = scaleOf(this.tints, this.colour?.minimum ?? null, this.colour?.maximum ?? null);
    const shares = sharesAt(this.trail.map(({ timeUs }) => timeUs), this.tints, scale);
    const legend = this.colour === null || scale === null ? null : { name: this.colour.name, least: formatNumber(scale.least, 1), most: `${formatNumber(scale.most, 1)} ${this.colour.unit}` };
    const place = this.detail.value?.place ?? null;
    // The alarms and interlocks of now say nothing of a moment that is past.
    const [alarms, interlocks] = this.past.store === undefined ? [this.alarms.store, this.interlocks.store] : [undefined, undefined];
    return html`<t-geo-map
      .robots=${this.robotsOnEarth(frame)}
      .trails=${frame === null ? [] : [trailOnEarth(this.trail, frame, shares)]}
      .zones=${drawnZones(this.site, map?.zones ?? [], alarms, interlocks)}
      .pictures=${this.overlays.pictures}
      .legend=${legend}
      .home=${frameOf(map) ?? (place === null ? null : { lat: place.latitude, lon: place.longitude })}
      .note=${note}
      .stale=${[this.stale, this.overlays.trouble].filter(Boolean).join(" · ")}
      .where=${this.positionText()}
    ></t-geo-map>`;
  }

  /** Of metres the site's own frame; of degrees the plane at the first fix. */
  private earthFrame(): MapFrame | MapPlace | null {
    return this.degrees ? this.origin : frameOf(this.detail.value?.map ?? null);
  }

  private robotsOnEarth(frame: MapFrame | MapPlace | null): readonly MapRobot[] {
    const { pose } = this;
    if (pose === null || frame === null) return [];
    const turned = "heading" in frame;
    // On the plane at a fix x is east.
    const heading = headingOfYaw(pose.yaw, turned ? frame.heading : 90);
    const place = turned ? placeOfLocal(pose, frame) : placeOfFlat(pose, frame);
    const robot: MapRobot = { id: this.signal?.address ?? "", name: this.name, place, heading, stale: this.stale !== "", trouble: "" };
    const ghost = turned ? this.ghostPose() : null;
    if (ghost === null || !turned) return [robot];
    // Drawn as what is old is: it is not the robot.
    return [{ ...robot, id: msg(str`${robot.id} twin`), name: "", place: placeOfLocal(ghost, frame), heading: headingOfYaw(ghost.yaw, frame.heading), stale: true }, robot];
  }

  /** Where the digital twin of this position's device says it is. */
  private twinSignal(): SignalShape | null {
    const device = this.signal?.address.split("/")[0] ?? "";
    const twin = this.degrees || device === "" ? undefined : this.detail.value?.devices.find(({ twin_of: of }) => of === device);
    return twin?.signals.find(({ id }) => id === "pose") ?? null;
  }

  /** Null for one that is not heard now: an old ghost would look like a difference. */
  private ghostPose(): Pose | null {
    const signal = this.twinSignal();
    const [x, y, yaw] = signal?.channels ?? [];
    if (signal === null || x === undefined || y === undefined || this.twin.freshnessOf(x, signal.max_age) !== "live") return null;
    const number = (channel: string | undefined): number => (channel === undefined ? Number.NaN : (this.twin.readingOf(channel)?.value ?? Number.NaN));
    const pose = { x: number(x), y: number(y), yaw: number(yaw) };
    return Number.isFinite(pose.x + pose.y) ? pose : null;
  }

  private tintChannels(): readonly string[] {
    const channel = this.colour?.channels[0];
    return channel === undefined || this.signal?.channels.includes(channel) === true ? [] : [channel];
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
    const heading = Number.isFinite(third) ? msg(str`, heading ${formatNumber((third * 180) / Math.PI, 0)}°`) : "";
    return msg(str`x ${formatNumber(first, 2)} m, y ${formatNumber(second, 2)} m${heading}`);
  }

  private receiveBatch(batch: Batch): void {
    const { channel, timeUs, value, ageMs } = batch.columns;
    const channels = this.signal?.channels ?? [];
    const tint = this.colour?.channels[0];
    const tints: SignalSample[] = [];
    let newest = 0;
    let age = 0;
    for (let i = 0; i < channel.length; i++) {
      const address = batch.channels[channel[i] ?? -1];
      if (address !== undefined && address === tint) tints.push({ timeUs: timeUs[i] ?? 0, value: value[i] ?? Number.NaN });
      if (address === undefined || !channels.includes(address)) continue;
      this.latest.set(address, value[i] ?? Number.NaN);
      if ((timeUs[i] ?? 0) >= newest) {
        newest = timeUs[i] ?? 0;
        age = ageMs[i] ?? 0;
      }
    }
    if (tints.length > 0) this.tints = keptTints([...this.tints, ...tints]);
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
    const tint = this.colour?.channels[0];
    const query = { channels: [first, second, ...(tint === undefined ? [] : this.tintChannels())], fromUs: toUs - TRAIL_US, toUs, width: HISTORY_WIDTH };
    const opened = this.opened;
    try {
      const { series } = await this.api.history(this.site, query);
      if (opened !== this.opened) return;
      this.trail = mergeTracks(this.pointsOf(series, first, second), this.trail);
      const tinted = series.find(({ address }) => address === tint);
      const heard = this.tints[0]?.timeUs ?? Number.POSITIVE_INFINITY;
      const before = (tinted?.t_us ?? []).flatMap((timeUs, i): SignalSample[] => {
        const value = tinted?.v[i];
        return typeof value === "number" && timeUs < heard ? [{ timeUs, value }] : [];
      });
      this.tints = keptTints([...before, ...this.tints]);
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
    this.stale = seconds > this.signal.max_age ? msg(str`Stale: from ${formatAge(seconds)}`) : "";
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
    this.tints = [];
  }
}

const sitesLoading = (state: LoadController<SiteShape>["result"]["state"]): boolean => state === "loading";

/** Those of the time that the trail reaches back. */
function keptTints(tints: readonly SignalSample[]): readonly SignalSample[] {
  const from = (tints.at(-1)?.timeUs ?? 0) - TRAIL_US;
  return tints.filter(({ timeUs }) => timeUs >= from).slice(-MOST_TINTS);
}

declare global {
  interface HTMLElementTagNameMap {
    "t-map": PositionMap;
  }
}
