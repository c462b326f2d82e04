/** Which objects are framed on a camera's picture, and how sure they must be. */

import { msg } from "@lit/localize";
import { css, html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, property, query } from "lit/decorators.js";
import { repeat } from "lit/directives/repeat.js";
import { objectKind, confidenceText } from "../../format/object-names.js";
import { base } from "../base/base-style.js";
import "../forms/button.js";

/** What can be chosen: a class of the site description, or one that was seen here. */
export interface ObjectOption {
  readonly label: string;
  readonly wanted: boolean;
  /** It is in the site description: counted, kept in history, and may raise alarms. */
  readonly described: boolean;
}

/** What a person chose; null goes back to what the site description says. */
export interface WantedObjects {
  readonly classes: readonly string[] | null;
  readonly confidence: number | null;
}

const LEAST = 0.3;
const MOST = 0.95;
const STEP = 0.05;

/**
 * @fires t-objects-want detail is what was chosen
 * @fires t-close it is chosen
 */
@customElement("t-objects-choice")
export class ObjectsChoicePanel extends LitElement {
  static override styles = [
    base,
    css`
      :host {
        display: block;
      }
      .quiet {
        color: var(--t-muted);
        font-weight: var(--t-weight);
      }
      .panel {
        display: grid;
        align-content: start;
        gap: var(--t-space-2);
        padding: var(--t-space-3);
        border: 1px solid var(--t-line);
        border-radius: var(--t-radius-s);
        background: var(--t-surface);
        font-size: var(--t-size-s);
      }
      fieldset {
        display: grid;
        grid-template-columns: repeat(auto-fill, minmax(7.5rem, 1fr));
        gap: 0 var(--t-space-2);
        margin: 0;
        padding: 0;
        border: 0;
      }
      legend {
        padding: 0;
        font-weight: var(--t-weight-strong);
      }
      label {
        display: flex;
        align-items: center;
        gap: var(--t-space-2);
        min-block-size: 2.25rem;
        overflow-wrap: anywhere;
        cursor: pointer;
      }
      .key {
        flex: none;
        inline-size: 0.8rem;
        block-size: 0.8rem;
        border: 2px solid #000;
        background: var(--t-box-thing);
      }
      .key.person {
        background: var(--t-box-person);
      }
      .key.animal {
        background: var(--t-box-animal);
      }
      .key.vehicle {
        background: var(--t-box-vehicle);
      }
      .sure {
        display: grid;
        grid-template-columns: minmax(0, 1fr) auto;
        gap: 0 var(--t-space-3);
      }
      .sure input {
        grid-column: 1 / -1;
        inline-size: 100%;
        min-block-size: 2.25rem;
        margin: 0;
      }
      output {
        font-weight: var(--t-weight-strong);
        font-variant-numeric: tabular-nums;
      }
      .foot {
        display: flex;
        flex-wrap: wrap;
        gap: var(--t-space-2);
      }
    `,
  ];

  @property({ attribute: false }) classes: readonly ObjectOption[] = [];
  /** What is less sure is not framed, 0 to 1. */
  @property({ type: Number }) confidence = 0.5;
  /** All is as the site description says. */
  @property({ type: Boolean }) plain = true;

  @query("input") private readonly first!: HTMLInputElement | null;

  override focus(): void {
    this.first?.focus();
  }

  override render(): TemplateResult {
    return html`<div class="panel" role="group" aria-label=${msg("Objects on the picture")} @keydown=${this.onKeyDown}>
      <fieldset @change=${this.onTick}>
        <legend>${msg("Framed")}</legend>
        ${repeat(
          this.classes,
          ({ label }) => label,
          ({ label, wanted, described }) => html`<label title=${described ? msg("Counted and kept in history") : msg("Seen here; shown only")}
            ><input type="checkbox" .value=${label} .checked=${wanted} /><span class="key ${objectKind(label)}"></span>${label}${described ? nothing : html` <span class="quiet">${msg("seen")}</span>`}</label
          >`,
        )}
      </fieldset>
      <label class="sure"
        ><span>${msg("At least as sure as")}</span><output aria-hidden="true">${confidenceText(this.confidence)}</output>
        <input
          type="range"
          aria-label=${msg("At least as sure as")}
          aria-valuetext=${confidenceText(this.confidence)}
          min=${LEAST * 100}
          max=${MOST * 100}
          step=${STEP * 100}
          .value=${String(Math.round(this.confidence * 100))}
          @input=${this.onSlide}
      /></label>
      <div class="foot">
        <t-button ?disabled=${this.plain} @click=${this.useDescribedObjects}>${msg("Default settings")}</t-button>
        <t-button @click=${this.closePanel}>${msg("Close")}</t-button>
      </div>
    </div>`;
  }

  private readonly closePanel = (): void => {
    this.dispatchEvent(new CustomEvent("t-close"));
  };

  private readonly onKeyDown = (event: KeyboardEvent): void => {
    if (event.key === "Escape") this.closePanel();
  };

  private readonly onTick = (event: Event): void => {
    const { target } = event;
    if (!(target instanceof HTMLInputElement)) return;
    const { value, checked } = target;
    this.fireWanted({
      classes: this.classes.filter(({ label, wanted }) => (label === value ? checked : wanted)).map(({ label }) => label),
      confidence: this.confidence,
    });
  };

  private readonly onSlide = (event: Event): void => {
    if (!(event.target instanceof HTMLInputElement)) return;
    this.fireWanted({ classes: this.classes.filter(({ wanted }) => wanted).map(({ label }) => label), confidence: event.target.valueAsNumber / 100 });
  };

  private readonly useDescribedObjects = (): void => {
    this.fireWanted({ classes: null, confidence: null });
  };

  private fireWanted(detail: WantedObjects): void {
    this.dispatchEvent(new CustomEvent("t-objects-want", { detail }));
  }
}

declare global {
  interface HTMLElementTagNameMap {
    "t-objects-choice": ObjectsChoicePanel;
  }
  interface HTMLElementEventMap {
    "t-objects-want": CustomEvent<WantedObjects>;
  }
}
