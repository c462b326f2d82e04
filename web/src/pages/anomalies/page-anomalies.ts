/** What is unusual at a site: groups of signals with who made them so, and the detectors of single signals. */

import { consume } from "@lit/context";
import { msg, str } from "@lit/localize";
import { css, html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, property } from "lit/decorators.js";
import { repeat } from "lit/directives/repeat.js";
import { AnomalyDetectorsController } from "../../controllers/anomaly-detectors.js";
import { ContextStoreController } from "../../controllers/context-store.js";
import { LoadController } from "../../controllers/load.js";
import { TickerController } from "../../controllers/ticker.js";
import { base, quietText } from "../../elements/base/base-style.js";
import { indentOf } from "../../elements/chart/chart-model.js";
import { PaintScheduler } from "../../elements/chart/paint-scheduler.js";
import { renderAdvice, renderLoaded } from "../../elements/feedback/load-state.js";
import { renderPageHead } from "../../elements/layout/page-head.js";
import { sheets } from "../../elements/layout/page-sections.js";
import { detectorWords } from "../../format/kinds/detector-kinds.js";
import { adviceFor } from "../../format/error-advice.js";
import { formatClock } from "../../format/time.js";
import type { TimeSpan } from "../../series/time-window.js";
import { apiContext, sitesContext } from "../../state/contexts.js";
import { sitePath } from "../../state/router.js";
import { signalLabels } from "../../state/signal-labels.js";
import type { Detector } from "../../state/anomaly-detectors.js";
import type { SiteShape } from "../../generated/api.js";
import type { HubApi } from "../../wire/hub-api.js";
import { causeQuery } from "../cause/cause-words.js";
import { AlarmBudgetApi } from "./alarm-budget-api.js";
import { BackTestsApi } from "./back-tests-api.js";
import "../../elements/feedback/empty.js";
import "../../elements/feedback/loading.js";
import "../../elements/feedback/status.js";
import "../history/chart/anomaly-scores.js";
import "./alarm-budget.js";
import "./back-test.js";
import "./learn-form.js";

const SHOWN_US = 3600e6;
/** The window goes on with the time; scores need no more. */
const STEP_MS = 10_000;
const CHART_PX = 800;

@customElement("t-page-anomalies")
export class PageAnomalies extends LitElement {
  static override styles = [
    base,
    sheets,
    css`
      .muted {
        ${quietText}
        max-inline-size: 60rem;
      }
      .rows .why {
        ${quietText}
        grid-column: 1 / -1;
      }
      .rows > li[data-on] .why {
        color: var(--t-text);
      }
    `,
  ];

  @property() site = "";

  @consume({ context: apiContext, subscribe: true }) private readonly api: HubApi | undefined;
  private readonly sites = new ContextStoreController(this, sitesContext);
  private readonly detail = new LoadController<SiteShape>(this);
  private readonly detectors = new AnomalyDetectorsController(this);
  private readonly painter = new PaintScheduler();
  private tests: BackTestsApi | null = null;
  private testsOf = "";
  private budget: AlarmBudgetApi | null = null;
  private budgetOf = "";

  constructor() {
    super();
    new TickerController(this, STEP_MS);
  }

  protected override willUpdate(): void {
    const sites = this.sites.store;
    if (this.api === undefined || sites === undefined || this.site === "") return;
    this.detail.load(`${this.site} ${sites.catalogueOf(this.site)}`, () => sites.loadDetail(this.site));
    if (this.detail.value !== undefined) this.detectors.loadDetectors(this.api, this.site, this.detail.value.catalogue);
  }

  override render(): TemplateResult {
    const name = this.sites.store?.siteRow(this.site)?.name ?? this.site;
    return html`${renderPageHead(
        msg("Anomalies"),
        msg(str`What is not as usual at ${name}: several signals judged together, and single ones.`),
        html`<div class="actions"><a href=${sitePath(this.site, "history")}>${msg("History")}</a> <a href=${sitePath(this.site, "live")}>${msg("Real-time")}</a></div>`,
      )}
      ${renderLoaded(this.detail, msg("the site"), (detail) => this.renderDetectors(detail))}`;
  }

  private renderDetectors(detail: SiteShape): TemplateResult {
    if (this.detectors.state === "failed") return renderAdvice(adviceFor(this.detectors.renderError, msg("the anomaly detectors")), this.retry);
    if (!this.detectors.hasList) return html`<t-loading what=${msg("Loading the anomaly detectors")}></t-loading>`;
    const { list, mayForgive } = this.detectors.book;
    if (list.length === 0) return html`${renderNone()} ${this.renderTrial(detail, [])}`;
    const groups = list.filter(({ signals }) => signals.length > 0);
    const singles = list.filter(({ signals }) => signals.length === 0);
    const labels = signalLabels(detail);
    return html`${groups.length === 0 ? nothing : this.renderGroups(detail, groups, labels, mayForgive)}
      ${singles.length === 0 ? nothing : this.renderSingles(detail, singles, labels)} ${this.renderBudget()} ${mayForgive ? this.renderTrial(detail, severalOf(groups)) : nothing}`;
  }

  private renderTrial(detail: SiteShape, groups: readonly Detector[]): TemplateResult | typeof nothing {
    if (this.api === undefined || !this.detectors.book.mayForgive) return nothing;
    if (this.tests === null || this.testsOf !== this.site) {
      this.tests = new BackTestsApi(this.api, this.site);
      this.testsOf = this.site;
    }
    return html`<section class="sheet" aria-labelledby="trial">
      <h2 id="trial">${msg("Try a detector on the past")}</h2>
      <p class="muted">${msg("What it would have said of stored history, by two settings. It looks at one sample a second; nothing is switched on and nobody is told.")}</p>
      <t-back-test .site=${this.site} .zone=${detail.zone} .groups=${groups} .signals=${numbersOf(detail)} .hub=${this.tests}></t-back-test>
    </section>`;
  }

  private renderBudget(): TemplateResult | typeof nothing {
    if (this.api === undefined) return nothing;
    if (this.budget === null || this.budgetOf !== this.site) {
      this.budget = new AlarmBudgetApi(this.api, this.site);
      this.budgetOf = this.site;
    }
    return html`<section class="sheet" aria-labelledby="budget">
      <h2 id="budget">${msg("How often may it cry?")}</h2>
      <t-alarm-budget .hub=${this.budget}></t-alarm-budget>
    </section>`;
  }

  private renderGroups(detail: SiteShape, groups: readonly Detector[], labels: ReadonlyMap<string, string>, mayForgive: boolean): TemplateResult {
    const toUs = Date.now() * 1000;
    const span: TimeSpan = { fromUs: toUs - SHOWN_US, toUs };
    const channels = groups.map(({ address }) => address);
    return html`<section class="sheet" aria-labelledby="together">
        <h2 id="together">${msg("Signals together")}</h2>
        <p class="muted">${msg("The last hour of each group's score. A bar says how much of an anomaly a signal made.")}</p>
        <t-anomalies
          bare
          .site=${this.site}
          .edition=${detail.catalogue}
          .channels=${channels}
          .labels=${labels}
          .span=${span}
          .indent=${indentOf(1, 48)}
          .painter=${this.painter}
          .width=${CHART_PX}
          .zone=${detail.zone}
        ></t-anomalies>
        ${renderCauses(this.site, detail, groups)}
      </section>
      ${mayForgive && severalOf(groups).length > 0 ? this.renderLearning(detail, severalOf(groups)) : nothing}`;
  }

  private renderLearning(detail: SiteShape, groups: readonly Detector[]): TemplateResult {
    return html`<section class="sheet" aria-labelledby="learn">
      <h2 id="learn">${msg("Learn from a run")}</h2>
      <p class="muted">
        ${msg("Name a stretch of the history in which nothing was wrong and in which the machine did all that it usually does. The group forgets what it knew and takes that stretch for usual.")}
      </p>
      <t-learn-form .site=${this.site} .zone=${detail.zone} .groups=${groups} .hub=${this.api ?? null}></t-learn-form>
    </section>`;
  }

  private renderSingles(detail: SiteShape, singles: readonly Detector[], labels: ReadonlyMap<string, string>): TemplateResult {
    // What is on comes first, then what was last.
    const order = [...singles].sort((a, b) => (b.anomaly?.toUs ?? 0) - (a.anomaly?.toUs ?? 0));
    return html`<section class="sheet" aria-labelledby="single">
      <h2 id="single">${msg("Single signals")}</h2>
      <ul class="rows">
        ${repeat(
          order,
          ({ scores }) => scores,
          (detector) => renderSingle(this.site, detail, detector, labels.get(detector.address) ?? detector.address),
        )}
      </ul>
    </section>`;
  }

  private readonly retry = (): void => {
    this.detectors.retry();
  };
}

function renderSingle(site: string, detail: SiteShape, { address, name, on, learning, anomaly }: Detector, label: string): TemplateResult {
  const path = `${sitePath(site, "history")}?${new URLSearchParams({ c: address }).toString()}`;
  const [kind, word] = on ? ["warn", msg("anomaly")] : learning > 0 ? ["busy", msg("learning")] : ["ok", msg("as usual")];
  return html`<li ?data-on=${on}>
    <a href=${path}>${label}, ${detectorWords(name)}</a>
    <t-status kind=${kind} word=${word}></t-status>
    ${anomaly === null ? nothing : html`<span class="why">${on ? msg("Since") : msg("Last at")} ${formatClock(anomaly.fromUs, detail.zone)}: ${anomaly.why} <a href=${`${sitePath(site, "cause")}?${causeQuery(anomaly.fromUs)}`}>${msg("Cause")}</a></span>`}
  </li>`;
}

/** Those of several signals: of a single number there is nothing to learn from a run, and nothing to try. */
function severalOf(groups: readonly Detector[]): readonly Detector[] {
  return groups.filter(({ signals }) => signals.length > 1);
}

/** Where to look for the cause of each group's newest anomaly. */
function renderCauses(site: string, detail: SiteShape, groups: readonly Detector[]): TemplateResult | typeof nothing {
  const told = groups.flatMap(({ title, anomaly }) => (anomaly === null ? [] : [{ title, fromUs: anomaly.fromUs }]));
  if (told.length === 0) return nothing;
  return html`<ul class="rows">
    ${repeat(
      told,
      ({ title }) => title,
      ({ title, fromUs }) => html`<li><a href=${`${sitePath(site, "cause")}?${causeQuery(fromUs)}`}>${msg(str`Cause of ${title}, ${formatClock(fromUs, detail.zone)}`)}</a></li>`,
    )}
  </ul>`;
}

const numbers = new WeakMap<SiteShape, ReadonlyMap<string, string>>();

function numbersOf(detail: SiteShape): ReadonlyMap<string, string> {
  const known = numbers.get(detail);
  if (known !== undefined) return known;
  const labels = signalLabels(detail);
  const found = detail.devices.flatMap((device) => device.signals.filter(({ type }) => type === "number").map(({ address }): [string, string] => [address, labels.get(address) ?? address]));
  const made = new Map(found);
  numbers.set(detail, made);
  return made;
}

function renderNone(): TemplateResult {
  return html`<t-empty heading=${msg("Nothing is watched for anomalies")} icon="live">
    <p>${msg("Switch it on in the site description: services: {anomaly_detection: true}, or name detectors at signals and groups.")}</p>
  </t-empty>`;
}

declare global {
  interface HTMLElementTagNameMap {
    "t-page-anomalies": PageAnomalies;
  }
}
