/** Real-time: a chart for each signal of a site, grouped by device. */

import { consume } from "@lit/context";
import { msg, str } from "@lit/localize";
import { html, LitElement, nothing, type PropertyValues, type TemplateResult } from "lit";
import { customElement, property, state } from "lit/decorators.js";
import { repeat } from "lit/directives/repeat.js";
import { ActionController } from "../../controllers/action.js";
import { AnomalyDetectorsController } from "../../controllers/anomaly-detectors.js";
import { ConnectionStateController } from "../../controllers/connection-state.js";
import { LoadController } from "../../controllers/load.js";
import { ContextStoreController } from "../../controllers/context-store.js";
import { base } from "../../elements/base/base-style.js";
import { control } from "../../elements/forms/input-style.js";
import { PaintScheduler } from "../../elements/chart/paint-scheduler.js";
import type { ChoiceOption } from "../../elements/forms/choice.js";
import { AlarmMarks } from "../../series/alarm-marks.js";
import { SECOND_US } from "../../series/zone-clock.js";
import { apiContext, sitesContext } from "../../state/contexts.js";
import { sitePath } from "../../state/router.js";
import type { Anomaly, Detector } from "../../state/anomaly-detectors.js";
import { ChartFeed } from "../../tiles/chart/chart-feed.js";
import type { DeviceShape, SignalShape, SiteShape } from "../../generated/api.js";
import { AlarmsApi } from "../../wire/alarms-api.js";
import type { HubApi } from "../../wire/hub-api.js";
import { liveStyle } from "./live-style.js";
import { renderAdvice, renderLoaded } from "../../elements/feedback/load-state.js";
import "../../elements/feedback/banner.js";
import "../../elements/forms/button.js";
import "../../elements/forms/choice.js";
import "../../elements/values/clock.js";
import "../../elements/feedback/empty.js";
import "../../elements/analysis/outlier-tool.js";
import { renderSignalTile } from "../../tiles/catalog.js";
import "../../tiles/chart/chart-tile.js";
import "../../tiles/topic/topic-tiles.js";

const WINDOWS: readonly ChoiceOption[] = [
  { id: "10", label: "10 s" },
  { id: "30", label: "30 s" },
  { id: "60", label: "1 min" },
  { id: "300", label: "5 min" },
];
const FIRST_WINDOW = "30";
const LONGEST_US = 300 * SECOND_US;

interface DeviceGroup {
  readonly device: DeviceShape;
  readonly signals: readonly SignalShape[];
}

@customElement("t-page-live")
export class PageLive extends LitElement {
  static override styles = [base, control, liveStyle];

  @property() site = "";

  @consume({ context: apiContext }) private api: HubApi | undefined;

  @state() private seconds = FIRST_WINDOW;
  @state() private paused = false;
  @state() private all = false;
  @state() private outliers = 0;
  @state() private filter = "";
  @state() private refused: ReadonlySet<string> = new Set();

  private feed: ChartFeed | null = null;
  private bookOf: readonly Detector[] = [];
  private detectorsOf: ReadonlyMap<string, readonly Detector[]> = new Map();
  private anomaliesOf: ReadonlyMap<string, readonly Anomaly[]> = new Map();
  private readonly painter = new PaintScheduler();
  private readonly marks = new AlarmMarks();
  private readonly detail = new LoadController<SiteShape>(this);
  private readonly sites = new ContextStoreController(this, sitesContext);
  private readonly watching = new AnomalyDetectorsController(this);
  private readonly action = new ActionController(this);
  private readonly link = new ConnectionStateController(this, (connection) => [
    connection.onMessage("event", (news) => {
      if (news.site !== this.site) return;
      this.marks.add([news]);
      this.requestUpdate();
    }),
    connection.onMessage("subscribed", ({ refused }) => {
      if (refused.length > 0) this.refused = new Set([...this.refused, ...refused]);
    }),
  ]);

  override connectedCallback(): void {
    super.connectedCallback();
    window.addEventListener("keydown", this.onKeyDown);
    this.requestUpdate();
  }

  override disconnectedCallback(): void {
    super.disconnectedCallback();
    window.removeEventListener("keydown", this.onKeyDown);
    this.feed?.close();
    this.feed = null;
  }

  protected override willUpdate(changed: PropertyValues<this>): void {
    const sites = this.sites.store;
    const { connection } = this.link;
    if (changed.has("site")) {
      this.feed?.close();
      this.feed = null;
      this.marks.clear();
      void this.loadPastEvents();
    }
    if (sites === undefined || connection === undefined || this.api === undefined) return;
    this.detail.load(`${this.site} ${sites.catalogueOf(this.site)} ${String(sites.siteRow(this.site)?.online)}`, () => sites.loadDetail(this.site));
    const detail = this.detail.value;
    if (detail === undefined || !this.isConnected) return;
    this.feed ??= new ChartFeed(this.site, connection, this.api, this.onSiteLoaded, this.lengthUs);
    this.watching.loadDetectors(this.api, this.site, detail.catalogue);
    const signals = this.groupSignals(detail).flatMap((group) => group.signals);
    const shown = new Set(signals.map(({ address }) => address));
    const { book } = this.watching;
    this.feed.subscribeSignals(signals, book.list.filter(({ address }) => shown.has(address)).map(({ scores }) => scores));
    if (book.list !== this.bookOf) this.sortByMember(book.list);
  }

  override render(): TemplateResult {
    const detail = this.detail.value;
    return html`
      <div class="top">
        <div class="title">
          <h1>${msg("Real-time")}</h1>
          <p class="muted">${detail?.name ?? this.site}</p>
          <a href=${sitePath(this.site, "topics")}>${msg("Topics")}</a>
          ${detail === undefined ? nothing : html`<t-clock zone=${detail.zone}></t-clock>`}
        </div>
        ${detail === undefined ? nothing : this.renderTools(detail)}
      </div>
      ${this.feed?.backfill === "failed" ? html`<t-banner>${msg("Earlier samples could not be loaded; the charts fill as new ones come.")}</t-banner>` : nothing}
      ${this.renderMessage()} ${renderLoaded(this.detail, msg("the site"), (loaded) => this.renderContent(loaded))}
      <t-topic-tiles .site=${this.site} .online=${!this.isLinkLost()}></t-topic-tiles>
    `;
  }

  private renderTools(detail: SiteShape): TemplateResult {
    const secondary = detail.devices.flatMap(({ signals }) => signals).filter(({ primary }) => !primary).length;
    return html`<div class="tools" role="toolbar" aria-label=${msg("Charts")}>
      <t-choice label=${msg("Time shown")} .options=${WINDOWS} chosen=${this.seconds} @t-choose=${this.chooseWindow}></t-choice>
      <t-button
        kind=${this.paused ? "primary" : "plain"}
        pressed=${this.paused ? "true" : "false"}
        aria-keyshortcuts="Space"
        @click=${this.togglePause}
        >${this.paused ? msg("Resume") : msg("Pause")} <kbd>space</kbd></t-button
      >
      ${secondary === 0
          ? nothing
          : html`<t-button pressed=${this.all ? "true" : "false"} @click=${this.toggleAll}
              >${msg(html`Show all <span class="count">+${secondary}</span>`)}</t-button
            >`}
      <t-outlier-tool .k=${this.outliers} @t-outliers=${this.onOutliersChange}></t-outlier-tool>
      <input
        type="search"
        aria-label=${msg("Filter signals")}
        placeholder=${msg("Filter", { id: "filter.verb" })}
        .value=${this.filter}
        @input=${this.onFilterInput}
      />
    </div>`;
  }

  /** What stands between the person and fresh values, said once, above all. */
  /** What became of "not an anomaly", and whether there are scores at all. */
  private renderMessage(): TemplateResult {
    const { problem, doneText: done } = this.action;
    const failed = this.watching.state === "failed";
    return html`<p class="said" role="status">${done}</p>
      ${renderAdvice(problem)}
      ${failed
          ? html`<t-banner>${msg("The anomaly detectors could not be loaded; the charts continue without them.")} <t-button kind="quiet" @click=${this.resumeFollowing}>${msg("Try again")}</t-button></t-banner>`
          : nothing}`;
  }

  /** Lists that stay the same while nothing new is known: tiles are drawn again for others only. */
  private sortByMember(list: readonly Detector[]): void {
    this.bookOf = list;
    const addresses = new Set(list.flatMap(({ address, signals }) => [address, ...signals]));
    const { book } = this.watching;
    this.detectorsOf = new Map([...addresses].map((address) => [address, book.detectorsOf(address)]));
    this.anomaliesOf = new Map([...addresses].map((address) => [address, book.anomalies(address)]));
  }

  private renderContent(detail: SiteShape): TemplateResult {
    const groups = this.groupSignals(detail);
    if (groups.length === 0) return this.renderEmpty(detail);
    return html`${repeat(
      groups,
      ({ device }) => device.id,
      (group) => this.renderGroup(group, detail),
    )}`;
  }

  private renderGroup({ device, signals }: DeviceGroup, detail: SiteShape): TemplateResult {
    return html`<section aria-labelledby=${`device-${device.id}`}>
      <h2 id=${`device-${device.id}`}>${device.name}</h2>
      <div class="charts" @t-forgive=${this.onForgive}>
        ${repeat(
          signals,
          (signal) => signal.address,
          (signal) =>
            renderSignalTile({
              signal,
              feed: this.feed,
              painter: this.painter,
              colour: device.signals.indexOf(signal),
              cut: this.isLinkLost(),
              zone: detail.zone,
              paused: this.paused,
              outliers: this.outliers,
              marks: this.marks.marksOf(device.id),
              detectors: this.detectorsOf.get(signal.address),
              anomalies: this.anomaliesOf.get(signal.address),
              mayForgive: this.watching.book.mayForgive,
              busy: this.action.busy,
              forbidden: signal.channels.some((channel) => this.refused.has(channel)),
            }),
        )}
      </div>
    </section>`;
  }

  /** The shell says so in words; here it keeps young values from looking fresh. */
  private isLinkLost(): boolean {
    return this.link.state === "lost" || this.sites.store?.siteRow(this.site)?.online === false;
  }

  private renderEmpty(detail: SiteShape): TemplateResult {
    if (detail.devices.every(({ signals }) => signals.length === 0)) {
      return html`<t-empty heading=${msg("Nothing to show")} icon="live"
        ><p>${msg("This site has no signals that you may see. They are named in its site description.")}</p></t-empty
      >`;
    }
    return html`<t-empty heading=${msg("No signal matches")} icon="live">
      <p>${this.filter === "" ? msg("The main signals of this site are none; show all to see the rest.") : msg(str`Nothing here is called “${this.filter}”.`)}</p>
      <t-button @click=${this.clearFilter}>${msg("Show everything")}</t-button>
    </t-empty>`;
  }

  // A filter looks through all signals: who types a name wants to find it.
  private groupSignals(detail: SiteShape): DeviceGroup[] {
    const words = this.filter.toLowerCase().split(/\s+/).filter(Boolean);
    const isShown = (device: DeviceShape, signal: SignalShape): boolean => {
      if (words.length === 0) return this.all || signal.primary;
      const text = `${device.name} ${signal.name} ${signal.address} ${signal.unit}`.toLowerCase();
      return words.every((word) => text.includes(word));
    };
    return detail.devices
      .map((device) => ({ device, signals: device.signals.filter((signal) => isShown(device, signal)) }))
      .filter(({ signals }) => signals.length > 0);
  }

  private get lengthUs(): number {
    return Number(this.seconds) * SECOND_US;
  }

  private readonly onSiteLoaded = (): void => {
    this.painter.wakeUp();
    if (this.feed?.backfill === "failed") this.requestUpdate();
  };

  /** What alarms did in the longest window that can be shown. Without it the charts are as good. */
  private async loadPastEvents(): Promise<void> {
    const { site, api } = this;
    if (site === "" || api === undefined) return;
    const query = new URLSearchParams({ kind: "alarm", from_us: String(Math.round(Date.now() * 1000 - LONGEST_US)), limit: "200" });
    const found = await new AlarmsApi(api).events(site, query.toString()).catch(() => null);
    if (found === null || site !== this.site) return;
    this.marks.add(found.events);
    this.requestUpdate();
  }

  private readonly resumeFollowing = (): void => {
    this.watching.retry();
  };

  private readonly onForgive = (event: CustomEvent<Detector>): void => {
    event.stopPropagation();
    void this.forgive(event.detail);
  };

  private async forgive({ address, detector, name }: Detector): Promise<void> {
    const { api, site } = this;
    if (api === undefined) return;
    // How it stands then comes over the socket, to every page.
    await this.action.run(msg("tell the detector"), () => api.dismissAnomaly(site, address, detector), msg(str`Noted: ${address} is as usual for “${name}”.`));
  }

  private readonly chooseWindow = (event: CustomEvent<string>): void => {
    this.seconds = event.detail;
    this.feed?.setLength(this.lengthUs);
  };

  private readonly togglePause = (): void => {
    this.paused = !this.paused;
  };

  private readonly onOutliersChange = (event: CustomEvent<number>): void => {
    this.outliers = event.detail;
  };

  private readonly toggleAll = (): void => {
    this.all = !this.all;
  };

  private readonly onFilterInput = (event: Event): void => {
    if (event.target instanceof HTMLInputElement) this.filter = event.target.value.trim();
  };

  private readonly clearFilter = (): void => {
    this.filter = "";
    this.all = true;
  };

  private readonly onKeyDown = (event: KeyboardEvent): void => {
    if (event.key !== " " || event.repeat || event.defaultPrevented || event.ctrlKey || event.altKey || event.metaKey) return;
    // Space already means something on a button, a field, a choice.
    const target = event.composedPath()[0];
    if (target instanceof Element && target.matches("input, textarea, select, button, a, summary, [role=button]")) return;
    event.preventDefault();
    this.togglePause();
  };
}

declare global {
  interface HTMLElementTagNameMap {
    "t-page-live": PageLive;
  }
}
