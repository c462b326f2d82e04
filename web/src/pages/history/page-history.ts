/**
 * History: chosen channels over a chosen stretch of time, one chart for each unit. Longer than most
 * files: it is where the window, what is loaded for it, and all that shows it come together.
 */

import { consume } from "@lit/context";
import { msg, str } from "@lit/localize";
import { html, LitElement, nothing, type PropertyValues, type TemplateResult } from "lit";
import { customElement, property, query, state } from "lit/decorators.js";
import { repeat } from "lit/directives/repeat.js";
import { LiveValuesController } from "../../controllers/live-values.js";
import { LoadController } from "../../controllers/load.js";
import { ContextStoreController } from "../../controllers/context-store.js";
import { base } from "../../elements/base/base-style.js";
import { indentOf, type SpanChange } from "../../elements/chart/chart-model.js";
import { PaintScheduler } from "../../elements/chart/paint-scheduler.js";
import { momentText } from "../../elements/chart/cursor-values.js";
import { adviceFor } from "../../format/error-advice.js";
import { formatDate, knownZone, localSpan, timeText, utcSpan } from "../../format/time.js";
import { DrawRate } from "../../series/draw-rate.js";
import { lengthOf, panned } from "../../series/time-window.js";
import { DAY_US, clockOf, type ZoneClock } from "../../series/zone-clock.js";
import { signalLabels } from "../../state/signal-labels.js";
import { apiContext, routerContext, sitesContext } from "../../state/contexts.js";
import { sitePath } from "../../state/router.js";
import type { EventList, NoteShape, SiteShape, StoredShape } from "../../generated/api.js";
import { FilmsApi } from "../../wire/films-api.js";
import type { ExportQuery, HubApi } from "../../wire/hub-api.js";
import { axesFor } from "./chart/axes-for.js";
import { FilmController } from "./film/film-controller.js";
import type { FilmPanel } from "./film/film-panel.js";
import { eventMarks, mergeMarks, type EventMark, type MarkKind } from "./chart/event-marks.js";
import { ghostUs, writeView, type HistoryView } from "./history-query.js";
import { firstChoice, channelRows, groupChannels, unitsOf, type ChannelRow, type ChartGroup } from "./data/channel-rows.js";
import { renderCompared, renderNothingChosen } from "./history-words.js";
import type { ChosenRuns } from "../runs/run-picker.js";
import { HistoryNotes } from "./history-notes.js";
import { historyStyle } from "./history-style.js";
import { WindowController } from "./window-controller.js";
import { WindowData } from "./data/window-data.js";
import { noteMarks } from "../notes/note-marks.js";
import { isBusy, isTaken, pageKeyAction } from "./window-keys.js";
import { renderAdvice, renderLoaded } from "../../elements/feedback/load-state.js";
import "../../elements/feedback/empty.js";
import "../../elements/feedback/loading.js";
import "../runs/compare-runs.js";
import "./chart/anomaly-scores.js";
import "./export-menu.js";
import "./chart/history-chart.js";
import "./film/film-lane.js";
import "./film/film-panel.js";
import "./history-tools.js";
import "./chart/marks-lane.js";
import "./share-menu.js";
import "./signal-picker.js";
import "./view-options.js";

/** Shorter presses on a chart are clicks (CSS pixels). */
const LEAST_DRAG = 6;
/** Beside values the day is enough; the line above the charts says the year. */
const YEAR = / \d{4}$/;

@customElement("t-page-history")
export class PageHistory extends LitElement {
  static override styles = [base, historyStyle];

  @property() site = "";

  @consume({ context: apiContext, subscribe: true }) @state() private api: HubApi | undefined;

  @state() private cursorUs: number | null = null;
  @state() private width = 0;
  /** Said to who listens, after keys have moved the window. */
  @state() private said = "";

  @query(".charts") private readonly charts!: HTMLElement | null;
  @query("t-film-panel") private readonly panel!: FilmPanel | null;

  private rows: readonly ChannelRow[] = [];
  private groups: readonly ChartGroup[] = [];
  private groupsKey = "";
  private axisWidth = 0;
  private filmed = false;
  private indent = indentOf(1, 0);
  private data: WindowData | null = null;
  private clock: ZoneClock | null = null;
  private ghostUs = 0;
  private marks: readonly EventMark[] = [];
  private markedOf: EventList | null = null;
  private notedOf: readonly NoteShape[] | null = null;
  private resized: ResizeObserver | null = null;
  // Nothing moves by itself here, so a round is drawn at the next frame, however dear the last one was.
  private readonly painter = new PaintScheduler(new DrawRate(16, 1, 16));
  private readonly wide = matchMedia("(min-width: 60.01rem)");
  private readonly detail = new LoadController<SiteShape>(this);
  private readonly former = new LoadController<readonly StoredShape[]>(this);
  private readonly sites = new ContextStoreController(this, sitesContext);
  private readonly window = new WindowController(this, {
    searchPart: () => this.router.store?.search ?? "",
    navigate: (search) => this.router.store?.navigate(sitePath(this.site, "history") + search),
    width: () => this.width,
  });
  private readonly router = new ContextStoreController(this, routerContext, () => {
    this.window.applyAddress();
  });
  private readonly live = new LiveValuesController(this);
  private readonly notes = new HistoryNotes(this, () => ({ site: this.site, span: this.window.span, cursorUs: this.shownCursor() }));
  private readonly films = new FilmController(
    this,
    () => (this.api === undefined ? null : new FilmsApi(this.api)),
    (us) => {
      const { span } = this.window;
      const part = (us - span.fromUs) / lengthOf(span);
      // Playing, the window is turned like a page, with a little of the last one at its left.
      this.window.applySpanChange({ span: panned(span, (part - 0.05) * lengthOf(span)), settled: false });
    },
  );
  /** The moment of the address that films were put to already. */
  private putTo: number | undefined;
  /** Where a press on a chart began (CSS pixels): what moves from there is no click. */
  private pressedX = 0;

  override connectedCallback(): void {
    super.connectedCallback();
    this.resized = new ResizeObserver(() => {
      this.measureWidth();
    });
    this.resized.observe(this);
    document.addEventListener("keydown", this.onKeyDown);
  }

  override disconnectedCallback(): void {
    super.disconnectedCallback();
    document.removeEventListener("keydown", this.onKeyDown);
    this.resized?.disconnect();
    this.data?.close();
    this.data = null;
  }

  protected override willUpdate(changed: PropertyValues<this>): void {
    const sites = this.sites.store;
    if (changed.has("site")) {
      this.data?.close();
      this.films.clear();
    }
    if (sites === undefined || this.api === undefined || !this.isConnected) return;
    const { api, site } = this;
    // A gateway that comes back with another description has other signals.
    const described = [site, sites.catalogueOf(site)].join("\n");
    this.detail.load(described, () => sites.loadDetail(site));
    this.former.load(described, () => api.formerChannels(site));
    const detail = this.detail.value;
    if (detail === undefined) return;
    this.rows = channelRows(detail, this.former.value);
    this.clock = clockOf(knownZone(detail.zone));
    this.data ??= new WindowData(api, () => {
      this.requestUpdate();
    });
    this.groupChannels();
    this.loadWindow(this.data, this.clock);
    this.notes.loadNotes(this.api, this.site, this.window.span);
    this.buildMarks(this.data, detail);
    this.loadFilms(detail);
    this.live.observeChannels(this.site, this.channelsWithoutData());
  }

  protected override updated(): void {
    // A film beside the charts takes some of their room.
    const filmed = this.films.reels.length > 0;
    if (this.width === 0 || filmed !== this.filmed) this.measureWidth();
    this.filmed = filmed;
  }

  private measureWidth(): void {
    const width = this.charts?.clientWidth ?? 0;
    // A scroll bar that comes or goes is no reason to ask again.
    if (Math.abs(width - this.width) > 24) this.width = width;
  }

  override render(): TemplateResult {
    const detail = this.detail.value;
    return html`
      <div class="title">
        <h1>${msg("History")}</h1>
        <p class="muted">${detail?.name ?? this.site}</p>
        ${detail === undefined ? nothing : this.renderSpan(detail.zone)}
        ${detail === undefined ? nothing : this.renderMenus()}
      </div>
      <p class="visually-hidden" aria-live="polite">${this.said}</p>
      ${renderLoaded(this.detail, msg("the site"), (loaded) => this.renderContent(loaded))} ${this.notes.renderDialog(this.site, detail)}
    `;
  }

  /** First by the clock that the axes go by, then in UTC. */
  private renderSpan(zone: string): TemplateResult {
    const { span, nowUs } = this.window;
    const utc = utcSpan(span, zone, nowUs);
    return html`<p class="utc">${localSpan(span, zone, nowUs)}${utc === "" ? nothing : html` <span>(${utc})</span>`}</p>`;
  }

  private readonly exportRefusal = (query: ExportQuery): Promise<string> =>
    this.api?.exportRefusal(this.site, query) ?? Promise.resolve("");

  private renderMenus(): TemplateResult {
    const { view, span } = this.window;
    const channels = this.chosenChannels();
    const link = (shown: HistoryView["shown"]): string =>
      new URL(sitePath(this.site, "history") + writeView({ ...view, channels, shown, at: "last" in shown ? undefined : (this.films.cursorUs ?? undefined) }), location.href).href;
    return html`<div class="menus">
      ${this.notes.renderButtons(this.detail.value)}
      <t-compare-runs site=${this.site} .zone=${this.detail.value?.zone ?? "UTC"} .span=${span} @t-runs=${this.onRuns}></t-compare-runs>
      <a class="way" href=${sitePath(this.site, "recordings")}>${msg("Recordings")}</a>
      <t-share-menu fixed=${link(span)} live=${"last" in view.shown ? link(view.shown) : ""}></t-share-menu>
      <t-export-menu site=${this.site} .channels=${channels} .span=${span} width=${this.width} .refusal=${this.exportRefusal}></t-export-menu>
    </div>`;
  }

  private renderContent(detail: SiteShape): TemplateResult {
    const chosen = this.chosenChannels();
    const { view, span } = this.window;
    return html`
      <t-history-tools .shown=${view.shown} .span=${span} zone=${detail.zone} @t-shown=${this.onWindowChoice}></t-history-tools>
      <div class="body ${this.films.reels.length > 0 ? "filmed" : ""}" @t-moment=${this.onMomentRequest}>
        <details class="pick" ?open=${this.wide.matches}>
          <summary>${msg("Signals")} <span class="count">${chosen.length}</span></summary>
          <t-signal-picker .rows=${this.rows} .chosen=${chosen} ?incomplete=${this.former.result.state === "failed"} @t-pick=${this.onChannelChoice}></t-signal-picker>
        </details>
        <div class="charts" aria-busy=${this.data?.now.state === "loading" ? "true" : "false"}>
          <t-view-options .view=${view} .span=${span} zone=${detail.zone} @t-view=${this.onViewChange}></t-view-options>
          ${this.renderProblem()}
          ${this.renderAbsent(chosen.length === 0)}
          ${this.data === null || chosen.length === 0 ? nothing : this.renderChartList(detail, this.data)}
        </div>
        ${this.renderFilmPanel(detail)}
      </div>
    `;
  }

  private renderChartList(detail: SiteShape, data: WindowData): TemplateResult {
    const { now, ghost, statistics } = data;
    const { span, view } = this.window;
    const { ghostUs, painter, indent } = this;
    const cursorUs = this.shownCursor();
    const newest = new Map(this.channelsWithoutData().map((address) => [address, this.live.readingOf(address)?.timeUs ?? 0]));
    const marks = view.without.length === 0 ? this.marks : this.marks.filter(({ kind }) => !view.without.includes(kind));
    const numbers = statistics.numbersOf(this.site, span);
    const ghostNumbers = data.ghostStatistics.numbersOf(this.site, panned(span, -ghostUs));
    const fences = data.outliers.foundIn(this.site, span, view.outliers);
    const then = ghostUs === 0 ? "" : view.shiftUs === 0 ? formatDate(span.fromUs - ghostUs, detail.zone) : timeText(span.fromUs - ghostUs, detail.zone, span.fromUs).local;
    return html`<div class="progress" ?hidden=${now.state !== "loading"}></div>
      ${then === "" ? nothing : renderCompared(span, ghostUs, view, detail.zone, () => { this.window.updateView({ shiftUs: 0, versus: 0 }); })}
      <t-marks-lane
        .marks=${this.marks}
        .without=${view.without}
        .span=${span}
        .indent=${indent}
        .more=${data.events.more}
        problem=${data.missingText || this.notes.missingText}
        zone=${detail.zone}
        @t-hide=${this.onHiddenKinds}
        @t-cursor=${this.onCursorMove}
        @click=${this.onMarkClick}
      ></t-marks-lane>
      ${this.films.reels.length === 0
        ? nothing
        : html`<t-film-lane .reels=${this.films.reels} .span=${span} .indent=${indent} .us=${this.films.us ?? 0}></t-film-lane>`}
      ${repeat(
        this.groups,
        ({ key }) => key,
        (group) =>
          html`<t-history-chart
            .group=${group}
            .data=${now.data}
            .ghost=${ghost}
            .ghostUs=${ghostUs}
            ghost-name=${then.replace(YEAR, "")}
            .numbers=${numbers}
            .ghostNumbers=${ghostNumbers}
            .span=${span}
            .cursorUs=${cursorUs}
            .painter=${painter}
            .newest=${newest}
            .marks=${marks}
            .outliers=${view.outliers}
            .fences=${fences}
            ?unfenced=${data.outliers.state === "failed"}
            .indent=${indent}
            axis-width=${this.axisWidth}
            ?joined=${view.joined}
            .loaded=${now.state === "ready"}
            zone=${detail.zone}
            @t-span=${this.onSpanChange}
            @t-cursor=${this.onCursorMove}
            @pointerdown=${this.onChartPress}
            @click=${this.onChartClick}
            @t-reset=${this.resetWindow}
          ></t-history-chart>`,
      )}
      <t-anomalies
        site=${this.site}
        edition=${detail.catalogue}
        .channels=${this.chosenChannels()}
        .labels=${signalLabels(detail)}
        .span=${span}
        .indent=${indent}
        .painter=${painter}
        .cursorUs=${cursorUs}
        ?moving=${this.window.moving !== null}
        width=${this.width}
        zone=${detail.zone}
      ></t-anomalies>
      <p class="hint">
        ${msg("Drag to zoom in, double-click to go back. Click a chart, then turn the wheel. Keys: ← → move, + \u2212 zoom, Home its day, End now, Escape back; on a chart shift and ← → move the cursor.")}
      </p>`;
  }

  private renderFilmPanel(detail: SiteShape): unknown {
    const { films } = this;
    if (films.reels.length === 0 || films.us === null) return nothing;
    return html`<t-film-panel
      site=${this.site}
      .control=${films}
      .reels=${films.reels}
      .us=${films.us}
      .playing=${films.playing}
      .held=${films.held}
      .speed=${films.speed}
      .chosen=${this.window.view.films ?? null}
      zone=${detail.zone}
      @t-cameras=${this.onCamerasChange}
    ></t-film-panel>`;
  }

  private renderProblem(): unknown {
    const load = this.data?.now;
    return load?.state === "failed" ? renderAdvice(adviceFor(load.renderError, msg("the history of these signals")), this.retry) : nothing;
  }

  /** What the address asks for and is not here; what to do when nothing is chosen at all. @param empty nothing of it is here */
  private renderAbsent(empty: boolean): unknown {
    const known = new Set(this.rows.map(({ address }) => address));
    const absent = (this.window.view.channels ?? []).filter((address) => !known.has(address));
    if (absent.length === 0) return empty ? renderNothingChosen(this.rows) : nothing;
    const { state } = this.former.result;
    if (state === "idle" || state === "loading") return empty ? html`<t-loading what=${msg("Loading earlier signals")}></t-loading>` : nothing;
    const said = html`<p class="hint">${msg("Not at this site, or not open to you:")} ${absent.join(", ")}</p>`;
    return empty ? html`<t-empty heading=${msg("No such signal")} icon="history">${said}</t-empty>` : said;
  }

  private chosenChannels(): string[] {
    const { channels } = this.window.view;
    if (channels === null) return firstChoice(this.rows);
    const known = new Set(this.rows.map(({ address }) => address));
    return channels.filter((address) => known.has(address));
  }

  /** Films and charts stand at one moment; while nothing plays, the pointer has it. */
  private shownCursor(): number | null {
    const { films } = this;
    return films.playing ? films.us : (this.cursorUs ?? films.cursorUs);
  }

  private loadFilms(detail: SiteShape): void {
    const { at, shown } = this.window.view;
    const names = new Map(detail.devices.flatMap(({ streams }) => streams.map(({ address, name }) => [address, name])));
    this.films.load(this.site, this.window.span, names);
    if (at !== this.putTo && this.films.reels.length > 0) {
      this.putTo = at;
      if (at !== undefined && !("last" in shown)) this.films.seek(at);
    }
  }

  private groupChannels(): void {
    const chosen = this.chosenChannels();
    const { most, axisWidth } = axesFor(this.window.view.joined, this.width);
    const rows = this.rows.filter(({ address }) => chosen.includes(address));
    const kinds = rows.map(({ address, former }) => `${address}${former ? " -" : ""}`);
    const key = `${this.detail.value?.catalogue ?? ""} ${String(most)}\n${kinds.join("\n")}`;
    if (key === this.groupsKey) return;
    this.groupsKey = key;
    this.groups = groupChannels(rows, most);
    this.axisWidth = axisWidth;
    this.indent = indentOf(Math.max(1, ...this.groups.map(({ rows }) => unitsOf(rows).length)), axisWidth);
  }

  private loadWindow(data: WindowData, clock: ZoneClock): void {
    const { span, view, moving, isFollowing: following } = this.window;
    this.ghostUs = ghostUs(span, view, clock);
    if (this.width === 0) return;
    const channels = this.groups.flatMap(({ rows }) => rows).map(({ address, maxAge, shown }) => ({ address, maxAge, shown }));
    data.loadWindow({ site: this.site, channels, span, width: this.width, ghostUs: this.ghostUs, moving: moving !== null, following, outliers: view.outliers });
  }

  private buildMarks({ events }: WindowData, detail: SiteShape): void {
    const { notes } = this.notes;
    if (events === this.markedOf && notes === this.notedOf) return;
    // Nothing new happened: charts that got another list would be drawn again for it.
    const same = notes === this.notedOf && JSON.stringify(events.events) === JSON.stringify(this.markedOf?.events ?? []);
    this.markedOf = events;
    this.notedOf = notes;
    if (same) return;
    const names = new Map(detail.devices.map(({ id, name }) => [id, name]));
    this.marks = mergeMarks(eventMarks(events.events, names), noteMarks(notes, names));
  }

  /** Chosen channels of which nothing has come for this window. */
  private channelsWithoutData(): string[] {
    const loader = this.data?.now;
    if (loader?.state !== "ready") return [];
    const live = new Set(this.rows.filter(({ former }) => !former).map(({ address }) => address));
    return this.chosenChannels().filter((address) => live.has(address) && loader.data.get(address)?.count === 0);
  }

  private readonly onWindowChoice = (event: CustomEvent<HistoryView["shown"]>): void => {
    this.window.updateView({ shown: event.detail });
  };

  private readonly onHiddenKinds = (event: CustomEvent<readonly MarkKind[]>): void => {
    this.window.updateView({ without: event.detail });
  };

  private readonly onViewChange = (event: CustomEvent<Partial<HistoryView>>): void => {
    this.window.updateView(event.detail);
  };

  private readonly onChannelChoice = (event: CustomEvent<readonly string[]>): void => {
    this.window.updateView({ channels: event.detail });
  };

  private readonly onSpanChange = (event: CustomEvent<SpanChange>): void => {
    if (!this.notes.keepSpan(event.detail)) this.window.applySpanChange(event.detail);
  };

  private readonly onKeyDown = (event: KeyboardEvent): void => {
    const { clock } = this;
    if (clock === null || event.defaultPrevented || event.ctrlKey || event.metaKey || event.altKey) return;
    if (this.films.reels.length > 0 && !isTaken(event.key, event.composedPath()) && this.panel?.handleKey(event.key) === true) {
      event.preventDefault();
      return;
    }
    if (isBusy(event.composedPath())) return;
    const wish = pageKeyAction(event.key, event.shiftKey, this.window.span, clock);
    if (wish === null) return;
    event.preventDefault();
    if (wish.wish === "back") this.window.resetWindow();
    else if (wish.wish === "shown") this.window.updateView({ shown: wish.shown });
    else this.window.applySpanChange({ span: wish.span, settled: false });
    const { fromUs, toUs } = this.window.span;
    this.said = msg(str`${momentText(fromUs, clock.zone, DAY_US)} to ${momentText(toUs, clock.zone, DAY_US)}`);
  };

  private readonly onCursorMove = (event: CustomEvent<number | null>): void => {
    this.cursorUs = event.detail;
    // The film goes where the pointer is, but not while it plays: then a click says so.
    if (event.detail !== null && !this.films.playing && this.films.us !== null) this.films.previewMoment(event.detail);
  };

  private readonly onChartPress = (event: PointerEvent): void => {
    this.pressedX = event.clientX;
  };

  private readonly onChartClick = (event: MouseEvent): void => {
    if (Math.abs(event.clientX - this.pressedX) < LEAST_DRAG) this.onMarkClick();
  };

  private readonly onMarkClick = (): void => {
    if (this.cursorUs !== null && this.films.us !== null) this.films.seek(this.cursorUs);
  };

  private readonly onMomentRequest = (event: CustomEvent<number>): void => {
    this.cursorUs = null;
    this.films.seek(event.detail);
    const { fromUs, toUs } = this.window.span;
    if (event.detail < fromUs || event.detail > toUs) this.window.applySpanChange({ span: panned(this.window.span, event.detail - (fromUs + toUs) / 2), settled: true });
  };

  private readonly onCamerasChange = (event: CustomEvent<readonly string[]>): void => {
    this.window.updateView({ films: event.detail });
  };

  private readonly onRuns = ({ detail: { span, shiftUs } }: CustomEvent<ChosenRuns>): void => {
    this.window.updateView({ shown: span, shiftUs, versus: 0 });
  };

  private readonly resetWindow = (): void => {
    this.window.resetWindow();
  };

  private readonly retry = (): void => {
    this.data?.invalidate();
    this.requestUpdate();
  };
}

declare global {
  interface HTMLElementTagNameMap {
    "t-page-history": PageHistory;
  }
}
