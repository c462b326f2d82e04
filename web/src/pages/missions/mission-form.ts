/** A mission as a form: its steps one below the other, each moved by its own buttons, and when it begins. */

import { msg, str } from "@lit/localize";
import { css, html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, property, state } from "lit/decorators.js";
import { map } from "lit/directives/map.js";
import { repeat } from "lit/directives/repeat.js";
import { base, plainList } from "../../elements/base/base-style.js";
import { settled } from "../../elements/base/stable-field.js";
import { argumentLimitText, initialText, listHint } from "../../elements/command/argument-check.js";
import { renderFormActions, renderOptions } from "../../elements/forms/form-parts.js";
import { forms } from "../../elements/forms/form-style.js";
import type { ArgumentShape, MissionShape, SiteShape } from "../../generated/api.js";
import { commandAt, DAYS, emptyDraft, emptyStep, KINDS, movedStep, readDraft, type DraftErrors, type MissionDraft, type StepDraft } from "./mission-draft.js";
import "../../elements/forms/button.js";
import "../../elements/forms/field.js";

const SCHEDULES = [["never", msg("Only when somebody presses start")], ["weekly", msg("On days of the week")], ["once", msg("Once, on a day")]] as const;

/**
 * @fires t-save-mission detail is the mission
 * @fires t-draft detail is what is typed now
 * @fires t-leave the form is left
 */
@customElement("t-mission-form")
export class MissionForm extends LitElement {
  static override styles = [
    base,
    forms,
    css`
      :host {
        display: block;
      }
      ol {
        display: grid;
        gap: var(--t-space-3);
        ${plainList}
      }
      fieldset {
        display: grid;
        grid-template-columns: repeat(auto-fill, minmax(min(13rem, 100%), 1fr));
        align-items: start;
        gap: var(--t-space-3) var(--t-space-4);
        min-inline-size: 0;
        margin: 0;
        padding: var(--t-space-3);
        border: 1px solid var(--t-line);
        border-radius: var(--t-radius-s);
      }
      legend {
        padding-inline: var(--t-space-1);
        font-weight: var(--t-weight-strong);
      }
      /* What is chosen by name is read in full. */
      @media (min-width: 45rem) {
        .named {
          grid-column: span 2;
        }
      }
      .moves,
      .days {
        grid-column: 1 / -1;
        display: flex;
        flex-wrap: wrap;
        align-items: center;
        gap: var(--t-space-1) var(--t-space-3);
      }
      input[type="checkbox"] {
        inline-size: 1.25rem;
        block-size: 1.25rem;
        accent-color: var(--t-accent);
      }
    `,
  ];

  @property({ attribute: false }) site: SiteShape | null = null;
  @property({ attribute: false }) draft: MissionDraft = emptyDraft();
  @property({ type: Boolean }) busy = false;
  @state() private errors: DraftErrors = {};

  override render(): TemplateResult {
    const { draft } = this;
    return html`<form novalidate @submit=${this.onSubmit} @input=${this.onInput}>
      <t-field label=${msg("Name")} .error=${this.errors["name"] ?? ""}><input data-field="name" .value=${settled(draft.name)} maxlength="200" /></t-field>
      <t-field label=${msg("What it is for")}><input data-field="note" .value=${settled(draft.note)} maxlength="1000" /></t-field>
      <h3>${msg("Steps")}</h3>
      <ol>
        ${repeat(draft.steps, ({ key }) => key, (step, at) => html`<li>${this.renderStep(step, at)}</li>`)}
      </ol>
      <div class="moves"><t-button @click=${this.addStep}>${msg("Add a step")}</t-button></div>
      <h3>${msg("When it begins")}</h3>
      ${this.renderSchedule()} ${renderFormActions({ submit: msg("Save"), busy: this.busy, cancel: this.onLeave })}
    </form>`;
  }

  private renderStep(step: StepDraft, at: number): TemplateResult {
    const last = this.draft.steps.length - 1;
    const error = (field: string): string => this.errors[`${String(step.key)}/${field}`] ?? "";
    const limit = step.kind === "pause" ? msg("Seconds") : msg("At most (s)");
    return html`<fieldset data-step=${step.key}>
      <legend>${msg(str`Step ${at + 1}`)}</legend>
      <t-field label=${msg("What")}><select data-field="kind">${renderOptions(KINDS, step.kind)}</select></t-field>
      ${step.kind === "command" ? this.renderCommand(step, error) : nothing}
      ${step.kind === "until"
        ? html`<t-field label=${msg("Until")} hint=${msg("As an alarm's expression: {base/battery} > 80")} .error=${error("condition")}><input data-field="condition" .value=${settled(step.condition)} spellcheck="false" autocomplete="off" /></t-field>`
        : nothing}
      <t-field label=${limit} hint=${step.kind === "pause" ? "" : msg("Empty: an hour")} .error=${error("seconds")}><input data-field="seconds" inputmode="decimal" .value=${settled(step.seconds)} /></t-field>
      <t-field label=${msg("Name")} hint=${msg("Empty: what it does")}><input data-field="name" .value=${settled(step.name)} maxlength="200" /></t-field>
      <div class="moves">
        <t-button ?disabled=${at === 0} label=${msg(str`Move step ${String(at + 1)} up`)} @click=${this.moveUp}>${msg("Up")}</t-button>
        <t-button ?disabled=${at === last} label=${msg(str`Move step ${String(at + 1)} down`)} @click=${this.moveDown}>${msg("Down")}</t-button>
        <t-button ?disabled=${last === 0} label=${msg(str`Remove step ${String(at + 1)}`)} @click=${this.removeStep}>${msg("Remove")}</t-button>
        ${step.kind === "pause" ? nothing : html`<label class="tick"><input data-field="goesOn" type="checkbox" .checked=${step.goesOn} />${msg("Go on when it fails")}</label>`}
      </div>
    </fieldset>`;
  }

  private renderCommand(step: StepDraft, error: (field: string) => string): TemplateResult {
    const options = (this.site?.devices ?? []).flatMap((device) => device.commands.map((command) => [`${device.id}/${command.id}`, `${device.name}: ${command.name}`] as const));
    return html`<t-field class="named" label=${msg("Command")} .error=${error("command")}
        ><select data-field="command">${renderOptions([["", msg("Choose a command")], ...options], step.command)}</select></t-field
      >
      ${map(commandAt(this.site, step.command)?.arguments, (argument) => renderArgument(argument, step, error(argument.id)))}`;
  }

  private renderSchedule(): TemplateResult {
    const { draft } = this;
    return html`<fieldset>
      <legend class="visually-hidden">${msg("When it begins")}</legend>
      <t-field class="named" label=${msg("Begins")}><select data-field="schedule">${renderOptions(SCHEDULES, draft.schedule)}</select></t-field>
      ${draft.schedule === "never"
        ? nothing
        : html`<t-field label=${msg("At")} hint=${msg(str`Time in ${this.site?.zone ?? msg("the site's zone")}`)} .error=${this.errors["at"] ?? ""}><input data-field="at" type="time" .value=${settled(draft.at)} /></t-field>`}
      ${draft.schedule === "once" ? html`<t-field label=${msg("Day")} .error=${this.errors["date"] ?? ""}><input data-field="date" type="date" .value=${settled(draft.date)} /></t-field>` : nothing}
      ${draft.schedule === "weekly"
        ? html`<div class="days" role="group" aria-label=${msg("Days; none for every day")}>
            ${map(DAYS, ([day, name]) => html`<label class="tick"><input data-field="days" type="checkbox" .value=${day} .checked=${draft.days.includes(day)} />${name}</label>`)}
          </div>`
        : nothing}
      ${draft.schedule === "never" ? nothing : html`<p class="days">${msg("It has your rights then, as they are at that time. What is missed is told, and not done late.")}</p>`}
    </fieldset>`;
  }

  private change(draft: MissionDraft): void {
    this.draft = draft;
    // The page keeps it: what was typed outlives an element that is drawn anew.
    this.dispatchEvent(new CustomEvent<MissionDraft>("t-draft", { detail: draft }));
  }

  /** Reads what is so now, not what was when the form was drawn: several fields may change in between. */
  private readonly onInput = (event: Event): void => {
    const control = event.target;
    if (!isControl(control)) return;
    const { draft } = this;
    const key = stepOf(control);
    if (key === null) this.change(withField(draft, control));
    else this.change({ ...draft, steps: draft.steps.map((step) => (step.key === key ? withStepField(step, control) : step)) });
  };

  private readonly addStep = (): void => {
    this.change({ ...this.draft, steps: [...this.draft.steps, emptyStep()] });
  };

  private readonly moveUp = (event: Event): void => {
    this.moveStep(event, -1);
  };

  private readonly moveDown = (event: Event): void => {
    this.moveStep(event, 1);
  };

  private moveStep(event: Event, by: -1 | 1): void {
    const key = stepOf(event.currentTarget);
    if (key !== null) this.change({ ...this.draft, steps: movedStep(this.draft.steps, key, by) });
  }

  private readonly removeStep = (event: Event): void => {
    const removed = stepOf(event.currentTarget);
    this.change({ ...this.draft, steps: this.draft.steps.filter(({ key }) => key !== removed) });
  };

  private readonly onSubmit = (event: Event): void => {
    event.preventDefault();
    if (this.site === null) return;
    const { mission, errors } = readDraft(this.draft, this.site);
    this.errors = errors;
    if (mission !== null) this.dispatchEvent(new CustomEvent<MissionShape>("t-save-mission", { detail: mission }));
  };

  private readonly onLeave = (): void => {
    this.dispatchEvent(new CustomEvent("t-leave"));
  };
}

function renderArgument(argument: ArgumentShape, step: StepDraft, error: string): TemplateResult {
  const value = step.typed[argument.id] ?? initialText(argument);
  if (argument.type === "boolean") {
    return html`<label class="tick"><input data-argument=${argument.id} type="checkbox" .checked=${value === "true"} />${argument.name}</label>`;
  }
  const label = argument.unit === "" ? argument.name : `${argument.name} (${argument.unit})`;
  const hint = [listHint(argument), argumentLimitText(argument)].filter((part) => part !== "").join("; ");
  return html`<t-field .label=${label} .hint=${hint} .error=${error}><input data-argument=${argument.id} .value=${settled(value)} autocomplete="off" /></t-field>`;
}

type Control = HTMLInputElement | HTMLSelectElement;

function isControl(target: EventTarget | null): target is Control {
  return target instanceof HTMLInputElement || target instanceof HTMLSelectElement;
}

/** The key of the step that an element belongs to; null: to none. */
function stepOf(target: EventTarget | null): number | null {
  const key = target instanceof Element ? target.closest<HTMLElement>("[data-step]")?.dataset["step"] : undefined;
  return key === undefined ? null : Number(key);
}

function isTicked(control: Control): boolean {
  return control instanceof HTMLInputElement && control.checked;
}

function withField(draft: MissionDraft, control: Control): MissionDraft {
  const field = control.dataset["field"] ?? "";
  if (field === "days") {
    const days = DAYS.map(([day]) => day).filter((day) => (day === control.value ? isTicked(control) : draft.days.includes(day)));
    return { ...draft, days };
  }
  return field in draft ? { ...draft, [field]: control.value } : draft;
}

function withStepField(step: StepDraft, control: Control): StepDraft {
  const { field = "", argument } = control.dataset;
  if (argument !== undefined) return { ...step, typed: { ...step.typed, [argument]: control.type === "checkbox" ? String(isTicked(control)) : control.value } };
  if (field === "goesOn") return { ...step, goesOn: isTicked(control) };
  // Another command has other arguments.
  if (field === "command") return { ...step, command: control.value, typed: {} };
  return field in step ? { ...step, [field]: control.value } : step;
}

declare global {
  interface HTMLElementTagNameMap {
    "t-mission-form": MissionForm;
  }
  interface GlobalEventHandlersEventMap {
    "t-save-mission": CustomEvent<MissionShape>;
    "t-draft": CustomEvent<MissionDraft>;
  }
}
