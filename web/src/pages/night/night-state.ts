/** How the night stands, and for whoever may: arming it and disarming it, each after a question. */

import { consume } from "@lit/context";
import { msg, str } from "@lit/localize";
import { css, html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, property, state } from "lit/decorators.js";
import { QuestionController } from "../../controllers/question.js";
import { base } from "../../elements/base/base-style.js";
import { renderQuestion } from "../../elements/feedback/question.js";
import { sheets } from "../../elements/layout/page-sections.js";
import { PHASE_WORDS } from "../../format/observing-words.js";
import { formatClock, zoneName } from "../../format/time.js";
import type { NightAnswer, NightStateShape } from "../../generated/api.js";
import { apiContext } from "../../state/contexts.js";
import { sitePath } from "../../state/router.js";
import { Refused, type HubApi } from "../../wire/hub-api.js";
import { ObservingApi } from "../../wire/observing-api.js";
import "../../elements/feedback/status.js";
import "../../elements/forms/button.js";
import "../../elements/forms/choice.js";
import "../../elements/values/time.js";

type NightQuestion = "arm" | "disarm" | "short";
type ArmedFor = "night" | "longer";

/** @fires t-changed it was armed or disarmed */
@customElement("t-night-state")
export class NightStatePanel extends LitElement {
  static override styles = [
    base,
    sheets,
    css`
      .phase {
        display: flex;
        flex-wrap: wrap;
        align-items: baseline;
        gap: var(--t-space-1) var(--t-space-4);
      }
      .phase t-status {
        font-size: var(--t-size-l);
      }
      .facts {
        font-size: var(--t-size-m);
      }
      progress {
        inline-size: min(20rem, 100%);
        accent-color: var(--t-accent);
      }
      .texts {
        display: grid;
        gap: var(--t-space-3);
      }
    `,
  ];

  @property() site = "";
  /** Null before the gateway has said anything. */
  @property({ attribute: false }) night: NightStateShape | null = null;
  /** What is observed is called so; empty where that is not open to the person. */
  @property() target = "";
  /** The end of this night (µs since the epoch, UTC); 0 where nobody knows it. */
  @property({ attribute: false }) morningUs = 0;
  @property({ attribute: false }) mayArm = false;
  /** It is a simulator: a night in minutes can be tried. */
  @property({ type: Boolean }) simulated = false;
  /** The simulated site at which a whole night can be lived through at high speed, or empty. */
  @property({ attribute: false }) timeLapse = "";
  /** So many times as fast does this site live; 0: as everybody. */
  @property({ attribute: false }) speed = 0;
  /** Its gateway is there. */
  @property({ type: Boolean }) online = false;
  @property() zone = "UTC";
  @state() private armedFor: ArmedFor = "night";

  @consume({ context: apiContext }) private readonly api!: HubApi;
  private readonly question = new QuestionController<NightQuestion>(this, (asked) => this.performAsked(asked));

  override render(): TemplateResult {
    const { night } = this;
    const words = night === null ? null : PHASE_WORDS[night.phase];
    const armed = night !== null && night.phase !== "disarmed";
    return html`<section class="sheet" aria-label=${msg("State of the night")}>
      <div class="head">
        <div>
          <div class="phase" role="status">
            ${words === null
              ? html`<t-status kind="unknown" word=${msg("The gateway has not said how the night stands")}></t-status>`
              : html`<t-status kind=${this.online ? words.kind : "stale"} word=${words.word}></t-status>`}
            ${night === null || night.since_us === 0 ? nothing : html`<span class="muted">${msg(html`since <t-time .us=${night.since_us} .zone=${this.zone}></t-time>`)}</span>`}
          </div>
          ${words === null ? nothing : html`<p>${night?.why === "" ? words.meaning : night?.why}</p>`}
          ${night === null ? nothing : this.renderArmed(night)}
        </div>
        ${this.mayArm
          ? html`<div class="actions">
              ${this.simulated ? html`<t-button ?hidden=${armed} ?disabled=${!this.online} @click=${this.question.opener("short")}>${this.lapses ? msg("A whole night at high speed…") : msg("A night in minutes…")}</t-button>` : nothing}
              ${this.lapses ? nothing : html`<t-button kind="primary" ?hidden=${armed} ?disabled=${!this.online} @click=${this.question.opener("arm")}>${msg("Arm…")}</t-button>`}
              <t-button kind="danger" ?hidden=${!armed} ?disabled=${!this.online} @click=${this.question.opener("disarm")}>${msg("Disarm…")}</t-button>
            </div>`
          : nothing}
      </div>
      ${this.lapses || this.timeLapse === ""
        ? nothing
        : html`<p class="muted">
            ${msg(html`<a href=${sitePath(this.timeLapse, "night")}>A whole night at high speed</a>: the same observatory once more, in a time lapse.`)}
          </p>`}
      ${night === null || night.step === "" ? nothing : this.renderBlock(night)} ${this.renderQuestions()}
    </section>`;
  }

  private renderArmed(night: NightStateShape): unknown {
    if (night.phase === "disarmed") return this.mayArm ? nothing : html`<p class="muted">${msg("Your role may not arm it.")}</p>`;
    const who = html`<strong>${night.armed_by}</strong>`;
    const until = html`<t-time .us=${night.armed_until_us} .zone=${this.zone}></t-time>`;
    if (night.armed_until_us === 0) {
      return html`<p class="muted">${night.armed_by === "" ? msg("Armed until somebody disarms it.") : msg(html`Armed by ${who}, until somebody disarms it.`)}</p>`;
    }
    return html`<p class="muted">${night.armed_by === "" ? msg(html`Armed until ${until}.`) : msg(html`Armed by ${who}, until ${until}.`)}</p>`;
  }

  private renderBlock({ step, request, frames_done: done, frames }: NightStateShape): TemplateResult {
    const name = this.target === "" ? (request === "" ? "" : msg("a request that is not open to you")) : this.target;
    return html`<div class="facts">
      <span><strong>${name}</strong></span>
      <span>${step}</span>
      ${frames === 0
        ? nothing
        : html`<span>${msg(str`${done} of ${frames} frames`)}</span>
            <progress aria-label=${msg("Frames")} max=${frames} .value=${Math.min(done, frames)}></progress>`}
    </div>`;
  }

  private renderQuestions(): TemplateResult {
    const morning = `${formatClock(this.morningUs, this.zone).slice(0, 5)} ${zoneName(this.morningUs, this.zone)} (${formatClock(this.morningUs, "UTC").slice(0, 5)} UTC)`;
    const options = [
      ...(this.morningUs > 0 ? [{ id: "night", label: msg(str`For this night, to ${morning}`) }] : []),
      { id: "longer", label: msg("Until disarmed") },
    ];
    if (this.question.subject === "short" && this.lapses) {
      return renderQuestion(this.question, () => ({
        heading: msg("Run a whole night at high speed?"),
        action: msg("Run"),
        text: msg(str`This observatory is simulated, and so is its time: its next night passes ${this.speed.toFixed(0)} times as fast as one does. A dozen targets are asked for, and the night is armed to the morning: the roof opens when the sky is dark, the telescope focuses, centres and observes, closes when the weather wants it, and parks at dawn. Plan, sky, pictures and log follow below.`),
        kind: "primary",
      }));
    }
    if (this.question.subject === "short") {
      return renderQuestion(this.question, () => ({
        heading: msg("Run a night in minutes?"),
        action: msg("Run"),
        text: msg("This observatory is simulated. Three targets that stand high just now are asked for, with two frames of 5 s each, and the night is armed for half an hour: the roof opens, the telescope observes, and when all is done or it rains it parks and closes. Plan, sky, pictures and log follow below."),
        kind: "primary",
      }));
    }
    return renderQuestion(this.question, (asked) =>
      asked === "arm"
        ? {
            heading: msg("Arm the night?"),
            action: msg("Arm"),
            kind: "primary",
            text: html`<div class="texts">
              <p>
                ${msg("The roof opens by itself and the telescope moves without anybody at it, as soon as the Sun, the weather and every interlock allow it. Make sure that nobody is in the dome.")}
              </p>
              <t-choice label=${msg("For how long")} .options=${options} .chosen=${this.chosenFor} @t-choose=${this.onChoose}></t-choice>
            </div>`,
          }
        : { heading: msg("Disarm the night?"), action: msg("Disarm"), text: msg("The exposure is aborted; telescope and roof park and close. Frames that were read out are kept.") },
    );
  }

  private get lapses(): boolean {
    return this.speed > 0;
  }

  private get chosenFor(): ArmedFor {
    return this.morningUs > 0 ? this.armedFor : "longer";
  }

  private readonly onChoose = (event: CustomEvent<string>): void => {
    this.armedFor = event.detail === "longer" ? "longer" : "night";
  };

  private performAsked(asked: NightQuestion): Promise<boolean> {
    const api = new ObservingApi(this.api, this.site);
    const perform = asked === "short" ? (): Promise<NightAnswer> => api.beginShortNight() : asked === "arm" ? (): Promise<NightAnswer> => api.armNight(this.chosenFor === "night" ? this.morningUs : 0) : (): Promise<NightAnswer> => api.disarmNight("");
    return this.question.action
      .run(asked === "short" ? msg("run a night in minutes") : msg(str`${asked} the night`), async () => {
        const { refused } = await perform();
        if (refused !== "") throw new Refused(409, "refused", refused);
      })
      .then((done) => {
        this.dispatchEvent(new CustomEvent("t-changed"));
        return done;
      });
  }
}

declare global {
  interface HTMLElementTagNameMap {
    "t-night-state": NightStatePanel;
  }
}
