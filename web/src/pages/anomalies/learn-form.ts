/** "Learn from Tuesday's run": a stretch of the history that shows a group as it usually is. */

import { msg, str } from "@lit/localize";
import { css, html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, property, query, state } from "lit/decorators.js";
import { map } from "lit/directives/map.js";
import { ActionController } from "../../controllers/action.js";
import { base, quietText } from "../../elements/base/base-style.js";
import { control } from "../../elements/forms/input-style.js";
import { renderAdvice } from "../../elements/feedback/load-state.js";
import { clockOf, momentProblem } from "../../series/zone-clock.js";
import { subjectOf, type Detector } from "../../state/anomaly-detectors.js";
import { formText, submittedForm } from "../../format/form-values.js";
import type { LearnAnswer } from "../../generated/api.js";
import type { TimeWindow } from "../../wire/hub-api.js";
import "../../elements/forms/button.js";
import "../../elements/forms/field.js";

/** What this needs of the hub's HTTP interface. */
export interface LearnTarget {
  learnUsual(site: string, address: string, span: TimeWindow, comment: string): Promise<LearnAnswer>;
}

const HOUR_US = 3600e6;

@customElement("t-learn-form")
export class LearnForm extends LitElement {
  static override styles = [
    base,
    control,
    css`
      form {
        display: flex;
        flex-wrap: wrap;
        align-items: end;
        gap: var(--t-space-3) var(--t-space-4);
      }
      t-field {
        flex: 1 1 13rem;
        max-inline-size: 22rem;
      }
      .said {
        ${quietText}
        margin-block-start: var(--t-space-3);
      }
      .said:empty {
        display: none;
      }
    `,
  ];

  @property() site = "";
  @property() zone = "UTC";
  @property({ attribute: false }) groups: readonly Detector[] = [];
  @property({ attribute: false }) hub: LearnTarget | null = null;

  @state() private errors = { from: "", to: "" };
  @state() private learned = "";
  @query("form") private readonly form!: HTMLFormElement;
  private readonly action = new ActionController(this);

  override render(): TemplateResult {
    const clock = clockOf(this.zone);
    const now = Date.now() * 1000;
    const moment = (name: string, label: string, us: number, error: string): TemplateResult =>
      html`<t-field label=${`${label} (${clock.zone})`} .error=${error}
        ><input name=${name} type="text" autocomplete="off" maxlength="30" placeholder="2026-03-29 14:05:09" .defaultValue=${clock.toInput(us)}
      /></t-field>`;
    return html`<form novalidate @submit=${this.onSubmit}>
        <t-field label=${msg("Group")}>
          <select name="group">
            ${map(this.groups, (group) => html`<option value=${group.address}>${subjectOf(group)}</option>`)}
          </select>
        </t-field>
        ${moment("from", msg("From", { id: "from.time" }), now - HOUR_US, this.errors.from)} ${moment("to", msg("To", { id: "to.time" }), now, this.errors.to)}
        <t-field label=${msg("Which run it was (optional)")}><input name="comment" autocomplete="off" maxlength="500" /></t-field>
        <t-button kind="primary" type="submit" ?disabled=${this.action.busy} @click=${this.submit}>${this.action.busy ? msg("Learning…") : msg("Learn from it")}</t-button>
      </form>
      <p class="said" role="status">${this.learned}</p>
      ${this.action.problem === null ? nothing : renderAdvice(this.action.problem)}`;
  }

  private readonly submit = (): void => {
    this.form.requestSubmit();
  };

  private readonly onSubmit = (event: Event): void => {
    const said = submittedForm(event);
    if (said === undefined) return;
    const text = (name: string): string => formText(said, name);
    const clock = clockOf(this.zone);
    const fromUs = clock.fromInput(text("from"));
    const toUs = clock.fromInput(text("to"));
    const needed = msg("Write it like 2026-03-29 14:05:09.");
    const wrong = (typed: string, us: number): string => (typed === "" ? needed : momentProblem(typed, us));
    this.errors = { from: wrong(text("from"), fromUs), to: wrong(text("to"), toUs) };
    if (this.errors.to === "" && fromUs >= toUs) this.errors = { ...this.errors, to: msg("The stretch ends after it begins.") };
    if (this.errors.from !== "" || this.errors.to !== "") return;
    void this.learn(text("group"), { fromUs: Math.round(fromUs), toUs: Math.round(toUs) }, text("comment"));
  };

  private async learn(address: string, span: TimeWindow, comment: string): Promise<void> {
    const { hub, site } = this;
    if (hub === null) return;
    this.learned = "";
    const group = this.groups.find((known) => known.address === address);
    await this.action.run(msg("learn from this stretch"), async () => {
      this.learned = learnedText(group === undefined ? address : subjectOf(group), await hub.learnUsual(site, address, span, comment));
    });
  }
}

/** What was learned, in words. */
export function learnedText(group: string, { rows, modes, still }: LearnAnswer): string {
  const ways = modes.length === 0 ? "" : msg(str`, in the ways of running ${modes.join(", ")}`);
  const missing = still.length === 0 ? "" : msg(str` Of ${still.join(", ")} there was too little in it; it learns these as they come.`);
  return msg(str`${group} has learned from ${String(rows)} steps${ways}. What it knew before is forgotten.${missing}`);
}

declare global {
  interface HTMLElementTagNameMap {
    "t-learn-form": LearnForm;
  }
}
