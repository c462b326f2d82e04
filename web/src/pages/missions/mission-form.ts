/** A mission as a form: its steps one below the other, each moved by its own buttons, and when it begins. */

import { css, html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, property, state } from "lit/decorators.js";
import { repeat } from "lit/directives/repeat.js";
import { base, plainList } from "../../elements/base/base-style.js";
import { argumentLimitText, initialText, listHint } from "../../elements/command/argument-check.js";
import { renderFormActions, renderOptions } from "../../elements/forms/form-parts.js";
import { forms } from "../../elements/forms/form-style.js";
import type { ArgumentShape, MissionShape, SiteShape, StepKind } from "../../generated/api.js";
import { commandAt, DAYS, emptyDraft, emptyStep, KINDS, movedStep, readDraft, type DraftErrors, type MissionDraft, type ScheduleKind, type StepDraft } from "./mission-draft.js";
import "../../elements/forms/button.js";
import "../../elements/forms/field.js";

const SCHEDULES = [["never", "Only when somebody presses start"], ["weekly", "On days of the week"], ["once", "Once, on a day"]] as const;

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
    return html`<form novalidate @submit=${this.onSubmit}>
      <t-field label="Name" .error=${this.errors["name"] ?? ""}><input .value=${draft.name} maxlength="200" @input=${(event: Event) => { this.change({ name: textOf(event) }); }} /></t-field>
      <t-field label="What it is for"><input .value=${draft.note} maxlength="1000" @input=${(event: Event) => { this.change({ note: textOf(event) }); }} /></t-field>
      <h3>Steps</h3>
      <ol>
        ${repeat(draft.steps, ({ key }) => key, (step, at) => html`<li>${this.renderStep(step, at)}</li>`)}
      </ol>
      <div class="moves"><t-button @click=${() => { this.change({ steps: [...draft.steps, emptyStep()] }); }}>Add a step</t-button></div>
      <h3>When it begins</h3>
      ${this.renderSchedule()} ${renderFormActions({ submit: "Save", busy: this.busy, cancel: this.onLeave })}
    </form>`;
  }

  private renderStep(step: StepDraft, at: number): TemplateResult {
    const last = this.draft.steps.length - 1;
    const change = (part: Partial<StepDraft>): void => {
      this.change({ steps: this.draft.steps.map((other) => (other.key === step.key ? { ...other, ...part } : other)) });
    };
    const error = (field: string): string => this.errors[`${String(step.key)}/${field}`] ?? "";
    const limit = step.kind === "pause" ? "Seconds" : "At most (s)";
    return html`<fieldset>
      <legend>Step ${at + 1}</legend>
      <t-field label="What"><select @change=${(event: Event) => { change({ kind: textOf(event) as StepKind }); }}>${renderOptions(KINDS, step.kind)}</select></t-field>
      ${step.kind === "command" ? this.renderCommand(step, change, error) : nothing}
      ${step.kind === "until"
        ? html`<t-field label="Until" hint="As an alarm's expression: {base/battery} > 80" .error=${error("condition")}><input .value=${step.condition} spellcheck="false" autocomplete="off" @input=${(event: Event) => { change({ condition: textOf(event) }); }} /></t-field>`
        : nothing}
      <t-field label=${limit} hint=${step.kind === "pause" ? "" : "Empty: an hour"} .error=${error("seconds")}><input inputmode="decimal" .value=${step.seconds} @input=${(event: Event) => { change({ seconds: textOf(event) }); }} /></t-field>
      <t-field label="Name" hint="Empty: what it does"><input .value=${step.name} maxlength="200" @input=${(event: Event) => { change({ name: textOf(event) }); }} /></t-field>
      <div class="moves">
        <t-button ?disabled=${at === 0} label=${`Move step ${String(at + 1)} up`} @click=${() => { this.change({ steps: movedStep(this.draft.steps, step.key, -1) }); }}>Up</t-button>
        <t-button ?disabled=${at === last} label=${`Move step ${String(at + 1)} down`} @click=${() => { this.change({ steps: movedStep(this.draft.steps, step.key, 1) }); }}>Down</t-button>
        <t-button ?disabled=${last === 0} label=${`Remove step ${String(at + 1)}`} @click=${() => { this.change({ steps: this.draft.steps.filter(({ key }) => key !== step.key) }); }}>Remove</t-button>
        ${step.kind === "pause" ? nothing : html`<label class="tick"><input type="checkbox" .checked=${step.goesOn} @change=${(event: Event) => { change({ goesOn: isTicked(event) }); }} />Go on when it fails</label>`}
      </div>
    </fieldset>`;
  }

  private renderCommand(step: StepDraft, change: (part: Partial<StepDraft>) => void, error: (field: string) => string): unknown {
    const options = (this.site?.devices ?? []).flatMap((device) => device.commands.map((command) => [`${device.id}/${command.id}`, `${device.name}: ${command.name}`] as const));
    return html`<t-field label="Command" .error=${error("command")}
        ><select @change=${(event: Event) => { change({ command: textOf(event), typed: {} }); }}>${renderOptions([["", "Choose a command"], ...options], step.command)}</select></t-field
      >
      ${(commandAt(this.site, step.command)?.arguments ?? []).map((argument) => renderArgument(argument, step, change, error(argument.id)))}`;
  }

  private renderSchedule(): TemplateResult {
    const { draft } = this;
    return html`<fieldset>
      <legend class="visually-hidden">When it begins</legend>
      <t-field label="Begins"><select @change=${(event: Event) => { this.change({ schedule: textOf(event) as ScheduleKind }); }}>${renderOptions(SCHEDULES, draft.schedule)}</select></t-field>
      ${draft.schedule === "never"
        ? nothing
        : html`<t-field label="At" hint=${`Time in ${this.site?.zone ?? "the site's zone"}`} .error=${this.errors["at"] ?? ""}><input type="time" .value=${draft.at} @input=${(event: Event) => { this.change({ at: textOf(event) }); }} /></t-field>`}
      ${draft.schedule === "once" ? html`<t-field label="Day" .error=${this.errors["date"] ?? ""}><input type="date" .value=${draft.date} @input=${(event: Event) => { this.change({ date: textOf(event) }); }} /></t-field>` : nothing}
      ${draft.schedule === "weekly"
        ? html`<div class="days" role="group" aria-label="Days; none for every day">
            ${DAYS.map(([day, name]) => html`<label class="tick"><input type="checkbox" .checked=${draft.days.includes(day)} @change=${(event: Event) => { this.tickDay(day, isTicked(event)); }} />${name}</label>`)}
          </div>`
        : nothing}
      ${draft.schedule === "never" ? nothing : html`<p class="days">It has your rights then, as they are at that time. What is missed is told, and not done late.</p>`}
    </fieldset>`;
  }

  private tickDay(day: string, ticked: boolean): void {
    const days = ticked ? [...this.draft.days, day] : this.draft.days.filter((other) => other !== day);
    this.change({ days: DAYS.map(([name]) => name).filter((name) => days.includes(name)) });
  }

  private change(part: Partial<MissionDraft>): void {
    this.draft = { ...this.draft, ...part };
    // The page keeps it: what was typed outlives an element that is drawn anew.
    this.dispatchEvent(new CustomEvent<MissionDraft>("t-draft", { detail: this.draft }));
  }

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

function renderArgument(argument: ArgumentShape, step: StepDraft, change: (part: Partial<StepDraft>) => void, error: string): TemplateResult {
  const value = step.typed[argument.id] ?? initialText(argument);
  const put = (text: string): void => {
    change({ typed: { ...step.typed, [argument.id]: text } });
  };
  if (argument.type === "boolean") {
    return html`<label class="tick"><input type="checkbox" .checked=${value === "true"} @change=${(event: Event) => { put(String(isTicked(event))); }} />${argument.name}</label>`;
  }
  const label = argument.unit === "" ? argument.name : `${argument.name} (${argument.unit})`;
  const hint = [listHint(argument), argumentLimitText(argument)].filter((part) => part !== "").join("; ");
  return html`<t-field .label=${label} .hint=${hint} .error=${error}><input .value=${value} autocomplete="off" @input=${(event: Event) => { put(textOf(event)); }} /></t-field>`;
}

function textOf(event: Event): string {
  return event.target instanceof HTMLInputElement || event.target instanceof HTMLSelectElement ? event.target.value : "";
}

function isTicked(event: Event): boolean {
  return event.target instanceof HTMLInputElement && event.target.checked;
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
