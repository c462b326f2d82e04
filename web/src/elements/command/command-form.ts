/** One command of a device: its arguments as a form, and what became of the last ask. */

import { msg } from "@lit/localize";
import { css, html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, property, state } from "lit/decorators.js";
import { repeat } from "lit/directives/repeat.js";
import type { ArgumentShape, CommandShape } from "../../generated/api.js";
import { base } from "../base/base-style.js";
import { forms } from "../forms/form-style.js";
import "../forms/button.js";
import "../feedback/confirm.js";
import "../forms/field.js";
import "../base/icon.js";
import "../feedback/status.js";
import { PHASES, type RequestPhase } from "./command-phases.js";
import { checkArgument, argumentLimitText, initialText, listHint, type ArgumentValue } from "./argument-check.js";

export type { RequestPhase as AskPhase };

export interface CommandRequestState {
  readonly phase: RequestPhase;
  /** The robot's own words, where it gave any. */
  readonly message: string;
  /** 0 to 1 */
  readonly progress: number;
}

/**
 * @fires t-cancel what is under way is no longer wanted
 * @fires t-ask detail are the arguments by name; it is asked once and never again by itself
 */
@customElement("t-command")
export class CommandForm extends LitElement {
  static override styles = [
    base,
    forms,
    css`
      :host {
        display: block;
      }
      .fields {
        display: grid;
        grid-template-columns: repeat(auto-fit, minmax(11rem, 1fr));
        align-items: start;
        gap: var(--t-space-3);
      }
      .fields:empty {
        display: none;
      }
      label {
        align-self: end;
        display: inline-flex;
        align-items: center;
        gap: var(--t-space-3);
        min-block-size: var(--t-touch);
        font-weight: var(--t-weight-strong);
        cursor: pointer;
      }
      input[role="switch"] {
        appearance: none;
        position: relative;
        flex: none;
        inline-size: 3rem;
        block-size: 1.75rem;
        margin: 0;
        border: 2px solid var(--t-edge);
        border-radius: 1rem;
        background: var(--t-surface);
        cursor: pointer;
      }
      input[role="switch"]::before {
        content: "";
        position: absolute;
        inset: 3px auto 3px 3px;
        aspect-ratio: 1;
        border-radius: 50%;
        background: var(--t-edge);
      }
      input[role="switch"]:checked {
        border-color: var(--t-accent);
        background: var(--t-accent);
      }
      input[role="switch"]:checked::before {
        inset: 3px 3px 3px auto;
        background: var(--t-on-accent);
      }
      .do {
        display: flex;
        flex-wrap: wrap;
        align-items: center;
        gap: var(--t-space-2) var(--t-space-4);
      }
      .state {
        display: grid;
        gap: var(--t-space-1);
        flex: 1 1 12rem;
      }
      .locked {
        color: var(--t-warn);
        font-size: var(--t-size-s);
      }
      progress {
        inline-size: 100%;
        block-size: 0.5rem;
        accent-color: var(--t-accent);
      }
      dl {
        display: grid;
        grid-template-columns: auto 1fr;
        gap: var(--t-space-1) var(--t-space-4);
        margin: var(--t-space-3) 0 0;
      }
      dd {
        margin: 0;
        font-weight: var(--t-weight-strong);
      }
    `,
  ];

  @property({ attribute: false }) command: CommandShape | null = null;
  @property({ attribute: false }) asked: CommandRequestState | null = null;
  /** The site is connected. */
  @property({ type: Boolean }) online = true;
  /** This person may use the device. */
  @property({ type: Boolean }) allowed = true;

  /** Why it cannot be asked now and who can help; empty when it can. */
  @property() locked = "";

  @state() private confirming: Readonly<Record<string, ArgumentValue>> | null = null;
  @state() private errors: Readonly<Record<string, string>> = {};
  @state() private typed: Readonly<Record<string, string>> = {};

  override render(): TemplateResult | typeof nothing {
    const { command } = this;
    if (!command) return nothing;
    const busy = this.asked !== null && ["sent", "accepted", "running"].includes(this.asked.phase);
    return html`
      <form novalidate @submit=${this.onSubmit}>
        <div>
          <h3>${command.name}</h3>
          ${command.description === "" ? nothing : html`<p class="muted">${command.description}</p>`}
        </div>
        <div class="fields">
          ${repeat(command.arguments, (argument) => argument.id, (argument) => this.renderField(argument))}
        </div>
        <div class="do">
          <t-button type="submit" ?disabled=${!this.isAllowed} ?busy=${busy}>
            ${command.confirm ? msg("Send…") : msg("Send")}
          </t-button>
          ${command.cancellable && (this.asked?.phase === "accepted" || this.asked?.phase === "running")
            ? html`<t-button ?disabled=${!this.online || !this.allowed} @click=${this.onCancelCommand}>${msg("Cancel it")}</t-button>`
            : nothing}
          <div class="state" role="status">${this.renderOutcome()}</div>
        </div>
      </form>
      <t-confirm
        heading="${command.name}?"
        action=${msg("Send")}
        kind="primary"
        keep=${msg("Do not send")}
        ?open=${this.confirming !== null}
        @t-close=${this.onCancelQuestion}
        @t-confirm=${this.onConfirm}
      >
        <p>${command.description || msg("This is sent to the robot once.")}</p>
        ${this.renderSummary()}
      </t-confirm>
    `;
  }

  private get isAllowed(): boolean {
    return this.online && this.allowed && this.locked === "";
  }

  private renderField(argument: ArgumentShape): TemplateResult {
    const value = this.typed[argument.id] ?? initialText(argument);
    if (argument.type === "boolean") {
      return html`<label
        ><input
          type="checkbox"
          role="switch"
          name=${argument.id}
          .checked=${value === "true"}
          ?disabled=${!this.allowed}
          @change=${this.onInput}
        />${argument.name}: ${value === "true" ? msg("on") : msg("off")}</label
      >`;
    }
    const number = argument.type === "number" || argument.type === "integer";
    const hint = [listHint(argument), argumentLimitText(argument)].filter((part) => part !== "").join("; ");
    const label = argument.unit === "" ? argument.name : `${argument.name} (${argument.unit})`;
    return html`<t-field .label=${label} .hint=${hint} .error=${this.errors[argument.id] ?? ""}>
      <input
        name=${argument.id}
        type="text"
        inputmode=${number ? "decimal" : "text"}
        autocomplete="off"
        .value=${value}
        ?disabled=${!this.allowed}
        @input=${this.onInput}
      />
    </t-field>`;
  }

  private renderOutcome(): unknown {
    if (!this.allowed) return html`<span class="muted">${msg("You may look, but not send this.")}</span>`;
    const lock = this.locked === "" || !this.online ? nothing : html`<span class="locked"><t-icon name="lock"></t-icon> ${this.locked}</span>`;
    if (!this.asked && lock !== nothing) return lock;
    if (!this.asked) return this.online ? nothing : html`<t-status kind="offline" word=${msg("not connected")}></t-status>`;
    const { phase, message, progress } = this.asked;
    const { kind, word } = PHASES[phase];
    return html`
      <t-status kind=${kind} .word=${word}></t-status>
      ${phase === "running" && progress > 0
        ? html`<progress max="1" .value=${progress} aria-label=${msg("Progress")}></progress>`
        : nothing}
      ${message === "" ? nothing : html`<span>${message}</span>`} ${lock}
    `;
  }

  private renderSummary(): unknown {
    const given = this.confirming;
    if (!given || !this.command || this.command.arguments.length === 0) return nothing;
    return html`<dl>
      ${repeat(
        this.command.arguments,
        (argument) => argument.id,
        (argument) => html`<dt>${argument.name}</dt>
          <dd>${valueText(given[argument.id])} ${argument.unit}</dd>`,
      )}
    </dl>`;
  }

  private readonly onInput = (event: Event): void => {
    const input = event.target as HTMLInputElement;
    const text = input.type === "checkbox" ? String(input.checked) : input.value;
    this.typed = { ...this.typed, [input.name]: text };
    if (this.errors[input.name] !== undefined) this.readArguments();
  };

  private readArguments(): Readonly<Record<string, ArgumentValue>> | null {
    const values: Record<string, ArgumentValue> = {};
    const errors: Record<string, string> = {};
    for (const argument of this.command?.arguments ?? []) {
      const checked = checkArgument(argument, this.typed[argument.id] ?? initialText(argument));
      if (checked.ok) values[argument.id] = checked.value;
      else errors[argument.id] = checked.why;
    }
    this.errors = errors;
    return Object.keys(errors).length === 0 ? values : null;
  }

  private readonly onSubmit = (event: Event): void => {
    event.preventDefault();
    if (!this.isAllowed) return;
    const values = this.readArguments();
    if (!values) return;
    if (this.command?.confirm === true) this.confirming = values;
    else this.sendCommand(values);
  };

  private readonly onConfirm = (): void => {
    const values = this.confirming;
    this.confirming = null;
    // What was asked for a moment ago may be locked by now.
    if (values && this.isAllowed) this.sendCommand(values);
  };

  private readonly onCancelQuestion = (): void => {
    this.confirming = null;
  };

  private readonly onCancelCommand = (): void => {
    this.dispatchEvent(new CustomEvent("t-cancel", { bubbles: true, composed: true }));
  };

  private sendCommand(detail: Readonly<Record<string, ArgumentValue>>): void {
    this.dispatchEvent(new CustomEvent("t-ask", { detail, bubbles: true, composed: true }));
  }
}

function valueText(value: ArgumentValue | undefined): string {
  if (value === true) return msg("on");
  return value === false ? msg("off") : String(value ?? "");
}

declare global {
  interface HTMLElementTagNameMap {
    "t-command": CommandForm;
  }
  interface GlobalEventHandlersEventMap {
    "t-ask": CustomEvent<Readonly<Record<string, ArgumentValue>>>;
  }
}
