/** The logbook of a site: commands, alarms, sightings, interlocks, connections; who and why. */

import { consume } from "@lit/context";
import { css, html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, property, query, state } from "lit/decorators.js";
import { map } from "lit/directives/map.js";
import { repeat } from "lit/directives/repeat.js";
import { LinkController } from "../../controllers/link.js";
import { StoreController } from "../../controllers/store.js";
import { base } from "../../elements/base.js";
import { sheets } from "../../elements/sheets.js";
import { adviceFor } from "../../format/problem.js";
import { apiContext, routerContext, sitesContext } from "../../state/contexts.js";
import { sitePath } from "../../state/router.js";
import { AlarmsApi, type EventShape } from "../../wire/alarms.js";
import type { HubApi } from "../../wire/http.js";
import { KINDS, momentQuery, NO_FILTER, pageQuery, readFilter, writeFilter, type LogbookFilter } from "./query.js";
import "../../elements/button.js";
import "../../elements/empty.js";
import "../../elements/field.js";
import "../../elements/loading.js";
import "../../elements/problem.js";
import "../../elements/status.js";
import "../../elements/time.js";

const ROWS = 50;
/** What happens is seen this soon afterwards: the hub writes it down first (ms). */
const SOON_MS = 600;
const TYPING_MS = 400;

@customElement("t-page-logbook")
export class PageLogbook extends LitElement {
  static override styles = [
    base,
    sheets,
    css`
      form {
        display: grid;
        grid-template-columns: repeat(auto-fill, minmax(min(12rem, 100%), 1fr));
        align-items: end;
        gap: var(--t-space-3);
      }
      label.tick {
        display: flex;
        align-items: center;
        gap: var(--t-space-2);
        min-block-size: var(--t-touch);
      }
      .message {
        overflow-wrap: anywhere;
      }
      .ways {
        display: flex;
        flex-wrap: wrap;
        gap: 0 var(--t-space-3);
      }
      .ways a {
        display: inline-flex;
        align-items: center;
        min-block-size: var(--t-touch);
        font-weight: var(--t-weight-strong);
      }
      .end {
        min-block-size: 2rem;
        color: var(--t-muted);
      }
    `,
  ];

  @property() site = "";

  @state() private rows: readonly EventShape[] = [];
  @state() private more = true;
  @state() private loading = false;
  @state() private failure: unknown = null;
  @query(".end") private readonly end!: HTMLElement | null;

  @consume({ context: apiContext }) private readonly api!: HubApi;
  private readonly router = new StoreController(this, routerContext);
  private readonly sites = new StoreController(this, sitesContext);
  private shown: string | null = null;
  private run = 0;
  private timer: ReturnType<typeof setTimeout> | undefined;
  private readonly watcher = new IntersectionObserver((entries) => {
    if (entries.some(({ isIntersecting }) => isIntersecting)) void this.older();
  });

  constructor() {
    super();
    new LinkController(this, (connection) => [
      connection.on("event", (news) => {
        if (news.site === this.site) this.soon(SOON_MS, () => void this.newer());
      }),
    ]);
  }

  override disconnectedCallback(): void {
    super.disconnectedCallback();
    this.watcher.disconnect();
    clearTimeout(this.timer);
  }

  override willUpdate(): void {
    const written = `${this.site}\n${writeFilter(this.filter())}`;
    if (written === this.shown) return;
    this.shown = written;
    this.rows = [];
    this.more = true;
    this.failure = null;
    this.run += 1;
    this.loading = false;
    void this.older();
  }

  override updated(): void {
    this.watcher.disconnect();
    if (this.end !== null && this.more && this.failure === null) this.watcher.observe(this.end);
  }

  override render(): TemplateResult {
    const filter = this.filter();
    return html`<div class="head">
        <div>
          <h1>Logbook</h1>
          <p class="muted">What happened at ${this.sites.store?.row(this.site)?.name ?? this.site}, who did it and why; newest first.</p>
        </div>
        <div class="actions">
          <a href="/alarms">Alarms</a>
          <a href=${sitePath(this.site, "history")}>History</a>
        </div>
      </div>
      <section class="sheet" aria-label="Filter">
        <form novalidate @submit=${this.chosen} @input=${this.typed}>
          <t-field label="Search"><input name="text" type="search" maxlength="200" autocomplete="off" .value=${filter.text} /></t-field>
          <t-field label="What">
            <select name="kind">
              ${map(KINDS, ({ kind, name }) => html`<option value=${kind} ?selected=${kind === filter.kind}>${name}</option>`)}
            </select>
          </t-field>
          <t-field label="Who"><input name="who" maxlength="200" autocomplete="off" .value=${filter.who} /></t-field>
          <t-field label="Device"><input name="device" maxlength="200" autocomplete="off" .value=${filter.device} /></t-field>
          <label class="tick"><input name="bad" type="checkbox" ?checked=${filter.bad} /> Only what went wrong</label>
        </form>
      </section>
      ${this.content(filter)}`;
  }

  private content(filter: LogbookFilter): TemplateResult {
    const advice = this.failure === null ? null : adviceFor(this.failure, "the logbook");
    const empty = this.rows.length === 0 && !this.more;
    return html`${empty
        ? html`<t-empty heading="Nothing fits" icon="logbook">
            <p>${writeFilter(filter) === "" ? "Nothing has happened yet." : "Nothing in the logbook is like this."}</p>
            ${writeFilter(filter) === "" ? nothing : html`<t-button @click=${this.clear}>Show everything</t-button>`}
          </t-empty>`
        : nothing}
      ${this.rows.length === 0
        ? nothing
        : html`<section class="sheet" aria-label="Events" aria-busy=${this.loading}>
            <ul class="rows">
              ${repeat(
                this.rows,
                ({ id }) => id,
                (row) => this.row(row),
              )}
            </ul>
          </section>`}
      ${advice === null ? nothing : html`<t-problem what=${advice.what} how=${advice.how} retry="Try again" @t-retry=${this.again}></t-problem>`}
      ${this.loading ? html`<t-loading what="Loading the logbook"></t-loading>` : nothing}
      <p class="end">${this.more || empty ? "" : "This is where it begins."}</p>`;
  }

  private row(row: EventShape): TemplateResult {
    const zone = this.sites.store?.zoneOf(this.site) ?? "UTC";
    const recorded = row.kind.startsWith("recording");
    return html`<li>
      <div>
        <div class="facts">
          <t-time .us=${row.time_us} .zone=${zone}></t-time>
          ${row.who === "" ? nothing : html`<span>${row.who}</span>`}
          ${row.device === "" ? nothing : html`<span>${row.device}</span>`}
        </div>
        <div class="name">${row.good ? nothing : html`<t-status kind="bad" word="look"></t-status> `}${row.kind.replaceAll("_", " ")}</div>
        ${row.message === "" ? nothing : html`<div class="message">${row.message}</div>`}
      </div>
      <div class="ways">
        <a href=${`${sitePath(this.site, "history")}?${momentQuery(row.time_us)}`}>Chart</a>
        ${recorded ? html`<a href=${sitePath(this.site, "recordings")}>Recordings</a>` : nothing}
        ${row.kind.startsWith("alarm") ? html`<a href="/alarms">Alarms</a>` : nothing}
      </div>
    </li>`;
  }

  private filter(): LogbookFilter {
    return readFilter(this.router.store?.search ?? "");
  }

  private async older(): Promise<void> {
    if (this.loading || !this.more || this.failure !== null) return;
    const run = this.run;
    this.loading = true;
    try {
      const found = await new AlarmsApi(this.api).events(this.site, pageQuery(this.filter(), this.rows.at(-1)?.id ?? "", ROWS));
      if (run !== this.run) return;
      this.rows = [...this.rows, ...found.events];
      this.more = found.more;
    } catch (error) {
      if (run === this.run) this.failure = error;
    } finally {
      if (run === this.run) this.loading = false;
    }
  }

  /** Puts what has happened since above the rest. */
  private async newer(): Promise<void> {
    const run = this.run;
    try {
      const found = await new AlarmsApi(this.api).events(this.site, pageQuery(this.filter(), "", ROWS));
      if (run !== this.run) return;
      const first = this.rows.findIndex(({ id }) => id === found.events.at(-1)?.id);
      // More than a page has happened: begin anew.
      this.rows = first < 0 && this.rows.length > 0 && found.more ? found.events : [...found.events, ...this.rows.filter(({ id }) => !found.events.some((one) => one.id === id))];
      if (this.rows === found.events) this.more = found.more;
    } catch {
      // The next event, or the next page, tries again.
    }
  }

  private soon(ms: number, then: () => void): void {
    clearTimeout(this.timer);
    this.timer = setTimeout(then, ms);
  }

  private readonly again = (): void => {
    this.failure = null;
    void this.older();
  };

  private readonly clear = (): void => {
    this.go(NO_FILTER);
  };

  private readonly typed = (event: Event): void => {
    const form = event.currentTarget;
    if (!(form instanceof HTMLFormElement)) return;
    this.soon(event.target instanceof HTMLInputElement && event.target.type !== "checkbox" ? TYPING_MS : 0, () => {
      this.choose(form);
    });
  };

  private readonly chosen = (event: Event): void => {
    event.preventDefault();
    if (event.currentTarget instanceof HTMLFormElement) this.choose(event.currentTarget);
  };

  private choose(form: HTMLFormElement): void {
    const data = new FormData(form);
    const text = (key: string): string => {
      const value = data.get(key);
      return typeof value === "string" ? value.trim() : "";
    };
    this.go({ text: text("text"), kind: text("kind"), device: text("device"), who: text("who"), bad: data.has("bad") });
  }

  private go(filter: LogbookFilter): void {
    const written = writeFilter(filter);
    this.router.store?.replace(`${sitePath(this.site, "logbook")}${written === "" ? "" : `?${written}`}`);
  }
}

declare global {
  interface HTMLElementTagNameMap {
    "t-page-logbook": PageLogbook;
  }
}
