/** "At most one false alarm a week": how often a site's detectors may cry, and what their thresholds stand on. */

import { msg, str } from "@lit/localize";
import { css, html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, property, query, state } from "lit/decorators.js";
import { ActionController } from "../../controllers/action.js";
import { LoadController } from "../../controllers/load.js";
import { TickerController } from "../../controllers/ticker.js";
import { base, quietText } from "../../elements/base/base-style.js";
import { renderAdvice, renderLoaded } from "../../elements/feedback/load-state.js";
import type { StatusKind } from "../../elements/feedback/status.js";
import { control } from "../../elements/forms/input-style.js";
import { formText, submittedForm } from "../../format/form-values.js";
import { plural } from "../../words/plural.js";
import type { BudgetShape } from "../../generated/api.js";
import "../../elements/feedback/status.js";
import "../../elements/forms/button.js";
import "../../elements/forms/field.js";

/** What this needs of the hub's HTTP interface. */
export interface BudgetSource {
  showBudget(): Promise<BudgetShape>;
  changeBudget(aWeek: number | null): Promise<BudgetShape>;
}

export const FEWEST = 0.05;
export const MOST = 50;
const AGAIN_MS = 30_000;
const DAY_S = 86_400;

@customElement("t-alarm-budget")
export class AlarmBudget extends LitElement {
  static override styles = [
    base,
    control,
    css`
      :host {
        display: grid;
        gap: var(--t-space-3);
      }
      form {
        display: flex;
        flex-wrap: wrap;
        align-items: end;
        gap: var(--t-space-3) var(--t-space-4);
      }
      t-field {
        flex: 0 1 15rem;
      }
      .stands {
        display: flex;
        flex-wrap: wrap;
        align-items: baseline;
        gap: var(--t-space-1) var(--t-space-3);
      }
      .quiet {
        ${quietText}
        max-inline-size: 60rem;
      }
    `,
  ];

  @property({ attribute: false }) hub: BudgetSource | null = null;

  @state() private wrong = "";
  @query("form") private readonly form!: HTMLFormElement | null;
  private readonly loaded = new LoadController<BudgetShape>(this);
  private readonly action = new ActionController(this);
  private asked = 0;

  constructor() {
    super();
    new TickerController(this, AGAIN_MS);
  }

  protected override willUpdate(): void {
    const { hub } = this;
    if (hub === null) return;
    const due = Math.floor(Date.now() / AGAIN_MS);
    this.loaded.load(`${String(due)} ${String(this.asked)}`, () => hub.showBudget());
  }

  override render(): unknown {
    return renderLoaded(this.loaded, msg("how often they may cry"), (budget) => this.renderBudget(budget));
  }

  private renderBudget(budget: BudgetShape): TemplateResult {
    const [kind, word] = standsOf(budget);
    return html`<div class="stands"><t-status kind=${kind} word=${word}></t-status> <span>${sentenceOf(budget)}</span></div>
      <p class="quiet" role="status">${reasonOf(budget)}</p>
      ${budget.may_change ? this.renderForm(budget) : nothing} ${this.action.problem === null ? nothing : renderAdvice(this.action.problem)}`;
  }

  private renderForm(budget: BudgetShape): TemplateResult {
    const { busy } = this.action;
    return html`<form novalidate @submit=${this.onSubmit}>
      <t-field label=${msg("False alarms a week")} .error=${this.wrong}
        ><input name="a_week" type="number" inputmode="decimal" min="0" max=${MOST} step="any" .defaultValue=${budget.a_week > 0 ? String(budget.a_week) : "1"}
      /></t-field>
      <t-button kind="primary" type="submit" ?disabled=${busy} @click=${this.submit}>${budget.a_week > 0 ? msg("Change") : msg("Keep to it")}</t-button>
      ${budget.a_week > 0 ? html`<t-button ?disabled=${busy} @click=${this.switchOff}>${msg("No limit")}</t-button>` : nothing}
      ${budget.by_person ? html`<t-button ?disabled=${busy} @click=${this.asDescribed}>${msg("As described")}</t-button>` : nothing}
    </form>`;
  }

  private readonly submit = (): void => {
    this.form?.requestSubmit();
  };

  private readonly onSubmit = (event: Event): void => {
    const said = submittedForm(event);
    if (said === undefined) return;
    const aWeek = Number(formText(said, "a_week"));
    this.wrong = Number.isFinite(aWeek) && aWeek >= FEWEST && aWeek <= MOST ? "" : msg(str`Write a number from ${String(FEWEST)} to ${String(MOST)}.`);
    if (this.wrong === "") void this.change(aWeek);
  };

  private readonly switchOff = (): void => {
    void this.change(0);
  };

  private readonly asDescribed = (): void => {
    void this.change(null);
  };

  private async change(aWeek: number | null): Promise<void> {
    const { hub } = this;
    if (hub === null) return;
    await this.action.run(msg("change how often they may cry"), async () => {
      await hub.changeBudget(aWeek);
      this.asked += 1;
    });
  }
}

function standsOf({ a_week, basis, kept }: BudgetShape): readonly [StatusKind, string] {
  if (a_week === 0) return ["unknown", msg("no limit")];
  if (kept === 0) return ["warn", msg("holds for none")];
  if (basis === "learning") return ["busy", "learning"];
  return basis === "short" ? ["warn", "estimated"] : ["ok", "counted"];
}

/** How often the detectors may cry, in words. */
export function sentenceOf({ a_week, by_person, described }: BudgetShape): string {
  if (a_week === 0) return msg("Each detector goes by its own bar, however often that is.");
  const often = a_week === 1 ? msg("one false alarm a week") : a_week < 1 ? msg(str`one false alarm in ${String(Math.round(10 / a_week) / 10)} weeks`) : msg(str`${String(a_week)} false alarms a week`);
  const whose = by_person ? (described > 0 ? msg(str` (the description says ${String(described)} a week)`) : "") : msg(" (as described)");
  return msg(str`About ${often} for this site${whose}.`);
}

/** What the thresholds stand on, in words. */
export function reasonOf({ a_week, basis, seen_s, needed_s, reading, kept, others }: BudgetShape): string {
  if (a_week > 0 && kept === 0) return msg("No detector at work here can be kept to it: limits, silence and the like go by bars of their own.");
  if (a_week === 0) return msg("Say how many false alarms you bear: thresholds are then set from what the detectors said of this site's own past.");
  const seen = daysOf(seen_s);
  const needed = daysOf(needed_s);
  const read = reading === 0 ? "" : plural(reading, msg(str` The stored history of ${String(reading)} detector is still being looked at.`), msg(str` The stored history of ${String(reading)} detectors are still being looked at.`));
  const rest = others === 0 ? "" : plural(others, msg(str` ${String(others)} detector goes by bars of their own, and its anomalies come on top.`), msg(str` ${String(others)} detectors go by bars of their own, and their anomalies come on top.`));
  const words = {
    learning: msg(str`It has seen ${seen}. Before a day nothing is set, and each detector goes by its own bar.`),
    short: msg(str`It has seen ${seen}, too short to count so few: ${needed} are needed. Until then the threshold is estimated, and there may be twice as many false alarms or more, or fewer.`),
    counted: msg(str`By ${seen} of this site's past, and set anew as time passes.`),
  };
  return `${words[basis]}${read}${rest}`;
}

function daysOf(seconds: number): string {
  const hours = Math.floor(seconds / 360) / 10;
  if (hours === 0) return msg("nothing yet");
  if (seconds < 2 * DAY_S) return plural(hours, msg("one hour"), msg(str`${String(hours)} hours`));
  return msg(str`${String(Math.floor(seconds / DAY_S))} days`);
}

declare global {
  interface HTMLElementTagNameMap {
    "t-alarm-budget": AlarmBudget;
  }
}
