/** The log of a site's robots: the lines that the hub keeps, found by words, level, node and time; new ones come by themselves. */

import { consume } from "@lit/context";
import { msg, str } from "@lit/localize";
import { css, html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, property, state } from "lit/decorators.js";
import { map } from "lit/directives/map.js";
import { boardAtPath } from "../../boards/board-query.js";
import { shownLine } from "../../boards/kept-log.js";
import { findLogLines, listLogNodes } from "../../boards/robot-log-api.js";
import { LOG_LEVELS } from "../../boards/robot-log.js";
import { ContextStoreController } from "../../controllers/context-store.js";
import { FilterForm } from "../../controllers/filter-form.js";
import { InfiniteList } from "../../controllers/infinite-list.js";
import { LoadController } from "../../controllers/load.js";
import { base } from "../../elements/base/base-style.js";
import { settled } from "../../elements/base/stable-field.js";
import { renderOptions } from "../../elements/forms/form-parts.js";
import { forms } from "../../elements/forms/form-style.js";
import { renderPageHead } from "../../elements/layout/page-head.js";
import { sheets } from "../../elements/layout/page-sections.js";
import { formTexts } from "../../format/filter-query.js";
import { formText } from "../../format/form-values.js";
import { knownZone } from "../../format/time.js";
import type { LogLineShape } from "../../generated/api.js";
import { clockOf, momentProblem, type ZoneClock } from "../../series/zone-clock.js";
import { apiContext, routerContext, sitesContext } from "../../state/contexts.js";
import { sitePath, withQuery } from "../../state/router.js";
import type { HubApi } from "../../wire/hub-api.js";
import { causeQuery } from "../cause/cause-words.js";
import { renderInfiniteList } from "../infinite-list-view.js";
import { momentQuery } from "../logbook/logbook-query.js";
import { canGrow, FILTER_KEYS, logPageQuery, NO_FILTER, readLogFilter, writeLogFilter, type LogFilter } from "./log-query.js";
import { LogPages } from "./log-pages.js";
import "../../elements/feedback/banner.js";
import "../../elements/feedback/empty.js";
import "../../elements/feedback/status.js";
import "../../elements/forms/button.js";
import "../../elements/forms/field.js";
import "../../elements/values/time.js";

/** The hub is asked for new lines so often (ms), while somebody looks. */
const AGAIN_MS = 2000;

@customElement("t-page-log")
export class PageLog extends LitElement {
  static override styles = [
    base,
    sheets,
    forms,
    css`
      .line {
        font-family: var(--t-mono);
        font-size: var(--t-size-s);
        white-space: pre-wrap;
        overflow-wrap: anywhere;
      }
      .node {
        overflow-wrap: anywhere;
      }
    `,
  ];

  @property() site = "";
  /** What is written as a time and is none, by field: nothing is filtered by it. */
  @state() private wrongTimes: Readonly<Record<string, string>> = {};
  /** New lines are held back, so that what is read stays where it is. */
  @state() private paused = false;

  @consume({ context: apiContext }) private readonly api!: HubApi;
  private readonly router = new ContextStoreController(this, routerContext);
  private readonly sites = new ContextStoreController(this, sitesContext);
  private readonly nodes = new LoadController<readonly string[]>(this);
  private pages = this.newPages();
  private timer: ReturnType<typeof setInterval> | undefined;
  private readonly list: InfiniteList<LogLineShape> = new InfiniteList<LogLineShape>(this, (before) => this.pages.findRows(before, this.list.rows.length === 0));
  private readonly form = new FilterForm<LogFilter>(
    this,
    (said) => this.readFilter(said),
    (filter) => {
      if (filter === NO_FILTER) this.wrongTimes = {};
      this.router.store?.replace(withQuery(sitePath(this.site, "log"), writeLogFilter(filter)));
    },
    NO_FILTER,
  );
  private asked = "";

  override connectedCallback(): void {
    super.connectedCallback();
    this.timer = setInterval(() => {
      if (!this.paused && !document.hidden && canGrow(this.filter(), Date.now() * 1000)) void this.list.loadNewer();
    }, AGAIN_MS);
  }

  override disconnectedCallback(): void {
    super.disconnectedCallback();
    clearInterval(this.timer);
  }

  override willUpdate(): void {
    if (this.site === "") return;
    this.nodes.load(this.site, async () => (await listLogNodes(this.api, this.site)).nodes);
    const question = `${this.site}\n${writeLogFilter(this.filter())}`;
    if (question !== this.asked) {
      this.asked = question;
      this.pages = this.newPages();
    }
    this.list.load(question);
  }

  override render(): TemplateResult {
    const row = this.sites.store?.siteRow(this.site);
    return html`${renderPageHead(
        msg("Robot's log"),
        msg(str`What the nodes of ${row?.name ?? this.site} wrote, as far as it is kept; newest first.`),
        html`<div class="actions">
          <t-button pressed=${String(!this.paused)} @click=${this.togglePause}>${msg("New lines come by themselves")}</t-button>
          <a href=${sitePath(this.site, "logbook")}>${msg("Logbook")}</a>
          <a href=${sitePath(this.site, "topics")}>${msg("Topics")}</a>
        </div>`,
      )}
      ${row?.online === false ? html`<t-banner kind="warn">${msg("The robot's gateway is not connected: what it writes meanwhile comes when it is back.")}</t-banner>` : nothing}
      ${this.renderSearch(this.filter())}
      ${renderInfiniteList(this.list, { label: msg("Lines"), what: msg("the robot's log"), row: (line) => this.renderLine(line), nothing: () => this.renderEmpty() })}`;
  }

  private renderSearch(filter: LogFilter): TemplateResult {
    const clock = this.clock();
    const time = (name: "from" | "to", label: string, us: number | null): TemplateResult => html`<t-field class="time" label=${`${label} (${clock.zone})`} .error=${momentProblem(this.wrongTimes[name] ?? "", Number.NaN)}>
      <input name=${name} type="text" autocomplete="off" placeholder="2026-03-29 14:05:09" maxlength="30" .value=${settled(this.wrongTimes[name] ?? (us === null ? "" : clock.toInput(us)))} />
    </t-field>`;
    const known = this.nodes.value ?? [];
    // One that has said nothing for long may still stand in the address.
    const nodes = filter.node === "" || known.includes(filter.node) ? known : [filter.node, ...known];
    return html`<section class="sheet" aria-label=${msg("Filter")}>
      <form class="filter" novalidate @submit=${this.form.onSubmit} @input=${this.form.onInput}>
        <t-field label=${msg("Search")}><input name="text" type="search" maxlength="200" autocomplete="off" .value=${settled(filter.text)} /></t-field>
        <t-field label=${msg("From level")}>
          <select name="level">${renderOptions([["", msg("All", { id: "all.levels" })], ...LOG_LEVELS.map(([level, word]) => [String(level), word] as const)], filter.level)}</select>
        </t-field>
        <t-field label=${msg("Node")}>
          <select name="node">${renderOptions([["", msg("All", { id: "all.nodes" })], ...nodes.map((node) => [node, node] as const)], filter.node)}</select>
        </t-field>
        ${time("from", msg("From", { id: "from.time" }), filter.fromUs)} ${time("to", msg("To", { id: "to.time" }), filter.toUs)}
        <t-button kind="quiet" ?disabled=${writeLogFilter(filter) === ""} @click=${this.form.clearFilter}>${msg("Clear")}</t-button>
      </form>
    </section>`;
  }

  private renderLine(kept: LogLineShape): TemplateResult {
    const { timeUs, level, word, node, text, source } = shownLine(kept);
    return html`<li>
      <div>
        <div class="facts">
          <t-time .us=${timeUs} .zone=${this.zone}></t-time>
          ${node === "" ? nothing : html`<span class="node">${node}</span>`}
          ${source === "" ? nothing : html`<span class="node">${source}</span>`}
        </div>
        <div class="line"><t-status kind=${level >= 40 ? "bad" : level >= 30 ? "warn" : "unknown"} word=${word.toLowerCase()}></t-status> ${text}</div>
      </div>
      <div class="ways">
        ${map(
          [
            [msg("Chart"), `${sitePath(this.site, "history")}?${momentQuery(timeUs)}`],
            [msg("Board then"), boardAtPath(this.site, timeUs)],
            [msg("Cause"), `${sitePath(this.site, "cause")}?${causeQuery(timeUs)}`],
          ] as const,
          ([name, path]) => html`<a href=${path}>${name}</a>`,
        )}
      </div>
    </li>`;
  }

  private renderEmpty(): TemplateResult {
    if (writeLogFilter(this.filter()) !== "") {
      return html`<t-empty heading=${msg("No matches")} icon="logbook">
        <p>${msg("No line that is kept is like this.")}</p>
        <t-button @click=${this.form.clearFilter}>${msg("Show everything")}</t-button>
      </t-empty>`;
    }
    return html`<t-empty heading=${msg("No line is kept yet")} icon="logbook">
      <p>${msg(html`Of a robot with ROS, warnings and worse are kept as they come. From which level on is said by <code>keep_log</code> in the site's description; a site without ROS has no such log.`)}</p>
    </t-empty>`;
  }

  private newPages(): LogPages {
    return new LogPages((place) => findLogLines(this.api, this.site, logPageQuery(this.filter(), place)));
  }

  private readonly togglePause = (): void => {
    this.paused = !this.paused;
  };

  private get zone(): string {
    return this.sites.store?.zoneOf(this.site) ?? "UTC";
  }

  private clock(): ZoneClock {
    return clockOf(knownZone(this.zone));
  }

  private filter(): LogFilter {
    return readLogFilter(this.router.store?.search ?? "");
  }

  private readFilter(said: FormData): LogFilter {
    const time = (name: "from" | "to"): number | null => {
      const text = formText(said, name);
      const us = this.clock().fromInput(text);
      const others = Object.entries(this.wrongTimes).filter(([other]) => other !== name);
      this.wrongTimes = Object.fromEntries(momentProblem(text, us) === "" ? others : [...others, [name, text]]);
      return Number.isNaN(us) ? null : us;
    };
    return { ...formTexts(said, FILTER_KEYS), fromUs: time("from"), toUs: time("to") };
  }
}

declare global {
  interface HTMLElementTagNameMap {
    "t-page-log": PageLog;
  }
}
