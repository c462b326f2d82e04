/** The night of a site by itself: how it stands, the plan as a line and as a table, the sky, shares, what waits, pictures, log. */

import { consume } from "@lit/context";
import { msg, str } from "@lit/localize";
import { css, html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, property } from "lit/decorators.js";
import { map } from "lit/directives/map.js";
import { repeat } from "lit/directives/repeat.js";
import { eventWords } from "../../format/kinds/event-kinds.js";
import { ConnectionStateController } from "../../controllers/connection-state.js";
import { ContextStoreController } from "../../controllers/context-store.js";
import { LoadController } from "../../controllers/load.js";
import { TickerController } from "../../controllers/ticker.js";
import { base, panelBox, plainList } from "../../elements/base/base-style.js";
import { renderLoaded } from "../../elements/feedback/load-state.js";
import { renderTable, tables } from "../../elements/layout/data-table.js";
import { renderPageHead } from "../../elements/layout/page-head.js";
import { sheets } from "../../elements/layout/page-sections.js";
import { renderRows } from "../../elements/layout/rows.js";
import { BLOCK_WORDS, pauseText } from "../../elements/observatory/plan-timeline.js";
import type { PlannedAim } from "../../elements/observatory/sky-chart.js";
import { formatDuration } from "../../format/duration.js";
import { fixedText, roundText } from "../../format/number.js";
import type { EventList, FrameList, FrameShape, SiteNightShape, ProposalList, RequestDetail, RequestList, SiteShape } from "../../generated/api.js";
import { nightWindow, proposalMarks, type NightBlock, type ProposalMark } from "../../series/plan-layout.js";
import { nextMorning, nightSky, type SkySpan } from "../../sky/night-sky.js";
import { horizontalOf } from "../../sky/request-visibility.js";
import { targetPlace } from "../../sky/target-place.js";
import { apiContext, sitesContext, themeContext } from "../../state/contexts.js";
import { sitePath } from "../../state/router.js";
import type { Theme } from "../../state/theme.js";
import { AlarmsApi } from "../../wire/alarms-api.js";
import { ArchiveApi, previewPath } from "../../wire/archive-api.js";
import type { HubApi } from "../../wire/hub-api.js";
import { ObservingApi } from "../../wire/observing-api.js";
import { nightBlocks, plannedBlocks, shareRows, takenBlocks, type ShareRow } from "../../series/night-blocks.js";
import "../../elements/feedback/banner.js";
import "../../elements/feedback/empty.js";
import "../../elements/feedback/status.js";
import "../../elements/observatory/plan-timeline.js";
import "../../elements/values/clock.js";
import "../../elements/values/time.js";
import "../../elements/forms/button.js";
import "../../tiles/observatory/night-glance.js";
import "./night-state.js";

const EVERY_MS = 15_000;
const REFRESH_MS = 3000;
const PICTURES = 8;
const FRAMES = 400;
const EVENTS = 20;
/** So many targets of the plan stand on the chart of the sky. */
const AIMS = 12;
const HALF_DAY_MS = 43_200_000;

@customElement("t-page-night")
export class PageNight extends LitElement {
  static override styles = [
    base,
    sheets,
    tables,
    css`
      .two {
        display: grid;
        grid-template-columns: minmax(0, 1fr) minmax(0, 1fr);
        align-items: start;
        gap: var(--t-space-4);
      }
      .plan-and-log {
        display: grid;
        grid-template-columns: minmax(0, 2fr) minmax(0, 1fr);
        gap: var(--t-space-4);
      }
      .plan-and-log > * {
        min-inline-size: 0;
      }
      /* As high as the plan beside it: the newest stands on top, the rest scrolls. */
      .log {
        max-block-size: 27rem;
        overflow: auto;
      }
      .plan {
        --t-columns: 8rem minmax(8rem, 2fr) 8rem 6rem 9rem minmax(10rem, 3fr);
      }
      .shares {
        --t-columns: minmax(8rem, 1fr) 5rem 5rem 7rem;
      }
      .pictures {
        display: grid;
        grid-template-columns: repeat(auto-fill, minmax(9rem, 1fr));
        gap: var(--t-space-3);
        ${plainList}
      }
      .pictures a {
        display: grid;
        gap: var(--t-space-1);
        padding: var(--t-space-2);
        ${panelBox}
        color: inherit;
        text-decoration: none;
      }
      .pictures img {
        inline-size: 100%;
        aspect-ratio: 4 / 3;
        object-fit: contain;
        background: #000;
        filter: var(--t-still-filter, none);
      }
      .bar {
        display: block;
        block-size: 0.5rem;
        border: 1px solid var(--t-edge);
        background: linear-gradient(var(--t-accent) 0 0) no-repeat;
      }
      @media (max-width: 60rem) {
        .two,
        .plan-and-log {
          grid-template-columns: minmax(0, 1fr);
        }
      }
    `,
  ];

  @property() site = "";

  @consume({ context: apiContext }) private readonly api!: HubApi;
  private readonly sites = new ContextStoreController(this, sitesContext);
  private readonly theme = new ContextStoreController(this, themeContext);
  private formerTheme: Theme = "auto";
  private readonly detail = new LoadController<SiteShape>(this);
  private readonly overview = new LoadController<SiteNightShape>(this);
  private readonly proposals = new LoadController<ProposalList>(this);
  private readonly waiting = new LoadController<RequestList>(this);
  private readonly targets = new LoadController<readonly RequestDetail[]>(this);
  private readonly frames = new LoadController<FrameList>(this);
  private readonly events = new LoadController<EventList>(this);
  private readonly link: ConnectionStateController;
  private timer: ReturnType<typeof setTimeout> | undefined;

  constructor() {
    super();
    new TickerController(this, EVERY_MS);
    this.link = new ConnectionStateController(this, (connection) => {
      const refresh = (news: { readonly site: string }): void => {
        if (news.site === this.site) this.scheduleRefresh();
      };
      return [connection.onMessage("night", refresh), connection.onMessage("night_plan", refresh), connection.onMessage("observing_request", refresh), connection.onMessage("event", refresh)];
    });
  }

  override disconnectedCallback(): void {
    super.disconnectedCallback();
    clearTimeout(this.timer);
    this.timer = undefined;
  }

  override willUpdate(): void {
    const { api, site } = this;
    const sites = this.sites.store;
    const observing = new ObservingApi(api, site);
    if (sites !== undefined) this.detail.load(`${site} ${sites.catalogueOf(site)}`, () => sites.loadDetail(site));
    this.overview.load(site, () => observing.nightOverview());
    this.proposals.load(site, () => observing.listProposals());
    this.waiting.load(site, () => observing.findRequests("state=PENDING&limit=200"));
    this.frames.load(site, () => new ArchiveApi(api, site).findFrames(`limit=${String(FRAMES)}`));
    this.events.load(site, () => new AlarmsApi(api).events(site, `limit=${String(EVENTS)}`));
    const asked = this.plannedRequests();
    this.targets.load(`${site} ${asked.join(" ")}`, () => Promise.all(asked.map((id) => observing.requestDetail(id))));
  }

  override render(): TemplateResult {
    const links = html`<div class="actions">
      <a href=${sitePath(this.site, "forecast")}>${msg("Forecast")}</a>
      <a href=${sitePath(this.site, "requests")}>${msg("Requests")}</a>
      <a href=${sitePath(this.site, "proposals")}>${msg("Proposals")}</a>
      <a href=${sitePath(this.site, "archive")}>${msg("Archive")}</a>
      <t-button kind="quiet" @click=${this.switchRed}>${this.theme.store?.theme === "night" ? msg("Leave red") : msg("Red screen")}</t-button>
    </div>`;
    return html`${renderPageHead(msg("Night"), html`${msg(str`What ${this.sites.store?.siteRow(this.site)?.name ?? this.site} observes by itself.`)} ${(this.overview.value?.state?.site_time_us ?? 0) > 0 ? nothing : html`<t-clock zone=${this.zone}></t-clock>`}`, links)}
    ${this.proposals.value?.observes === false
      ? html`<t-empty heading=${msg("This site does not observe by itself")} icon="live">
          <p>${msg(html`Its description has no section night: with a telescope and a camera. How to write one is in the docs: <em>Observe by itself</em>.`)}</p>
        </t-empty>`
      : renderLoaded(this.overview, msg("the night"), (overview) => this.renderNight(overview))}`;
  }

  private renderNight(overview: SiteNightShape): TemplateResult {
    const ms = siteMs(overview);
    const blocks = nightBlocks(this.takenTonight(ms), plannedBlocks(overview.plan, overview.state, ms));
    const marks = proposalMarks([...(this.proposals.value?.proposals ?? []).map(({ id }) => id), ...blocks.map(({ proposal }) => proposal)].filter((id) => id !== ""));
    const current = blocks.find(({ state }) => state === "current");
    const observed = this.waiting.value?.requests.find(({ id }) => id === overview.state?.request);
    return html`${this.renderStale(overview)} ${this.renderSimulatedTime(overview)}
      <t-night-state
        .site=${this.site}
        .night=${overview.state}
        .target=${observed?.target ?? current?.name ?? ""}
        .morningUs=${this.morningUs(overview, ms)}
        .mayArm=${this.proposals.value?.may_arm === true}
        ?simulated=${overview.simulated}
        .timeLapse=${this.timeLapse(overview)}
        .speed=${overview.state?.speed ?? 0}
        ?online=${this.isOnline(overview)}
        .zone=${this.zone}
        @t-changed=${this.overview.invalidate}
      ></t-night-state>
      <t-night-glance
        .site=${this.site}
        .detail=${this.detail.value ?? null}
        .planned=${this.plannedAims(marks, ms)}
        .target=${observed?.target ?? current?.name ?? ""}
        .step=${overview.state?.step ?? ""}
        .ms=${ms}
        ?online=${this.isOnline(overview)}
      ></t-night-glance>
      <div class="plan-and-log">${this.renderPlan(overview, blocks, marks, ms)} ${this.renderLog()}</div>
      <div class="two">${this.renderWaiting(blocks, overview.state?.request ?? "")} ${this.renderShares(marks)}</div>
      ${this.renderPictures(ms)}`;
  }

  /** What is shown is old, and since when. */
  private renderStale(overview: SiteNightShape): unknown {
    if (this.isOnline(overview)) return nothing;
    const since = overview.state?.heard_us ?? this.sites.store?.siteRow(this.site)?.last_seen_us ?? 0;
    return html`<t-banner kind="warn"
      >${msg(html`The site's gateway cannot be reached: what is shown is old, as it was said <t-time .us=${since} .zone=${this.zone}></t-time>. An armed night goes on without the hub.`)}</t-banner
    >`;
  }

  /** The time there is not the time here. */
  private renderSimulatedTime({ state }: SiteNightShape): unknown {
    if (state === null || state.site_time_us === 0) return nothing;
    return html`<t-banner
      >${msg(html`Time lapse: the time of this simulated observatory is not that of the clock on your wall. It is <t-time .us=${state.site_time_us} .zone=${this.zone}></t-time> there; while its night is armed, time passes ${state.speed.toFixed(0)} times as fast. All times below are its own, but for those of the log.`)}</t-banner
    >`;
  }

  /** The site that lives through nights at high speed, as far as the person may see it. */
  private timeLapse({ time_lapse: name }: SiteNightShape): string {
    return this.sites.store?.siteRow(name) === undefined ? "" : name;
  }

  private renderPlan(overview: SiteNightShape, blocks: readonly NightBlock[], marks: ReadonlyMap<string, ProposalMark>, ms: number): TemplateResult {
    const { plan } = overview;
    const span = this.nightSpan(overview, blocks, ms);
    const place = this.detail.value?.place ?? null;
    return html`<section class="sheet" aria-labelledby="plan">
      <div class="head">
        <div>
          <h2 id="plan">${msg("Tonight")}</h2>
          <p class="muted">
            ${plan === null
              ? msg("No plan yet: the gateway makes one once it has requests.")
              : msg(html`Planned at <t-time .us=${plan.made_us} .zone=${this.zone}></t-time>${boundText(plan.value, plan.bound)}`)}
          </p>
        </div>
      </div>
      <t-plan-timeline .span=${span} .sky=${place === null ? null : nightSky(place, span)} .blocks=${blocks} .marks=${marks} .ms=${ms} .zone=${this.zone}></t-plan-timeline>
      ${blocks.length === 0
        ? nothing
        : html`<details>
            <summary>${msg("As a table")}</summary>
            <div class="plan">${this.renderPlanTable(blocks, marks)}</div>
          </details>`}
    </section>`;
  }

  private renderPlanTable(blocks: readonly NightBlock[], marks: ReadonlyMap<string, ProposalMark>): TemplateResult {
    return renderTable({
      label: msg("Blocks of the night"),
      rows: blocks,
      key: ({ id }) => id,
      columns: [
        { title: msg("Begins"), cell: ({ startMs }) => html`<t-time .us=${startMs * 1000} .zone=${this.zone}></t-time>` },
        { title: msg("Target"), heads: true, cell: ({ name, request }) => (request === "" ? name : html`<a href=${this.requestPath(request)}>${name}</a>`) },
        { title: msg("Proposal"), cell: ({ proposal }) => `${marks.get(proposal)?.letter ?? ""} ${proposal}` },
        { title: msg("Lasts"), cell: ({ startMs, endMs }) => formatDuration((endMs - startMs) / 1000) },
        { title: msg("State"), cell: ({ state }) => BLOCK_WORDS[state] },
        { title: msg("Why"), cell: ({ reason, pauses }) => html`${reason}${map(pauses ?? [], (pause) => html`<div class="muted">${pauseText(pause, this.zone)}</div>`)}` },
      ],
    });
  }

  private renderShares(marks: ReadonlyMap<string, ProposalMark>): TemplateResult {
    const percent = (part: number): string => (Number.isNaN(part) ? "–" : `${(part * 100).toFixed(0)} %`);
    return html`<section class="sheet" aria-labelledby="shares">
      <h2 id="shares">${msg("Share by proposal")}</h2>
      ${renderLoaded(this.proposals, msg("the proposals"), ({ proposals }) =>
        proposals.length === 0
          ? html`<p class="muted">${msg("No proposal is open to you.")}</p>`
          : html`<div class="shares">
              ${renderTable<ShareRow, string>({
                label: msg("Share by proposal"),
                rows: shareRows(proposals),
                key: ({ id }) => id,
                columns: [
                  { title: msg("Proposal"), heads: true, cell: ({ id, title }) => html`<strong>${marks.get(id)?.letter ?? ""}</strong> ${title === "" ? id : title}` },
                  { title: msg("Due"), name: "number", titled: true, cell: ({ due }) => percent(due) },
                  { title: msg("Got"), name: "number", titled: true, cell: ({ got }) => percent(got) },
                  { title: msg("Used"), name: "number", titled: true, cell: ({ usedS, hours }) => msg(str`${fixedText(usedS / 3600, 1)} of ${hours.toFixed(0)} h`) },
                ],
              })}
            </div>`,
      )}
    </section>`;
  }

  private renderWaiting(blocks: readonly NightBlock[], observed: string): TemplateResult {
    const planned = new Set(blocks.filter(({ state }) => state !== "done").map(({ request }) => request));
    return html`<section class="sheet" aria-labelledby="waits">
      <h2 id="waits">${msg("What waits, and why not now")}</h2>
      ${renderLoaded(this.waiting, msg("the requests"), ({ requests }) => {
        const rows = requests.filter(({ id, why_not: why }) => id !== observed && (why !== null || !planned.has(id)));
        return rows.length === 0
          ? html`<p class="muted">${msg("Nothing waits.")} <a href=${`${sitePath(this.site, "requests")}?new=1`}>${msg("Ask for an observation")}</a></p>`
          : renderRows(
              rows,
              ({ id, target, group_name: name, proposal, why_not: why }) => html`<li>
                <div>
                  <a class="name" href=${this.requestPath(id)}>${target === "" ? name || msg("no target") : target}</a>
                  <div>${why === null ? msg("It is not in the newest plan yet.") : why.message}</div>
                  <div class="facts">
                    <span>${proposal}</span>
                    ${why?.planned_us == null ? nothing : html`<span>${msg(html`planned <t-time .us=${why.planned_us} .zone=${this.zone}></t-time>`)}</span>`}
                    ${why?.until_us == null ? nothing : html`<span>${msg(html`until <t-time .us=${why.until_us} .zone=${this.zone}></t-time>`)}</span>`}
                  </div>
                </div>
              </li>`,
            );
      })}
    </section>`;
  }

  private renderPictures(ms: number): TemplateResult {
    return html`<section class="sheet" aria-labelledby="pictures">
      <h2 id="pictures">${msg("Newest pictures of the night")}</h2>
      ${renderLoaded(this.frames, msg("the pictures"), () => {
        const frames = this.framesTonight(ms).slice(0, PICTURES);
        return frames.length === 0
          ? html`<p class="muted">${msg("No picture yet in this night.")} <a href=${sitePath(this.site, "archive")}>${msg("Pictures of other nights")}</a></p>`
          : html`<ul class="pictures" aria-label=${msg("Pictures")}>
              ${repeat(
                frames,
                ({ id }) => id,
                (frame) => html`<li>
                  <a href=${`${sitePath(this.site, "archive")}?frame=${encodeURIComponent(frame.id)}`}>
                    <img alt="" loading="lazy" decoding="async" src=${previewPath(this.site, frame.id, "asinh", 320)} />
                    <span class="name">${frame.target === "" ? frame.kind || msg("No target named") : frame.target}</span>
                    <span class="small">${[frame.filter, frame.exposure_s === null ? "" : `${roundText(frame.exposure_s, 3)} s`].filter(Boolean).join(" · ")}</span>
                    <span class="small"><t-time short .us=${frame.time_us} .zone=${this.zone}></t-time></span>
                  </a>
                </li>`,
              )}
            </ul>`;
      })}
    </section>`;
  }

  private renderLog(): TemplateResult {
    return html`<section class="sheet log" aria-labelledby="log" tabindex="0">
      <div class="head">
        <h2 id="log">${msg("Log")}</h2>
        <div class="actions"><a href=${sitePath(this.site, "logbook")}>${msg("All of the logbook")}</a></div>
      </div>
      ${renderLoaded(this.events, msg("the log"), ({ events }) =>
        events.length === 0
          ? html`<p class="muted">${msg("Nothing has happened yet.")}</p>`
          : renderRows(
              events,
              ({ time_us: time, kind, who, message, good }) => html`<li>
                <div>
                  <div class="facts"><t-time .us=${time} .zone=${this.zone}></t-time>${who === "" ? nothing : html`<span>${who}</span>`}</div>
                  <div>${good ? nothing : html`<t-status kind="bad" word=${msg("look")}></t-status> `}<strong>${eventWords(kind)}</strong> ${message}</div>
                </div>
              </li>`,
            ),
      )}
    </section>`;
  }

  /** Red for eyes that are used to the dark, and back to what was before. */
  private readonly switchRed = (): void => {
    const { store } = this.theme;
    if (store === undefined) return;
    if (store.theme === "night") {
      store.setTheme(this.formerTheme);
      return;
    }
    this.formerTheme = store.theme;
    store.setTheme("night");
  };

  private get zone(): string {
    return this.sites.store?.zoneOf(this.site) ?? "UTC";
  }

  private isOnline(overview: SiteNightShape): boolean {
    return (this.sites.store?.siteRow(this.site)?.online ?? overview.online) && this.link.state === "open";
  }

  private requestPath(id: string): string {
    return `${sitePath(this.site, "requests")}?request=${encodeURIComponent(id)}`;
  }

  private morningUs({ plan }: SiteNightShape, ms: number): number {
    const planned = plan?.night_end_us ?? 0;
    if (planned > ms * 1000) return planned;
    const place = this.detail.value?.place ?? null;
    return place === null ? 0 : (nextMorning(place, ms) ?? 0) * 1000;
  }

  /** The night that is planned or, before there is a plan, the half day round the next morning. */
  private nightSpan({ plan }: SiteNightShape, blocks: readonly NightBlock[], ms: number): SkySpan {
    if (plan !== null && plan.night_end_us / 1000 > ms - HALF_DAY_MS) return nightWindow({ from: plan.night_start_us / 1000, to: plan.night_end_us / 1000 }, blocks);
    const place = this.detail.value?.place ?? null;
    const morning = (place === null ? null : nextMorning(place, ms)) ?? ms + HALF_DAY_MS;
    return nightWindow({ from: morning - 1.2 * HALF_DAY_MS, to: morning }, blocks);
  }

  private framesTonight(ms: number): readonly FrameShape[] {
    const from = ms - 1.5 * HALF_DAY_MS;
    return (this.frames.value?.frames ?? []).filter(({ time_us: time }) => time / 1000 > from);
  }

  private takenTonight(ms: number): readonly NightBlock[] {
    return takenBlocks(this.framesTonight(ms), this.waiting.value?.requests ?? []);
  }

  /** The requests of the plan whose places are wanted for the sky. */
  private plannedRequests(): readonly string[] {
    const ids = (this.overview.value?.plan?.blocks ?? []).map(({ request }) => request).filter((id) => id !== "");
    return [...new Set(ids)].slice(0, AIMS);
  }

  private plannedAims(marks: ReadonlyMap<string, ProposalMark>, ms: number): readonly PlannedAim[] {
    const site = this.detail.value?.place ?? null;
    if (site === null) return [];
    return (this.targets.value ?? []).flatMap(({ request, group }) => {
      const place = targetPlace(request.target);
      const mark = marks.get(group.proposal);
      if (place === null) return [];
      return [{ ...horizontalOf(place, site, ms), name: request.target?.name ?? "", letter: mark?.letter ?? "", colour: mark?.colour ?? 1 }];
    });
  }

  /** Many messages within seconds are one reason to load anew. */
  private scheduleRefresh(): void {
    this.timer ??= setTimeout(() => {
      this.timer = undefined;
      for (const load of [this.overview, this.waiting, this.frames, this.events, this.proposals]) load.invalidate();
    }, REFRESH_MS);
  }
}

/** What time it is at the site: of a simulated one that lives faster, as it said last. */
function siteMs({ state }: SiteNightShape): number {
  return state !== null && state.site_time_us > 0 ? state.site_time_us / 1000 : Date.now();
}

/** How near the plan is to the best there can be. */
function boundText(value: number, bound: number | null): string {
  return bound === null || bound <= 0 ? "." : msg(str`: ${((100 * value) / bound).toFixed(0)} % of what is possible at the most.`);
}

declare global {
  interface HTMLElementTagNameMap {
    "t-page-night": PageNight;
  }
}
