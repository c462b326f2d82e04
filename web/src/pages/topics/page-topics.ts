/** The raw topics of a site that a person may follow, and one of them. */

import { consume } from "@lit/context";
import { msg, str } from "@lit/localize";
import { css, html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, property, state } from "lit/decorators.js";
import { repeat } from "lit/directives/repeat.js";
import { ConnectionStateController } from "../../controllers/connection-state.js";
import { ContextStoreController } from "../../controllers/context-store.js";
import { LoadController } from "../../controllers/load.js";
import { base } from "../../elements/base/base-style.js";
import { renderLoaded } from "../../elements/feedback/load-state.js";
import { control } from "../../elements/forms/input-style.js";
import { renderPageHead } from "../../elements/layout/page-head.js";
import { sheets } from "../../elements/layout/page-sections.js";
import type { SiteShape, TopicShape, TopicTable } from "../../generated/api.js";
import { apiContext, routerContext, sitesContext } from "../../state/contexts.js";
import { sitePath, topicPagePath } from "../../state/router.js";
import type { HubApi } from "../../wire/hub-api.js";
import { TopicsApi } from "../../topics/topics-api.js";
import { filterTopics, rateText, whoMaySee } from "./topic-list.js";
import "../../elements/feedback/banner.js";
import "../../elements/feedback/empty.js";
import "../../elements/feedback/problem.js";
import "./topic-detail.js";

/** Topics come and go, and rates become known; it is asked so often (ms). */
const AGAIN_MS = 5000;

@customElement("t-page-topics")
export class PageTopics extends LitElement {
  static override styles = [
    base,
    sheets,
    control,
    css`
      .both {
        display: grid;
        grid-template-columns: minmax(16rem, 24rem) minmax(0, 1fr);
        align-items: start;
        gap: var(--t-space-4);
      }
      .both.list-only {
        grid-template-columns: minmax(0, 1fr);
      }
      .rows > li {
        grid-template-columns: minmax(0, 1fr);
        padding-block: 0;
      }
      .rows a {
        display: grid;
        gap: 0;
        padding-block: var(--t-space-2);
        min-block-size: var(--t-touch);
        color: inherit;
        text-decoration: none;
        align-content: center;
      }
      .rows a:hover .name,
      .rows a[aria-current] .name {
        color: var(--t-accent);
        text-decoration: underline;
      }
      .rows a[aria-current] {
        border-inline-start: 3px solid var(--t-accent);
        padding-inline-start: var(--t-space-3);
      }
      .name {
        font-family: var(--t-mono);
      }
      .all {
        display: none;
        align-items: center;
        min-block-size: var(--t-touch);
        font-weight: var(--t-weight-strong);
      }
      @media (max-width: 60rem) {
        /* The list is not beside it there. */
        .all {
          display: inline-flex;
        }
        .both {
          grid-template-columns: minmax(0, 1fr);
        }
        .both:not(.list-only) > .sheet {
          display: none;
        }
      }
    `,
  ];

  @property() site = "";

  @consume({ context: apiContext }) private api: HubApi | undefined;
  @state() private words = "";
  private readonly router = new ContextStoreController(this, routerContext);
  private readonly sites = new ContextStoreController(this, sitesContext);
  private readonly link = new ConnectionStateController(this);
  private readonly detail = new LoadController<SiteShape>(this);
  private readonly topics = new LoadController<TopicTable>(this);
  private timer: ReturnType<typeof setInterval> | undefined;
  /** A list that was had once stays, also when the next one cannot be had. */
  private known: TopicTable | undefined;
  private knownOf = "";

  override connectedCallback(): void {
    super.connectedCallback();
    this.timer = setInterval(() => {
      if (!document.hidden) this.topics.invalidate();
    }, AGAIN_MS);
  }

  override disconnectedCallback(): void {
    super.disconnectedCallback();
    clearInterval(this.timer);
  }

  protected override willUpdate(): void {
    const { api, site } = this;
    const sites = this.sites.store;
    if (api === undefined || sites === undefined || site === "") return;
    this.detail.load(`${site} ${sites.catalogueOf(site)}`, () => sites.loadDetail(site));
    this.topics.load(`${site} ${String(this.isOnline())}`, () => new TopicsApi(api, site).listTopics());
    if (this.knownOf !== site) this.known = undefined;
    if (this.topics.result.state === "ready") {
      this.known = this.topics.result.value;
      this.knownOf = site;
    }
  }

  override render(): TemplateResult {
    const name = this.sites.store?.siteRow(this.site)?.name ?? this.site;
    return html`${renderPageHead(
        msg("Topics"),
        msg(str`What the robot of ${name} publishes, as it comes. It is heard for this only while you look.`),
        html`<div class="actions"><a href=${sitePath(this.site, "scene")}>${msg("Scene")}</a> <a href=${sitePath(this.site, "live")}>${msg("Real-time")}</a></div>`,
      )}
      ${this.known === undefined ? renderLoaded(this.topics, msg("the topics"), (table) => this.renderContent(table)) : this.renderContent(this.known)}`;
  }

  private renderContent({ topics }: TopicTable): TemplateResult {
    const chosen = this.chosenTopic();
    if (topics.length === 0 && chosen === "") return this.renderEmpty();
    const known = topics.find(({ topic }) => topic === chosen);
    return html`${this.isOnline() ? nothing : html`<t-banner kind="warn">${msg("The robot's gateway is not connected; these are the topics that it had.")}</t-banner>`}
      <div class=${chosen === "" ? "both list-only" : "both"}>
        ${this.renderList(topics, chosen)}
        ${chosen === ""
          ? nothing
          : known !== undefined
            ? html`<t-topic .site=${this.site} .topic=${chosen} .type=${known.type} asked=${this.askedSignal()} .online=${this.isOnline()}></t-topic>`
            : html`<div>
                <t-problem what=${msg(str`There is no topic ${chosen} that you may follow.`)} how=${msg("The robot does not publish it now, or it is not yours to see. An admin names topics and rights in the site's description, under topics.")}></t-problem>
                <a class="all" href=${sitePath(this.site, "topics")}>${msg("All topics")}</a>
              </div>`}
      </div>`;
  }

  private renderList(topics: readonly TopicShape[], chosen: string): TemplateResult {
    const shown = filterTopics(topics, this.words);
    return html`<section class="sheet" aria-label=${msg("All topics")}>
      <input type="search" aria-label=${msg("Filter topics")} placeholder=${msg("Name or type")} .value=${this.words} @input=${this.onFilter} />
      ${shown.length === 0
        ? html`<p class="muted" role="status">${msg("No topic is called so.")}</p>`
        : html`<ul class="rows">
            ${repeat(
              shown,
              ({ topic }) => topic,
              (row) => this.renderRow(row, row.topic === chosen),
            )}
          </ul>`}
    </section>`;
  }

  private renderRow(one: TopicShape, current: boolean): TemplateResult {
    const rate = rateText(one.rate);
    return html`<li>
      <a href=${topicPagePath(this.site, one.topic)} aria-current=${current ? "true" : nothing}>
        <span class="name">${one.topic}</span>
        <span class="facts">
          <span>${one.type}</span>
          ${rate === "" ? nothing : html`<span>${rate}</span>`}
          ${one.latched ? html`<span>${msg("latched", { id: "latched.topic" })}</span>` : nothing}
          <span>${whoMaySee(one, this.detail.value)}</span>
          ${one.problem === "" ? nothing : html`<span>${one.problem}</span>`}
        </span>
      </a>
    </li>`;
  }

  private renderEmpty(): TemplateResult {
    return this.isOnline()
      ? html`<t-empty heading=${msg("No topics")} icon="live">
          <p>${msg(html`The robot publishes none that you may follow. An admin opens them in the site's description, under <code>topics:</code>.`)}</p>
        </t-empty>`
      : html`<t-empty heading=${msg("The gateway is away")} icon="unlinked"><p>${msg("The robot's topics are listed when its gateway has connected.")}</p></t-empty>`;
  }

  private isOnline(): boolean {
    return this.sites.store?.siteRow(this.site)?.online === true && this.link.state === "open";
  }

  private chosenTopic(): string {
    return new URLSearchParams(this.router.store?.search ?? "").get("topic") ?? "";
  }

  /** The field that the address asks to make a signal of. */
  private askedSignal(): string {
    return new URLSearchParams(this.router.store?.search ?? "").get("signal") ?? "";
  }

  private readonly onFilter = (event: Event): void => {
    if (event.target instanceof HTMLInputElement) this.words = event.target.value;
  };
}

declare global {
  interface HTMLElementTagNameMap {
    "t-page-topics": PageTopics;
  }
}
