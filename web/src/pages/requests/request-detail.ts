/** One request: how it stands, why not now, what of it is done, its log, and what may be done with its group. */

import { consume } from "@lit/context";
import { msg, str } from "@lit/localize";
import { css, html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, property } from "lit/decorators.js";
import { map } from "lit/directives/map.js";
import { ConnectionStateController } from "../../controllers/connection-state.js";
import { LoadController } from "../../controllers/load.js";
import { QuestionController } from "../../controllers/question.js";
import { base } from "../../elements/base/base-style.js";
import { renderLoaded } from "../../elements/feedback/load-state.js";
import { renderQuestion } from "../../elements/feedback/question.js";
import { renderTable, tables } from "../../elements/layout/data-table.js";
import { sheets } from "../../elements/layout/page-sections.js";
import { formatDuration } from "../../format/duration.js";
import { OBSERVATION_WORDS, REQUEST_WORDS, URGENCY_WORDS } from "../../format/observing-words.js";
import { formatDec, formatRa } from "../../format/sexagesimal.js";
import type { GroupShape, RequestDetail, RequestShape } from "../../generated/api.js";
import type { GeoPlace } from "../../sky/coordinates.js";
import { targetText } from "../../sky/target-place.js";
import { apiContext } from "../../state/contexts.js";
import type { HubApi } from "../../wire/hub-api.js";
import { ObservingApi, type GroupStep } from "../../wire/observing-api.js";
import { plural } from "../../words/plural.js";
import { constraintsText, motionText } from "./constraint-text.js";
import { GUIDING_WORDS, IMAGE_WORDS } from "./form/draft.js";
import { angleText } from "./form/framing-draft.js";
import "../../elements/feedback/status.js";
import "../../elements/forms/button.js";
import "../../elements/values/time.js";
import "./request-pictures.js";
import "./visibility-chart.js";

const STEPS: Readonly<Record<GroupStep, { readonly button: string; readonly heading: string; readonly action: string; readonly asked: string; readonly text: string; readonly kind: "primary" | "danger" }>> = {
  submit: { button: msg("Submit…"), heading: msg("Submit this request?"), action: msg("Submit"), asked: msg("submit the request"), text: msg("It is charged to its proposal as long as it waits, and observed as soon as the planner finds its place."), kind: "primary" },
  approve: { button: msg("Approve…"), heading: msg("Approve this request?"), action: msg("Approve"), asked: msg("approve the request"), text: msg("From then on it may be observed."), kind: "primary" },
  withdraw: { button: msg("Take back…"), heading: msg("Take this request back?"), action: msg("Take back"), asked: msg("take the request back"), text: msg("It becomes a draft, which may be changed and submitted anew. Frames that were taken are kept."), kind: "primary" },
  retry: { button: msg("Try again…"), heading: msg("Let it be tried again?"), action: msg("Try again"), asked: msg("let the request be tried again"), text: msg("It failed too often and was put aside. Look first at why."), kind: "primary" },
  cancel: { button: msg("Cancel the request…"), heading: msg("Cancel this request?"), action: msg("Cancel the request"), asked: msg("cancel the request"), text: msg("What of it is not yet observed never will be. It cannot be taken back."), kind: "danger" },
};
const ORDER: readonly GroupStep[] = ["submit", "approve", "withdraw", "retry", "cancel"];

function framesText(done: readonly number[]): string {
  const many = done.reduce((sum, frames) => sum + frames, 0);
  return plural(many, msg("1 frame done"), msg(str`${String(many)} frames done`));
}

/**
 * @fires t-changed something of it has changed
 * @fires t-edit detail is the group whose form is to be opened
 * @fires t-again detail is the group that is to be asked for once more
 * @fires t-close
 */
@customElement("t-request-detail")
export class RequestDetailView extends LitElement {
  static override styles = [
    base,
    sheets,
    tables,
    css`
      dl {
        display: grid;
        grid-template-columns: auto minmax(0, 1fr);
        gap: var(--t-space-1) var(--t-space-4);
        margin: 0;
      }
      dt {
        color: var(--t-muted);
      }
      dd {
        margin: 0;
        overflow-wrap: anywhere;
      }
      .frames {
        --t-columns: 6rem 6rem 8rem 6rem 6rem minmax(6rem, 1fr) 8rem;
      }
    `,
  ];

  @property() site = "";
  @property() request = "";
  /** There is a proposal in whose name the person may ask. */
  @property({ attribute: false }) mayAsk = false;
  @property({ attribute: false }) place: GeoPlace | null = null;
  @property() zone = "UTC";

  @consume({ context: apiContext }) private readonly api!: HubApi;
  private readonly loaded = new LoadController<RequestDetail>(this);
  private readonly question = new QuestionController<GroupStep>(this, (step) => this.performStep(step));

  constructor() {
    super();
    new ConnectionStateController(this, (connection) => [
      connection.onMessage("observing_request", (news) => {
        if (news.site === this.site && news.request === this.request) this.loaded.invalidate();
      }),
    ]);
  }

  override willUpdate(): void {
    const api = new ObservingApi(this.api, this.site);
    this.loaded.load(`${this.site} ${this.request}`, () => api.requestDetail(this.request));
  }

  override render(): TemplateResult {
    return html`<section class="sheet" aria-label=${msg("Request")}>
      ${renderLoaded(this.loaded, msg("this request"), (detail) => this.renderDetail(detail))}
      <div class="actions"><t-button kind="quiet" @click=${this.onClose}>${msg("Back to the list")}</t-button></div>
    </section>`;
  }

  private renderDetail({ request, group, why_not: why, log, observations }: RequestDetail): TemplateResult {
    const { word, kind } = REQUEST_WORDS[request.state];
    return html`<div class="head">
        <div>
          <h2>${targetText(request.target)}</h2>
          <div class="facts">
            <t-status kind=${kind} word=${group.waits ? msg("waits to be approved") : word}></t-status>
            <span>${group.proposal}</span><span>${msg(str`asked by ${group.requester}`)}</span><span>${group.name}</span>
          </div>
          ${why === null || request.state !== "PENDING" ? nothing : html`<p><strong>${msg("Why not now:")}</strong> ${why.message}</p>`}
        </div>
        ${this.renderActions(group)}
      </div>
      ${this.renderFacts(request, group)} ${this.renderFrames(request)}
      <h3>${msg("When it may be observed")}</h3>
      <t-visibility-chart .target=${request.target} .constraints=${request.constraints} .windows=${request.windows} .place=${this.place} .zone=${this.zone}></t-visibility-chart>
      <h3>${msg("Tries")}</h3>
      ${observations.length === 0
        ? html`<p class="muted">${msg("It has not been tried yet.")}</p>`
        : html`<ul class="rows">
            ${map(observations, (attempt) => {
              const words = OBSERVATION_WORDS[attempt.state];
              return html`<li>
                <div>
                  <div class="facts"><t-time .us=${attempt.began_us} .zone=${this.zone}></t-time><t-status kind=${words.kind} word=${words.word}></t-status></div>
                  <div>${attempt.why}</div>
                  <div class="facts"><span>${msg(str`charged ${formatDuration(attempt.charge_s)}`)}</span><span>${framesText(attempt.frames_done)}</span></div>
                </div>
              </li>`;
            })}
          </ul>`}
      ${observations.length === 0
        ? nothing
        : html`<h3>${msg("Pictures")}</h3>
            <t-request-pictures .site=${this.site} .request=${this.request} .zone=${this.zone} .taken=${request.frames_done.reduce((sum, many) => sum + many, 0)}></t-request-pictures>`}
      <h3>${msg("Log")}</h3>
      <ol class="rows">
        ${map(
          log,
          ({ time_us: time, who, before, after, why: reason }) => html`<li>
            <div>
              <div class="facts"><t-time .us=${time} .zone=${this.zone}></t-time>${who === "" ? nothing : html`<span>${who}</span>`}</div>
              <div>${before === null ? "" : `${REQUEST_WORDS[before].word} → `}<strong>${REQUEST_WORDS[after].word}</strong>${reason === "" ? "" : `: ${reason}`}</div>
            </div>
          </li>`,
        )}
      </ol>
      ${renderQuestion(this.question, (step) => ({ ...STEPS[step], text: group.requests.length > 1 ? msg(str`${STEPS[step].text} This is about all ${String(group.requests.length)} requests of the group.`) : STEPS[step].text }))}`;
  }

  private renderActions(group: GroupShape): TemplateResult {
    const onEdit = (): void => {
      this.dispatchEvent(new CustomEvent("t-edit", { detail: group.id }));
    };
    const onAgain = (): void => {
      this.dispatchEvent(new CustomEvent("t-again", { detail: group.id }));
    };
    return html`<div class="actions">
      ${group.may.includes("edit") ? html`<t-button @click=${onEdit}>${msg("Change…")}</t-button>` : nothing}
      ${this.mayAsk ? html`<t-button @click=${onAgain}>${msg("Ask again like this…")}</t-button>` : nothing}
      ${map(
        ORDER.filter((step) => group.may.includes(step)),
        (step) => html`<t-button kind=${step === "submit" || step === "approve" ? "primary" : "plain"} @click=${this.question.opener(step)}>${STEPS[step].button}</t-button>`,
      )}
    </div>`;
  }

  private renderFacts({ target, charge_s: charge, windows, constraints }: RequestShape, group: GroupShape): TemplateResult {
    return html`<dl>
      <dt>${msg("Charged")}</dt>
      <dd>${msg(str`about ${formatDuration(charge)} of its proposal's time`)}</dd>
      <dt>${msg("Urgency")}</dt>
      <dd>${msg(str`${URGENCY_WORDS[group.urgency]}, priority ${group.priority}`)}</dd>
      ${target?.type === "ICRS" ? html`<dt>J2000</dt><dd>${formatRa(target.ra / 15)} ${formatDec(target.dec)}${motionText(target)}</dd>` : nothing}
      ${target?.type === "ICRS" && target.position_angle != null ? html`<dt>${msg("Position angle")}</dt><dd>${msg(str`${angleText(target.position_angle)}°, of the top from north through east`)}</dd>` : nothing}
      <dt>${windows.length === 1 ? msg("Window") : msg("Windows")}</dt>
      <dd>${map(windows, ({ start_us: start, end_us: end }) => html`<div>${msg(html`<t-time .us=${start} .zone=${this.zone}></t-time> to <t-time .us=${end} .zone=${this.zone}></t-time>`)}</div>`)}</dd>
      <dt>${msg("Must hold")}</dt>
      <dd>${constraintsText(constraints)}</dd>
    </dl>`;
  }

  private renderFrames({ configurations, frames_done: done }: RequestShape): TemplateResult {
    const rows = configurations.map((row, i) => ({ ...row, id: String(i), done: done[i] ?? 0 }));
    return html`<div class="frames">
      ${renderTable({
        label: msg("Frames"),
        rows,
        key: ({ id }) => id,
        columns: [
          { title: msg("Kind"), heads: true, cell: ({ type = "LIGHT" }) => IMAGE_WORDS[type] },
          { title: msg("Filter", { id: "filter.optical" }), titled: true, cell: ({ filter = "" }) => (filter === "" ? msg("any") : filter) },
          { title: msg("Exposure"), titled: true, cell: ({ exposure }) => `${String(exposure)} s` },
          { title: msg("Binning"), titled: true, cell: ({ binning = 1 }) => `${String(binning)} × ${String(binning)}` },
          { title: msg("Gain"), titled: true, cell: ({ gain }) => (gain == null ? msg("as it is") : String(gain)) },
          { title: msg("Guiding"), titled: true, cell: ({ guiding = "OFF" }) => GUIDING_WORDS[guiding] },
          { title: msg("Done", { id: "done.frames" }), titled: true, cell: ({ done: many, count = 1 }) => msg(str`${String(many)} of ${String(count)}`) },
        ],
      })}
    </div>`;
  }

  private performStep(step: GroupStep): Promise<boolean> {
    const group = this.loaded.value?.group.id ?? "";
    return this.question.action
      .run(STEPS[step].asked, () => new ObservingApi(this.api, this.site).changeGroup(group, step))
      .then((done) => {
        this.loaded.invalidate();
        this.dispatchEvent(new CustomEvent("t-changed"));
        return done;
      });
  }

  private readonly onClose = (): void => {
    this.dispatchEvent(new CustomEvent("t-close"));
  };
}

declare global {
  interface HTMLElementTagNameMap {
    "t-request-detail": RequestDetailView;
  }
}
