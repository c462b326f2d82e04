/** Tonight and the week: the sky of each night, its plan as a line, chances of what waits, why it waits, hours by proposal. */

import { consume } from "@lit/context";
import { msg, str } from "@lit/localize";
import { css, html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, property, state } from "lit/decorators.js";
import { map } from "lit/directives/map.js";
import { ConnectionStateController } from "../../controllers/connection-state.js";
import { ContextStoreController } from "../../controllers/context-store.js";
import { LoadController } from "../../controllers/load.js";
import { TickerController } from "../../controllers/ticker.js";
import { base } from "../../elements/base/base-style.js";
import { styled } from "../../elements/base/style-directive.js";
import { renderLoaded } from "../../elements/feedback/load-state.js";
import { renderTable, tables } from "../../elements/layout/data-table.js";
import { renderPageHead } from "../../elements/layout/page-head.js";
import { sheets } from "../../elements/layout/page-sections.js";
import { renderRows } from "../../elements/layout/rows.js";
import { formatChance } from "../../format/chance.js";
import { formatDuration } from "../../format/duration.js";
import { intlLocale } from "../../words/locale.js";
import { fixedText } from "../../format/number.js";
import { PHASE_WORDS } from "../../format/observing-words.js";
import { plural } from "../../words/plural.js";
import { formatDate } from "../../format/time.js";
import type { ForecastShape, ProposalList, RequestList, SiteNightShape, SiteShape, WeekNightShape, WeekShape } from "../../generated/api.js";
import { nightWindow, proposalMarks, type ProposalMark } from "../../series/plan-layout.js";
import { nightSky } from "../../sky/night-sky.js";
import { apiContext, sitesContext } from "../../state/contexts.js";
import { sitePath } from "../../state/router.js";
import type { HubApi } from "../../wire/hub-api.js";
import { ObservingApi } from "../../wire/observing-api.js";
import { plannedBlocks } from "../../series/night-blocks.js";
import { chanceRows, expectedShares, skyFacts, type ChanceRow, type ExpectedShare } from "./forecast-rows.js";
import "../../elements/feedback/empty.js";
import "../../elements/feedback/status.js";
import "../../elements/observatory/plan-timeline.js";
import "../../elements/values/time.js";

/** A newer forecast is asked for so often (ms). */
const EVERY_MS = 30_000;
const DONE = 10;

@customElement("t-page-forecast")
export class PageForecast extends LitElement {
  static override styles = [
    base,
    sheets,
    tables,
    css`
      .two {
        display: grid;
        grid-template-columns: repeat(auto-fit, minmax(min(26rem, 100%), 1fr));
        align-items: start;
        gap: var(--t-space-4);
      }
      details[open] > summary {
        margin-block-end: var(--t-space-2);
      }
      .shares {
        --t-columns: minmax(7rem, 1fr) 4rem 4rem 6rem 7rem;
      }
    `,
  ];

  @property() site = "";
  /** Which nights beside tonight are drawn: those that were opened. */
  @state() private opened: ReadonlySet<number> = new Set();

  @consume({ context: apiContext }) private readonly api!: HubApi;
  private readonly sites = new ContextStoreController(this, sitesContext);
  private readonly detail = new LoadController<SiteShape>(this);
  private readonly overview = new LoadController<SiteNightShape>(this);
  private readonly proposals = new LoadController<ProposalList>(this);
  private readonly week = new LoadController<WeekShape>(this);
  private readonly tonight = new LoadController<ForecastShape>(this);
  private readonly done = new LoadController<RequestList>(this);

  constructor() {
    super();
    new TickerController(this, EVERY_MS);
    new ConnectionStateController(this, (connection) => [
      connection.onMessage("observing_request", (news) => {
        if (news.site === this.site) this.done.invalidate();
      }),
      connection.onMessage("night", (news) => {
        if (news.site === this.site) this.overview.invalidate();
      }),
    ]);
  }

  override willUpdate(): void {
    const { site } = this;
    const sites = this.sites.store;
    const api = new ObservingApi(this.api, site);
    if (sites !== undefined) this.detail.load(`${site} ${sites.catalogueOf(site)}`, () => sites.loadDetail(site));
    this.overview.load(site, () => api.nightOverview());
    this.proposals.load(site, () => api.listProposals());
    this.done.load(site, () => api.findRequests(`state=COMPLETED&limit=${String(DONE)}`));
    if (this.proposals.value?.observes !== true) return;
    // Asked again with the clock; the hub gives what it has, and makes a newer one beside that.
    const turn = String(Math.floor(Date.now() / EVERY_MS));
    this.week.load(`${site} ${turn}`, () => api.weekForecast());
    const made = this.week.value?.made_us;
    if (made !== undefined) this.tonight.load(`${site} ${String(made)}`, () => api.nightForecast());
  }

  override render(): TemplateResult {
    const links = html`<div class="actions">
      <a href=${sitePath(this.site, "night")}>${msg("Night")}</a>
      <a href=${sitePath(this.site, "requests")}>${msg("Requests")}</a>
      <a href=${sitePath(this.site, "proposals")}>${msg("Proposals")}</a>
    </div>`;
    return html`${renderPageHead(msg("Forecast"), msg(str`What the nights of ${this.sites.store?.siteRow(this.site)?.name ?? this.site} would bring, by what waits now.`), links)}
    ${renderLoaded(this.proposals, msg("the proposals"), ({ observes }) =>
      observes
        ? renderLoaded(this.week, msg("the week, which takes up to a minute the first time"), (week) => this.renderWeek(week))
        : html`<t-empty heading=${msg("This site does not observe by itself")} icon="live"><p>${msg("Its description has no section night.")}</p></t-empty>`,
    )}`;
  }

  private renderWeek(week: WeekShape): TemplateResult {
    const known = this.proposals.value?.proposals ?? [];
    const planned = week.nights.flatMap(({ plan }) => plan.blocks.map(({ proposal }) => proposal));
    const marks = proposalMarks([...known.map(({ id }) => id), ...planned].filter((id) => id !== ""));
    const [tonight] = week.nights;
    return html`<p role="status">${this.ageText(week)}</p>
      ${tonight === undefined ? nothing : html`<section class="sheet" aria-labelledby="tonight"><h2 id="tonight">${this.nightName(tonight, 0)}</h2>${this.renderNow()}${this.renderNight(tonight, marks)}</section>`}
      ${this.renderLaterNights(week.nights, marks)} ${this.renderChances(week)}
      <div class="two">${this.renderShares(week, marks)} ${this.renderDone()}</div>
      ${this.renderReasons()}`;
  }

  /** How old it is, and what it takes for granted. */
  private ageText({ made_us: made, renewing, open_share: open }: WeekShape): TemplateResult {
    const age = Math.max(0, Date.now() / 1000 - made / 1e6);
    return html`${renewing ? msg(str`Worked out ${age < 60 ? msg("less than a minute") : formatDuration(Math.floor(age / 60) * 60)} ago; a newer one is under way. Plans are for a clear sky; a chance counts with a roof that is open ${(open * 100).toFixed(0)} % of the time, for nobody here knows the weather to come.`) : msg(str`Worked out ${age < 60 ? msg("less than a minute") : formatDuration(Math.floor(age / 60) * 60)} ago. Plans are for a clear sky; a chance counts with a roof that is open ${(open * 100).toFixed(0)} % of the time, for nobody here knows the weather to come.`)}`;
  }

  /** How the night stands now: whether it is armed, and what the weather and the roof say. */
  private renderNow(): TemplateResult | typeof nothing {
    const now = this.overview.value?.state ?? null;
    if (now === null) return nothing;
    const { word, kind, meaning } = PHASE_WORDS[now.phase];
    return html`<p><t-status kind=${kind} word=${word}></t-status> ${now.why === "" ? meaning : `${now.why}.`}</p>`;
  }

  private renderLaterNights(nights: readonly WeekNightShape[], marks: ReadonlyMap<string, ProposalMark>): TemplateResult | typeof nothing {
    if (nights.length < 2) return nothing;
    return html`<section class="sheet" aria-labelledby="later">
      <h2 id="later">${msg("The nights after it")}</h2>
      ${map(nights.slice(1), (night, i) => {
        const at = i + 1;
        return html`<details ?open=${this.opened.has(at)} @toggle=${this.toggler(at)}>
          <summary>${this.nightName(night, at)}: ${plural(night.planned, msg("one request"), msg(str`${String(night.planned)} requests`))}</summary>
          ${this.opened.has(at) ? this.renderNight(night, marks) : nothing}
        </details>`;
      })}
    </section>`;
  }

  private renderNight(night: WeekNightShape, marks: ReadonlyMap<string, ProposalMark>): TemplateResult {
    const place = this.detail.value?.place ?? null;
    const blocks = plannedBlocks(night.plan, null, Date.now());
    if (night.end_us <= night.start_us) return html`<p>${msg("The Sun does not get 6° below the horizon.")}</p>`;
    const span = nightWindow({ from: night.start_us / 1000, to: night.end_us / 1000 }, blocks);
    const sky = place === null ? null : nightSky(place, span);
    const facts = sky === null ? null : skyFacts(sky);
    return html`${facts === null
        ? nothing
        : html`<p>
            ${facts.darkMs === 0 ? msg(str`No full darkness; the Moon is ${(facts.moonLit * 100).toFixed(0)} % lit.`) : msg(str`Dark for ${formatDuration(facts.darkMs / 1000)}, ${facts.moonlessMs === 0 ? msg("none", { id: "none.time" }) : formatDuration(facts.moonlessMs / 1000)} of it without the Moon, which is ${(facts.moonLit * 100).toFixed(0)} % lit.`)}
          </p>`}
      ${blocks.length === 0 ? html`<p class="muted">${msg("Nothing is planned in it.")}</p>` : nothing}
      <t-plan-timeline .span=${span} .sky=${sky} .blocks=${blocks} .marks=${marks} .ms=${Date.now()} .zone=${this.zone}></t-plan-timeline>`;
  }

  private renderChances({ nights }: WeekShape): TemplateResult {
    const rows = chanceRows(nights);
    const columns = `minmax(8rem, 2fr) repeat(${String(nights.length)}, minmax(3.5rem, 1fr)) 5rem`;
    return html`<section class="sheet" aria-labelledby="chances">
      <h2 id="chances">${msg("Chance of each request")}</h2>
      ${rows.length === 0
        ? html`<p class="muted">${msg("Nothing that is open to you is planned.")} <a href=${`${sitePath(this.site, "requests")}?new=1`}>${msg("Ask for an observation")}</a></p>`
        : html`<div ${styled({ "--t-columns": columns })}>
            ${renderTable<ChanceRow, string>({
              label: msg("Chance of each request"),
              rows,
              key: ({ id }) => id,
              columns: [
                { title: msg("Request"), heads: true, cell: ({ id, target, proposal }) => html`<a href=${this.requestPath(id)}>${target === "" ? msg("no target") : target}</a> <span class="muted small">${proposal}</span>` },
                ...nights.map((night, at) => ({
                  title: at === 0 ? msg("Tonight") : this.dayName(night),
                  name: "number",
                  titled: true,
                  cell: ({ chances }: ChanceRow) => (chances[at] ? formatChance(chances[at]) : "–"),
                })),
                { title: msg("In all"), name: "number", titled: true, cell: ({ all }) => html`<strong>${formatChance(all)}</strong>` },
              ],
            })}
          </div>`}
    </section>`;
  }

  private renderShares(week: WeekShape, marks: ReadonlyMap<string, ProposalMark>): TemplateResult {
    const rows = expectedShares(week, this.proposals.value?.proposals ?? []);
    const percent = (part: number): string => (Number.isNaN(part) ? "–" : `${(part * 100).toFixed(0)} %`);
    return html`<section class="sheet" aria-labelledby="shares">
      <h2 id="shares">${msg("Share by proposal")}</h2>
      ${rows.length === 0
        ? html`<p class="muted">${msg("No proposal is open to you.")}</p>`
        : html`<div class="shares">
            ${renderTable<ExpectedShare, string>({
              label: msg("Share by proposal"),
              rows,
              key: ({ id }) => id,
              columns: [
                { title: msg("Proposal"), heads: true, cell: ({ id, title }) => html`<strong>${marks.get(id)?.letter ?? ""}</strong> ${title === "" ? id : title}` },
                { title: msg("Due"), name: "number", titled: true, cell: ({ due }) => percent(due) },
                { title: msg("Gets"), name: "number", titled: true, cell: ({ got }) => percent(got) },
                { title: msg("In the mean"), name: "number", titled: true, cell: ({ expectedS }) => `${fixedText(expectedS / 3600, 1)} h` },
                { title: msg("Has left"), name: "number", titled: true, cell: ({ leftS, hours }) => msg(str`${fixedText(leftS / 3600, 1)} of ${hours.toFixed(0)} h`) },
              ],
            })}
          </div>`}
    </section>`;
  }

  private renderDone(): TemplateResult {
    return html`<section class="sheet" aria-labelledby="done">
      <h2 id="done">${msg("Done last")}</h2>
      ${renderLoaded(this.done, msg("what is done"), ({ requests }) =>
        requests.length === 0
          ? html`<p class="muted">${msg("Nothing that is open to you is done yet.")}</p>`
          : renderRows(
              requests,
              ({ id, target, group_name: name, proposal, changed_us: changed }) => html`<li>
                <div>
                  <a class="name" href=${this.requestPath(id)}>${target === "" ? name || msg("no target") : target}</a>
                  <div class="facts"><span>${proposal}</span><t-time short .us=${changed} .zone=${this.zone}></t-time></div>
                </div>
              </li>`,
            ),
      )}
    </section>`;
  }

  private renderReasons(): TemplateResult {
    return html`<section class="sheet" aria-labelledby="waits">
      <h2 id="waits">${msg("What waits longer than tonight, and why")}</h2>
      ${renderLoaded(this.tonight, msg("the reasons"), ({ reasons, more }) =>
        reasons.length === 0
          ? html`<p class="muted">${msg("All that is open to you and waits is planned tonight.")}</p>`
          : html`${renderRows(
              reasons.map((reason) => ({ ...reason, id: reason.request })),
              ({ request, target, why_not: why }) => html`<li>
                <div>
                  <a class="name" href=${this.requestPath(request)}>${target === "" ? msg("no target") : target}</a>
                  <div>${why.message}</div>
                </div>
              </li>`,
            )}
            ${more ? html`<p class="muted">${msg("And more.")}</p>` : nothing}`,
      )}
    </section>`;
  }

  private toggler(at: number): (event: Event) => void {
    return (event) => {
      const isOpen = event.target instanceof HTMLDetailsElement && event.target.open;
      const opened = new Set(this.opened);
      if (isOpen) opened.add(at);
      else opened.delete(at);
      if (this.opened.has(at) !== isOpen) this.opened = opened;
    };
  }

  private nightName(night: WeekNightShape, at: number): string {
    const date = formatDate(night.start_us, this.zone);
    return at === 0 ? (night.start_us > Date.now() * 1000 ? msg(str`The next night, ${date}`) : msg(str`Tonight, ${date}`)) : date;
  }

  private dayName({ start_us: start }: WeekNightShape): string {
    return new Intl.DateTimeFormat(intlLocale(), { weekday: "short", day: "numeric", timeZone: this.zone }).format(start / 1000);
  }

  private get zone(): string {
    return this.sites.store?.zoneOf(this.site) ?? "UTC";
  }

  private requestPath(id: string): string {
    return `${sitePath(this.site, "requests")}?request=${encodeURIComponent(id)}`;
  }
}

declare global {
  interface HTMLElementTagNameMap {
    "t-page-forecast": PageForecast;
  }
}
