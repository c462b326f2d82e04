/** From an anomaly, alarm or event to its cause: all that was unusual, asked for, seen and said in that minute. */

import { consume } from "@lit/context";
import { msg, str } from "@lit/localize";
import { css, html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, property, state } from "lit/decorators.js";
import { map } from "lit/directives/map.js";
import { eventWords } from "../../format/kinds/event-kinds.js";
import { shownLine } from "../../boards/kept-log.js";
import { ActionController } from "../../controllers/action.js";
import { ContextStoreController } from "../../controllers/context-store.js";
import { LoadController } from "../../controllers/load.js";
import { base, quietText } from "../../elements/base/base-style.js";
import { renderAdvice, renderLoaded } from "../../elements/feedback/load-state.js";
import { renderOptions } from "../../elements/forms/form-parts.js";
import { forms } from "../../elements/forms/form-style.js";
import { renderPageHead } from "../../elements/layout/page-head.js";
import { sheets } from "../../elements/layout/page-sections.js";
import { formatNumber } from "../../format/number.js";
import { formatClock } from "../../format/time.js";
import { apiContext, routerContext, sitesContext } from "../../state/contexts.js";
import { sitePath } from "../../state/router.js";
import { signalLabels } from "../../state/signal-labels.js";
import type { CauseShape, EventShape, KnownShape, LogLineShape, SeenShape, SimilarShape, SiteShape } from "../../generated/api.js";
import type { HubApi } from "../../wire/hub-api.js";
import { sightingPicturePath } from "../../wire/sightings-api.js";
import { momentQuery } from "../logbook/logbook-query.js";
import { CauseApi } from "./cause-api.js";
import { ALL, causeQuery, excessOf, knownText, momentOf, repeatable, repeatedComment, sortEvents, subjectsOf, verdictText, type Verdict } from "./cause-words.js";
import "../../elements/analysis/sighting-card.js";
import "../../elements/analysis/signal-shares.js";
import "../../elements/feedback/empty.js";
import "../../elements/feedback/status.js";
import "../../elements/forms/button.js";
import "../../elements/forms/field.js";

type Unusual = CauseShape["unusual"][number];

/** All that one page shows. */
interface Minute {
  readonly cause: CauseShape;
  readonly events: readonly EventShape[];
  readonly sightings: readonly SeenShape[];
  readonly log: readonly LogLineShape[];
}

@customElement("t-page-cause")
export class PageCause extends LitElement {
  static override styles = [
    base,
    sheets,
    forms,
    css`
      .quiet {
        ${quietText}
        max-inline-size: 60rem;
      }
      .text {
        overflow-wrap: anywhere;
        white-space: pre-wrap;
      }
      .rows li {
        grid-template-columns: minmax(0, 1fr) auto;
      }
      .rows t-signal-shares {
        grid-column: 1 / -1;
      }
      .excess {
        inline-size: 8rem;
        block-size: 0.6rem;
        border-radius: var(--t-radius-s);
        background: var(--t-line);
      }
      .excess rect {
        fill: var(--t-warn);
      }
      .score {
        display: flex;
        flex-wrap: wrap;
        align-items: center;
        gap: var(--t-space-2) var(--t-space-3);
        font-variant-numeric: tabular-nums;
      }
      .known {
        display: flex;
        flex-wrap: wrap;
        align-items: end;
        gap: var(--t-space-2) var(--t-space-3);
      }
      .known t-field {
        flex: 0 1 16rem;
      }
    `,
  ];

  @property() site = "";

  @state() private chosen = "";
  @consume({ context: apiContext, subscribe: true }) private readonly api: HubApi | undefined;
  private readonly sites = new ContextStoreController(this, sitesContext);
  private readonly router = new ContextStoreController(this, routerContext);
  private readonly detail = new LoadController<SiteShape>(this);
  private readonly minute = new LoadController<Minute>(this);
  private readonly action = new ActionController(this);
  private asked = 0;

  protected override willUpdate(): void {
    const sites = this.sites.store;
    const { api, atUs } = this;
    if (api === undefined || sites === undefined || this.site === "") return;
    this.detail.load(`${this.site} ${sites.catalogueOf(this.site)}`, () => sites.loadDetail(this.site));
    if (!Number.isNaN(atUs)) this.minute.load(`${this.site} ${String(atUs)} ${String(this.asked)}`, () => this.loadMinute(new CauseApi(api, this.site), atUs));
  }

  override render(): TemplateResult {
    const { atUs, zone } = this;
    if (Number.isNaN(atUs)) {
      return html`${renderPageHead(msg("Cause"), msg("What else was unusual at a moment."))}
        <t-empty heading=${msg("No moment is chosen")} icon="live"
          ><p>${msg(html`Open it from an <a href=${sitePath(this.site, "anomalies")}>anomaly</a>, an <a href="/alarms">alarm</a> or a line of the <a href=${sitePath(this.site, "logbook")}>logbook</a>.`)}</p></t-empty
        >`;
    }
    const site = this.sites.store?.siteRow(this.site)?.name ?? this.site;
    return html`${renderPageHead(
        msg("Cause"),
        msg(str`What else was unusual at ${site} within a minute of ${formatClock(atUs, zone)}.`),
        html`<div class="actions">
          <a href=${`${sitePath(this.site, "history")}?${momentQuery(atUs)}`}>${msg("History")}</a> <a href=${sitePath(this.site, "logbook")}>${msg("Logbook")}</a>
          <a href=${sitePath(this.site, "anomalies")}>${msg("Anomalies")}</a>
        </div>`,
      )}
      ${renderLoaded(this.minute, msg("that minute"), (minute) => this.renderMinute(minute))}`;
  }

  private get atUs(): number {
    return momentOf(this.router.store?.search ?? "");
  }

  private get zone(): string {
    return this.detail.value?.zone ?? "UTC";
  }

  private async loadMinute(api: CauseApi, atUs: number): Promise<Minute> {
    const cause = await api.showCause(atUs);
    const { from_us: fromUs, to_us: toUs } = cause;
    const [events, sightings, log] = await Promise.all([
      api.listEvents(fromUs, toUs),
      api.listSightings(fromUs, toUs),
      // Who may view some devices only is shown the rest of the page.
      api.listLog(fromUs, toUs).catch(() => ({ lines: [] })),
    ]);
    return { cause, events: events.events, sightings: sightings.sightings, log: log.lines };
  }

  private renderMinute({ cause, events, sightings, log }: Minute): TemplateResult {
    const { commands, others } = sortEvents(events);
    return html`${this.action.problem === null ? nothing : renderAdvice(this.action.problem)}
      <p class="quiet" role="status">${this.action.doneText}</p>
      <section class="sheet" aria-labelledby="unusual">
        <h2 id="unusual">${msg("Unusual, the most first")}</h2>
        ${cause.unusual.length === 0
          ? html`<p class="quiet">${msg("No detector that you may see said anything unusual in that minute.")}</p>`
          : html`<ul class="rows">
              ${map(cause.unusual, (row) => this.renderUnusual(row))}
            </ul>`}
        ${cause.may_use && cause.unusual.length > 0 ? this.renderKnow(cause) : nothing}
      </section>
      <section class="sheet" aria-labelledby="similar">
        <h2 id="similar">${msg("The last time it was like this")}</h2>
        ${cause.similar === null ? html`<p class="quiet">${msg("There was no episode like it in the last thousand anomalies.")}</p>` : this.renderSimilar(cause, cause.similar)}
      </section>
      ${this.renderEvents("commanded", msg("Commanded"), commands, msg("Nothing was commanded in that minute."))}
      ${this.renderSightings(sightings)}
      ${this.renderEvents("said", msg("Logbook"), others, msg("Nothing else was written down in that minute."))}
      ${this.renderLog(log)}
      ${cause.known.length === 0 ? nothing : this.renderKnown(cause)}`;
  }

  private renderUnusual(one: Unusual): TemplateResult {
    const path = one.address.startsWith("/") ? sitePath(this.site, "anomalies") : `${sitePath(this.site, "history")}?${momentQuery(one.at_us, [one.address])}`;
    const over = one.score >= one.bar;
    return html`<li>
      <div>
        <a href=${path}>${one.title}</a>
        <div class="score">
          <t-status kind=${over ? "warn" : "ok"} word=${over ? msg("anomaly") : msg("near it")}></t-status>
          <span>${msg(str`${formatNumber(one.score, 2)}, told from ${formatNumber(one.bar, 2)} (${one.detector})`)}</span>
        </div>
      </div>
      <svg class="excess" viewBox="0 0 100 6" preserveAspectRatio="none" aria-hidden="true"><rect width=${100 * excessOf(one)} height="6"></rect></svg>
      ${one.shares.length === 0 || this.detail.value === undefined ? nothing : html`<t-signal-shares .shares=${one.shares} .labels=${signalLabels(this.detail.value)}></t-signal-shares>`}
    </li>`;
  }

  private renderSimilar(cause: CauseShape, similar: SimilarShape): TemplateResult {
    const verdict = repeatable(similar);
    const when = formatClock(similar.began_us, this.zone);
    const newest = subjectsOf(cause.unusual, ALL).filter((row) => row.newest);
    return html`<p>
        ${msg(html`<a href=${`${sitePath(this.site, "cause")}?${causeQuery(similar.began_us)}`}>${when}</a>: ${similar.names.join(", ")} (${formatNumber(100 * similar.likeness, 0)} % in common)`)}
      </p>
      <p class="quiet">${verdictText(similar)}</p>
      ${verdict === null || newest.length === 0 || !cause.may_use
        ? nothing
        : html`<div class="actions">
            <t-button kind="primary" ?disabled=${this.action.busy} @click=${this.judger(newest, verdict, repeatedComment(similar, when))}>${msg("Same as last time")}</t-button>
          </div>`}`;
  }

  private renderKnow(cause: CauseShape): TemplateResult | typeof nothing {
    const single = cause.unusual.map(({ address, detector, title }) => [`${address}~${detector}`, `${title} (${detector})`] as const);
    const anomalous = subjectsOf(cause.unusual, ALL).length;
    const options = anomalous < 2 ? single : [[ALL, msg(str`all ${String(anomalous)} that were anomalous`)] as const, ...single];
    const chosen = this.chosen === "" ? (options[0]?.[0] ?? "") : this.chosen;
    const subjects = subjectsOf(cause.unusual, chosen);
    if (subjects.length === 0) return nothing;
    const newest = subjects.filter((row) => row.newest);
    return html`<div class="known">
      <t-field label=${msg("Say of")}><select @change=${this.onSubject}>${renderOptions(options, chosen)}</select></t-field>
      ${map(
        cause.states,
        (row) => html`<t-button ?disabled=${this.action.busy} @click=${this.knower(subjects, row)}>${msg(str`Ignore while ${row.title} is ${row.name}`)}</t-button>`,
      )}
      ${newest.length > 0
        ? html`<t-button ?disabled=${this.action.busy} @click=${this.judger(newest, "confirmed", "")}>${msg("It was real")}</t-button>
            <t-button ?disabled=${this.action.busy} @click=${this.judger(newest, "forgiven", "")}>${msg("Not an anomaly")}</t-button>`
        : html`<span class="quiet">${msg("Only its newest anomaly can be judged; this is none of it.")}</span>`}
    </div>`;
  }

  private renderKnown(cause: CauseShape): TemplateResult {
    return html`<section class="sheet" aria-labelledby="known">
      <h2 id="known">${msg("Known, and not told")}</h2>
      <ul class="rows">
        ${map(
          cause.known,
          (row) =>
            html`<li>
              <div>
                <div>${row.title} (${row.detector}) ${knownText(row)}</div>
                <div class="quiet">${row.who}, ${formatClock(row.since_us, this.zone)}${row.comment === "" ? "" : `: ${row.comment}`}</div>
              </div>
              ${cause.may_use ? html`<t-button ?disabled=${this.action.busy} label=${msg(str`Tell again: ${row.title}`)} @click=${this.teller(row)}>${msg("Tell again")}</t-button>` : nothing}
            </li>`,
        )}
      </ul>
    </section>`;
  }

  private renderEvents(id: string, heading: string, events: readonly EventShape[], none: string): TemplateResult {
    return html`<section class="sheet" aria-labelledby=${id}>
      <h2 id=${id}>${heading}</h2>
      ${events.length === 0
        ? html`<p class="quiet">${none}</p>`
        : html`<ul class="rows">
            ${map(
              events,
              (event) =>
                html`<li>
                  <div>
                    <div class="facts"><span>${formatClock(event.time_us, this.zone)}</span>${event.who === "" ? nothing : html`<span>${event.who}</span>`}</div>
                    <div>${event.good ? nothing : html`<t-status kind="bad" word=${msg("look")}></t-status> `}${eventWords(event.kind)}</div>
                    ${event.message === "" ? nothing : html`<div class="quiet">${event.message}</div>`}
                  </div>
                </li>`,
            )}
          </ul>`}
    </section>`;
  }

  private renderLog(log: readonly LogLineShape[]): TemplateResult | typeof nothing {
    // A site without a robot's log has none of this section.
    if (log.length === 0) return nothing;
    return html`<section class="sheet" aria-labelledby="log">
      <h2 id="log">${msg("Robot's log")}</h2>
      <ul class="rows">
        ${map(log.map(shownLine), (line) => {
          const grave = line.level >= 40;
          return html`<li>
            <div>
              <div class="facts"><span>${formatClock(line.timeUs, this.zone)}</span><span>${line.node}</span></div>
              <div><t-status kind=${grave ? "bad" : line.level >= 30 ? "warn" : "ok"} word=${line.word.toLowerCase()}></t-status> <span class="text">${line.text}</span></div>
              ${line.source === "" ? nothing : html`<div class="quiet">${line.source}</div>`}
            </div>
          </li>`;
        })}
      </ul>
    </section>`;
  }

  private renderSightings(sightings: readonly SeenShape[]): TemplateResult | typeof nothing {
    const streams = (this.detail.value?.devices ?? []).flatMap((device) => device.streams);
    if (streams.length === 0 && sightings.length === 0) return nothing;
    return html`<section class="sheet" aria-labelledby="seen">
      <h2 id="seen">${msg("Seen by cameras")}</h2>
      ${sightings.length === 0
        ? html`<p class="quiet">${msg("No camera told of anything in that minute.")}</p>`
        : html`<ul class="rows">
            ${map(
              sightings,
              (row) =>
                html`<li>
                  <t-sighting
                    .sighting=${row}
                    .camera=${streams.find(({ address }) => address === row.camera)?.name ?? row.camera}
                    .picture=${row.picture ? sightingPicturePath(this.site, row.id) : ""}
                    .zone=${this.zone}
                    ><div class="ways"><a href=${`${sitePath(this.site, "review")}?sighting=${row.id}&all=true`}>${msg("Clip")}</a></div></t-sighting
                  >
                </li>`,
            )}
          </ul>`}
    </section>`;
  }

  private readonly onSubject = (event: Event): void => {
    this.chosen = (event.target as HTMLSelectElement).value;
  };

  private judger(subjects: readonly Unusual[], verdict: Verdict, comment: string): () => void {
    const said = verdict === "confirmed" ? msg("was real") : msg("was none");
    return () => {
      const judge = (api: CauseApi): Promise<unknown> => forEach(subjects, ({ address, detector }) => api.judgeNewest(verdict, { address, detector, comment }));
      this.act(msg("say what it was"), judge, msg(str`Said: the newest anomaly of ${titlesOf(subjects)} ${said}.`));
    };
  }

  private knower(subjects: readonly Unusual[], { address: stateOf, title: stateTitle, value, name }: CauseShape["states"][number]): () => void {
    return () => {
      const keep = (api: CauseApi): Promise<unknown> => forEach(subjects, ({ address, detector }) => api.addKnown({ address, detector, state: stateOf, value, comment: "" }));
      this.act(msg("keep that it is known"), keep, msg(str`Known: nobody is told of ${titlesOf(subjects)} while ${stateTitle} is ${name}.`));
    };
  }

  private teller({ key, title }: KnownShape): () => void {
    return () => {
      this.act(msg("tell of it again"), (api) => api.endKnown(key), msg(str`${title} is told again.`));
    };
  }

  private act(asked: string, say: (api: CauseApi) => Promise<unknown>, done: string): void {
    const { api } = this;
    if (api === undefined) return;
    void this.action.run(
      asked,
      async () => {
        await say(new CauseApi(api, this.site));
        this.asked += 1;
      },
      done,
    );
  }
}

/** One after the other: what went before a failure was said, and the page shows it. */
async function forEach(subjects: readonly Unusual[], say: (subject: Unusual) => Promise<unknown>): Promise<void> {
  for (const subject of subjects) await say(subject);
}

function titlesOf(subjects: readonly Unusual[]): string {
  return [...new Set(subjects.map(({ title }) => title))].join(", ");
}

declare global {
  interface HTMLElementTagNameMap {
    "t-page-cause": PageCause;
  }
}
