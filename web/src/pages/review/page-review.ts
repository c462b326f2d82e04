/** Looks through what cameras saw, day by day: what is new to this person first, one after the other, by keyboard too. */

import { consume } from "@lit/context";
import { msg, str } from "@lit/localize";
import { html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, property, query, queryAll, state } from "lit/decorators.js";
import { map } from "lit/directives/map.js";
import { repeat } from "lit/directives/repeat.js";
import { ActionController } from "../../controllers/action.js";
import { ConnectionStateController } from "../../controllers/connection-state.js";
import { ContextStoreController } from "../../controllers/context-store.js";
import { InfiniteList } from "../../controllers/infinite-list.js";
import { LoadController } from "../../controllers/load.js";
import { base } from "../../elements/base/base-style.js";
import { renderAdvice, renderLoaded } from "../../elements/feedback/load-state.js";
import { renderOptions } from "../../elements/forms/form-parts.js";
import { forms } from "../../elements/forms/form-style.js";
import { renderPageHead } from "../../elements/layout/page-head.js";
import { sheets } from "../../elements/layout/page-sections.js";
import { adviceFor } from "../../format/error-advice.js";
import { countText } from "../../format/object-names.js";
import { formatClock, knownZone } from "../../format/time.js";
import { clockOf, type ZoneClock } from "../../series/zone-clock.js";
import { apiContext, routerContext, sitesContext } from "../../state/contexts.js";
import { sitePath, withQuery } from "../../state/router.js";
import type { FilmListShape, LabelShape, ReviewDay, SeenShape, SiteShape } from "../../generated/api.js";
import { FilmsApi } from "../../wire/films-api.js";
import type { HubApi } from "../../wire/hub-api.js";
import { sightingPicturePath, SightingsApi } from "../../wire/sightings-api.js";
import type { SightingClip } from "../../tiles/camera/sighting-clip.js";
import { historyQuery } from "../sightings/sightings-query.js";
import { reviewStyle } from "./review-style.js";
import { clipOf, dayCounts, readReviewFilter, reviewKey, reviewPageQuery, shownDay, writeReviewFilter, type DayCount, type ReviewFilter } from "./review-query.js";
import "../../elements/analysis/sighting-card.js";
import "../../elements/base/icon.js";
import "../../elements/feedback/empty.js";
import "../../elements/feedback/loading.js";
import "../../elements/forms/button.js";
import "../../elements/forms/field.js";
import "../../tiles/camera/sighting-clip.js";

const ROWS = 60;
/** Of a film so much is shown before something came into sight (s). */
const BEFORE_S = 5;

@customElement("t-page-review")
export class PageReview extends LitElement {
  static override styles = [base, sheets, forms, reviewStyle];

  @property() site = "";
  /** The sighting that is looked at. */
  @state() private shownId = "";
  /** Marks that were set here since the list was loaded. */
  @state() private marks: ReadonlyMap<string, boolean> = new Map();

  @query("t-sighting-clip") private readonly clip!: SightingClip | null;
  @queryAll("li[data-sighting]") private readonly thumbs!: NodeListOf<HTMLElement>;
  @consume({ context: apiContext }) private readonly api!: HubApi;
  private readonly router = new ContextStoreController(this, routerContext);
  private readonly sites = new ContextStoreController(this, sitesContext);
  private readonly marking = new ActionController(this);
  private readonly detail = new LoadController<SiteShape>(this);
  private readonly labels = new LoadController<readonly LabelShape[]>(this);
  private readonly days = new LoadController<readonly ReviewDay[]>(this);
  private readonly films = new LoadController<FilmListShape>(this);
  private readonly list = new InfiniteList<SeenShape>(
    this,
    async (before) => {
      const { sightings, more } = await this.sightingsApi().findSightings(reviewPageQuery(this.filter(), this.day(), this.clock(), before, ROWS));
      return { rows: sightings, more };
    },
    () => true,
  );
  /** Which list is shown; the marks and the one that is looked at are of it. */
  private listed = "";

  constructor() {
    super();
    new ConnectionStateController(this, (connection) => [
      connection.onMessage("sighting", (news) => {
        // One that is over counts; the list itself stays as it is below the person's fingers.
        if (news.site === this.site && news.ended_us !== 0) this.days.invalidate();
      }),
    ]);
  }

  override connectedCallback(): void {
    super.connectedCallback();
    window.addEventListener("keydown", this.onKeyDown);
  }

  override disconnectedCallback(): void {
    super.disconnectedCallback();
    window.removeEventListener("keydown", this.onKeyDown);
  }

  override willUpdate(): void {
    const sites = this.sites.store;
    if (sites === undefined || this.site === "") return;
    this.detail.load(`${this.site} ${sites.catalogueOf(this.site)}`, () => sites.loadDetail(this.site));
    this.labels.load(this.site, () => this.sightingsApi().labels());
    const filter = this.filter();
    this.days.load(`${this.site}\n${filter.camera}\n${filter.label}`, () => this.sightingsApi().reviewDays(filter.camera, filter.label));
    if (this.days.value === undefined) return;
    const listed = `${this.site}\n${this.day()}\n${writeReviewFilter({ ...filter, day: "", sighting: "" })}`;
    if (listed !== this.listed) {
      this.listed = listed;
      this.marks = new Map();
      this.shownId = filter.sighting;
    }
    if (this.day() !== "") this.list.load(listed);
    const shown = this.shown();
    if (shown !== undefined) {
      const [from, to] = [shown.began_us - 60e6, shown.began_us + 60e6];
      this.films.load(`${this.site} ${shown.id}`, () => new FilmsApi(this.api).listFilms(this.site, from, to));
    }
  }

  override render(): TemplateResult {
    return html`${renderPageHead(
        msg("Review", { id: "review.page" }),
        msg(str`What the cameras of ${this.sites.store?.siteRow(this.site)?.name ?? this.site} saw, day by day.`),
        html`<div class="actions">
          <a href=${sitePath(this.site, "sightings")}>${msg("Sightings")}</a>
          <a href=${sitePath(this.site, "cameras")}>${msg("Cameras")}</a>
        </div>`,
      )}
      ${this.renderFilter(this.filter())} ${renderLoaded(this.days, msg("the days"), (days) => this.renderDays(dayCounts(days)))}`;
  }

  private renderFilter(filter: ReviewFilter): TemplateResult {
    const labels = [...new Set((this.labels.value ?? []).map(({ label }) => label))].sort((a, b) => a.localeCompare(b));
    const any: [string, string] = ["", msg("all", { id: "all.cameras" })];
    const plain = (words: readonly string[]): [string, string][] => words.map((word): [string, string] => [word, word]);
    return html`<section class="sheet" aria-label=${msg("Filter")}>
      <form class="filter" @change=${this.onFilter} @submit=${stopSubmit}>
        <t-field label=${msg("Camera")}><select name="camera">${renderOptions([any, ...this.cameras()], filter.camera)}</select></t-field>
        <t-field label=${msg("Object")}><select name="label">${renderOptions([any, ...plain(labels)], filter.label)}</select></t-field>
        <t-field label=${msg("Zone or line")}><select name="zone">${renderOptions([any, ...plain(this.zones(filter.camera))], filter.zone)}</select></t-field>
        <label class="tick"><input name="all" type="checkbox" .checked=${filter.all} /> ${msg("Also what I have seen")}</label>
      </form>
    </section>`;
  }

  private renderDays(days: readonly DayCount[]): TemplateResult {
    if (days.length === 0) {
      return html`<t-empty heading=${msg("Nothing seen yet")} icon="camera">
        <p>${msg("What comes into sight of a camera with object detection is listed here by day.")}</p>
      </t-empty>`;
    }
    const day = this.day();
    return html`<nav class="days" aria-label=${msg("Days")}>
        ${map(days, (other) => {
          const path = withQuery(sitePath(this.site, "review"), writeReviewFilter({ ...this.filter(), day: other.day, sighting: "", until: "" }));
          const { count, unseen } = other;
          return html`<a href=${path} aria-current=${other.day === day ? "date" : "false"}>
            <span>${other.day}</span>
            <span class="many">${unseen > 0 ? msg(str`${String(unseen)} new of ${String(count)}`) : msg(str`all ${String(count)} seen`)}</span>
          </a>`;
        })}
      </nav>
      ${this.renderDay()}`;
  }

  private renderDay(): TemplateResult {
    const { rows } = this.list;
    const failure = this.list.renderFailure === null ? null : adviceFor(this.list.renderFailure, msg("the sightings"));
    if (rows.length === 0) {
      if (failure !== null) return renderAdvice(failure, this.list.retry);
      if (this.list.loading || !this.list.hasStarted || this.list.hasMore) return html`<t-loading what=${msg("Loading the sightings")}></t-loading><p class="end"></p>`;
      return html`<t-empty heading=${this.filter().all ? msg("No matches") : msg("You have seen everything")} icon="camera">
        <p>${this.filter().all ? msg("No camera saw anything like this on that day.") : msg("Nothing of that day is new to you.")}</p>
        ${this.filter().all ? nothing : html`<t-button @click=${this.showAll}>${msg("Show what I have seen")}</t-button>`}
      </t-empty>`;
    }
    return html`<div class="desk">
      <section class="stage" aria-label=${msg("Shown now")}>${this.renderShown()}</section>
      <section aria-label=${msg("Sightings of the day")}>
        <ol class="strip">
          ${repeat(rows, ({ id }) => id, (row) => this.renderThumb(row))}
        </ol>
        ${renderAdvice(failure, this.list.retry)}
        ${this.list.loading ? html`<t-loading what=${msg("Loading the sightings")}></t-loading>` : nothing}
        <p class="end">${this.list.hasMore ? "" : msg("This is where the day begins.")}</p>
      </section>
    </div>`;
  }

  private renderShown(): TemplateResult | typeof nothing {
    const shown = this.shown();
    if (shown === undefined) return nothing;
    const found = this.films.value === undefined ? null : clipOf(this.films.value, shown, BEFORE_S);
    const camera = this.nameOf(shown.camera);
    const picture = shown.picture ? sightingPicturePath(this.site, shown.id) : "";
    const seen = this.isSeen(shown);
    return html`<t-sighting-clip
        .site=${this.site}
        .film=${found?.film ?? null}
        .from=${found?.from ?? 0}
        .picture=${picture}
        .what=${msg(str`${shown.label} on ${camera}`)}
      ></t-sighting-clip>
      <div class="actions">
        <t-button @click=${this.onPrevious} title="K">${msg("Previous")}</t-button>
        <t-button @click=${this.onNext} title="J">${msg("Next")}</t-button>
        <t-button kind="primary" ?busy=${this.marking.busy} @click=${this.onSeen} title="S">${seen ? msg("Not seen") : msg("Seen, next")}</t-button>
        <t-button kind="quiet" @click=${this.markAll}>${msg("All of these seen")}</t-button>
      </div>
      ${renderAdvice(this.marking.problem)}
      <t-sighting .sighting=${shown} .camera=${camera} .picture=${picture} .zone=${this.clock().zone}>
        <div class="ways">
          <a href=${`${sitePath(this.site, "history")}?${historyQuery(shown, this.detail.value)}`}>${msg("Chart")}</a>
        </div>
      </t-sighting>
      <p class="keys">${msg(html`<kbd>J</kbd> next, <kbd>K</kbd> previous, <kbd>Space</kbd> play, <kbd>S</kbd> seen`)}</p>`;
  }

  private renderThumb(row: SeenShape): TemplateResult {
    const shown = row.id === this.shown()?.id;
    const seen = this.isSeen(row);
    const show = (): void => {
      this.shownId = row.id;
    };
    const when = formatClock(row.began_us, this.clock().zone);
    return html`<li data-sighting=${row.id}>
      <button type="button" class="thumb ${seen ? "seen" : ""}" aria-current=${shown ? "true" : "false"} @click=${show}>
        <span class="picture">
          ${row.picture
            ? html`<img src=${sightingPicturePath(this.site, row.id)} alt="" loading="lazy" decoding="async" />`
            : html`<t-icon name="camera"></t-icon>`}
        </span>
        <span class="what">${countText(1, row.label)}</span>
        <span class="when">${when}</span>
        <span class="when">${this.nameOf(row.camera)}${seen ? msg(", seen") : ""}</span>
      </button>
    </li>`;
  }

  // ── what is there ──

  private shown(): SeenShape | undefined {
    const { rows } = this.list;
    return rows.find(({ id }) => id === this.shownId) ?? rows[0];
  }

  private isSeen(row: SeenShape): boolean {
    return this.marks.get(row.id) ?? row.seen === true;
  }

  private day(): string {
    return shownDay(this.filter(), dayCounts(this.days.value ?? []));
  }

  private cameras(): [string, string][] {
    const names = new Map<string, string>((this.labels.value ?? []).map(({ camera }) => [camera, camera]));
    for (const { streams } of this.detail.value?.devices ?? []) {
      for (const { address, name, detect } of streams) if (detect != null || names.has(address)) names.set(address, name);
    }
    return [...names];
  }

  private zones(camera: string): string[] {
    const streams = (this.detail.value?.devices ?? []).flatMap(({ streams }) => streams).filter(({ address }) => camera === "" || address === camera);
    const marks = streams.flatMap(({ detect }) => [...(detect?.zones ?? []), ...(detect?.lines ?? [])]);
    return [...new Set(marks.map(({ name }) => name))];
  }

  private nameOf(camera: string): string {
    return new Map(this.cameras()).get(camera) ?? camera;
  }

  private clock(): ZoneClock {
    return clockOf(knownZone(this.sites.store?.zoneOf(this.site) ?? "UTC"));
  }

  private filter(): ReviewFilter {
    return readReviewFilter(this.router.store?.search ?? "");
  }

  private sightingsApi(): SightingsApi {
    return new SightingsApi(this.api, this.site);
  }

  // ── what a person does ──

  private setFilter(filter: ReviewFilter): void {
    this.router.store?.replace(withQuery(sitePath(this.site, "review"), writeReviewFilter(filter)));
  }

  private readonly onFilter = (event: Event): void => {
    const form = event.currentTarget as HTMLFormElement;
    const said = new FormData(form);
    const text = (name: string): string => {
      const value = said.get(name);
      return typeof value === "string" ? value : "";
    };
    this.setFilter({ ...this.filter(), camera: text("camera"), label: text("label"), zone: text("zone"), all: said.has("all"), sighting: "", until: "" });
  };

  private readonly showAll = (): void => {
    this.setFilter({ ...this.filter(), day: this.day(), all: true });
  };

  private readonly onNext = (): void => {
    this.step(1);
  };

  private readonly onPrevious = (): void => {
    this.step(-1);
  };

  private step(by: 1 | -1): void {
    const { rows } = this.list;
    const at = rows.findIndex(({ id }) => id === this.shown()?.id);
    const to = rows[at + by];
    if (to === undefined) return;
    this.shownId = to.id;
    void this.updateComplete.then(() => {
      [...this.thumbs].find(({ dataset }) => dataset["sighting"] === to.id)?.scrollIntoView({ block: "nearest" });
    });
  }

  private readonly onSeen = (): void => {
    const shown = this.shown();
    if (shown === undefined) return;
    const seen = !this.isSeen(shown);
    void this.mark([shown.id], seen).then((done) => {
      if (done && seen) this.step(1);
    });
  };

  private readonly markAll = (): void => {
    void this.mark(this.list.rows.slice(0, 500).map(({ id }) => id), true);
  };

  private async mark(ids: readonly string[], seen: boolean): Promise<boolean> {
    const done = await this.marking.run(msg("mark it"), () => this.sightingsApi().markSeen(ids, seen));
    if (done) {
      this.marks = new Map([...this.marks, ...ids.map((id): [string, boolean] => [id, seen])]);
      this.days.invalidate();
    }
    return done;
  }

  private readonly onKeyDown = (event: KeyboardEvent): void => {
    if (event.ctrlKey || event.metaKey || event.altKey || event.defaultPrevented || isTyping(event)) return;
    switch (reviewKey(event.key)) {
      case "next":
        this.step(1);
        break;
      case "previous":
        this.step(-1);
        break;
      case "seen":
        if (!event.repeat) this.onSeen();
        break;
      case "play":
        if (this.clip?.togglePlay() !== true) return;
        break;
      case null:
        return;
    }
    event.preventDefault();
  };
}

function stopSubmit(event: Event): void {
  event.preventDefault();
}

/** Letters belong to a field; a blank belongs to a button and to a film's own controls as well. */
function isTyping(event: KeyboardEvent): boolean {
  const fields = event.key === " " ? "input, select, textarea, button, a, video" : "input, select, textarea";
  return event.composedPath().some((target) => target instanceof HTMLElement && target.matches(fields));
}

declare global {
  interface HTMLElementTagNameMap {
    "t-page-review": PageReview;
  }
}
