import { msg, str } from "@lit/localize";
import { css, html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, property, state } from "lit/decorators.js";
import { map } from "lit/directives/map.js";
import { repeat } from "lit/directives/repeat.js";
import { base, quietText } from "../../elements/base/base-style.js";
import { renderOptions } from "../../elements/forms/form-parts.js";
import { plural } from "../../words/plural.js";
import { UNITS } from "../../generated/units.js";
import type { Schema } from "../../wire/descriptions-api.js";
import type { FindingShape } from "../../generated/api.js";
import { emptyOf, schemaFields, freeName, isObject, pathOf, type FormEdit, type SchemaField, type Json, type JsonObject, type JsonPath } from "./json-schema.js";
import "../../elements/forms/button.js";
import "../../elements/forms/field.js";

/**
 * The form of one part of a description: its own lines, and the forms of its parts below it.
 *
 * @fires t-edit detail is a FormEdit; it bubbles
 */
@customElement("t-form-part")
export class SchemaForm extends LitElement {
  static override styles = [
    base,
    css`
      :host {
        display: grid;
        grid-template-columns: minmax(0, 1fr);
        gap: var(--t-space-3);
        min-inline-size: 0;
      }
      .lines {
        display: grid;
        grid-template-columns: repeat(auto-fill, minmax(min(100%, 15rem), 1fr));
        align-items: start;
        gap: var(--t-space-3) var(--t-space-4);
      }
      .truth {
        display: flex;
        align-items: center;
        gap: var(--t-space-2);
        min-block-size: var(--t-touch);
        font-weight: var(--t-weight-strong);
        font-size: var(--t-size-s);
      }
      .truth input {
        inline-size: 1.25rem;
        block-size: 1.25rem;
        accent-color: var(--t-accent);
      }
      details {
        border: 1px solid var(--t-line);
        border-radius: var(--t-radius-s);
        min-inline-size: 0;
      }
      details[open] > summary {
        border-block-end: 1px solid var(--t-line);
      }
      summary {
        display: flex;
        flex-wrap: wrap;
        align-items: center;
        gap: 0 var(--t-space-3);
        min-block-size: var(--t-touch);
        padding: var(--t-space-1) var(--t-space-3);
        font-weight: var(--t-weight-strong);
        cursor: pointer;
        overflow-wrap: anywhere;
      }
      summary::before {
        content: "▸";
        color: var(--t-muted);
      }
      details[open] > summary::before {
        content: "▾";
      }
      .inside {
        display: grid;
        grid-template-columns: minmax(0, 1fr);
        gap: var(--t-space-3);
        padding: var(--t-space-3);
      }
      .muted {
        ${quietText}
        font-weight: var(--t-weight);
      }
      .wrong {
        color: var(--t-bad);
        font-size: var(--t-size-s);
      }
      .ways {
        display: flex;
        flex-wrap: wrap;
        align-items: end;
        gap: var(--t-space-2);
      }
    `,
  ];

  @property({ attribute: false }) root: Schema = {};
  @property({ attribute: false }) schema: Schema = {};
  @property({ attribute: false }) value: JsonObject = {};
  @property({ attribute: false }) path: JsonPath = [];
  @property({ attribute: false }) findings: readonly FindingShape[] = [];

  @state() private open: ReadonlySet<string> = new Set();

  override render(): TemplateResult {
    const fields = schemaFields(this.root, this.schema);
    const plain = fields.filter((field) => field.kind !== "part" && field.kind !== "parts" && field.kind !== "other");
    const inner = fields.filter((field) => field.kind === "part" || field.kind === "parts");
    const other = fields.filter((field) => field.kind === "other" && this.value[field.key] !== undefined);
    return html`<datalist id="units">
        ${map(Object.keys(UNITS), (unit) => html`<option value=${unit}></option>`)}
      </datalist>
      <div class="lines">${repeat(plain, (field) => field.key, (field) => this.renderLine(field))}</div>
      ${repeat(inner, (field) => field.key, (field) => (field.kind === "part" ? this.renderPart(field) : this.renderParts(field)))}
      ${other.length === 0
        ? nothing
        : html`<p class="muted">${msg(str`Changed in the text only: ${other.map((field) => field.label.toLowerCase()).join(", ")}.`)}</p>`}`;
  }

  private renderLine(field: SchemaField): TemplateResult {
    const value = this.value[field.key] ?? field.standard;
    const error = this.problemAt([field.key]);
    if (field.kind === "truth") {
      return html`<div>
        <label class="truth"
          ><input type="checkbox" .checked=${value === true} @change=${this.valueSetter(field, (input) => input.checked)} />${field.label}</label
        >
        <div class="muted">${field.help}</div>
      </div>`;
    }
    return html`<t-field label=${field.required ? `${field.label} *` : field.label} hint=${field.help} error=${error}>${this.renderControl(field, value)}</t-field>`;
  }

  private renderControl(field: SchemaField, value: Json): TemplateResult {
    if (field.kind === "choice") {
      return html`<select @change=${this.valueSetter(field, (input) => input.value)}>${renderOptions(field.choices, typeof value === "string" ? value : "")}</select>`;
    }
    if (field.kind === "words") {
      const words = Array.isArray(value) ? value.map(String).join(", ") : "";
      return html`<input .value=${words} autocomplete="off" @change=${this.valueSetter(field, (input) => splitList(input.value))} />`;
    }
    if (field.kind === "number" || field.kind === "whole") {
      const shown = typeof value === "number" ? String(value) : "";
      return html`<input
        type="number"
        inputmode="decimal"
        step=${field.kind === "whole" ? "1" : "any"}
        .value=${shown}
        @change=${this.valueSetter(field, (input) => parseNumber(input.value, field))}
      />`;
    }
    return html`<input
      .value=${typeof value === "string" ? value : ""}
      autocomplete="off"
      autocapitalize="off"
      spellcheck="false"
      list=${field.key === "unit" ? "units" : nothing}
      @change=${this.valueSetter(field, (input) => input.value)}
    />`;
  }

  private renderPart(field: SchemaField): TemplateResult {
    const value = this.value[field.key];
    if (!isObject(value)) {
      return html`<div class="ways"><t-button @click=${this.partAdder([field.key], field)}>${msg("Add:")} ${field.label.toLowerCase()}</t-button></div>`;
    }
    return html`<details ?open=${this.isOpen(field.key)} @toggle=${this.openToggler(field.key)}>
      <summary>${field.label} ${this.renderProblemCount([field.key])}</summary>
      ${this.isOpen(field.key)
        ? html`<div class="inside">
            ${this.renderBelow(field.schema, value, [field.key])}
            ${field.nullable ? html`<div class="ways"><t-button @click=${this.partRemover([field.key])}>${msg("Remove")}</t-button></div>` : nothing}
          </div>`
        : nothing}
    </details>`;
  }

  private renderParts(field: SchemaField): TemplateResult {
    const value = this.value[field.key];
    const entries = isObject(value) ? Object.entries(value) : [];
    return html`<details ?open=${this.isOpen(field.key)} @toggle=${this.openToggler(field.key)}>
      <summary>${field.label} <span class="muted">${entries.length}</span> ${this.renderProblemCount([field.key])}</summary>
      ${this.isOpen(field.key)
        ? html`<div class="inside">
            ${field.help === "" ? nothing : html`<p class="muted">${field.help}</p>`}
            ${repeat(entries, ([key]) => key, ([key, part], at) => this.renderEntry(field, key, part, at, entries.length))}
            <div class="ways">
              <t-button label=${msg(str`Add to ${field.label.toLowerCase()}`)} @click=${this.optionAdder(field, value)}>${msg("Add")}</t-button>
            </div>
          </div>`
        : nothing}
    </details>`;
  }

  private renderEntry(field: SchemaField, key: string, part: Json, at: number, count: number): TemplateResult {
    const path = [field.key, key];
    const mark = path.join("/");
    const name = isObject(part) && typeof part["name"] === "string" ? part["name"] : "";
    return html`<details ?open=${this.isOpen(mark)} @toggle=${this.openToggler(mark)}>
      <summary>${key} <span class="muted">${name}</span> ${this.renderProblemCount(path)}</summary>
      ${this.isOpen(mark) && isObject(part)
        ? html`<div class="inside">
            <div class="ways">
              <t-field label=${msg("Short name")} error=${this.problemAt(path)}
                ><input .value=${key} autocomplete="off" autocapitalize="off" spellcheck="false" @change=${this.partRenamer(path)}
              /></t-field>
              <t-button label=${msg(str`Move ${key} up`)} ?disabled=${at === 0} @click=${this.partMover(path, -1)}>${msg("Up")}</t-button>
              <t-button label=${msg(str`Move ${key} down`)} ?disabled=${at === count - 1} @click=${this.partMover(path, 1)}>${msg("Down")}</t-button>
              <t-button label=${msg(str`Remove ${key}`)} @click=${this.partRemover(path)}>${msg("Remove")}</t-button>
            </div>
            ${this.renderBelow(field.schema, part, path)}
          </div>`
        : nothing}
    </details>`;
  }

  private renderBelow(schema: Schema, value: JsonObject, path: JsonPath): TemplateResult {
    return html`<t-form-part
      .root=${this.root}
      .schema=${schema}
      .value=${value}
      .path=${[...this.path, ...path]}
      .findings=${this.findings}
    ></t-form-part>`;
  }

  /** How many things do not fit below a path, in words. */
  private renderProblemCount(path: JsonPath): unknown {
    const at = [...this.path, ...path].join("/");
    const count = this.findings.filter((problem) => !problem.note && `${pathOf(problem.where).join("/")}/`.startsWith(`${at}/`)).length;
    if (count === 0) return nothing;
    return html`<span class="wrong">${plural(count, msg("1 problem"), msg(str`${String(count)} problems`))}</span>`;
  }

  private problemAt(path: JsonPath): string {
    const at = [...this.path, ...path].join("/");
    const found = this.findings.find((problem) => pathOf(problem.where).join("/") === at);
    return found === undefined ? "" : [found.problem, found.remedy].filter((address) => address !== "").join("; ");
  }

  private isOpen(mark: string): boolean {
    return this.open.has(mark);
  }

  private openToggler(mark: string): (event: Event) => void {
    return (event) => {
      if (!(event.target instanceof HTMLDetailsElement) || event.target.open === this.open.has(mark)) return;
      const open = new Set(this.open);
      if (event.target.open) open.add(mark);
      else open.delete(mark);
      this.open = open;
    };
  }

  private valueSetter(field: SchemaField, read: (input: HTMLInputElement) => Json | undefined): (event: Event) => void {
    return (event) => {
      this.fireEdit({ what: "set", path: this.fullPath([field.key]), value: read(event.target as HTMLInputElement) });
    };
  }

  private partAdder(path: JsonPath, field: SchemaField): () => void {
    return () => {
      this.fireEdit({ what: "set", path: this.fullPath(path), value: emptyOf(this.root, field.schema, field.key) });
    };
  }

  private optionAdder(field: SchemaField, value: Json | undefined): () => void {
    return () => {
      const taken = isObject(value) ? value : undefined;
      const key = freeName(taken, `new_${field.key.replace(/s$/, "")}`);
      this.open = new Set([...this.open, `${field.key}/${key}`]);
      this.fireEdit({ what: "set", path: this.fullPath([field.key, key]), value: emptyOf(this.root, field.schema, key) });
    };
  }

  private partRemover(path: JsonPath): () => void {
    return () => {
      this.fireEdit({ what: "set", path: this.fullPath(path), value: undefined });
    };
  }

  private partRenamer(path: JsonPath): (event: Event) => void {
    return (event) => {
      const name = (event.target as HTMLInputElement).value.trim();
      const key = path.at(-1) ?? "";
      if (this.open.has(path.join("/"))) this.open = new Set([...this.open, [...path.slice(0, -1), name].join("/")]);
      if (name !== key) this.fireEdit({ what: "rename", path: this.fullPath(path), name });
    };
  }

  private partMover(path: JsonPath, by: -1 | 1): () => void {
    return () => {
      this.fireEdit({ what: "move", path: this.fullPath(path), by });
    };
  }

  private fullPath(path: JsonPath): JsonPath {
    return [...this.path, ...path];
  }

  private fireEdit(edit: FormEdit): void {
    this.dispatchEvent(new CustomEvent("t-edit", { detail: edit, bubbles: true, composed: true }));
  }
}

function splitList(text: string): string[] {
  return text.split(",").map((address) => address.trim()).filter((address) => address !== "");
}

/** What was typed as a number; nothing where a field may say none. */
function parseNumber(text: string, field: SchemaField): Json | undefined {
  const value = Number(text);
  if (text.trim() === "" || !Number.isFinite(value)) return field.nullable ? null : undefined;
  return value;
}

declare global {
  interface HTMLElementTagNameMap {
    "t-form-part": SchemaForm;
  }
}
