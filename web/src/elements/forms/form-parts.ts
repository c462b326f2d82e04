/** Parts that forms share: choices, and the bar of buttons below them. */

import { msg } from "@lit/localize";
import { html, nothing, type TemplateResult } from "lit";
import { map } from "lit/directives/map.js";
import "./button.js";
import "./copy-text.js";

/** What can be chosen: a word that is its own value, or a value with its words. */
export type SelectOption = string | readonly [value: string, label: unknown];

/** The options of a `<select>`. */
export function renderOptions(options: Iterable<SelectOption>, chosen: string): unknown {
  return map(options, (option) => {
    const [value, label] = typeof option === "string" ? [option, option] : option;
    return html`<option value=${value} .selected=${value === chosen}>${label}</option>`;
  });
}

interface FormActions {
  /** Words of the button that sends the form. */
  readonly submit: string;
  readonly busy: boolean;
  /** For a form that can be left. */
  readonly cancel?: () => void;
}

/** The bar below a form: what sends it comes first. */
export function renderFormActions({ submit, busy, cancel }: FormActions, more: unknown = nothing): TemplateResult {
  return html`<div class="actions">
    <t-button type="submit" kind="primary" ?busy=${busy}>${submit}</t-button>
    ${cancel === undefined ? nothing : html`<t-button @click=${cancel}>${msg("Cancel")}</t-button>`} ${more}
  </div>`;
}

interface ShownOnce {
  /** What it is, as the copying button names it. */
  readonly label: string;
  readonly secret: string;
  /** Words of the button after which it is forgotten here. */
  readonly done: string;
  readonly onDone: () => void;
}

/** A secret that the hub says once: why to keep it, itself, and how it is used. */
export function renderShownOnce({ label, secret, done, onDone }: ShownOnce, why: TemplateResult, use: unknown = nothing): TemplateResult {
  return html`<div class="fields" style="max-inline-size: 46rem">
    <p>${why}</p>
    <t-copy label=${label} .text=${secret}></t-copy>
    ${use}
    <div class="actions"><t-button kind="primary" @click=${onDone}>${done}</t-button></div>
  </div>`;
}
