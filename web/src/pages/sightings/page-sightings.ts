/** What the cameras of a site have seen: newest first, found by camera, class and time. */

import { consume } from "@lit/context";
import { msg, str } from "@lit/localize";
import { css, html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, property, state } from "lit/decorators.js";
import { map } from "lit/directives/map.js";
import { InfiniteList } from "../../controllers/infinite-list.js";
import { FilterForm } from "../../controllers/filter-form.js";
import { ConnectionStateController } from "../../controllers/connection-state.js";
import { LoadController } from "../../controllers/load.js";
import { ContextStoreController } from "../../controllers/context-store.js";
import { base } from "../../elements/base/base-style.js";
import { renderOptions } from "../../elements/forms/form-parts.js";
import { forms } from "../../elements/forms/form-style.js";
import { settled } from "../../elements/base/stable-field.js";
import { renderPageHead } from "../../elements/layout/page-head.js";
import { sheets } from "../../elements/layout/page-sections.js";
import { knownZone } from "../../format/time.js";
import { formTexts } from "../../format/filter-query.js";
import { formText } from "../../format/form-values.js";
import { clockOf, momentProblem, type ZoneClock } from "../../series/zone-clock.js";
import { apiContext, routerContext, sitesContext } from "../../state/contexts.js";
import { sitePath, withQuery } from "../../state/router.js";
import type { LabelShape, RecordingShape, SeenShape, SiteShape } from "../../generated/api.js";
import type { HubApi } from "../../wire/hub-api.js";
import { RecordingsApi } from "../../wire/recordings-api.js";
import { sightingPicturePath, SightingsApi } from "../../wire/sightings-api.js";
import { renderInfiniteList } from "../infinite-list-view.js";
import { recordingAt } from "../logbook/logbook-query.js";
import { FILTER_KEYS, historyQuery, NO_FILTER, sightingsPageQuery, readSightingFilter, withUpdate, writeSightingFilter, type SightingFilter } from "./sightings-query.js";
import "../../elements/forms/button.js";
import "../../elements/feedback/empty.js";
import "../../elements/forms/field.js";
import "../../elements/analysis/sighting-card.js";

const ROWS = 30;

@customElement("t-page-sightings")
export class PageSightings extends LitElement {
  static override styles = [
    base,
    sheets,
    forms,
    css`
      ul.rows > li {
        grid-template-columns: minmax(0, 1fr);
        align-content: start;
      }
      @media (min-width: 75rem) {
        ul.rows {
          grid-template-columns: 1fr 1fr;
          column-gap: var(--t-space-6);
        }
        ul.rows > li:nth-child(2) {
          border-block-start: 0;
          padding-block-start: 0;
        }
      }
    `,
  ];

  @property() site = "";
  /** What is written as a time and is none, by field: nothing is filtered by it. */
  @state() private wrongTimes: Readonly<Record<string, string>> = {};

  @consume({ context: apiContext }) private readonly api!: HubApi;
  private readonly router = new ContextStoreController(this, routerContext);
  private readonly sites = new ContextStoreController(this, sitesContext);
  private readonly detail = new LoadController<SiteShape>(this);
  private readonly labels = new LoadController<readonly LabelShape[]>(this);
  private readonly recordings = new LoadController<readonly RecordingShape[]>(this);
  private readonly list = new InfiniteList<SeenShape>(
    this,
    async (before) => {
      const { sightings, more } = await this.sightingsApi().findSightings(sightingsPageQuery(this.filter(), this.knownLabels(), before, ROWS));
      return { rows: sightings, more };
    },
    (row) => !this.filter().open || row.ended_us === null,
  );
  private readonly form = new FilterForm<SightingFilter>(
    this,
    (said) => this.readFilter(said),
    (filter) => {
      if (filter === NO_FILTER) this.wrongTimes = {};
      this.router.store?.replace(withQuery(sitePath(this.site, "sightings"), writeSightingFilter(filter)));
    },
    NO_FILTER,
  );

  constructor() {
    super();
    new ConnectionStateController(this, (connection) => [
      connection.onMessage("sighting", (news) => {
        if (news.site !== this.site) return;
        this.list.updateRows((rows) => withUpdate(rows, news) ?? rows);
        // Whether there is a picture, and whether it fits the filter, only the hub knows.
        this.list.scheduleRefresh();
      }),
    ]);
  }

  override willUpdate(): void {
    const sites = this.sites.store;
    if (sites === undefined || this.site === "") return;
    this.detail.load(`${this.site} ${sites.catalogueOf(this.site)}`, () => sites.loadDetail(this.site));
    this.labels.load(this.site, () => this.sightingsApi().labels());
    // Who may not see them has no links to them, and that is all.
    this.recordings.load(this.site, async () => (await new RecordingsApi(this.api).listRecordings(this.site)).recordings);
    const filter = this.filter();
    // What was typed means a class only once the classes are known.
    if (filter.what !== "" && this.labels.value === undefined && this.labels.result.state !== "failed") return;
    this.list.load(`${this.site}\n${writeSightingFilter(filter)}`);
  }

  override render(): TemplateResult {
    return html`${renderPageHead(
        msg("Sightings"),
        msg(str`What the cameras of ${this.sites.store?.siteRow(this.site)?.name ?? this.site} have seen, newest first.`),
        html`<div class="actions">
          <a href=${sitePath(this.site, "review")}>${msg("Review", { id: "review.page" })}</a>
          <a href=${sitePath(this.site, "cameras")}>${msg("Cameras")}</a>
          <a href=${sitePath(this.site, "logbook")}>${msg("Logbook")}</a>
        </div>`,
      )}
      ${this.renderSearch(this.filter())}
      ${renderInfiniteList(this.list, {
        label: msg("Sightings"),
        what: msg("the sightings"),
        row: (row) => this.renderRow(row),
        nothing: () => this.renderEmpty(),
      })}`;
  }

  private renderSearch(filter: SightingFilter): TemplateResult {
    const clock = this.clock();
    const shown = (us: number | null): string => (us === null ? "" : clock.toInput(us));
    return html`<section class="sheet" aria-label=${msg("Filter")}>
      <form class="filter" novalidate @submit=${this.form.onSubmit} @input=${this.form.onInput}>
        <t-field label=${msg("Detected object")}>
          <input name="what" type="search" list="labels" maxlength="200" autocomplete="off" .value=${settled(filter.what)} />
        </t-field>
        <datalist id="labels">${map(this.knownLabels(), (label) => html`<option value=${label}></option>`)}</datalist>
        <t-field label=${msg("Camera")}>
          <select name="camera">
            ${renderOptions([["", msg("all", { id: "all.cameras" })], ...this.cameras()], filter.camera)}
          </select>
        </t-field>
        <t-field class="time" label=${msg(str`From (${clock.zone})`)} .error=${momentProblem(this.wrongTimes["from"] ?? "", Number.NaN)}><input name="from" type="text" autocomplete="off" placeholder="2026-03-29 14:05:09" maxlength="30" .value=${settled(this.wrongTimes["from"] ?? shown(filter.fromUs))} /></t-field>
        <t-field class="time" label=${msg(str`To (${clock.zone})`)} .error=${momentProblem(this.wrongTimes["to"] ?? "", Number.NaN)}><input name="to" type="text" autocomplete="off" placeholder="2026-03-29 14:05:09" maxlength="30" .value=${settled(this.wrongTimes["to"] ?? shown(filter.toUs))} /></t-field>
        <label class="tick"><input name="open" type="checkbox" .checked=${filter.open} /> ${msg("Only what is visible now")}</label>
        <t-button kind="quiet" ?disabled=${writeSightingFilter(filter) === ""} @click=${this.form.clearFilter}>${msg("Clear")}</t-button>
      </form>
    </section>`;
  }

  private renderEmpty(): TemplateResult {
    const all = writeSightingFilter(this.filter()) === "";
    const looking = this.detail.value?.devices.some(({ streams }) => streams.some(({ detect }) => detect != null)) === true;
    if (!all) {
      return html`<t-empty heading=${msg("No matches")} icon="camera">
        <p>${msg("No camera has seen anything like this.")}</p>
        <t-button @click=${this.form.clearFilter}>${msg("Show everything")}</t-button>
      </t-empty>`;
    }
    if (looking) return html`<t-empty heading=${msg("Nothing seen yet")} icon="camera"><p>${msg("What comes into sight of a camera is listed here by itself.")}</p></t-empty>`;
    return html`<t-empty heading=${msg("No camera looks for anything")} icon="camera">
      <p>${msg(html`Object detection is switched on for each camera in the site's description, under <code>detect:</code>.`)}</p>
    </t-empty>`;
  }

  private renderRow(row: SeenShape): TemplateResult {
    const device = row.camera.split("/", 1)[0] ?? "";
    return html`<li data-sighting=${row.id}>
      <t-sighting
        .sighting=${row}
        .camera=${this.nameOf(row.camera)}
        .picture=${row.picture ? sightingPicturePath(this.site, row.id) : ""}
        .zone=${this.sites.store?.zoneOf(this.site) ?? "UTC"}
      >
        <div class="ways">
          <a href=${`${sitePath(this.site, "history")}?${historyQuery(row, this.detail.value)}`} aria-label=${msg(str`Chart at the moment of ${row.label}`)}>${msg("Chart")}</a>
          <a href=${this.reviewPathOf(row)} aria-label=${msg(str`Review ${row.label}`)}>${msg("Review")}</a>
          ${recordingAt(this.recordings.value ?? [], row.began_us) === undefined
            ? nothing
            : html`<a href=${`${sitePath(this.site, "recordings")}?at=${String(row.began_us)}`}>${msg("Recording")}</a>`}
          ${row.ended_us === null ? html`<a href=${`/sites/${encodeURIComponent(this.site)}/devices/${encodeURIComponent(device)}`}>${msg("Look now")}</a>` : nothing}
        </div>
      </t-sighting>
    </li>`;
  }

  /** Where it is shown large, with its clip. */
  private reviewPathOf(row: SeenShape): string {
    const day = this.clock().toInput(row.began_us).slice(0, 10);
    return `${sitePath(this.site, "review")}?${new URLSearchParams({ day, all: "true", sighting: row.id, until: String(row.began_us) }).toString()}`;
  }

  // ── what can be chosen ──

  private cameras(): readonly (readonly [address: string, name: string])[] {
    const names = new Map<string, string>();
    for (const { camera } of this.labels.value ?? []) names.set(camera, camera);
    for (const { streams } of this.detail.value?.devices ?? []) {
      for (const { address, name, detect } of streams) if (detect != null || names.has(address)) names.set(address, name);
    }
    return [...names];
  }

  private knownLabels(): readonly string[] {
    const described = (this.detail.value?.devices ?? []).flatMap(({ streams }) => streams.flatMap(({ detect }) => detect?.classes ?? []));
    return [...new Set([...(this.labels.value ?? []).map(({ label }) => label), ...described])].sort((a, b) => a.localeCompare(b));
  }

  private nameOf(camera: string): string {
    return new Map(this.cameras()).get(camera) ?? camera;
  }

  private clock(): ZoneClock {
    return clockOf(knownZone(this.sites.store?.zoneOf(this.site) ?? "UTC"));
  }

  private filter(): SightingFilter {
    return readSightingFilter(this.router.store?.search ?? "");
  }

  private sightingsApi(): SightingsApi {
    return new SightingsApi(this.api, this.site);
  }

  private readFilter(said: FormData): SightingFilter {
    const time = (name: "from" | "to"): number | null => {
      const text = formText(said, name);
      const us = this.clock().fromInput(text);
      const others = Object.entries(this.wrongTimes).filter(([other]) => other !== name);
      this.wrongTimes = Object.fromEntries(momentProblem(text, us) === "" ? others : [...others, [name, text]]);
      return Number.isNaN(us) ? null : us;
    };
    return { ...formTexts(said, FILTER_KEYS), fromUs: time("from"), toUs: time("to"), open: said.has("open") };
  }
}

declare global {
  interface HTMLElementTagNameMap {
    "t-page-sightings": PageSightings;
  }
}
