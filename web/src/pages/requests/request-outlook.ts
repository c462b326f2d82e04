/** What would become of a request that is being typed: its charge, what is left, what forbids it, when it can be seen. */

import { consume } from "@lit/context";
import { msg, str } from "@lit/localize";
import { css, html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, property, state } from "lit/decorators.js";
import { map } from "lit/directives/map.js";
import { LoadController } from "../../controllers/load.js";
import { base } from "../../elements/base/base-style.js";
import { renderAdvice } from "../../elements/feedback/load-state.js";
import { formatChance } from "../../format/chance.js";
import { formatDuration } from "../../format/duration.js";
import { adviceFor } from "../../format/error-advice.js";
import type { GroupAsk, RequestOutlookShape, ValidationShape } from "../../generated/api.js";
import { apiContext } from "../../state/contexts.js";
import type { HubApi } from "../../wire/hub-api.js";
import { ObservingApi } from "../../wire/observing-api.js";
import { curveNight } from "./outlook-curve.js";
import "../../elements/observatory/night-curve.js";

/** So long nothing may be typed before the hub is asked (ms). */
const PAUSE_MS = 600;
/** Without a forecast of the week it is asked again so much later (ms). */
const FORECAST_MS = 5000;

@customElement("t-request-outlook")
export class RequestOutlook extends LitElement {
  static override styles = [
    base,
    css`
      :host {
        display: grid;
        gap: var(--t-space-3);
      }
      t-night-curve {
        max-inline-size: 48rem;
      }
    `,
  ];

  @property() site = "";
  /** Null while it cannot be asked. */
  @property({ attribute: false }) asked: GroupAsk | null = null;
  /** What the requests are called. */
  @property({ attribute: false }) names: readonly string[] = [];
  /** Which of them is shown: its curve is drawn. */
  @property({ type: Number }) at = 0;
  /** Whether the hub's curve of the best night is drawn, too. */
  @property({ type: Boolean }) curve = false;
  @property() zone = "UTC";
  /** What the hub is asked, as JSON; empty for nothing. */
  @state() private question = "";

  @consume({ context: apiContext }) private readonly api!: HubApi;
  private readonly answer = new LoadController<ValidationShape | null>(this);
  private typed = "";
  private timer: ReturnType<typeof setTimeout> | undefined;
  private forecastTimer: ReturnType<typeof setTimeout> | undefined;

  override willUpdate(): void {
    const typed = this.asked === null ? "" : JSON.stringify(this.asked);
    if (typed !== this.typed) {
      this.typed = typed;
      clearTimeout(this.timer);
      this.timer = setTimeout(() => {
        this.question = typed;
      }, PAUSE_MS);
    }
    const { asked, question } = this;
    if (question === typed) this.answer.load(`${this.site} ${question}`, async () => (asked === null ? null : new ObservingApi(this.api, this.site).validateGroup(asked)));
    // The hub makes one beside its other work, once somebody has asked.
    if (this.answer.value?.forecast_us === null && this.answer.result.state === "ready") {
      this.forecastTimer ??= setTimeout(() => {
        this.forecastTimer = undefined;
        this.answer.invalidate();
      }, FORECAST_MS);
    }
  }

  override disconnectedCallback(): void {
    super.disconnectedCallback();
    clearTimeout(this.timer);
    clearTimeout(this.forecastTimer);
    this.forecastTimer = undefined;
    this.typed = "";
  }

  override render(): TemplateResult {
    const { result, value } = this.answer;
    if (this.typed === "") return html`<p class="muted">${msg("What it is charged is shown once everything that it needs is written.")}</p>`;
    const isNow = this.question === this.typed && result.state !== "loading" && result.state !== "idle";
    if (isNow && result.state === "failed") return html`<div>${renderAdvice(adviceFor(result.error, msg("what this request would be charged")), this.answer.invalidate)}</div>`;
    if (value === undefined || value === null) return html`<p class="muted">${msg("Asking the hub what it is charged …")}</p>`;
    return html`<div role="status" aria-busy=${isNow ? "false" : "true"}>
        <p>${chargeText(value)}${isNow ? nothing : html` <span class="muted">${msg("(before the last change)")}</span>`}</p>
        ${value.problems.length === 0 ? nothing : html`<p>${msg("It cannot be submitted like this:")}</p><ul>${map(value.problems, (problem) => html`<li>${problem}</li>`)}</ul>`}
        ${this.renderOutlooks(value)}
      </div>
      ${this.curve && isNow ? this.renderCurve(value.requests[this.at]) : nothing}`;
  }

  private renderOutlooks(value: ValidationShape): TemplateResult {
    const { names } = this;
    const { requests, forecast_us: made } = value;
    const aside =
      made === null
        ? html`<p class="muted">${msg("How likely it is observed is shown once the week is worked out.")}</p>`
        : html`<p class="muted">${msg(str`Beside what waits already, as worked out ${formatDuration(Math.max(0, Date.now() / 1000 - made / 1e6))} ago, with a roof that is open as often as usual.`)}</p>`;
    if (names.length < 2) return html`${map(requests, (outlook) => html`<p>${msg(str`With a clear sky: ${outlook.message}.`)}</p><p>${chanceText(outlook, value)}</p>`)} ${aside}`;
    const more = names.length - requests.length;
    return html`<p>${msg("With a clear sky:")}</p>
      <ol>${map(requests, (outlook, i) => html`<li>${names[i]}: ${outlook.message}. ${chanceText(outlook, value)}</li>`)}</ol>
      ${more > 0 ? html`<p class="muted">${msg(str`Of the first ${requests.length} requests; the other ${more} are not looked at.`)}</p>` : nothing} ${aside}`;
  }

  private renderCurve({ curve = null, message = "" }: Partial<RequestOutlookShape> = {}): TemplateResult | typeof nothing {
    const drawn = curve === null ? null : curveNight(curve);
    if (drawn === null) return nothing;
    return html`<t-night-curve .night=${drawn.night} .seen=${drawn.seen} .moon=${drawn.moon} .allowed=${drawn.allowed} .ms=${Date.now()} .zone=${this.zone} .words=${message}></t-night-curve>`;
  }
}

/** How likely it is observed, tonight and in all nights that are forecast. */
function chanceText({ tonight, week, possible }: RequestOutlookShape, { forecast_us: made, forecast_nights: nights }: ValidationShape): string {
  if (made === null) return "";
  if (tonight === null || week === null) return msg("It is taken when the roof is closed or in a twilight: no plan says when.");
  if (possible === 0) return msg("Chance: none.");
  const more = nights > 1 ? msg(str`, ${formatChance(week)} within ${String(nights)} nights`) : "";
  return msg(str`Chance: ${formatChance(tonight)} tonight${more}.`);
}

function chargeText({ charge_s: charge, left_s: left, person_left_s: own }: ValidationShape): string {
  const part = own === null ? "" : msg(str`, your part of it ${formatDuration(own)}`);
  return msg(str`Charged about ${formatDuration(charge)} with pointing, readout and filters; the proposal has ${formatDuration(left)} left${part}.`);
}

declare global {
  interface HTMLElementTagNameMap {
    "t-request-outlook": RequestOutlook;
  }
}
