/** Choose two runs to be put beside each other: from recordings, drives, anomalies and notes, or by their times. */

import { consume } from "@lit/context";
import { msg, str } from "@lit/localize";
import { html, LitElement, nothing, type PropertyValues, type TemplateResult } from "lit";
import { customElement, property, query, state } from "lit/decorators.js";
import { LoadController } from "../../controllers/load.js";
import { base } from "../../elements/base/base-style.js";
import { renderOptions } from "../../elements/forms/form-parts.js";
import { forms } from "../../elements/forms/form-style.js";
import { formText } from "../../format/form-values.js";
import { formatDate, formatClock, knownZone } from "../../format/time.js";
import type { EventList } from "../../generated/api.js";
import { clockOf, momentProblem, type ZoneClock } from "../../series/zone-clock.js";
import type { TimeSpan } from "../../series/time-window.js";
import { apiContext } from "../../state/contexts.js";
import type { HubApi } from "../../wire/hub-api.js";
import { RecordingsApi } from "../../wire/recordings-api.js";
import { NotesApi } from "../notes/notes-api.js";
import { alignRuns, RUN_KINDS, runOffers, type RunOffer } from "./run-offers.js";
import "../../elements/feedback/dialog.js";
import "../../elements/forms/button.js";
import "../../elements/forms/field.js";

/** What two runs look like beside each other. */
export interface ChosenRuns {
  /** Of the first run. */
  readonly span: TimeSpan;
  /** The first run's time less the second's (µs). */
  readonly shiftUs: number;
}

const MOST_NOTES = 200;
const MOST_EVENTS = 500;

/**
 * @fires t-runs which two are compared
 * @fires t-close when it was closed, by whatever way
 */
@customElement("t-run-picker")
export class RunPicker extends LitElement {
  static override styles = [base, forms];

  @property() site = "";
  @property() zone = "UTC";
  @property({ type: Boolean }) open = false;
  /** What the first run is unless another is chosen. */
  @property({ attribute: false }) span: TimeSpan = { fromUs: 0, toUs: 1 };

  @state() private mistakes: Readonly<Record<string, string>> = {};
  @query("form") private readonly form!: HTMLFormElement;
  @consume({ context: apiContext }) private readonly api!: HubApi;
  private readonly offers = new LoadController<readonly RunOffer[]>(this);

  protected override willUpdate(): void {
    if (this.open) this.offers.load(this.site, () => this.loadOffers());
  }

  protected override updated(changed: PropertyValues<this>): void {
    if (!changed.has("open") || !this.open) return;
    this.mistakes = {};
    this.fill("first", this.span);
  }

  override render(): TemplateResult {
    return html`<t-dialog heading=${msg("Compare two runs")} ?open=${this.open} @t-close=${this.closePicker}>
      <form class="entry" novalidate @submit=${this.onSubmit} @change=${this.onChange}>
        ${this.renderRun("first", msg("First run"))} ${this.renderRun("second", msg("Second run"))}
        <p>${msg("They are laid over each other at their starts. A note at a moment is a mark: choose one in each run, and they meet there.")}</p>
        ${this.offers.result.state === "failed" ? html`<p role="alert">${msg("What was recorded and noted cannot be loaded now; write the times.")}</p>` : nothing}
      </form>
      <t-button slot="actions" @click=${this.closePicker}>${msg("Cancel")}</t-button>
      <t-button slot="actions" kind="primary" @click=${this.chooseRuns}>${msg("Compare")}</t-button>
    </t-dialog>`;
  }

  private renderRun(run: "first" | "second", label: string): TemplateResult {
    const { zone } = this.clock();
    const options = (this.offers.value ?? []).map(({ id, name, fromUs }) => [id, `${formatDate(fromUs, zone)}, ${formatClock(fromUs, zone)} ${name}`] as const);
    const time = (end: "from" | "to", name: string): TemplateResult =>
      html`<t-field label=${name} .error=${this.mistakes[`${run}-${end}`] ?? ""}><input name=${`${run}-${end}`} type="text" autocomplete="off" maxlength="30" placeholder="2026-03-29 14:05:09" /></t-field>`;
    return html`<t-field class="wide" label=${label}><select name=${run}>${renderOptions([["", msg("by its times")], ...options], "")}</select></t-field>${time("from", msg(str`${label}, from (${zone})`))}${time("to", msg(str`${label}, until (${zone})`))}`;
  }

  /** Who may not see recordings compares by the rest. */
  private async loadOffers(): Promise<readonly RunOffer[]> {
    const recordings = new RecordingsApi(this.api).listRecordings(this.site).then(({ recordings: found }) => found, () => []);
    const events = this.api.request<EventList>("GET", `/api/sites/${encodeURIComponent(this.site)}/events?kind=${RUN_KINDS}&limit=${String(MOST_EVENTS)}`).then(({ events: found }) => found, () => []);
    const { notes } = await new NotesApi(this.api, this.site).findNotes(`limit=${String(MOST_NOTES)}`);
    return runOffers(await recordings, notes, await events);
  }

  private clock(): ZoneClock {
    return clockOf(knownZone(this.zone));
  }

  private field(name: string): HTMLInputElement | null {
    const found = this.form.elements.namedItem(name);
    return found instanceof HTMLInputElement ? found : null;
  }

  private fill(run: string, { fromUs, toUs }: TimeSpan): void {
    const clock = this.clock();
    const [from, to] = [this.field(`${run}-from`), this.field(`${run}-to`)];
    if (from !== null) from.value = clock.toInput(fromUs);
    if (to !== null) to.value = toUs > fromUs ? clock.toInput(toUs) : "";
  }

  private readonly onChange = (event: Event): void => {
    if (!(event.target instanceof HTMLSelectElement)) return;
    const { name, value } = event.target;
    const offer = this.offers.value?.find(({ id }) => id === value);
    if (offer !== undefined) this.fill(name, offer);
  };

  private readonly onSubmit = (event: SubmitEvent): void => {
    event.preventDefault();
    this.chooseRuns();
  };

  private readonly chooseRuns = (): void => {
    const said = new FormData(this.form);
    const clock = this.clock();
    const mistakes: Record<string, string> = {};
    const [first, second] = ["first", "second"].map((run): TimeSpan => {
      const [from, to] = [formText(said, `${run}-from`), formText(said, `${run}-to`)];
      const fromUs = clock.fromInput(from);
      const toUs = to === "" ? fromUs : clock.fromInput(to);
      if (Number.isNaN(fromUs)) mistakes[`${run}-from`] = momentProblem(from || "?", fromUs);
      if (Number.isNaN(toUs)) mistakes[`${run}-to`] = momentProblem(to, toUs);
      else if (toUs < fromUs) mistakes[`${run}-to`] = msg("It ends before it begins.");
      return { fromUs, toUs };
    });
    if (first !== undefined && second !== undefined && first.fromUs === second.fromUs) mistakes["second-from"] = msg("That is the first run itself.");
    this.mistakes = mistakes;
    if (Object.keys(mistakes).length > 0 || first === undefined || second === undefined) return;
    this.dispatchEvent(new CustomEvent<ChosenRuns>("t-runs", { detail: alignRuns(first, second) }));
  };

  private readonly closePicker = (): void => {
    this.dispatchEvent(new CustomEvent("t-close"));
  };
}

declare global {
  interface HTMLElementTagNameMap {
    "t-run-picker": RunPicker;
  }
  interface HTMLElementEventMap {
    "t-runs": CustomEvent<ChosenRuns>;
  }
}
