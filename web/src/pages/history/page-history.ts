/** History: chosen channels over a chosen stretch of time, one chart for each unit. */

import { consume } from "@lit/context";
import { html, LitElement, nothing, type PropertyValues, type TemplateResult } from "lit";
import { customElement, property, query, state } from "lit/decorators.js";
import { repeat } from "lit/directives/repeat.js";
import { LiveValuesController } from "../../controllers/live-values.js";
import { LoadController } from "../../controllers/load.js";
import { StoreController } from "../../controllers/store.js";
import { base } from "../../elements/base.js";
import { indentOf, type SpanChange } from "../../elements/chart/model.js";
import { Painter } from "../../elements/chart/painter.js";
import { adviceFor } from "../../format/problem.js";
import { utcSpan } from "../../format/time.js";
import { lengthOf, notAfter, type Span } from "../../series/window.js";
import { HOUR_US, SECOND_US } from "../../series/zone.js";
import { apiContext, routerContext, sitesContext } from "../../state/contexts.js";
import { sitePath } from "../../state/router.js";
import type { EventList, SiteDetail } from "../../wire/api.js";
import type { HubApi } from "../../wire/http.js";
import { EventsLoader } from "./events-loader.js";
import { HistoryLoader } from "./loader.js";
import { marksOf, type Mark, type MarkKind } from "./marks.js";
import { readView, spanOf, writeView, type HistoryView } from "./query.js";
import { axesFor } from "./axes-for.js";
import { firstChoice, rowsOf, together, unitsOf, type Row, type Together } from "./rows.js";
import { historyStyle } from "./style.js";
import "../../elements/button.js";
import "../../elements/empty.js";
import "../../elements/loading.js";
import "../../elements/problem.js";
import "./history-chart.js";
import "./history-tools.js";
import "./marks-lane.js";
import "./signal-picker.js";
import "./view-options.js";

/** A window that follows is asked for again this often (ms), or each time it has moved two pixels. */
const FOLLOW_LEAST_MS = 1000;
const FOLLOW_PIXELS = 2;
/** Windows may end a little in the future, so that "now" is not stuck to the edge. */
const AHEAD = 0.05;
const COPIED_MS = 2000;

@customElement("t-page-history")
export class PageHistory extends LitElement {
  static override styles = [base, historyStyle];

  @property() site = "";

  @consume({ context: apiContext, subscribe: true }) @state() private api: HubApi | undefined;

  @state() private cursorUs: number | null = null;
  @state() private nowUs = Date.now() * 1000;
  @state() private width = 0;
  @state() private copied = false;
  /** The window while fingers or the wheel are at it; the address bar follows when they rest. */
  @state() private moving: Span | null = null;

  @query(".charts") private readonly charts!: HTMLElement | null;

  private rows: readonly Row[] = [];
  private groups: readonly Together[] = [];
  private groupsKey = "";
  private axisWidth = 0;
  private indent = indentOf(1, 0);
  private loader: HistoryLoader | null = null;
  private events: EventsLoader | null = null;
  private marks: readonly Mark[] = [];
  private markedOf: EventList | null = null;
  private timer: ReturnType<typeof setTimeout> | undefined;
  private resized: ResizeObserver | null = null;
  private readonly painter = new Painter();
  private readonly detail = new LoadController<SiteDetail>(this);
  private readonly sites = new StoreController(this, sitesContext);
  private readonly router = new StoreController(this, routerContext, () => {
    this.moving = null;
  });
  private readonly live = new LiveValuesController(this);

  override connectedCallback(): void {
    super.connectedCallback();
    this.resized = new ResizeObserver(([entry]) => {
      const width = Math.round(entry?.contentRect.width ?? 0);
      // A scroll bar that comes or goes is no reason to ask again.
      if (Math.abs(width - this.width) > 24) this.width = width;
    });
    this.resized.observe(this);
    this.follow();
  }

  override disconnectedCallback(): void {
    super.disconnectedCallback();
    clearTimeout(this.timer);
    this.resized?.disconnect();
    this.loader?.close();
    this.events?.close();
    this.loader = null;
    this.events = null;
  }

  protected override willUpdate(changed: PropertyValues<this>): void {
    const sites = this.sites.store;
    if (changed.has("site")) {
      this.loader?.close();
      this.events?.close();
    }
    if (sites === undefined || this.api === undefined || !this.isConnected) return;
    this.detail.ask(this.site, () => sites.detail(this.site));
    const detail = this.detail.value;
    if (detail === undefined) return;
    this.rows = rowsOf(detail);
    this.loader ??= new HistoryLoader(this.api, () => {
      this.requestUpdate();
    });
    this.events ??= new EventsLoader(this.api, () => {
      this.requestUpdate();
    });
    this.group();
    this.ask();
    this.mark(detail);
    this.live.observe(this.site, this.silent());
  }

  protected override updated(): void {
    const width = this.charts?.clientWidth ?? 0;
    if (this.width === 0 && width > 0) this.width = width;
  }

  override render(): TemplateResult {
    const detail = this.detail.value;
    return html`
      <div class="title">
        <h1>History</h1>
        <p class="muted">${detail?.name ?? this.site}</p>
        ${detail === undefined ? nothing : html`<p class="utc">${utcSpan(this.span(), detail.zone, this.nowUs)}</p>`}
        <t-button class="share" @click=${this.share}>${this.copied ? "Link copied" : "Copy link"}</t-button>
      </div>
      ${this.trouble()} ${detail === undefined ? this.waiting() : this.content(detail)}
    `;
  }

  private content(detail: SiteDetail): TemplateResult {
    const chosen = this.chosen();
    const { shown } = this.view();
    return html`
      <t-history-tools .shown=${shown} .span=${this.span()} zone=${detail.zone} @t-shown=${this.showAnother}></t-history-tools>
      <div class="body">
        <details class="pick" ?open=${this.wide()}>
          <summary>Signals <span class="count">${chosen.length}</span></summary>
          <t-signal-picker .rows=${this.rows} .chosen=${chosen} @t-pick=${this.pick}></t-signal-picker>
        </details>
        <div class="charts" aria-busy=${this.loader?.state === "loading" ? "true" : "false"}>
          <t-view-options .view=${this.view()} @t-view=${this.viewChanged}></t-view-options>
          ${this.chartTrouble()} ${chosen.length === 0 ? this.nothingChosen() : this.chartList(detail)}
        </div>
      </div>
    `;
  }

  private chartList(detail: SiteDetail): TemplateResult {
    const loader = this.loader;
    const newest = new Map(this.silent().map((address) => [address, this.live.reading(address)?.timeUs ?? 0]));
    const { without } = this.view();
    const marks = without.length === 0 ? this.marks : this.marks.filter(({ kind }) => !without.includes(kind));
    return html`<div class="progress" ?hidden=${loader?.state !== "loading"}></div>
      <t-marks-lane
        .marks=${this.marks}
        .without=${without}
        .span=${this.span()}
        .indent=${this.indent}
        .more=${this.events?.list.more === true}
        .failed=${this.events?.failed === true}
        zone=${detail.zone}
        @t-hide=${this.hide}
        @t-cursor=${this.cursorMoved}
      ></t-marks-lane>
      ${repeat(
        this.groups,
        ({ key }) => key,
        (group) =>
          html`<t-history-chart
            .group=${group}
            .data=${loader?.data ?? new Map<string, never>()}
            .span=${this.span()}
            .cursorUs=${this.cursorUs}
            .painter=${this.painter}
            .newest=${newest}
            .marks=${marks}
            .indent=${this.indent}
            axis-width=${this.axisWidth}
            ?joined=${this.view().joined}
            .loaded=${loader?.state === "ready"}
            zone=${detail.zone}
            @t-span=${this.spanChanged}
            @t-cursor=${this.cursorMoved}
            @t-reset=${this.back}
          ></t-history-chart>`,
      )}
      <p class="hint">
        Drag to zoom in, double-click to go back. Click a chart, then turn the wheel. Keys: ← → cursor, + − zoom, Page up and
        down to move.
      </p>`;
  }

  private trouble(): unknown {
    const detail = this.detail.result;
    if (detail.state !== "failed") return nothing;
    const advice = adviceFor(detail.error, "this site");
    return html`<t-problem what=${advice.what} how=${advice.how} retry="Try again" @t-retry=${this.siteAgain}></t-problem>`;
  }

  private chartTrouble(): unknown {
    if (this.loader?.state !== "failed") return nothing;
    const advice = adviceFor(this.loader.error, "the history of these signals");
    return html`<t-problem what=${advice.what} how=${advice.how} retry="Try again" @t-retry=${this.again}></t-problem>`;
  }

  private waiting(): unknown {
    return this.detail.result.state === "failed" ? nothing : html`<t-loading what="Loading the site"></t-loading>`;
  }

  private nothingChosen(): TemplateResult {
    return this.rows.length === 0
      ? html`<t-empty heading="Nothing to show" icon="history"><p>This site has no signals that you may see.</p></t-empty>`
      : html`<t-empty heading="Choose a signal" icon="history"
          ><p>Tick what you want to see under “Signals”. Signals of one unit share a chart.</p></t-empty
        >`;
  }

  // ── what is shown ───────────────────────────────────────────────────────────────────────

  private view(): HistoryView {
    return readView(this.router.store?.search ?? "");
  }

  private span(): Span {
    return this.moving ?? spanOf(this.view().shown, this.nowUs);
  }

  private chosen(): string[] {
    const { channels } = this.view();
    if (channels === null) return firstChoice(this.rows);
    const known = new Set(this.rows.map(({ address }) => address));
    return channels.filter((address) => known.has(address));
  }

  private group(): void {
    const chosen = this.chosen();
    const { most, axisWidth } = axesFor(this.view().joined, this.width);
    const key = `${this.detail.value?.catalogue ?? ""} ${String(most)}\n${chosen.join("\n")}`;
    if (key === this.groupsKey) return;
    this.groupsKey = key;
    this.groups = together(this.rows.filter(({ address }) => chosen.includes(address)), most);
    this.axisWidth = axisWidth;
    this.indent = indentOf(Math.max(1, ...this.groups.map(({ rows }) => unitsOf(rows).length)), axisWidth);
  }

  private ask(): void {
    if (this.width === 0 || this.loader === null) return;
    const channels = this.groups.flatMap(({ rows }) => rows).map(({ address, maxAge }) => ({ address, maxAge }));
    const question = { site: this.site, channels, span: this.span(), width: this.width };
    this.loader.ask(question, this.moving !== null);
  }

  private mark(detail: SiteDetail): void {
    if (this.events === null) return;
    this.events.ask(this.site, this.span());
    const { list } = this.events;
    if (list === this.markedOf) return;
    this.markedOf = list;
    this.marks = marksOf(list.events, new Map(detail.devices.map(({ id, name }) => [id, name])));
  }

  /** Chosen channels of which nothing has come for this window. */
  private silent(): string[] {
    const { loader } = this;
    if (loader?.state !== "ready") return [];
    return this.chosen().filter((address) => loader.data.get(address)?.count === 0);
  }

  private wide(): boolean {
    return matchMedia("(min-width: 60.01rem)").matches;
  }

  private show(view: Partial<HistoryView>): void {
    const next: HistoryView = { ...this.view(), ...view };
    this.nowUs = Date.now() * 1000;
    this.router.store?.go(sitePath(this.site, "history") + writeView(next));
    this.follow();
  }

  /** Moves the window on, as often as it is worth it. */
  private follow(): void {
    clearTimeout(this.timer);
    const { shown } = this.view();
    const pixelMs = "last" in shown ? (shown.last * 1000) / Math.max(300, this.width) : Infinity;
    const everyMs = Math.min(HOUR_US / 1000, Math.max(FOLLOW_LEAST_MS, pixelMs * FOLLOW_PIXELS));
    this.timer = setTimeout(() => {
      if (document.visibilityState === "visible" && "last" in this.view().shown && this.moving === null) this.nowUs = Date.now() * 1000;
      this.follow();
    }, everyMs);
  }

  private readonly showAnother = (event: CustomEvent<HistoryView["shown"]>): void => {
    this.show({ shown: event.detail });
  };

  private readonly hide = (event: CustomEvent<readonly MarkKind[]>): void => {
    this.show({ without: event.detail });
  };

  private readonly viewChanged = (event: CustomEvent<Partial<HistoryView>>): void => {
    this.show(event.detail);
  };

  private readonly share = (): void => {
    void navigator.clipboard.writeText(location.href).then(() => {
      this.copied = true;
      setTimeout(() => {
        this.copied = false;
      }, COPIED_MS);
    });
  };

  private readonly pick = (event: CustomEvent<readonly string[]>): void => {
    this.show({ channels: event.detail });
  };

  private readonly spanChanged = (event: CustomEvent<SpanChange>): void => {
    const { span, settled } = event.detail;
    const latest = Date.now() * 1000 + Math.max(lengthOf(span) * AHEAD, SECOND_US);
    const next = notAfter(span, latest);
    this.moving = next;
    if (settled) this.show({ shown: { fromUs: Math.round(next.fromUs), toUs: Math.round(next.toUs) } });
  };

  private readonly cursorMoved = (event: CustomEvent<number | null>): void => {
    this.cursorUs = event.detail;
  };

  private readonly back = (): void => {
    history.back();
  };

  private readonly again = (): void => {
    this.loader?.forget();
    this.requestUpdate();
  };

  private readonly siteAgain = (): void => {
    this.detail.again();
  };
}

declare global {
  interface HTMLElementTagNameMap {
    "t-page-history": PageHistory;
  }
}
